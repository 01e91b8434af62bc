#include <gtest/gtest.h>

#include "planner/pddl/parser.h"
#include "planner/pddl/text.h"

namespace cxlab::planner::writer_test {
namespace {

constexpr const char* kDomain = R"((define (domain d) (:requirements :typing :adl)
  (:types robot place - object depot - place bay - (either depot robot))
  (:constants base - depot odd - robot odd - place)
  (:predicates (at ?r - robot ?p - place) (open ?p - (either place robot)) (done) (shut ?p - place))
  (:functions (battery ?r - robot) (load ?r - robot) (total-cost)) (:timeless (open base))
  (:derived (shut ?p - place) (not (open ?p)))
  (:action look :parameters (?r - robot) :precondition (or (done) (exists (?p - place) (at ?r ?p)))
    :effect (and (done) (forall (?p - place) (when (shut ?p) (not (at ?r ?p))))))
  (:durative-action go :parameters (?r - robot ?a ?b - place)
    :duration (and (>= ?duration 1) (at end (<= ?duration (* 2 (battery ?r)))))
    :condition (and (at start (at ?r ?a)) (forall (?p - place) (over all (imply (at ?r ?p) (open ?p)))) (at end (not (= ?a ?b))))
    :effect (and (at start (not (at ?r ?a))) (when (and (at start (done)) (over all (open ?b))) (at end (at ?r ?b)))
      (at end (assign (battery ?r) (- (battery ?r) ?duration))) (decrease (battery ?r) (* #t (/ (load ?r) 2))))))
)";
constexpr const char* kProblem = R"((define (problem p) (:domain d) (:objects r1 - robot hall - place)
  (:init (at r1 base) (= (battery r1) 0.25) (at 4.5 (open hall)) (at 6 (not (open hall))) (at 7 (= (battery r1) 1)))
  (:goal (forall (?r - robot) (> (battery ?r) -1))) (:metric minimize (+ (total-time) (* 2 (total-cost))))))";

TEST(Writer, WrittenTextReadsBackTheSame) {
  const auto domain = parse_domain(kDomain, "d");
  ASSERT_TRUE(domain) << domain.error().text();
  const auto problem = parse_problem(kProblem, "p", *domain);
  ASSERT_TRUE(problem) << problem.error().text();
  const std::string domain_text = to_pddl(*domain);
  const std::string problem_text = to_pddl(*domain, *problem);
  EXPECT_NE(domain_text.find("(decrease (battery ?r) (* #t (/ (load ?r) 2)))"), std::string::npos) << domain_text;
  const auto again = parse_domain(domain_text, "again");
  ASSERT_TRUE(again) << again.error().text() << "\n" << domain_text;
  const auto problem_again = parse_problem(problem_text, "again", *again);
  ASSERT_TRUE(problem_again) << problem_again.error().text() << "\n" << problem_text;
  EXPECT_EQ(to_pddl(*again), domain_text);
  EXPECT_EQ(to_pddl(*again, *problem_again), problem_text);
  EXPECT_EQ(again->actions.at(1).effects.size(), domain->actions.at(1).effects.size());
  EXPECT_EQ(again->constants.at(1).types, domain->constants.at(1).types);
}

TEST(Writer, NumbersAndTimesAreShortAndExact) {
  EXPECT_EQ(number_text(5), "5");
  EXPECT_EQ(number_text(0.1), "0.1");
  EXPECT_EQ(time_text(5), "5.000");
  EXPECT_EQ(time_text(100.0 / 3), "33.333333333");
  EXPECT_EQ(time_text(0.1 + 0.2), "0.300");
  EXPECT_EQ(time_text(-1e-12), "0.000");
  EXPECT_EQ(time_text(5.0010010000000005), "5.001001");
  EXPECT_EQ(time_text(0.0005), "0.0005");
  EXPECT_EQ(time_text(-1440), "-1440.000");
}

}  // namespace
}  // namespace cxlab::planner::writer_test
