#include "planner/bounds/lower_bound.h"

#include <gtest/gtest.h>

#include "planner/ground/ground.h"
#include "planner/pddl/parser.h"
#include "planner/validator/validator.h"

namespace cxlab::planner::lower_bound_test {

namespace {

Task parse(const std::string& domain_body, const std::string& problem_body) {
  Expected<Domain> domain = parse_domain(
      "(define (domain d) (:requirements :durative-actions :typing :negative-preconditions :conditional-effects)" +
          domain_body + ")",
      "d.pddl");
  EXPECT_TRUE(domain) << domain.error().text();
  Expected<Problem> problem = parse_problem("(define (problem p) (:domain d) " + problem_body + ")", "p.pddl", *domain);
  EXPECT_TRUE(problem) << problem.error().text();
  return {std::move(*domain), std::move(*problem)};
}

LowerBound bound_of(const Task& task, std::int64_t slice = 1'000'000) {
  const Expected<GroundTask> made = ground(task);
  EXPECT_TRUE(made);
  Budget budget;
  return lower_bound(*made, budget, slice);
}

double seconds(const LowerBound& bound) { return static_cast<double>(bound.makespan) / kMicrosPerSecond; }

// An oven is filled, works and must be emptied before the next piece.
constexpr const char* kOven =
    R"((:types piece - object) (:predicates (raw ?p - piece) (in ?p - piece) (empty) (baked ?p - piece) (out ?p - piece))
  (:durative-action fill :parameters (?p - piece) :duration (= ?duration 2) :condition (and (at start (raw ?p)) (over all (empty)))
   :effect (and (at start (not (raw ?p))) (at end (in ?p)) (at end (not (empty)))))
  (:durative-action bake :parameters (?p - piece) :duration (= ?duration 10) :condition (and (at start (in ?p)))
   :effect (and (at end (baked ?p))))
  (:durative-action take :parameters (?p - piece) :duration (= ?duration 3) :condition (and (at start (baked ?p)) (at start (in ?p)))
   :effect (and (at start (not (in ?p))) (at end (out ?p)) (at end (empty)))))";
constexpr const char* kTwoPieces =
    "(:objects a b - piece) (:init (raw a) (raw b) (empty)) (:goal (and (out a) (out b)))";

}  // namespace

TEST(LowerBound, PiecesThatShareAPlaceComeOneAfterTheOther) {
  EXPECT_EQ(seconds(bound_of(parse(kOven, kTwoPieces))), 30);
}

TEST(LowerBound, DoesNotBeginWhereTheSliceIsTooShortForOneRound) {
  std::string pieces, raw, out;
  for (int i = 0; i < 60; ++i) {
    const std::string piece = " p" + std::to_string(i);
    pieces += piece;
    raw += " (raw" + piece + ")";
    out += " (out" + piece + ")";
  }
  const Expected<GroundTask> made =
      ground(parse(kOven, "(:objects" + pieces + " - piece) (:init (empty)" + raw + ") (:goal (and" + out + "))"));
  ASSERT_TRUE(made);
  Budget budget;
  EXPECT_FALSE(lower_bound(*made, budget, 100).complete);
  EXPECT_LT(budget.units(), 100);
}

TEST(LowerBound, ReportsThatActionsThatEndTogetherWouldBeShorter) {
  const Task task = parse(kOven, kTwoPieces);
  EXPECT_TRUE(bound_of(task).assumes_order);
  const auto step = [&](double start, ActionId action, ObjectId piece, double duration) {
    return PlanStep{start, action, {piece}, duration, 0};
  };
  // PDDL 2.1 spares the instant of the end: both fill the oven at once.
  const Plan plan = {step(0, 0, 0, 2),     step(0, 0, 1, 2),     step(2.01, 1, 0, 10),
                     step(2.01, 1, 1, 10), step(12.02, 2, 0, 3), step(12.02, 2, 1, 3)};
  const Expected<Verdict> verdict = Validator(task.domain, task.problem).check(plan);
  ASSERT_TRUE(verdict);
  EXPECT_TRUE(verdict->valid);
}

TEST(LowerBound, AssumesNothingWhereTheFirstActionTakesThePlaceAtItsStart) {
  std::string domain = kOven;
  domain.replace(domain.find("(over all (empty))"), 18, "(at start (empty))");
  domain.replace(domain.find("(at end (not (empty)))"), 22, "(at start (not (empty)))");
  const LowerBound bound = bound_of(parse(domain, kTwoPieces));
  EXPECT_EQ(seconds(bound), 30);
  EXPECT_FALSE(bound.assumes_order);
}

TEST(LowerBound, ConditionalEffectsOfOneActionComeTogether) {
  const std::string domain = R"((:predicates (p) (c1) (c2) (x) (y) (done))
    (:durative-action prepare :parameters () :duration (= ?duration 1) :condition () :effect (and (at end (c1)) (at end (c2))))
    (:durative-action both :parameters () :duration (= ?duration 1) :condition (and (at start (p)) (at end (p)))
     :effect (and (at end (not (p))) (when (at end (c1)) (at end (x))) (when (at end (c2)) (at end (y)))))
    (:durative-action finish :parameters () :duration (= ?duration 1) :condition (and (at start (x)) (at start (y))) :effect (at end (done)))
    (:durative-action crawl :parameters () :duration (= ?duration 50) :condition () :effect (at end (done))))";
  EXPECT_EQ(seconds(bound_of(parse(domain, "(:init (p)) (:goal (done))"))), 2);
}

TEST(LowerBound, OneActionMayOverlapItself) {
  const std::string domain = R"((:predicates (here) (x) (y) (fresh))
    (:durative-action paint :parameters () :duration (= ?duration 4) :condition (at start (here)) :effect (and (at start (x)) (at end (y)) (at end (not (x))))))";
  // x and y together: a run that has begun before another one ends.
  const LowerBound bound = bound_of(parse(domain, "(:init (here)) (:goal (and (x) (y)))"));
  EXPECT_LE(seconds(bound), 8);
  EXPECT_GE(seconds(bound), 4);
}

TEST(LowerBound, AShortSliceGivesTheCriticalPath) {
  const LowerBound bound = bound_of(parse(kOven, kTwoPieces), 0);
  EXPECT_FALSE(bound.complete);
  EXPECT_FALSE(bound.assumes_order);
  EXPECT_EQ(seconds(bound), 15);
}

}  // namespace cxlab::planner::lower_bound_test
