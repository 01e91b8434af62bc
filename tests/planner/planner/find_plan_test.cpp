// Problems that need one feature each, and the answers that are not plans.

#include <gtest/gtest.h>

#include "answers.h"

namespace cxlab::planner {
namespace {

constexpr const char* kLamp = R"((:predicates (dark) (light) (done ?i) (item ?i) (free))
  (:durative-action strike :parameters () :duration (= ?duration 5) :condition (at start (dark))
   :effect (and (at start (not (dark))) (at start (light)) (at end (not (light))) (at end (dark))))
  (:durative-action mend :parameters (?i) :duration (= ?duration 2)
   :condition (and (at start (item ?i)) (at start (free)) (over all (light)))
   :effect (and (at start (not (free))) (at end (free)) (at end (done ?i)))))";

TEST(FindPlan, OverlapsActionsWhereOneNeedsTheOther) {
  const PlanAnswer found = answer(parse(
      kLamp,
      "(:objects a b c) (:init (dark) (free) (item a) (item b) (item c)) (:goal (and (done a) (done b) (done c)))"));
  ASSERT_TRUE(found.plan);
  EXPECT_EQ(found.plan->steps.size(), 5u);  // two matches: three items take six seconds
}

TEST(FindPlan, SeparatesHappeningsThatValidatorsSeparateThoughNothingDependsOnIt) {
  const auto starts = [](const char* condition, const char* init) {
    const PlanAnswer found =
        answer(parse(std::string(R"((:predicates (known) (never) (fixed) (go) (seen) (done)) (:functions (count) (sum))
      (:durative-action look :parameters () :duration (= ?duration 2) :condition (at start )") +
                         condition + R"() :effect (at end (seen)))
      (:durative-action work :parameters () :duration (= ?duration 2) :condition (at start (go))
       :effect (and (at start (known)) (at start (not (never))) (at start (assign (count) 1)) (at end (done)))))",
                     std::string("(:init (go) (= (count) 0) (= (sum) 0) ") + init + ") (:goal (and (seen) (done)))"));
    EXPECT_TRUE(found.plan) << condition;
    return found.plan ? found.plan->steps[1].start : -1;
  };
  EXPECT_GE(starts("(known)", "(known)"), 0.001);                       // always true, made true again
  EXPECT_GE(starts("(not (never))", ""), 0.001);                        // always false, made false again
  EXPECT_GE(starts("(or (fixed) (known))", "(fixed) (known)"), 0.001);  // decided by what never changes
  EXPECT_GE(starts("(imply (never) (fixed))", "(fixed)"), 0.001);
  EXPECT_GE(starts("(or (fixed) (> (count) 5))", "(fixed)"), 0.001);
  EXPECT_EQ(starts("(fixed)", "(fixed)"), 0);
}

TEST(FindPlan, SeparatesInterferingChangesThatNothingNeeds) {
  const auto second_start = [](const char* first, const char* second) {
    const PlanAnswer found = answer(parse(std::string(R"((:predicates (a) (b) (lamp) (go)) (:functions (sum) (rate))
      (:durative-action one :parameters () :duration (= ?duration 2) :condition (at start (go)) :effect (and (at start )") +
                                              first + R"() (at end (a))))
      (:durative-action two :parameters () :duration (= ?duration 2) :condition (at start (go)) :effect (and (at start )" +
                                              second + ") (at end (b))))",
                                          "(:init (go) (= (sum) 0) (= (rate) 1)) (:goal (and (a) (b)))"));
    EXPECT_TRUE(found.plan) << first;
    return found.plan ? found.plan->steps[1].start : -1;
  };
  EXPECT_GE(second_start("(lamp)", "(not (lamp))"), 0.001);
  EXPECT_GE(second_start("(assign (sum) 1)", "(increase (sum) 1)"), 0.001);
  EXPECT_GE(second_start("(increase (sum) (rate))", "(increase (rate) 1)"), 0.001);
  EXPECT_EQ(second_start("(increase (sum) 2)", "(increase (sum) 1)"), 0);
  EXPECT_EQ(second_start("(lamp)", "(lamp)"), 0);
}

TEST(FindPlan, AnActionWithoutDurationMustNotDisturbItself) {
  struct Case {
    const char *condition, *effect;
    bool possible;
  };
  for (const auto& [condition, effect, possible] : {Case{"(at start (f))", "", true},
                                                    {"(at end (f))", "(at start (g))", true},
                                                    {"(at end (f))", "(at start (not (f)))", false},
                                                    {"(at start (f))", "(at end (not (f)))", false},
                                                    {"(at end (g))", "(at start (g))", false},
                                                    {"", "(at start (g)) (at end (not (g)))", false},
                                                    {"", "(at start (not (f))) (at end (f))", false},
                                                    {"", "(at start (g)) (at end (not (f)))", true},
                                                    {"", "(at start (assign (n) 1)) (at end (increase (n) 1))", false},
                                                    {"(at end (> (n) 0))", "(at start (increase (n) 1))", false},
                                                    {"(at start (= (n) 0))", "(at end (increase (n) 1))", false},
                                                    {"(at end (= (n) 0))", "(at start (increase (m) 1))", true}}) {
    const PlanAnswer found = answer(parse(std::string(R"((:predicates (f) (g) (done)) (:functions (n) (m))
      (:durative-action a :parameters () :duration (= ?duration 0) :condition (and )") +
                                              condition + ") :effect (and (at end (done)) " + effect + "))",
                                          "(:init (f) (= (n) 0) (= (m) 0)) (:goal (done))"),
                                    {.budget = 50'000});
    EXPECT_EQ(found.plan.has_value(), possible) << condition << " " << effect;
  }
}

TEST(FindPlan, ABoundOfADurationCanBeReadAtTheEnd) {
  const PlanAnswer found = answer(parse(R"((:predicates (done)) (:functions (n))
      (:durative-action a :parameters () :duration (and (at start (>= ?duration 2)) (at end (<= ?duration (n))))
       :condition () :effect (and (at start (assign (n) 5)) (at end (done)))))",
                                        "(:init (= (n) 0)) (:goal (done))"),
                                  {.budget = 50'000});
  ASSERT_TRUE(found.plan);
  EXPECT_GE(found.plan->steps[0].duration, 2);
}

TEST(FindPlan, IgnoresActionsThatLastTooShortly) {
  std::string objects, init, goal;
  for (int i = 0; i < 40; ++i) {
    const std::string name = " b" + std::to_string(i);
    objects += name;
    init += (i % 2 ? " (small" : " (big") + name + ")";
    goal += " (baked" + name + ") (glazed" + name + ")";
  }
  const PlanAnswer found = answer(parse(R"((:predicates (hot) (in ?b) (small ?b) (big ?b) (glazed ?b) (baked ?b))
    (:durative-action a-short-fire :parameters () :duration (= ?duration 8) :condition () :effect (and (at start (hot)) (at end (not (hot)))))
    (:durative-action long-fire :parameters () :duration (= ?duration 20) :condition () :effect (and (at start (hot)) (at end (not (hot)))))
    (:durative-action bake :parameters (?b) :duration (= ?duration 15) :condition (and (at start (big ?b)) (over all (hot)))
     :effect (and (at start (in ?b)) (at end (not (in ?b))) (at end (baked ?b))))
    (:durative-action toast :parameters (?b) :duration (= ?duration 5) :condition (and (at start (small ?b)) (over all (hot)))
     :effect (and (at start (in ?b)) (at end (not (in ?b))) (at end (baked ?b))))
    (:durative-action glaze :parameters (?b) :duration (= ?duration 2) :condition (over all (in ?b)) :effect (at end (glazed ?b))))",
                                        "(:objects" + objects + ") (:init" + init + ") (:goal (and" + goal + "))"),
                                  {.budget = 100'000});
  ASSERT_TRUE(found.plan);
  EXPECT_NEAR(found.plan->makespan_s, 20.0, 0.1);
}

TEST(FindPlan, APlanThatComesTooLateIsNotReturned) {
  const std::string domain = R"((:predicates (open) (in))
    (:durative-action enter :parameters () :duration (= ?duration 4) :condition (over all (open)) :effect (at end (in))))";
  const PlanAnswer in_time = answer(parse(domain, "(:init (at 2 (open)) (at 7 (not (open)))) (:goal (in))"));
  ASSERT_TRUE(in_time.plan);
  EXPECT_GE(in_time.plan->steps[0].start, 2.0);
  EXPECT_FALSE(answer(parse(domain, "(:init (at 2 (open)) (at 5 (not (open)))) (:goal (in))")).plan);
}

TEST(FindPlan, APlanThatWaitsForAnEventEndsAfterIt) {
  const PlanAnswer found = answer(parse(R"((:predicates (day) (awake))
    (:durative-action rise :parameters () :duration (= ?duration 1) :condition () :effect (at end (awake))))",
                                        "(:init (at 6 (day))) (:goal (and (day) (awake)))"));
  ASSERT_TRUE(found.plan);
  EXPECT_GT(found.plan->makespan_s, 6.0);
}

TEST(FindPlan, AGoalThatAnEventUndoesAfterwardsDoesNotCount) {
  const std::string domain = R"((:predicates (lit))
    (:durative-action light :parameters () :duration (= ?duration 1) :condition () :effect (at end (lit))))";
  for (const char* init : {"(:init (at 6 (not (lit))))", "(:init (lit) (at 6 (not (lit))))"}) {
    const PlanAnswer found = answer(parse(domain, std::string(init) + " (:goal (lit))"));
    ASSERT_TRUE(found.plan) << init;
    EXPECT_GT(found.plan->makespan_s, 6.0);
  }
  EXPECT_EQ(answer(parse(domain, "(:init (at 6 (not (lit))) (at 7 (lit))) (:goal (lit))")).plan->makespan_s, 1.0);
}

TEST(FindPlan, AnEventAfterTheLastActionCanMakeTheGoalTrue) {
  const PlanAnswer found =
      answer(parse(R"((:predicates (lamp) (photo))
    (:durative-action expose :parameters () :duration (= ?duration 3) :condition (over all (lamp)) :effect (at end (photo))))",
                   "(:init (at 2 (lamp)) (at 6 (not (lamp)))) (:goal (and (photo) (not (lamp))))"));
  ASSERT_TRUE(found.plan);
  EXPECT_LT(found.plan->makespan_s, 6.0);
}

TEST(FindPlan, CollectsAsMuchAsIsNeeded) {
  const PlanAnswer found = answer(parse(R"((:functions (coins)) (:predicates (bought))
    (:durative-action earn :parameters () :duration (= ?duration 2) :condition (at start (<= (coins) 5)) :effect (at end (increase (coins) 2)))
    (:durative-action buy :parameters () :duration (= ?duration 1) :condition (at start (>= (coins) 5)) :effect (and (at end (bought)) (at start (decrease (coins) 5)))))",
                                        "(:init (= (coins) 0)) (:goal (bought))"));
  ASSERT_TRUE(found.plan);
  EXPECT_EQ(found.plan->steps.size(), 4u);
}

TEST(FindPlan, DurationsDependOnTheState) {
  const PlanAnswer found = answer(parse(R"((:functions (fuel) (rate)) (:predicates (full))
    (:durative-action refuel :parameters () :duration (= ?duration (/ (- 10 (fuel)) (rate))) :condition () :effect (and (at end (assign (fuel) 10)) (at end (full)))))",
                                        "(:init (= (fuel) 4) (= (rate) 2)) (:goal (full))"));
  ASSERT_TRUE(found.plan);
  EXPECT_NEAR(found.plan->steps[0].duration, 3.0, 1e-9);
}

TEST(FindPlan, DerivedFactsAndTheirAbsence) {
  const PlanAnswer found =
      answer(parse(R"((:predicates (on ?a ?b) (above ?a ?b) (taken))
    (:derived (above ?a ?b) (or (on ?a ?b) (exists (?c) (and (on ?a ?c) (above ?c ?b)))))
    (:action lift :parameters (?a ?b) :precondition (on ?a ?b) :effect (not (on ?a ?b)))
    (:action take :parameters (?b) :precondition (forall (?a) (not (above ?a ?b))) :effect (taken)))",
                   "(:objects x y z) (:init (on x y) (on y z)) (:goal (and (taken) (not (above x z))))"));
  ASSERT_TRUE(found.plan);
}

TEST(FindPlan, ADerivedFactIsDecidedBeforeTheRulesThatNegateIt) {
  // Without `broken`, no part is bad, so the machine is sound, so it needs no repair.
  const std::string domain = R"((:predicates (broken) (bad) (sound) (needs-repair) (sold))
    (:derived (needs-repair) (not (sound)))
    (:derived (sound) (not (bad)))
    (:derived (bad) (broken))
    (:action sell :parameters () :precondition (not (needs-repair)) :effect (sold))
    (:action drop :parameters () :precondition () :effect (broken))
    (:action mend :parameters () :precondition (broken) :effect (not (broken))))";
  const PlanAnswer sound = answer(parse(domain, "(:init) (:goal (sold))"));
  ASSERT_TRUE(sound.plan);
  EXPECT_EQ(sound.plan->steps.size(), 1u);
  const PlanAnswer broken = answer(parse(domain, "(:init (broken)) (:goal (sold))"));
  ASSERT_TRUE(broken.plan);
  EXPECT_EQ(broken.plan->steps.size(), 2u) << "it is mended first";
}

TEST(FindPlan, ComparisonsWithNearlyEqualConstantsAreDifferent) {
  const PlanAnswer found = answer(parse(R"((:functions (x)) (:predicates (done))
    (:action strict :parameters () :precondition (>= (x) 0.0000004) :effect (done))
    (:action lax :parameters () :precondition (>= (x) 0.0000001) :effect (done))
    (:action spend :parameters () :precondition (done) :effect (decrease (x) 1)))",
                                        "(:init (= (x) 0.0000002)) (:goal (done))"));
  ASSERT_TRUE(found.plan) << found.reason;
  EXPECT_EQ(found.plan->steps.size(), 1u);
}

TEST(FindPlan, ReportsABoundThatLeavesOutEndsAtOneInstant) {
  // Two pieces can share the oven only if both are put in at the same instant.
  const std::string domain = R"((:predicates (raw ?p) (in ?p) (empty) (baked ?p) (out ?p))
    (:durative-action fill :parameters (?p) :duration (= ?duration 2) :condition (and (at start (raw ?p)) (over all (empty)))
     :effect (and (at start (not (raw ?p))) (at end (in ?p)) (at end (not (empty)))))
    (:durative-action bake :parameters (?p) :duration (= ?duration 10) :condition (at start (in ?p)) :effect (at end (baked ?p)))
    (:durative-action take :parameters (?p) :duration (= ?duration 3) :condition (and (at start (baked ?p)) (at start (in ?p)))
     :effect (and (at start (not (in ?p))) (at end (out ?p)) (at end (empty)))))";
  const PlanAnswer two =
      answer(parse(domain, "(:objects a b) (:init (raw a) (raw b) (empty)) (:goal (and (out a) (out b)))"),
             {.budget = 200'000, .anytime = true});
  ASSERT_TRUE(two.plan);
  EXPECT_EQ(two.lower_bound_s, 30);
  EXPECT_TRUE(two.bound_assumes_order);
  EXPECT_EQ(two.reason, "no plan is shorter in which no two actions change one fact at one instant");
  const PlanAnswer one = answer(parse(domain, "(:objects a) (:init (in a) (empty)) (:goal (baked a))"));
  EXPECT_FALSE(one.bound_assumes_order);
}

TEST(FindPlan, AConditionOfTheBeginningDecidesAnEffectAtTheEnd) {
  const PlanAnswer found = answer(parse(R"((:predicates (wet) (rain) (home))
    (:durative-action walk :parameters () :duration (= ?duration 3) :condition () :effect (and (at end (home)) (when (at start (rain)) (at end (wet))))))",
                                        "(:init (rain) (at 1 (not (rain)))) (:goal (and (home) (not (wet))))"));
  ASSERT_TRUE(found.plan);
  EXPECT_GT(found.plan->steps[0].start, 1.0);
}

TEST(FindPlan, PreventsAnEffectThatMustNotHappen) {
  const PlanAnswer found = answer(parse(
      R"((:predicates (wet ?p) (rain) (roof ?p) (home ?p) (person ?p))
    (:durative-action walk :parameters (?p) :duration (= ?duration 4) :condition (at start (person ?p))
     :effect (and (at end (home ?p)) (when (and (at start (rain)) (over all (not (roof ?p)))) (at end (wet ?p)))))
    (:action open-umbrella :parameters (?p) :precondition (person ?p) :effect (roof ?p)))",
      "(:objects a b) (:init (rain) (person a) (person b)) (:goal (and (home a) (not (wet a)) (home b) (wet b)))"));
  ASSERT_TRUE(found.plan);
  EXPECT_EQ(found.plan->steps.size(), 3u);
}

TEST(FindPlan, ADurationIsBoundedWhenTheActionEnds) {
  const PlanAnswer found = answer(parse(R"((:functions (most)) (:predicates (done))
    (:durative-action work :parameters () :duration (and (at start (>= ?duration 2)) (at end (<= ?duration (most)))) :condition () :effect (at end (done)))
    (:durative-action allow :parameters () :duration (= ?duration 1) :condition () :effect (at end (increase (most) 2))))",
                                        "(:init (= (most) 1)) (:goal (done))"));
  ASSERT_TRUE(found.plan);
  EXPECT_EQ(found.plan->steps.size(), 2u);
}

TEST(FindPlan, AnActionWithoutDurationIsOneHappening) {
  const std::string start_and_end =
      "(:predicates (a) (b)) (:durative-action x :parameters () :duration (= ?duration 0) :effect (and (at start (a)) "
      "(at end (b))) :condition ";
  EXPECT_TRUE(answer(parse(start_and_end + "())", "(:init) (:goal (and (a) (b)))")).plan);
  EXPECT_EQ(answer(parse(start_and_end + "(at end (a)))", "(:init) (:goal (and (a) (b)))")).status, PlanStatus::kEnded);
}

TEST(FindPlan, SeveralActionsInTurnKeepAnExistentialConditionTrue) {
  const PlanAnswer found = answer(parse(R"((:predicates (on ?l) (fresh ?l) (done))
    (:durative-action light :parameters (?l) :duration (= ?duration 3) :condition (at start (fresh ?l))
     :effect (and (at start (not (fresh ?l))) (at start (on ?l)) (at end (not (on ?l)))))
    (:durative-action work :parameters () :duration (= ?duration 5) :condition (over all (exists (?l) (on ?l))) :effect (at end (done))))",
                                        "(:objects l1 l2) (:init (fresh l1) (fresh l2)) (:goal (done))"));
  ASSERT_TRUE(found.plan);
  EXPECT_NEAR(found.plan->makespan_s, 5.002, 0.001);
}

TEST(FindPlan, AConditionOverAllMayEndWithItsAction) {
  const PlanAnswer found = answer(parse(R"((:predicates (open) (done))
    (:durative-action stay :parameters () :duration (= ?duration 5) :condition (over all (open)) :effect (at end (done))))",
                                        "(:init (open) (at 5 (not (open)))) (:goal (done))"));
  ASSERT_TRUE(found.plan);
  EXPECT_EQ(found.plan->makespan_s, 5.0);
}

TEST(FindPlan, NumbersThatChangeContinuously) {
  const PlanAnswer found = answer(parse(R"((:functions (level)) (:predicates (idle))
    (:durative-action pump :parameters () :duration (= ?duration 3) :condition (and (at start (idle)) (over all (>= (level) 0)))
     :effect (and (at start (not (idle))) (at end (idle)) (increase (level) (* #t 2)))))",
                                        "(:init (idle) (= (level) 1)) (:goal (>= (level) 12))"));
  ASSERT_TRUE(found.plan);
  EXPECT_EQ(found.plan->steps.size(), 2u);
}

TEST(FindPlan, ReportsWhatAProofAssumes) {
  // Only the end of filling takes the oven: plans in which both pieces are filled in at one instant are not counted.
  const char* oven = R"((:predicates (raw ?p) (in ?p) (empty) (baked ?p) (out ?p))
    (:durative-action fill :parameters (?p) :duration (= ?duration 2) :condition (and (at start (raw ?p)) (WHEN (empty)))
     :effect (and (at start (not (raw ?p))) (at end (in ?p)) (WHEN (not (empty)))))
    (:durative-action bake :parameters (?p) :duration (= ?duration 10) :condition (at start (in ?p)) :effect (at end (baked ?p)))
    (:durative-action take :parameters (?p) :duration (= ?duration 3) :condition (and (at start (baked ?p)) (at start (in ?p)))
     :effect (and (at start (not (in ?p))) (at end (out ?p)) (at end (empty)))))";
  const auto found = [&](const std::string& condition, const std::string& effect) {
    std::string domain = oven;
    domain.replace(domain.find("WHEN"), 4, condition);
    domain.replace(domain.find("WHEN"), 4, effect);
    return answer(parse(domain, "(:objects a b) (:init (raw a) (raw b) (empty)) (:goal (and (out a) (out b)))"),
                  {.budget = 1'000'000, .anytime = true});
  };
  const PlanAnswer assumes = found("over all", "at end");
  EXPECT_EQ(assumes.reason, "no plan is shorter in which no two actions change one fact at one instant");
  EXPECT_TRUE(assumes.bound_assumes_order);
  const PlanAnswer plain = found("at start", "at start");
  EXPECT_EQ(plain.reason, "no plan is shorter");
  EXPECT_FALSE(plain.bound_assumes_order);
}

TEST(FindPlan, ProvesThatNothingAddsTheGoal) {
  const PlanAnswer found = answer(parse(
      "(:predicates (a) (b)) (:action make :parameters () :precondition (b) :effect (a))", "(:init) (:goal (a))"));
  EXPECT_EQ(found.status, PlanStatus::kUnsolvable);
}

TEST(FindPlan, TakesActionsThatOnlyServeOthers) {
  struct Row {
    const char *what, *domain, *problem;
  };
  for (const auto& [what, domain, problem] :
       {Row{"a number in the value of an effect",
            "(:functions (rate) (total)) (:action raise :effect (increase (rate) 2))"
            "(:action collect :effect (increase (total) (rate)))",
            "(:init (= (rate) 0) (= (total) 0)) (:goal (>= (total) 5))"},
        Row{"the condition of an effect",
            "(:predicates (lit) (seen)) (:action light :effect (lit)) (:action look :effect (when (lit) (seen)))",
            "(:init) (:goal (seen))"},
        Row{"a number in the condition of an effect",
            "(:predicates (seen)) (:functions (light)) (:action light :effect (increase (light) 1))"
            "(:action look :effect (when (>= (light) 2) (seen)))",
            "(:init (= (light) 0)) (:goal (seen))"},
        Row{"an effect that must not come about",
            "(:predicates (covered) (clean) (painted)) (:action cover :effect (covered))"
            "(:action paint :effect (and (painted) (when (not (covered)) (not (clean)))))",
            "(:init (clean)) (:goal (and (painted) (clean)))"},
        Row{"a bound of a duration",
            "(:predicates (done)) (:functions (pace)) (:action hurry :effect (decrease (pace) 8))"
            "(:durative-action go :parameters () :duration (and (>= ?duration (pace)) (<= ?duration 5)) :condition ()"
            " :effect (at end (done)))",
            "(:init (= (pace) 10)) (:goal (done))"},
        Row{"a fact that must be gone",
            "(:predicates (blocked) (done)) (:action clear :effect (not (blocked)))"
            "(:action pass :precondition (not (blocked)) :effect (done))",
            "(:init (blocked)) (:goal (done))"},
        Row{"a number in a condition",
            "(:predicates (done)) (:functions (fuel)) (:action fill :effect (increase (fuel) 1))"
            "(:action go :precondition (> (fuel) 2) :effect (done))",
            "(:init (= (fuel) 0)) (:goal (done))"},
        Row{"a condition over all and one at the end",
            "(:predicates (calm) (ready) (done)) (:action soothe :effect (calm)) (:action prepare :effect (ready))"
            "(:durative-action work :parameters () :duration (= ?duration 2)"
            " :condition (and (over all (calm)) (at end (ready))) :effect (at end (done)))",
            "(:init) (:goal (done))"},
        Row{"conditions of rules, present and absent",
            "(:predicates (open) (barred) (locked) (done)) (:derived (open) (not (or (barred) (locked))))"
            "(:action unbar :effect (not (barred))) (:action unlock :effect (not (locked)))"
            "(:action enter :precondition (open) :effect (done))",
            "(:init (barred) (locked)) (:goal (done))"},
        Row{"a rule that must not hold",
            "(:predicates (alarm) (smoke) (heat) (done)) (:derived (alarm) (or (smoke) (heat)))"
            "(:action air :effect (not (smoke))) (:action cool :effect (not (heat)))"
            "(:action leave :precondition (not (alarm)) :effect (done))",
            "(:init (smoke) (heat)) (:goal (done))"}}) {
    const PlanAnswer found = answer(parse(domain, problem), {.budget = 200'000});
    EXPECT_TRUE(found.plan) << what << ": " << found.reason;
  }
}

TEST(FindPlan, ANumberThatNeverGetsAValueIsNamed) {
  const char* refuel = R"((:predicates (full ?c) (ready)) (:functions (fuel ?c) (spare ?c) (weight ?c))
    (:action fill :parameters (?c) :precondition (ready) :effect (and (increase (fuel ?c) 1) (full ?c)))
    (:action spill :parameters (?c) :precondition (ready) :effect (scale-down (spare ?c) 2)))";
  const auto reason = [&](const std::string& more, const std::string& init, const std::string& goal) {
    const PlanAnswer found = answer(
        parse(refuel + more, "(:objects a b) (:init (ready) " + init + ") (:goal " + goal + ")"), {.budget = 200'000});
    return found.status == PlanStatus::kUnsolvable ? found.reason
           : found.plan                            ? "a plan"
                                                   : "another answer: " + found.reason;
  };
  const std::string missing =
      "the goal is out of reach, judged by facts one by one and in pairs; without a value in :init, and nothing "
      "assigns one: ";
  EXPECT_EQ(reason("", "(= (fuel b) 0)", "(full a)"), missing + "(fuel a)");
  EXPECT_EQ(reason("", "", "(and (full a) (>= (spare b) 1))"), missing + "(fuel a), (spare b)");
  EXPECT_EQ(reason("", "(= (fuel a) 0)", "(full a)"), "a plan");
  EXPECT_EQ(reason("", "", "(>= (fuel a) 3)"), missing + "(fuel a)");
  EXPECT_EQ(reason("(:durative-action measure :parameters (?c) :duration (= ?duration (+ 1 (spare ?c))) :condition () "
                   ":effect (at end (full ?c)))",
                   "", "(full b)"),
            missing + "(fuel b), (spare b)");
  EXPECT_EQ(reason("(:action weigh :parameters (?c) :precondition (<= (weight ?c) 3) :effect (full ?c))",
                   "(= (weight b) 9)", "(full a)"),
            missing + "(fuel a), (weight a)");
  EXPECT_EQ(reason("(:action calibrate :parameters (?c) :effect (assign (fuel ?c) 2))", "", "(>= (fuel a) 4)"),
            "a plan");
  EXPECT_EQ(reason("(:action pour :parameters (?c ?d) :precondition (not (= ?c ?d)) :effect (and (full ?c) (assign "
                   "(fuel ?c) (fuel ?d))))",
                   "", "(full a)"),
            missing + "(fuel a), (fuel b)");
  EXPECT_EQ(reason("(:action calibrate :parameters (?c) :effect (assign (fuel ?c) 2))", "", "(full a)"), "a plan");
  EXPECT_EQ(reason("(:action copy :parameters (?c) :effect (and (full ?c) (assign (fuel ?c) (spare ?c)))) (:action "
                   "repair :parameters (?c) :effect (assign (spare ?c) 2))",
                   "", "(full a)"),
            "a plan");
  EXPECT_EQ(reason("", "(at 5 (= (fuel a) 1))", "(>= (fuel a) 3)"), "a plan");
  EXPECT_EQ(reason("", "", "(and (full a) (not (ready)))"),
            "the goal is out of reach, judged by facts one by one and in pairs");
}

TEST(FindPlan, ProvesThatNoOrderWorks) {
  const PlanAnswer found = answer(parse(R"((:predicates (key) (a) (b))
    (:action open-a :parameters () :precondition (key) :effect (and (a) (not (key))))
    (:action open-b :parameters () :precondition (key) :effect (and (b) (not (key)))))",
                                        "(:init (key)) (:goal (and (a) (b)))"));
  EXPECT_EQ(found.status, PlanStatus::kUnsolvable);
}

TEST(FindPlan, ProvesThatTwoFactsOfTheGoalAreNeverTrueTogetherWithoutTryingAllStates) {
  std::string objects = "(:objects", off;
  for (int i = 0; i < 40; ++i) {
    objects += " s" + std::to_string(i);
    off += " (off s" + std::to_string(i) + ")";
  }
  const PlanAnswer found =
      answer(parse(R"((:predicates (key) (left) (right) (on ?s) (off ?s))
    (:durative-action open-left :parameters () :duration (= ?duration 2) :condition (at start (key))
     :effect (and (at start (not (key))) (at end (left))))
    (:durative-action open-right :parameters () :duration (= ?duration 2) :condition (at start (key))
     :effect (and (at start (not (key))) (at end (right))))
    (:action switch-on :parameters (?s) :precondition (off ?s) :effect (and (on ?s) (not (off ?s))))
    (:action switch-off :parameters (?s) :precondition (on ?s) :effect (and (off ?s) (not (on ?s)))))",
                   objects + ") (:init (key)" + off + ") (:goal (and (left) (right) (forall (?s) (on ?s))))"),
             {.budget = 20'000});
  EXPECT_EQ(found.status, PlanStatus::kUnsolvable);
  EXPECT_LT(found.units, 5'000);
}

TEST(FindPlan, ProvesUsingThatAnActionEndsOnce) {
  // If one lifting could end often, a block would be in the hand and on another one.
  const PlanAnswer found =
      answer(parse(R"((:predicates (on ?x ?y) (table ?x) (clear ?x) (free) (held ?x))
    (:durative-action lift :parameters (?x) :duration (= ?duration 2)
     :condition (and (at start (clear ?x)) (at start (table ?x)) (at start (free)))
     :effect (and (at start (not (free))) (at start (not (clear ?x))) (at end (not (table ?x))) (at end (held ?x))))
    (:durative-action stack :parameters (?x ?y) :duration (= ?duration 3)
     :condition (and (at start (held ?x)) (at start (clear ?y)))
     :effect (and (at start (not (held ?x))) (at start (not (clear ?y))) (at end (clear ?x)) (at end (on ?x ?y)) (at end (free))))
    (:durative-action unstack :parameters (?x ?y) :duration (= ?duration 3)
     :condition (and (at start (on ?x ?y)) (at start (clear ?x)) (at start (free)))
     :effect (and (at start (not (free))) (at start (not (clear ?x))) (at end (not (on ?x ?y))) (at end (held ?x)) (at end (clear ?y)))))",
                   R"((:objects a b c) (:init (table a) (table b) (table c) (clear a) (clear b) (clear c) (free))
    (:goal (and (on a b) (on b a))))"));
  EXPECT_EQ(found.status, PlanStatus::kUnsolvable);
}

TEST(FindPlan, StatesThatDifferOnlyInUnreadCostsAreOne) {
  // Three tiles on a ring of four places only go round: two of them never change their order.
  const PlanAnswer found =
      answer(parse(R"((:predicates (at ?t ?p) (empty ?p) (next ?p ?q)) (:functions (total-cost))
    (:action slide :parameters (?t ?p ?q) :precondition (and (at ?t ?p) (empty ?q) (next ?p ?q))
     :effect (and (at ?t ?q) (empty ?p) (not (at ?t ?p)) (not (empty ?q)) (increase (total-cost) 1))))",
                   R"((:objects a b c n e s w) (:init (at a n) (at b e) (at c s) (empty w) (= (total-cost) 0)
     (next n e) (next e s) (next s w) (next w n) (next e n) (next s e) (next w s) (next n w))
    (:goal (and (at b n) (at a e) (at c s))) (:metric minimize (total-cost)))"),
             {.budget = 100'000});
  EXPECT_EQ(found.status, PlanStatus::kUnsolvable);
  EXPECT_GT(found.units, 20);  // not by facts in pairs
}

TEST(FindPlan, WithoutDurationsOneSearchThroughAllOrdersIsTheProof) {
  // Five tiles on a board of two by three: half of the 720 states can be reached.
  const PlanAnswer found = answer(parse(R"((:predicates (at ?t ?p) (empty ?p) (next ?p ?q))
    (:action slide :parameters (?t ?p ?q) :precondition (and (at ?t ?p) (empty ?q) (next ?p ?q))
     :effect (and (at ?t ?q) (empty ?p) (not (at ?t ?p)) (not (empty ?q)))))",
                                        R"((:objects a b c d e p1 p2 p3 p4 p5 p6)
    (:init (at a p1) (at b p2) (at c p3) (at d p4) (at e p5) (empty p6)
     (next p1 p2) (next p2 p1) (next p2 p3) (next p3 p2) (next p4 p5) (next p5 p4) (next p5 p6) (next p6 p5)
     (next p1 p4) (next p4 p1) (next p2 p5) (next p5 p2) (next p3 p6) (next p6 p3))
    (:goal (and (at b p1) (at a p2) (at c p3) (at d p4) (at e p5))))"));
  EXPECT_EQ(found.status, PlanStatus::kUnsolvable);
  EXPECT_EQ(found.reason, "no order of actions reaches the goal");
}

TEST(FindPlan, EndsWithoutProofWhereOnlyTimesRuleOutPlans) {
  const std::string domain = R"((:predicates (lit) (done))
    (:durative-action flash :parameters () :duration (= ?duration 1) :condition () :effect (and (at start (lit)) (at end (not (lit)))))
    (:durative-action work :parameters () :duration (= ?duration 2) :condition (over all (lit)) :effect (at end (done))))";
  EXPECT_EQ(answer(parse(domain, "(:init) (:goal (done))")).status, PlanStatus::kEnded);
}

TEST(FindPlan, ReportsThatTheBudgetEnded) {
  std::string objects = "(:objects";
  std::string init;
  for (int i = 0; i < 14; ++i) {
    objects += " o" + std::to_string(i);
    init += " (item o" + std::to_string(i) + ")";
  }
  const PlanAnswer found = answer(
      parse(kLamp, objects + ") (:init (dark) (free)" + init + ") (:goal (forall (?i) (done ?i)))"), {.budget = 300});
  EXPECT_EQ(found.status, PlanStatus::kBudget);
  EXPECT_GE(found.units, 300);
}

/// Objects o0 ... of which fact (p o) holds.
std::string numbered(int count) {
  std::string objects = "(:objects", init;
  for (int i = 0; i < count; ++i) {
    objects += " o" + std::to_string(i);
    init += " (p o" + std::to_string(i) + ")";
  }
  return objects + ") (:init (next o0 o1)" + init + ")";
}

TEST(FindPlan, TheBudgetCanEndDuringGrounding) {
  std::string different;  // twelve of eleven objects are never all different
  for (char a = 'a'; a <= 'l'; ++a)
    for (char b = 'a'; b < a; ++b) different += std::string(" (not (= ?") + a + " ?" + b + "))";
  const std::string five = "(?a ?b ?c ?d ?e)", all = "(p ?a) (p ?b) (p ?c) (p ?d) (p ?e)";
  const std::pair<std::string, int> actions[] = {
      {"(:action a :parameters " + five + " :precondition (and " + all + ") :effect (and (g) (made ?a ?b ?c ?d ?e)))",
       60},
      {"(:action a :parameters (?a ?b ?c ?d ?e ?f ?g ?h ?i ?j ?k ?l) :precondition (and " + all + different +
           ") :effect (g)) (:action b :parameters () :effect (g))",
       11},
      {"(:action a :parameters () :effect (and (g) (forall " + five + " (made ?a ?b ?c ?d ?e))))", 60},
      {"(:action a :parameters (?x) :precondition (forall " + five +
           " (or (p ?a) (made ?a ?b ?c ?d ?e))) :effect (and (g) (made ?x ?x ?x ?x ?x) (not (p ?x))))",
       60}};
  for (const auto& [action, objects] : actions) {
    const Task task = parse("(:predicates (p ?x) (next ?x ?y) (g) (made ?a ?b ?c ?d ?e))" + action,
                            numbered(objects) + "(:goal (or (g) (made o1 o2 o3 o4 o5)))");
    const PlanAnswer found = answer(task, {.budget = 5'000}), again = answer(task, {.budget = 5'000});
    EXPECT_EQ(found.status, PlanStatus::kBudget) << action;
    EXPECT_EQ(found.reason, "the budget ended while the problem was written out") << action;
    EXPECT_LE(found.units, 5'100) << action;
    EXPECT_EQ(found.units, again.units) << action;
  }
}

TEST(FindPlan, GroundingCountsAsWork) {
  const auto units = [](int objects) {
    return answer(parse("(:predicates (p ?x) (next ?x ?y) (g)) (:action a :parameters (?a ?b) :precondition (and (p "
                        "?a) (p ?b)) :effect (and (next ?a ?b) (g)))",
                        numbered(objects) + "(:goal (g))"))
        .units;
  };
  EXPECT_GT(units(60), 3 * units(30));
}

TEST(FindPlan, ATimeoutOfZeroEndsAtOnce) {
  const PlanAnswer found = answer(
      parse("(:predicates (g)) (:action a :parameters () :effect (g))", "(:init) (:goal (g))"), {.timeout_s = 0.0});
  EXPECT_EQ(found.status, PlanStatus::kBudget);
  EXPECT_FALSE(found.plan);
}

constexpr const char* kJobs =
    R"((:types job machine - object) (:predicates (waits ?j - job) (at ?j - job ?m - machine) (free ?m - machine) (done ?j - job))
  (:durative-action load :parameters (?j - job ?m - machine) :duration (= ?duration 2) :condition (and (at start (waits ?j)) (at start (free ?m)))
   :effect (and (at start (not (waits ?j))) (at start (not (free ?m))) (at end (at ?j ?m))))
  (:durative-action work :parameters (?j - job ?m - machine) :duration (= ?duration 5) :condition (at start (at ?j ?m))
   :effect (and (at start (not (at ?j ?m))) (at end (free ?m)) (at end (done ?j)))))";
constexpr const char* kSixJobs = R"((:objects j1 j2 j3 j4 j5 j6 - job m1 m2 m3 - machine)
  (:init (waits j1) (waits j2) (waits j3) (waits j4) (waits j5) (waits j6) (free m1) (free m2) (free m3))
  (:goal (forall (?j - job) (done ?j))))";

TEST(FindPlan, ImprovesUntilTheBudgetEnds) {
  const Task task = parse(kJobs, kSixJobs);
  const PlanAnswer found = answer(task, {.budget = 500'000, .anytime = true});
  ASSERT_TRUE(found.plan);
  EXPECT_NEAR(found.plan->makespan_s, 14.0, 0.02);  // two rounds on three machines
  EXPECT_LE(found.lower_bound_s, found.plan->makespan_s);
}

TEST(FindPlan, SameBudgetSamePlan) {
  const Task task = parse(kJobs, kSixJobs);
  const PlanOptions options{.budget = 200'000, .anytime = true};
  const PlanAnswer once = answer(task, options), again = answer(task, options);
  ASSERT_TRUE(once.plan && again.plan);
  EXPECT_EQ(to_text(once.plan->steps, task.domain, task.problem),
            to_text(again.plan->steps, task.domain, task.problem));
  EXPECT_EQ(once.units, again.units);
}

TEST(FindPlan, EveryReportedPlanIsBetterThanTheLast) {
  const Task task = parse(kJobs, kSixJobs);
  std::vector<double> reported;
  PlanOptions options{.budget = 300'000, .anytime = true};
  options.on_plan = [&](const TimedPlan& plan, std::int64_t) { reported.push_back(plan.makespan_s); };
  const PlanAnswer found = answer(task, options);
  ASSERT_FALSE(reported.empty());
  EXPECT_TRUE(std::ranges::is_sorted(reported, std::greater_equal<>{}));
  EXPECT_EQ(reported.back(), found.plan->makespan_s);
}

TEST(FindPlan, PlansShiftedWithinThePartialOrderAreValid) {
  const Task task = parse(kJobs, kSixJobs);
  const PlanAnswer found = answer(task, {.budget = 200'000, .anytime = true});
  ASSERT_TRUE(found.plan);
  Plan late = found.plan->steps;
  for (std::size_t i = 0; i < late.size(); ++i)
    late[i].start = static_cast<double>(found.plan->latest[2 * i]) / kMicrosPerSecond;
  const Expected<Verdict> verdict = Validator(task.domain, task.problem).check(late);
  EXPECT_TRUE(verdict && verdict->valid) << (verdict ? verdict->violation->message : verdict.error().text());
}

TEST(FindPlan, ContinuesAPlanUnderExecution) {
  const Task before = parse(kJobs, kSixJobs);
  const PlanAnswer first = answer(before);
  ASSERT_TRUE(first.plan);
  const Task now = parse(kJobs, R"((:objects j1 j2 j3 j4 j5 j6 - job m1 m2 m3 - machine)
    (:init (waits j2) (waits j3) (waits j4) (waits j5) (waits j6) (at j1 m1) (free m2) (free m3)) (:goal (forall (?j - job) (done ?j))))");
  const PlanAnswer second = answer(now, {.budget = 200'000, .warm_start = first.plan->steps});
  ASSERT_TRUE(second.plan);
  EXPECT_EQ(second.plan->steps.size(), 11u);
}

constexpr const char* kErrands = R"((:types place) (:predicates (at ?p - place) (shop ?p - place) (bought ?p - place))
  (:durative-action go :parameters (?from ?to - place) :duration (= ?duration 5)
    :condition (at start (at ?from)) :effect (and (at start (not (at ?from))) (at end (at ?to))))
  (:durative-action buy :parameters (?p - place) :duration (= ?duration 1)
    :condition (and (over all (at ?p)) (at start (shop ?p))) :effect (at end (bought ?p))))";

TEST(FindPlan, OfAWarmStartOnlyWhatIsLeftIsKept) {
  const std::string objects = "(:objects home s1 s2 - place) (:init (shop s1) (shop s2) ";
  const std::string goal = ") (:goal (and (bought s1) (bought s2) (at home)))";
  const auto steps_of = [&](const std::string& now, const Plan& warm) {
    const Task task = parse(kErrands, (objects + now + goal).c_str());
    const PlanAnswer found = answer(task, {.warm_start = warm});
    EXPECT_TRUE(found.plan);
    std::string text;
    for (const PlanStep& step : found.plan->steps) text += step_text(step, task.domain, task.problem);
    return text;
  };
  const auto step = [](ActionId action, std::vector<ObjectId> arguments) {
    return PlanStep{0, action, std::move(arguments), 1};
  };
  const Plan plan = {step(0, {0, 1}), step(1, {1}), step(0, {1, 0}), step(0, {0, 2}), step(1, {2}), step(0, {2, 0})};
  EXPECT_EQ(steps_of("(at home)", plan), "(go home s1)(buy s1)(go s1 home)(go home s2)(buy s2)(go s2 home)")
      << "the plan stays as it was";
  EXPECT_EQ(steps_of("(at home) (bought s1)", plan), "(go home s2)(buy s2)(go s2 home)")
      << "what was done could be done again";
  EXPECT_EQ(steps_of("(at s1) (bought s2)", plan), "(buy s1)(go s1 home)") << "a step was done by somebody else";
  EXPECT_EQ(steps_of("(at home) (bought s1) (bought s2)", plan), "");
}

/// Parcels by air, quick and dear, or by road, slow and cheap; several go at once.
constexpr const char* kParcels = R"((:predicates (waits ?p) (there ?p)) (:functions (total-cost) (fuel-used))
  (:durative-action fly :parameters (?p) :duration (= ?duration 2) :condition (at start (waits ?p))
   :effect (and (at start (not (waits ?p))) (at end (there ?p)) (at end (increase (total-cost) 9)) (at end (increase (fuel-used) 6))))
  (:durative-action drive :parameters (?p) :duration (= ?duration 7) :condition (at start (waits ?p))
   :effect (and (at start (not (waits ?p))) (at end (there ?p)) (at end (increase (total-cost) 2)) (at end (increase (fuel-used) 1)))))";

PlanAnswer send_parcels(const std::string& metric) {
  return answer(parse(kParcels,
                      "(:objects a b c) (:init (waits a) (waits b) (waits c) (= (total-cost) 0) (= (fuel-used) 0)) "
                      "(:goal (and (there a) (there b) (there c)))" +
                          metric),
                {.budget = 300'000, .anytime = true});
}

TEST(Metric, WithoutOneTheShortestPlanIsTheBest) {
  const PlanAnswer found = send_parcels("");
  EXPECT_FALSE(found.by_metric);
  EXPECT_NEAR(found.plan->makespan_s, 2.0, 0.01);
}

TEST(Metric, CostAloneTakesTheSlowWay) {
  const PlanAnswer found = send_parcels("(:metric minimize (total-cost))");
  EXPECT_TRUE(found.by_metric);
  EXPECT_DOUBLE_EQ(found.plan->metric.value(), 6.0);
  EXPECT_NEAR(found.plan->makespan_s, 7.0, 0.01);  // the shortest of the cheapest
}

TEST(Metric, WeighsTimeAndFuelTogether) {
  // All by road: 2 * 7 + 3 = 17; all by air: 2 * 2 + 18 = 22; one by air changes fuel only.
  EXPECT_NEAR(send_parcels("(:metric minimize (+ (* 2 (total-time)) (fuel-used)))").plan->metric.value(), 17.0, 0.01);
  // All by air: 4 * 2 + 18 = 26; all by road: 4 * 7 + 3 = 31.
  EXPECT_NEAR(send_parcels("(:metric minimize (+ (* 4 (total-time)) (fuel-used)))").plan->metric.value(), 26.0, 0.01);
}

TEST(Metric, TheBoundIsThatOfTheMakespanTimesItsWeight) {
  const PlanAnswer found = send_parcels("(:metric minimize (+ (* 4 (total-time)) (fuel-used)))");
  ASSERT_TRUE(found.metric_bound);
  EXPECT_DOUBLE_EQ(*found.metric_bound, 4 * found.lower_bound_s);
  EXPECT_GT(*found.metric_bound, 0.0);
  const PlanAnswer unweighted = send_parcels("(:metric minimize (- (fuel-used) (total-time)))");
  EXPECT_FALSE(unweighted.metric_bound);  // waiting makes it better without end
}

TEST(Metric, AMultipleOfTheMakespanIsTheMakespan) {
  const PlanAnswer found = send_parcels("(:metric minimize (+ (* 3 (total-time)) 5))");
  EXPECT_FALSE(found.by_metric);
  EXPECT_NEAR(found.plan->metric.value(), 3 * found.plan->makespan_s + 5, 1e-9);
  EXPECT_NEAR(found.metric_bound.value(), 11.0, 1e-9);
}

TEST(Metric, AMaximizedNumberGrowsBeyondTheGoal) {
  const Task task = parse(R"((:predicates (ripe ?t) (home) (basket)) (:functions (apples))
    (:durative-action pick :parameters (?t) :duration (= ?duration 1) :condition (and (at start (ripe ?t)) (at start (basket)))
     :effect (and (at start (not (ripe ?t))) (at end (increase (apples) 3))))
    (:durative-action sell :parameters () :duration (= ?duration 1) :condition (at start (basket))
     :effect (and (at start (not (basket))) (at end (increase (apples) 4)))))",
                          "(:objects x y z) (:init (ripe x) (ripe y) (ripe z) (basket) (home) (= (apples) 0)) (:goal "
                          "(home)) (:metric maximize (apples))");
  const PlanAnswer found = answer(task, {.budget = 300'000, .anytime = true});
  EXPECT_DOUBLE_EQ(found.plan->metric.value(), 13.0);  // three trees, then the basket is sold
  EXPECT_FALSE(found.metric_bound);
}

TEST(Metric, TheSameBudgetGivesTheSamePlan) {
  const std::string metric = "(:metric minimize (+ (* 2 (total-time)) (fuel-used)))";
  const PlanAnswer first = send_parcels(metric), second = send_parcels(metric);
  EXPECT_EQ(first.units, second.units);
  ASSERT_EQ(first.plan->steps.size(), second.plan->steps.size());
  for (std::size_t i = 0; i < first.plan->steps.size(); ++i) {
    EXPECT_EQ(first.plan->steps[i].arguments, second.plan->steps[i].arguments);
    EXPECT_EQ(first.plan->steps[i].start, second.plan->steps[i].start);
  }
}

}  // namespace
}  // namespace cxlab::planner
