// Small problems in which times decide: a table of problems with what is right, judged by a person. Each has a plan of
// this makespan, or none, which is proved.

#include <gtest/gtest.h>

#include <optional>

#include "answers.h"
#include "planner/validator/validator.h"

namespace cxlab::planner::small_spaces_test {
namespace {

struct Row {
  const char* name;
  const char* domain;
  const char* problem;
  std::optional<double> makespan;  ///< of the best plan; none: there is no plan
};

void PrintTo(const Row& row, std::ostream* out) { *out << row.name; }

constexpr const char* kWalk = R"((:predicates (open) (crossed))
  (:durative-action cross :parameters () :duration (= ?duration 3) :condition (and (at start (open)) (at end (open)))
   :effect (at end (crossed))))";
constexpr const char* kHeat = R"((:predicates (on) (slow) (hot)) (:functions (time))
  (:durative-action heat :parameters () :duration (= ?duration (time)) :condition (at end (on))
   :effect (and (at start (on)) (at end (hot)) (at end (assign (time) 2))))
  (:action slow-down :parameters () :precondition (slow) :effect (increase (time) 3)))";
constexpr const char* kShop = R"((:predicates (open) (done))
  (:durative-action serve :parameters () :duration (= ?duration 4) :condition (at start (open))
   :effect (and (at start (not (open))) (at end (open)) (at end (done)))))";
constexpr const char* kWork = R"((:predicates (free) (open) (a) (b))
  (:durative-action make-a :parameters () :duration (= ?duration 4) :condition (and (at start (free)) (at end (open)))
   :effect (and (at start (not (free))) (at end (free)) (at end (a))))
  (:durative-action make-b :parameters () :duration (= ?duration 4) :condition (and (at start (free)) (at end (open)))
   :effect (and (at start (not (free))) (at end (free)) (at end (b)))))";
constexpr const char* kCandles = R"((:predicates (fresh ?c) (light ?c) (read))
  (:durative-action burn :parameters (?c) :duration (= ?duration 3) :condition (at start (fresh ?c))
   :effect (and (at start (not (fresh ?c))) (at start (light ?c)) (at end (not (light ?c)))))
  (:durative-action study :parameters () :duration (= ?duration 7) :condition (over all (exists (?c) (light ?c)))
   :effect (at end (read))))";
constexpr const char* kMatch = R"((:predicates (unused ?m) (light) (mended ?f))
  (:durative-action strike :parameters (?m) :duration (= ?duration 5) :condition (at start (unused ?m))
   :effect (and (at start (not (unused ?m))) (at start (light)) (at end (not (light)))))
  (:durative-action mend :parameters (?f) :duration (= ?duration 6) :condition (over all (light)) :effect (at end (mended ?f))))";
constexpr const char* kCoins = R"((:predicates (bought)) (:functions (coins))
  (:durative-action insert :parameters () :duration (= ?duration 4) :condition (at start (<= (coins) 2))
   :effect (at end (increase (coins) 1)))
  (:durative-action buy :parameters () :duration (= ?duration 3) :condition (at start (>= (coins) 3))
   :effect (and (at start (decrease (coins) 3)) (at end (bought)))))";
constexpr const char* kGear = R"((:predicates (there) (low)) (:functions (speed) (way))
  (:durative-action shift :parameters () :duration (= ?duration 2) :condition (at start (low))
   :effect (and (at start (not (low))) (at end (scale-up (speed) 3))))
  (:durative-action drive :parameters () :duration (= ?duration (/ (way) (speed))) :condition () :effect (at end (there))))";
constexpr const char* kTuned = R"((:predicates (open) (begun) (done) (shown)) (:functions (pace))
  (:durative-action work :parameters () :duration (= ?duration (pace)) :condition ()
   :effect (and (at start (begun)) (at end (done))))
  (:action tune :parameters () :precondition (begun) :effect (assign (pace) 1))
  (:action show :parameters () :precondition (and (open) (done)) :effect (shown)))";
constexpr const char* kOven = R"((:predicates (baked ?b) (open)) (:functions (used))
  (:durative-action bake :parameters (?b) :duration (= ?duration 4) :condition (and (over all (<= (used) 1)) (at end (open)))
   :effect (and (at start (increase (used) 1)) (at end (decrease (used) 1)) (at end (baked ?b)))))";
constexpr const char* kPress = R"((:predicates (open) (free)) (:functions (made))
  (:durative-action press :parameters () :duration (= ?duration 4) :condition (and (at start (free)) (at end (open)))
   :effect (and (at start (not (free))) (at end (free)) (at end (increase (made) 1)))))";
constexpr const char* kTimer = R"((:predicates (done) (idle)) (:functions (watch))
  (:durative-action measure :parameters () :duration (= ?duration 6) :condition (and (at start (idle)) (over all (<= (watch) 12)))
   :effect (and (at start (not (idle))) (at start (assign (watch) 0)) (increase (watch) (* #t 2)) (at end (done)))))";

const Row kRows[] = {
    {"EventsInTheMiddle", kWalk,
     "(:init (at 2 (open)) (at 3 (not (open))) (at 5 (open)) (at 6 (not (open)))) (:goal (crossed))", 5.001},
    {"NoTwoWindowsFit",
     kWalk,
     "(:init (at 2 (open)) (at 3 (not (open))) (at 7 (open)) (at 8 (not (open)))) (:goal (crossed))",
     {}},
    {"ClosesMeanwhile", kShop, "(:init (at 1 (open)) (at 2 (not (open)))) (:goal (done))", 5.001},
    {"ClosesBeforeItOpens", kShop, "(:init (at 1 (open)) (at 1.001 (not (open)))) (:goal (done))", {}},
    {"DeadlineOfBoth", kWork, "(:init (free) (open) (at 9 (not (open)))) (:goal (and (a) (b)))", 8.001},
    {"DeadlineBeforeTheSum", kWork, "(:init (free) (open) (at 7.5 (not (open)))) (:goal (and (a) (b)))", {}},
    {"RelayOfThree", kCandles, "(:objects x y z) (:init (fresh x) (fresh y) (fresh z)) (:goal (read))", 7.002},
    {"RelayOfTwoIsTooShort", kCandles, "(:objects x y) (:init (fresh x) (fresh y)) (:goal (read))", {}},
    {"NoMatchLastsLongEnough", kMatch, "(:objects m n f) (:init (unused m) (unused n)) (:goal (mended f))", {}},
    {"OverlappingCopies", kCoins, "(:init (= (coins) 0)) (:goal (bought))", 7.001},
    {"ASecondCopyIsFasterThanTheOneThatRuns", kTuned,
     "(:init (open) (= (pace) 20) (at 10 (not (open)))) (:goal (shown))", 20},
    {"AFasterGearFirst", kGear, "(:init (low) (= (speed) 1) (= (way) 12)) (:goal (there))", 6.001},
    {"ANumberOfItsOwn", kTimer, "(:init (idle)) (:goal (and (done) (= (watch) 12)))", 6},
    {"ANumberOfItsOwnThatGrowsTooFar", kTimer, "(:init (idle)) (:goal (and (done) (= (watch) 13)))", {}},
    {"TakesAwayWhatItNeeds",
     R"((:predicates (p) (g))
  (:durative-action a :parameters () :duration (= ?duration 2) :condition (over all (p)) :effect (and (at start (not (p))) (at end (g))))
  (:durative-action b :parameters () :duration (= ?duration 1) :condition () :effect (at end (p))))",
     "(:init (p)) (:goal (g))",
     {}},
    {"NoDurationIsAllowed",
     R"((:predicates (g)) (:functions (x))
  (:durative-action a :parameters () :duration (and (>= ?duration (x)) (<= ?duration 3)) :condition () :effect (at end (g))))",
     "(:init (= (x) 4)) (:goal (g))",
     {}},
    {"DurationAtEnd", R"((:predicates (g)) (:functions (x))
  (:durative-action wait :parameters () :duration (at end (= ?duration (x))) :condition () :effect (at end (g)))
  (:durative-action grow :parameters () :duration (= ?duration 1) :condition () :effect (at end (assign (x) 3))))",
     "(:init (= (x) 2)) (:goal (g))", 2},
    {"BothBeginAtOnce", R"((:predicates (a) (b) (ga) (gb))
  (:durative-action left :parameters () :duration (= ?duration 4) :condition (over all (b)) :effect (and (at start (a)) (at end (ga))))
  (:durative-action right :parameters () :duration (= ?duration 4) :condition (over all (a)) :effect (and (at start (b)) (at end (gb)))))",
     "(:init) (:goal (and (ga) (gb)))", 4},
    {"FillsUpToALine", R"((:predicates (full) (free)) (:functions (level))
  (:durative-action fill :parameters () :duration (>= ?duration 0) :condition (and (at start (free)) (over all (<= (level) 7)))
   :effect (and (at start (not (free))) (increase (level) (* #t 2))))
  (:action check :parameters () :precondition (>= (level) 7) :effect (full)))",
     "(:init (free) (= (level) 1)) (:goal (full))", 3.001},
    {"LeaksFasterThanItFills",
     R"((:predicates (g) (free)) (:functions (level))
  (:durative-action fill :parameters () :duration (= ?duration 3) :condition (at start (free))
   :effect (and (at start (not (free))) (at end (free)) (increase (level) (* #t 1)) (at end (assign (level) 0))))
  (:action check :parameters () :precondition (>= (level) 4) :effect (g)))",
     "(:init (free) (= (level) 0)) (:goal (g))",
     {}},
    {"ACapacityAndADeadline", kOven,
     "(:objects a b) (:init (open) (= (used) 0) (at 8.5 (not (open)))) (:goal (and (baked a) (baked b)))", 8},
    {"ACapacityBeforeADeadline",
     kOven,
     "(:objects a b) (:init (open) (= (used) 0) (at 7.5 (not (open)))) (:goal (and (baked a) (baked b)))",
     {}},
    {"ACounterBeforeADeadline",
     kPress,
     "(:init (open) (free) (= (made) 0) (at 11.5 (not (open)))) (:goal (>= (made) 3))",
     {}},
    {"ACounterAndADeadline", kPress, "(:init (open) (free) (= (made) 0) (at 12.5 (not (open)))) (:goal (>= (made) 3))",
     12.002},
    {"AFactThatIsDeletedAndAddedAtOnce", R"((:predicates (p ?x) (q ?x)) (:functions (n))
  (:action renew :parameters (?x) :precondition () :effect (and (forall (?y) (p ?y)) (not (p ?x)) (increase (n) 1)))
  (:action mark :parameters (?x) :precondition () :effect (and (p ?x) (q ?x))))",
     "(:objects a) (:init (= (n) 0)) (:goal (and (p a) (q a) (>= (n) 2)))", 0.002},
    {"AnEffectThatWouldMeetTheStart", R"((:predicates (dry) (g))
  (:durative-action wipe :parameters () :duration (= ?duration 0) :condition (and (at start (dry)) (over all (dry)))
   :effect (and (at end (g)) (when (at start (not (dry))) (at end (dry))))))",
     "(:init (dry)) (:goal (g))", 0},
    {"GrowsFromNothingInNoTime", R"((:predicates (g)) (:functions (level))
  (:durative-action fill :parameters () :duration (and (>= ?duration 0) (<= ?duration 3)) :condition ()
   :effect (and (at end (assign (level) 5)) (increase (level) (* #t 1))))
  (:action look :parameters () :precondition (= (level) 5) :effect (g)))",
     "(:init) (:goal (g))", 0.001},
    {"ItsEndNeedsWhatItsStartMakesInNoTime", kHeat, "(:init (= (time) 0)) (:goal (hot))", {}},
    {"ItsEndNeedsWhatItsStartMakes", kHeat, "(:init (slow) (= (time) 0)) (:goal (hot))", 3.001},
    {"ItsEndDerivesFromWhatItsStartMakesInNoTime",
     R"((:predicates (on) (warm) (hot)) (:functions (time)) (:derived (warm) (on))
  (:durative-action heat :parameters () :duration (= ?duration (time)) :condition (at end (warm))
   :effect (and (at start (on)) (at start (assign (time) 2)) (at end (hot)))))",
     "(:init (= (time) 0)) (:goal (hot))",
     {}},
    {"ItsEndSetsItsDurationInNoTime",
     R"((:predicates (done)) (:functions (time))
  (:durative-action tick :parameters () :duration (= ?duration (time)) :condition ()
   :effect (and (at end (assign (time) 1)) (at end (done)))))",
     "(:init (= (time) 0)) (:goal (done))",
     {}},
    {"BothEndsInNoTime", R"((:predicates (a) (b)) (:functions (time))
  (:durative-action blink :parameters () :duration (= ?duration (time)) :condition () :effect (and (at start (a)) (at end (b))))
  (:action slow-down :parameters () :precondition (a) :effect (increase (time) 3)))",
     "(:init (= (time) 0)) (:goal (and (a) (b)))", 0},
    {"SetWhereAConditionHolds",
     R"((:predicates (idle) (ready) (late) (g)) (:functions (watch))
  (:durative-action measure :parameters () :duration (= ?duration 6) :condition (and (at start (idle)) (over all (<= (watch) 12)))
   :effect (and (at start (not (idle))) (when (at start (ready)) (at start (assign (watch) 0)))
    (when (at start (late)) (at end (ready))) (increase (watch) (* #t 2)) (at end (late)) (at end (g)))))",
     "(:init (idle) (ready)) (:goal (g))", 6},
    {"ComparedWithItself", R"((:predicates (g)) (:functions (x) (y))
  (:action weigh :parameters () :precondition () :effect (assign (x) 1))
  (:action sell :parameters () :precondition (and (<= (x) (x)) (>= (+ (y) (x)) (+ 2 (x)))) :effect (g)))",
     "(:init (= (y) 2)) (:goal (g))", 0.001},
    {"ComparedWithItselfWithoutAValue",
     R"((:predicates (g)) (:functions (x))
  (:action sell :parameters () :precondition (<= (x) (x)) :effect (g)))",
     "(:init) (:goal (g))",
     {}},
    {"ItIsGoneAtOnceAndComesBack", kWalk, "(:init (crossed) (at 0 (not (crossed))) (at 4 (crossed))) (:goal (crossed))",
     0},
    {"TheGoalComesByItself", kWalk, "(:init (at 4 (crossed))) (:goal (crossed))", 0},
    {"ValueFromOutside", R"((:predicates (g)) (:functions (price))
  (:durative-action buy :parameters () :duration (= ?duration 1) :condition (at start (<= (price) 2)) :effect (at end (g))))",
     "(:init (= (price) 5) (at 3 (= (price) 2)) (at 4 (= (price) 9))) (:goal (g))", 4.001},
};

class SmallSpaces : public testing::TestWithParam<Row> {};

TEST_P(SmallSpaces, EndWithTheBestPlanOrAProof) {
  const Row& row = GetParam();
  const Task task = parse(row.domain, row.problem);
  const PlanAnswer found = *find_plan(task, {.budget = 3'000'000, .anytime = true});
  if (!row.makespan) {
    EXPECT_EQ(found.refused, 0) << found.refusal;
    EXPECT_EQ(found.status, PlanStatus::kUnsolvable) << found.reason;
    EXPECT_FALSE(found.plan) << to_text(found.plan->steps, task.domain, task.problem);
    return;
  }
  ASSERT_TRUE(found.plan) << found.reason;
  EXPECT_NEAR(found.plan->makespan_s, *row.makespan, 0.003) << to_text(found.plan->steps, task.domain, task.problem);
  EXPECT_LE(found.lower_bound_s, *row.makespan + 1e-6);
  const Expected<Verdict> verdict = Validator(task.domain, task.problem).check(found.plan->steps);
  EXPECT_TRUE(verdict && verdict->valid);
  const PlanAnswer again = *find_plan(task, {.budget = 3'000'000, .anytime = true});
  EXPECT_EQ(again.units, found.units);
  EXPECT_EQ(to_text(again.plan->steps, task.domain, task.problem),
            to_text(found.plan->steps, task.domain, task.problem));
}

INSTANTIATE_TEST_SUITE_P(All, SmallSpaces, testing::ValuesIn(kRows),
                         [](const testing::TestParamInfo<Row>& row) { return row.param.name; });

TEST(SmallSpaces, ABatteryThatNeverSufficesIsSearchedToItsEnd) {
  const PlanAnswer found = answer(
      parse(
          R"((:types wp) (:predicates (at ?w - wp) (dock ?w - wp) (seen ?w - wp) (road ?a ?b - wp)) (:functions (soc))
  (:durative-action move :parameters (?a ?b - wp) :duration (= ?duration 10)
   :condition (and (at start (road ?a ?b)) (at start (at ?a)) (at start (>= (soc) 70)))
   :effect (and (at start (not (at ?a))) (at start (decrease (soc) 70)) (at end (at ?b))))
  (:durative-action look :parameters (?a - wp) :duration (= ?duration 5) :condition (over all (at ?a)) :effect (at end (seen ?a)))
  (:durative-action charge :parameters (?a - wp) :duration (= ?duration 5)
   :condition (and (over all (at ?a)) (over all (dock ?a)) (at start (<= (soc) 100))) :effect (at end (assign (soc) 100))))",
          R"((:objects c w1 w2 - wp) (:init (at c) (dock w2) (road c w1) (road w1 c) (road c w2) (road w2 c) (= (soc) 99))
  (:goal (and (seen w1) (seen w2))))"),
      {.budget = 3'000'000});
  EXPECT_EQ(found.status, PlanStatus::kUnsolvable) << found.reason;
}

TEST(SmallSpaces, MetricsOfProductsAndRatiosGetAsGoodAsTheyCan) {
  const char* tokens = R"((:predicates (g)) (:functions (left) (a) (b) (c))
  (:action to-a :parameters () :precondition (>= (left) 1) :effect (and (decrease (left) 1) (increase (a) 1) (g)))
  (:action to-b :parameters () :precondition (>= (left) 1) :effect (and (decrease (left) 1) (increase (b) 2) (g))))";
  const auto best = [&](const std::string& metric) {
    const PlanAnswer found = answer(
        parse(tokens, "(:init (= (left) 4) (= (a) 1) (= (b) 1) (= (c) 12)) (:goal (g)) (:metric " + metric + ")"),
        {.budget = 2'000'000, .anytime = true});
    return found.plan && found.plan->metric ? *found.plan->metric : -1;
  };
  EXPECT_DOUBLE_EQ(best("maximize (* (a) (b))"), 15) << "a = 3, b = 5";
  EXPECT_DOUBLE_EQ(best("minimize (/ (c) (b))"), 12.0 / 9);
}

}  // namespace
}  // namespace cxlab::planner::small_spaces_test
