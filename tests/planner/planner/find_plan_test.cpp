// Problems that need one feature each.

#include <gtest/gtest.h>

#include "answers.h"
#include "lamp.h"

namespace cxlab::planner {
namespace {

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

TEST(FindPlan, APlanEndsWithItsLastActionThoughAnEventBringsAboutTheGoalLater) {
  const PlanAnswer found = answer(parse(R"((:predicates (day) (awake))
    (:durative-action rise :parameters () :duration (= ?duration 1) :condition () :effect (at end (awake))))",
                                        "(:init (at 6 (day))) (:goal (and (day) (awake)))"));
  ASSERT_TRUE(found.plan);
  EXPECT_EQ(found.plan->makespan_s, 1.0);
}

TEST(FindPlan, AGoalThatAnEventUndoesAfterwardsDoesNotCount) {
  const std::string domain = R"((:predicates (lit))
    (:durative-action light :parameters () :duration (= ?duration 1) :condition () :effect (at end (lit))))";
  for (const char* init : {"(:init (at 6 (not (lit))))", "(:init (lit) (at 6 (not (lit))))"}) {
    const PlanAnswer found = answer(parse(domain, std::string(init) + " (:goal (lit))"));
    ASSERT_TRUE(found.plan) << init;
    EXPECT_GT(found.plan->makespan_s, 6.0);
  }
  EXPECT_EQ(answer(parse(domain, "(:init (at 6 (not (lit))) (at 7 (lit))) (:goal (lit))")).plan->makespan_s, 0.0);
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
  EXPECT_EQ(answer(parse(start_and_end + "(at end (a)))", "(:init) (:goal (and (a) (b)))")).status,
            PlanStatus::kUnsolvable)
      << "its end would read what its start changes at the same instant";
}

TEST(FindPlan, SeveralActionsInTurnKeepAnExistentialConditionTrue) {
  const PlanAnswer found = answer(parse(R"((:predicates (on ?l) (fresh ?l) (done))
    (:durative-action light :parameters (?l) :duration (= ?duration 3) :condition (at start (fresh ?l))
     :effect (and (at start (not (fresh ?l))) (at start (on ?l)) (at end (not (on ?l)))))
    (:durative-action work :parameters () :duration (= ?duration 5) :condition (over all (exists (?l) (on ?l))) :effect (at end (done))))",
                                        "(:objects l1 l2) (:init (fresh l1) (fresh l2)) (:goal (done))"));
  ASSERT_TRUE(found.plan);
  EXPECT_NEAR(found.plan->makespan_s, 5, 0.002);
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

}  // namespace
}  // namespace cxlab::planner
