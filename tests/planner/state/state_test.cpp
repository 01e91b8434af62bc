#include "planner/state/state.h"

#include <gtest/gtest.h>

#include "planner/pddl/parser.h"

namespace cxlab::planner::state_test {
namespace {

constexpr const char* kDomain = R"((define (domain d) (:types place)
  (:predicates (road ?a ?b - place) (reach ?a ?b - place) (alone ?a - place) (marked ?a - place))
  (:functions (level ?a - place) (unknown))
  (:derived (reach ?a ?b - place) (or (road ?a ?b) (exists (?c - place) (and (reach ?a ?c) (road ?c ?b)))))
  (:derived (alone ?a - place) (not (exists (?b - place) (reach ?a ?b))))
  (:action mark :parameters (?a - place)
    :precondition (and (forall (?b - place) (imply (reach ?a ?b) (not (marked ?b)))) (>= (level ?a) 1))
    :effect (and (forall (?b - place) (when (reach ?a ?b) (marked ?b))) (increase (level ?a) (* 2 (level ?a)))))
  (:action guess :effect (assign (unknown) (/ 1 (unknown))))))";
constexpr const char* kProblem = R"((define (problem p) (:domain d) (:objects a b c e - place)
  (:init (road a b) (road b c) (= (level a) 1))))";

class StateTest : public ::testing::Test {
 protected:
  Domain domain_ = *parse_domain(kDomain, "d.pddl");
  Problem problem_ = *parse_problem(kProblem, "p.pddl", domain_);
  Evaluator evaluator_{domain_, problem_};
  State state_{domain_, problem_};

  bool holds(const char* predicate, std::vector<ObjectId> objects) {
    return state_.holds(find(domain_.predicate_names, predicate), objects);
  }
  bool precondition(const char* action, Frame frame) {
    const Action& found = domain_.actions[find(domain_.action_names, action)];
    frame.resize(static_cast<std::size_t>(found.slots));
    return evaluator_.holds(found.condition.start, frame, state_);
  }
};

constexpr auto always = [](Frame&) { return true; };

TEST_F(StateTest, DerivedFactsFollowTheStrata) {
  evaluator_.derive(state_);
  EXPECT_TRUE(holds("reach", {0, 2}));
  EXPECT_FALSE(holds("reach", {2, 0}));
  EXPECT_TRUE(holds("alone", {2}));
  EXPECT_FALSE(holds("alone", {0}));
  state_.set(find(domain_.predicate_names, "road"), std::vector<ObjectId>{1, 2}, false);
  evaluator_.derive(state_);
  EXPECT_FALSE(holds("reach", {0, 2}));
}

TEST_F(StateTest, QuantifiedConditionalEffectsAreExpandedInTheState) {
  evaluator_.derive(state_);
  EXPECT_TRUE(precondition("mark", {0}));
  const Action& mark = domain_.actions[0];
  Frame frame(static_cast<std::size_t>(mark.slots), 0);
  std::vector<Change> changes;
  for (const Effect& effect : mark.effects)
    ASSERT_TRUE(evaluator_.collect(
        effect, frame, state_, 0, [&](Frame& bound) { return evaluator_.holds(effect.condition.start, bound, state_); },
        changes));
  ASSERT_EQ(changes.size(), 3u) << "b and c are marked, the level grows";
  ASSERT_TRUE(apply_changes(changes, state_));
  EXPECT_TRUE(holds("marked", {1}));
  EXPECT_FALSE(holds("marked", {0}));
  EXPECT_EQ(state_.value(0, std::vector<ObjectId>{0}), 3);
  EXPECT_FALSE(precondition("mark", {0}));
}

TEST_F(StateTest, ReadingAnUndefinedValueFails) {
  EXPECT_FALSE(precondition("mark", {1})) << "level of b is not known";
  std::vector<Change> changes;
  Frame frame;
  EXPECT_FALSE(evaluator_.collect(domain_.actions[1].effects[0], frame, state_, 0, always, changes));
  state_.set_value(1, {}, 0);
  EXPECT_FALSE(evaluator_.collect(domain_.actions[1].effects[0], frame, state_, 0, always, changes)) << "divides by 0";
  state_.set_value(1, {}, 4);
  ASSERT_TRUE(evaluator_.collect(domain_.actions[1].effects[0], frame, state_, 0, always, changes));
  EXPECT_EQ(changes.at(0).value, 0.25);
}

TEST_F(StateTest, ValuesMayChangeWithTime) {
  const std::vector<ObjectId> a = {0};
  state_.add_rate(0, a, 2);
  state_.add_rate(0, a, -0.5);
  state_.look_ahead(2);
  EXPECT_EQ(state_.value(0, a), 4);
  state_.look_ahead(0);
  EXPECT_EQ(state_.value(0, a), 1);
  state_.advance(4);
  EXPECT_EQ(state_.value(0, a), 7);
  state_.clear_rates();
  state_.advance(4);
  EXPECT_EQ(state_.value(0, a), 7);
}

TEST_F(StateTest, FactsAreListedInTheOrderInWhichTheyBecameTrue) {
  const PredicateId road = find(domain_.predicate_names, "road");
  state_.set(road, std::vector<ObjectId>{0, 1}, false);
  state_.set(road, std::vector<ObjectId>{3, 3}, true);
  state_.set(road, std::vector<ObjectId>{0, 1}, true);
  const auto facts = state_.facts();
  ASSERT_EQ(facts.size(), 3u);
  EXPECT_EQ(facts[0].objects, (std::vector<ObjectId>{1, 2}));
  EXPECT_EQ(facts[2].objects, (std::vector<ObjectId>{0, 1}));
}

TEST_F(StateTest, ComparisonForgivesRounding) {
  EXPECT_TRUE(compare(0.1 + 0.2, Comparison::kEqual, 0.3));
  EXPECT_FALSE(compare(0.1 + 0.2, Comparison::kGreater, 0.3));
  EXPECT_TRUE(compare(0.3, Comparison::kGreaterEqual, 0.1 + 0.2));
  EXPECT_TRUE(compare(1.001, Comparison::kGreater, 1));
  EXPECT_FALSE(compare(0.3, Comparison::kLess, 0.1 + 0.2));
  EXPECT_TRUE(compare(0.1 + 0.2, Comparison::kLessEqual, 0.3));
  EXPECT_TRUE(compare(1, Comparison::kLess, 1.001));
}

}  // namespace
}  // namespace cxlab::planner::state_test
