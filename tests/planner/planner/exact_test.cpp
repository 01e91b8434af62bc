// Numbers and times are what they are: large, decimal, 0.

#include <gtest/gtest.h>

#include <algorithm>

#include "answers.h"

namespace cxlab::planner::exact_test {
namespace {

/// The names of the steps; or how it ended.
std::string steps(const Task& task, std::int64_t budget = 500'000) {
  const PlanAnswer found = answer(task, {.budget = budget});
  if (!found.plan) return found.status == PlanStatus::kUnsolvable ? "unsolvable" : "no answer: " + found.reason;
  std::string names;
  for (const PlanStep& step : found.plan->steps)
    names += (names.empty() ? "" : " ") + task.domain.actions[step.action].name;
  return names;
}

TEST(ExactNumbers, NeighboursAreTwoNumbers) {
  const char* domain = R"((:predicates (done)) (:functions (a) (b))
    (:action less :precondition (< (a) (b)) :effect (done))
    (:action same :precondition (= (a) (b)) :effect (done))
    (:action other :precondition (and (not (= (a) (b))) (>= (a) (b))) :effect (done))
    (:action touch :precondition (done) :effect (and (increase (a) 0) (increase (b) 0))))";
  const auto compare = [&](const std::string& a, const std::string& b) {
    return steps(parse(domain, "(:init (= (a) " + a + ") (= (b) " + b + ")) (:goal (done))"));
  };
  EXPECT_EQ(compare("1700000000", "1700000001"), "less");
  EXPECT_EQ(compare("4200000002", "4200000001"), "other");
  EXPECT_EQ(compare("9007199254740991", "9007199254740992"), "less");
  EXPECT_EQ(compare("1000000000.5", "1000000000.499999"), "other");
  EXPECT_EQ(compare("1e-12", "2e-12"), "less");
  EXPECT_EQ(compare("7", "7.0"), "same");
  EXPECT_EQ(compare("-1700000001", "-1700000000"), "less");
}

TEST(ExactNumbers, IncrementsAreCounted) {
  const auto count = [](const std::string& start, const std::string& by, const std::string& goal) {
    const std::string names = steps(parse("(:functions (x)) (:action up :effect (increase (x) " + by + "))",
                                          "(:init (= (x) " + start + ")) (:goal " + goal + ")"));
    return names.empty() ? 0 : std::ranges::count(names, ' ') + 1;
  };
  EXPECT_EQ(count("1000000000", "1", "(>= (x) 1000000010)"), 10);
  EXPECT_EQ(count("0", "0.1", "(>= (x) 1)"), 10);
  EXPECT_EQ(count("0", "0.1", "(> (x) 1)"), 11);
  EXPECT_EQ(count("0.3", "0.1", "(= (x) 0.6)"), 3);
  EXPECT_EQ(count("1700000000.1", "0.1", "(>= (x) 1700000000.5)"), 4);
  EXPECT_EQ(count("0", "(/ 1 3)", "(>= (x) 2)"), 6) << "thirds";
}

TEST(ExactNumbers, ADifferenceThatIsSmallBesideItsNumbersStillCounts) {
  EXPECT_EQ(steps(parse(R"((:predicates (done)) (:functions (x) (y))
    (:action up :effect (increase (x) 1))
    (:action go :precondition (> (- (x) (y)) 0) :effect (done)))",
                        "(:init (= (x) 4200000001) (= (y) 4200000001)) (:goal (done))")),
            "up go");
}

TEST(ExactNumbers, ALargeMetricIsMadeSmallerByOne) {
  PlanOptions options{.budget = 300'000};
  options.anytime = true;
  const PlanAnswer found = answer(parse(R"((:predicates (done)) (:functions (cost))
    (:action dear :effect (and (done) (increase (cost) 1700000001)))
    (:action cheap :effect (and (done) (increase (cost) 1700000000))))",
                                        "(:init (= (cost) 0)) (:goal (done)) (:metric minimize (cost))"),
                                  options);
  ASSERT_TRUE(found.plan);
  EXPECT_EQ(found.plan->metric, 1700000000);
}

TEST(ExactNumbers, LongSumsAreNumbers) {
  std::string sum = "(x)";
  for (int i = 0; i < 150; ++i) sum = "(+ 1 " + sum + ")";
  EXPECT_EQ(steps(parse("(:predicates (done)) (:functions (x)) (:action up :effect (increase (x) 1))"
                        " (:action go :precondition (>= " +
                            sum + " 152) :effect (done))",
                        "(:init (= (x) 0)) (:goal (done))")),
            "up up go");
}

constexpr const char* kGate = R"((:predicates (shut) (open) (done) (ready)) (:functions (length)))";

TEST(ExactNumbers, WhatAnActionChangesAtItsStartCountsForItsOtherConditions) {
  for (const auto& [when, other] : {std::pair{"at end", ""}, {"over all", ""}, {"at end", "(at start (<= (n) 9))"}})
    for (const auto& [n, found] : {std::pair{"0", "load"}, {"1", "unsolvable"}})
      EXPECT_EQ(steps(parse(std::string(R"((:predicates (done)) (:functions (n))
    (:durative-action load :parameters () :duration (= ?duration 2) :condition (and )") +
                                other + "(" + when +
                                R"( (<= (n) 1))) :effect (and (at start (increase (n) 1)) (at end (done)))))",
                            std::string("(:init (= (n) ") + n + ")) (:goal (done))")),
                found)
          << when << other;
}

TEST(NoDuration, NothingIsAskedOverAll) {
  const auto plan = [](const std::string& duration, const std::string& more = "", double length = 0) {
    return steps(parse(kGate + std::string("(:durative-action go :parameters () :duration ") + duration +
                           " :condition (over all (open)) :effect (at end (done)))" + more,
                       "(:init (shut) (= (length) " + std::to_string(length) + ")) (:goal (done))"));
  };
  EXPECT_EQ(plan("(= ?duration 0)"), "go");
  EXPECT_EQ(plan("(>= ?duration 0)"), "go");
  EXPECT_EQ(plan("(<= ?duration 5)"), "go");
  EXPECT_EQ(plan("()"), "go");
  EXPECT_EQ(plan("(= ?duration (length))"), "go");
  EXPECT_EQ(plan("(= ?duration (* 2 (length)))", "(:action set :effect (assign (length) 0))"), "go");
  EXPECT_EQ(plan("(= ?duration (length))", "(:action clear :effect (assign (length) 0))", 3), "clear go");
  EXPECT_EQ(plan("(= ?duration (length))", "", 3), "unsolvable");
  EXPECT_EQ(plan("(= ?duration 1)"), "unsolvable");
  EXPECT_EQ(plan("(= ?duration -3)"), "unsolvable");
  EXPECT_EQ(plan("(= ?duration (- 0 (length)))", "(:action set :effect (assign (length) 2))", 3), "unsolvable");
  EXPECT_EQ(plan("(and (>= ?duration 0) (>= ?duration 0.5))"), "unsolvable");
  EXPECT_EQ(plan("(at end (= ?duration 0))"), "go");
}

TEST(NoDuration, ConditionsOfStartAndEndStillCount) {
  const auto plan = [](const std::string& condition, const std::string& effect) {
    return steps(parse(kGate +
                           std::string("(:durative-action go :parameters () :duration (= ?duration 0) :condition ") +
                           condition + " :effect " + effect + ") (:action prepare :effect (ready))",
                       "(:init (shut)) (:goal (done))"));
  };
  EXPECT_EQ(plan("(and (at start (ready)) (over all (open)))", "(at end (done))"), "prepare go");
  EXPECT_EQ(plan("(and (at end (ready)) (over all (open)))", "(at start (done))"), "prepare go");
  EXPECT_EQ(plan("(at end (open))", "(at end (done))"), "unsolvable");
  EXPECT_EQ(plan("(and)", "(and (at start (not (shut))) (at end (done)))"), "go");
}

TEST(NoDuration, BeginningAndEndMustNotInterfere) {
  const auto plan = [](const std::string& condition, const std::string& effect) {
    return steps(parse(kGate +
                           std::string("(:durative-action go :parameters () :duration (= ?duration 0) :condition ") +
                           condition + " :effect " + effect + ")",
                       "(:init (shut) (= (length) 0)) (:goal (done))"));
  };
  EXPECT_EQ(plan("(at end (ready))", "(and (at start (ready)) (at end (done)))"), "unsolvable");
  EXPECT_EQ(plan("(and)", "(and (at start (done)) (at end (not (done))))"), "unsolvable");
  EXPECT_EQ(plan("(and)", "(and (at start (not (shut))) (at end (shut)) (at end (done)))"), "unsolvable");
  EXPECT_EQ(plan("(at end (not (open)))", "(and (at start (not (open))) (at end (done)))"), "unsolvable");
  EXPECT_EQ(plan("(at end (>= (length) 0))", "(and (at start (increase (length) 1)) (at end (done)))"), "unsolvable");
  EXPECT_EQ(plan("(and)", "(and (at start (increase (length) 1)) (at end (increase (length) 1)) (at end (done)))"),
            "go");
}

TEST(NoDuration, BeginningAndEndInterfereOnlyWhereTheirEffectsComeAbout) {
  const std::string domain =
      "(:predicates (armed) (inside)) (:durative-action enter :parameters () :duration (= ?duration 0) :condition () "
      ":effect (and (at start (inside)) (when (at end (armed)) (at end (not (inside)))))) ";
  const char* problem = "(:init (armed)) (:goal (inside))";
  EXPECT_EQ(steps(parse(domain + "(:action disarm :precondition (armed) :effect (not (armed)))", problem)),
            "disarm enter");
  EXPECT_EQ(steps(parse(domain + "(:action rearm :effect (armed))", problem)), "unsolvable");
}

TEST(NoDuration, TheEndMayNeedWhatTheBeginningDidOneSeparationBefore) {
  for (const auto& [duration, found] : {std::pair{"0.0005", "unsolvable"}, {"0.001001", "go"}, {"0.002", "go"}})
    EXPECT_EQ(
        steps(parse(kGate + std::string("(:durative-action go :parameters () :duration (= ?duration ") + duration +
                        ") :condition (at end (ready)) :effect (and (at start (ready)) (at end (done))))",
                    "(:init (shut) (= (length) 0)) (:goal (done))")),
        found)
        << duration;
}

TEST(NoDuration, EffectsWithAConditionOverAllComeAbout) {
  EXPECT_EQ(
      steps(parse(kGate + std::string("(:durative-action go :parameters () :duration (= ?duration 0) :condition ()"
                                      " :effect (when (over all (open)) (at end (done))))"),
                  "(:init (shut)) (:goal (done))")),
      "go");
}

TEST(Events, WhatHappensAt0ComesAfterTheBeginning) {
  const PlanAnswer found = answer(parse("(:predicates (p) (q) (done)) (:action go :precondition (p) :effect (done))",
                                        "(:init (at 0 (p)) (q) (at 0 (not (q)))) (:goal (and (done) (not (q))))"));
  ASSERT_TRUE(found.plan) << found.reason;
  EXPECT_NEAR(found.plan->steps.at(0).start, 0.001, 0.0001);
  const char* number = "(:predicates (done)) (:functions (x)) (:action buy :precondition (<= (x) 3) :effect (done))";
  EXPECT_EQ(steps(parse(number, "(:init (= (x) 9) (at 0 (= (x) 3))) (:goal (done))")), "buy");
}

TEST(Events, UnixTimesArePlanned) {
  const PlanAnswer found = answer(parse(R"((:predicates (open) (done))
    (:durative-action work :parameters () :duration (= ?duration 60) :condition (over all (open)) :effect (at end (done))))",
                                        "(:init (at 1700000000 (open)) (at 1700000100 (not (open)))) (:goal (done))"));
  ASSERT_TRUE(found.plan) << found.reason;
  EXPECT_NEAR(found.plan->steps.at(0).start, 1700000000, 0.01);
}

TEST(Grounding, AnActionOfTooManyCombinationsEndsWithinTheBudget) {
  std::string objects = "(:objects";
  for (int i = 0; i < 60; ++i) objects += " o" + std::to_string(i);
  const char* six = "(?a ?b ?c ?d ?e ?f)";
  const auto ends = [&](const std::string& domain) {
    const PlanAnswer found =
        answer(parse("(:constants o1) (:predicates (p ?a ?b ?c ?d ?e ?f) (q ?a) (far) (done))" + domain,
                     objects + ") (:init (q o1)) (:goal (done))"),
               {.budget = 50'000});
    EXPECT_LT(found.units, 200'000) << domain;
    return found.status;
  };
  const std::string all = six;
  EXPECT_EQ(ends("(:action go :parameters " + all + " :precondition (not (p ?a ?b ?c ?d ?e ?f)) :effect (done))"),
            PlanStatus::kBudget);
  EXPECT_EQ(ends("(:action go :precondition (exists " + all +
                 " (and (q ?a) (not (p ?a ?b ?c ?d ?e ?f)))) :effect (done))"
                 "(:action put :parameters " +
                 all + " :effect (p ?a ?b ?c ?d ?e ?f))"),
            PlanStatus::kBudget);
  EXPECT_EQ(ends("(:action go :precondition (q o1) :effect (and (done) (forall " + all +
                 " (p ?a ?b ?c ?d ?e ?f))))"
                 "(:action see :parameters " +
                 all + " :precondition (p ?a ?b ?c ?d ?e ?f) :effect (q ?a))"),
            PlanStatus::kBudget);
  EXPECT_EQ(ends("(:derived (far) (exists " + all +
                 " (and (q ?a) (not (= ?b ?c)) (p ?a ?b ?c ?d ?e ?f))))"
                 "(:action put :parameters " +
                 all +
                 " :effect (p ?a ?b ?c ?d ?e ?f))"
                 "(:action go :precondition (far) :effect (done))"),
            PlanStatus::kBudget);
}

}  // namespace
}  // namespace cxlab::planner::exact_test
