// Conditions in negation normal form, and the conjunctions that they are split into.

#include "planner/ground/formula.h"

#include <gtest/gtest.h>

#include <cmath>

#include "planner/ground/task.h"

namespace cxlab::planner {
namespace {

using Kind = Formula::Kind;

Formula fact(int id) { return {Kind::kFact, id, {}}; }
Formula any(std::vector<Formula> parts) { return join(Kind::kOr, std::move(parts)); }
Formula all(std::vector<Formula> parts) { return join(Kind::kAnd, std::move(parts)); }

/// "1&2" for a conjunction of facts, "(1|2)" for a disjunction.
std::string text(const Formula& formula) {
  switch (formula.kind) {
    case Kind::kTrue: return "true";
    case Kind::kFalse: return "false";
    case Kind::kFact: return std::to_string(formula.index);
    case Kind::kComparison: return "c" + std::to_string(formula.index);
    case Kind::kAnd:
    case Kind::kOr: break;
  }
  std::string out;
  for (const Formula& part : formula.parts)
    out += (out.empty() ? "" : formula.kind == Kind::kAnd ? "&" : "|") + text(part);
  return formula.kind == Kind::kAnd ? out : "(" + out + ")";
}

std::vector<std::string> texts(const std::vector<Formula>& formulas) {
  std::vector<std::string> out;
  for (const Formula& formula : formulas) out.push_back(text(formula));
  return out;
}

TEST(Formula, JoiningLeavesOutWhatDecidesNothing) {
  EXPECT_EQ(text(all({fact(1), truth(true), fact(2)})), "1&2");
  EXPECT_EQ(text(all({fact(1), truth(false)})), "false");
  EXPECT_EQ(text(any({fact(1), truth(false), fact(2)})), "(1|2)");
  EXPECT_EQ(text(any({fact(1), truth(true)})), "true");
  EXPECT_EQ(text(all({})), "true");
  EXPECT_EQ(text(any({})), "false");
  EXPECT_EQ(text(any({fact(7), truth(false)})), "7") << "one part stands for itself";
}

/// The value with the numbers 3 and 5, the duration 7 and the total time 11.
double value_of(std::vector<GroundExpression::Step> steps) {
  const double numbers[] = {3, 5};
  GroundExpression expression;
  expression.steps = std::move(steps);
  return expression.evaluate(numbers, 7, 11);
}

TEST(GroundExpression, EvaluatesItsStepsOnAStack) {
  using Step = GroundExpression::Kind;
  const GroundExpression::Step a{Step::kFunction, 0, 0}, b{Step::kFunction, 1, 0}, two{Step::kConstant, -1, 2},
      duration{Step::kDuration, -1, 0}, total{Step::kTotalTime, -1, 0};
  EXPECT_EQ(value_of({a}), 3);
  EXPECT_EQ(value_of({two}), 2);
  EXPECT_EQ(value_of({duration}), 7);
  EXPECT_EQ(value_of({total}), 11);
  EXPECT_EQ(value_of({b, {Step::kNegate, -1, 0}}), -5);
  EXPECT_EQ(value_of({a, b, {Step::kAdd, -1, 0}}), 8);
  EXPECT_EQ(value_of({a, b, {Step::kSubtract, -1, 0}}), -2);
  EXPECT_EQ(value_of({a, b, {Step::kMultiply, -1, 0}}), 15);
  EXPECT_EQ(value_of({b, two, {Step::kDivide, -1, 0}}), 2.5);
  EXPECT_EQ(value_of({total, a, b, {Step::kAdd, -1, 0}, {Step::kSubtract, -1, 0}, two, {Step::kMultiply, -1, 0}}), 6);
  EXPECT_TRUE(std::isnan(value_of({a, {Step::kConstant, -1, 0}, {Step::kDivide, -1, 0}})));
  EXPECT_TRUE(std::isnan(value_of({a, b}))) << "two values are no value";
}

TEST(Formula, JoiningIsFlat) {
  EXPECT_EQ(text(all({all({fact(1), fact(2)}), fact(3)})), "1&2&3");
  EXPECT_EQ(text(any({any({fact(1), fact(2)}), fact(3)})), "(1|2|3)");
  EXPECT_EQ(text(all({any({fact(1), fact(2)}), fact(3)})), "(1|2)&3");
}

TEST(Formula, AlternativesMultiplyOut) {
  const Formula formula = all({any({fact(1), fact(2)}), fact(3), any({fact(4), fact(5)})});
  EXPECT_EQ(texts(alternatives(formula, 4)), (std::vector<std::string>{"1&3&4", "1&3&5", "2&3&4", "2&3&5"}));
}

TEST(Formula, ADisjunctionStaysWhereSplittingWouldGiveTooMany) {
  const Formula formula = all({any({fact(1), fact(2)}), fact(3), any({fact(4), fact(5)})});
  EXPECT_EQ(texts(alternatives(formula, 3)), (std::vector<std::string>{"(1|2)&3&(4|5)"}));
}

TEST(Formula, WhatIsTrueHasOneEmptyAlternativeAndWhatIsFalseNone) {
  EXPECT_EQ(texts(alternatives(truth(true), 4)), (std::vector<std::string>{"true"}));
  EXPECT_TRUE(alternatives(truth(false), 4).empty());
  EXPECT_EQ(texts(alternatives(any({fact(1), fact(2)}), 4)), (std::vector<std::string>{"1", "2"}));
}

}  // namespace
}  // namespace cxlab::planner
