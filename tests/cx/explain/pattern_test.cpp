// Patterns of facts: what matches, with which values, and what does not.

#include "cx/explain/pattern.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cx/explain/left_hand_side.h"

namespace cxlab::explain {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

FactCopy fact(std::string name, std::vector<std::pair<std::string, Value>> slots) {
  FactCopy copy;
  copy.template_name = std::move(name);
  copy.slots = std::move(slots);
  return copy;
}

Value list(std::vector<std::int64_t> numbers) {
  std::vector<Value> items;
  for (const std::int64_t number : numbers) items.push_back(Value::integer(number));
  return Value::multifield(std::move(items));
}

Pattern pattern(const std::string& text) { return *Pattern::parse(tree_of(read_forms(text, "f").forms.at(0))); }

/// The values of variables in each way in which a fact matches: "x=1 y=2".
std::vector<std::string> ways(const std::string& text, const FactCopy& copy, Bindings bindings = {}) {
  std::vector<std::string> out;
  const std::size_t known = bindings.size();
  pattern(text).match(copy, bindings, nullptr, [&] {
    std::string& way = out.emplace_back();
    for (const auto& [name, value] : bindings) way += (way.empty() ? "" : " ") + name + '=' + value.print();
    return false;
  });
  EXPECT_EQ(bindings.size(), known) << "bindings are as before";
  return out;
}

// --- Of stories

TEST(PlainPattern, ComparesNumbersAsNumbersAndStringsApartFromSymbols) {
  const FactCopy t = fact("t", {{"a", Value::number(1.0)}, {"b", Value::string("x")}, {"c", list({1, 2, 3})}});
  const auto matches = [&](const std::string& text) { return Pattern::parse_plain(text, "f", 1)->matches(t); };
  EXPECT_TRUE(matches("(t (a 1) (b \"x\"))"));
  EXPECT_FALSE(matches("(t (a 2))"));
  EXPECT_FALSE(matches("(t (a 1.0000000000001))"));
  const FactCopy third = fact("t", {{"a", Value::number(1.0 / 3)}});
  EXPECT_TRUE(Pattern::parse_plain("(t (a 0.333333333333333))", "f", 1)->matches(third)) << "as CLIPS prints it";
  EXPECT_FALSE(Pattern::parse_plain("(t (a 0.33333333333333))", "f", 1)->matches(third));
  EXPECT_FALSE(matches("(t (b x))"));
  EXPECT_TRUE(matches("(t (b ?) (c 1 $?))"));
  EXPECT_TRUE(matches("(t (c $? 3))"));
  EXPECT_FALSE(matches("(t (c 1 3))"));
  EXPECT_FALSE(matches("(t (d 1))")) << "no such slot";
  EXPECT_FALSE(matches("(u (a 1))")) << "another template";
}

TEST(PlainPattern, RefusesWhatStoriesDoNotHave) {
  const auto error = [](const std::string& text) {
    const auto parsed = Pattern::parse_plain(text, "s.yaml", 7);
    return parsed ? "no error" : parsed.error().text();
  };
  EXPECT_THAT(error("(t (a 1|2))"), HasSubstr("s.yaml:7: fact pattern (t (a 1|2)): &, | and ~ are not understood"));
  EXPECT_THAT(error("(t (a (+ 1 2)))"), HasSubstr("a slot holds words, numbers, strings and ? only"));
  EXPECT_THAT(error("(t (a 1) b)"), HasSubstr("values between slots"));
  EXPECT_THAT(error("t"), HasSubstr("expected one pattern in parentheses"));
  EXPECT_THAT(error("()"), HasSubstr("expected the name of a deftemplate first"));
  EXPECT_THAT(error("(\"t\")"), HasSubstr("expected the name of a deftemplate first"));
  EXPECT_THAT(error("(t ())"), HasSubstr("expected the name of a slot"));
}

// --- Of rules

TEST(Pattern, KeepsNumbersOfTwoTypesApart) {
  EXPECT_THAT(ways("(t (a 1))", fact("t", {{"a", Value::number(1.0)}})), IsEmpty());
  EXPECT_THAT(ways("(t (a 1.0))", fact("t", {{"a", Value::number(1.0)}})), SizeIs(1));
  EXPECT_THAT(ways("(t (a +1))", fact("t", {{"a", Value::integer(1)}})), SizeIs(1));
  EXPECT_THAT(ways("(t (a 1e2))", fact("t", {{"a", Value::number(100.0)}})), SizeIs(1));
  EXPECT_THAT(ways("(t (a [x]))", fact("t", {{"a", Value::instance_name("x")}})), SizeIs(1));
  EXPECT_THAT(ways("(t (a -))", fact("t", {{"a", Value::symbol("-")}})), SizeIs(1));
  EXPECT_THAT(ways("(t (a \"q\\\"\"))", fact("t", {{"a", Value::string("q\"")}})), SizeIs(1));
}

TEST(Pattern, BindsVariablesAndComparesThem) {
  const FactCopy t = fact("t", {{"a", Value::integer(1)}, {"b", Value::integer(2)}, {"c", Value::integer(1)}});
  EXPECT_THAT(ways("(t (a ?x) (b ?y))", t), ElementsAre("x=1 y=2"));
  EXPECT_THAT(ways("(t (a ?x) (c ?x))", t), ElementsAre("x=1"));
  EXPECT_THAT(ways("(t (a ?x) (b ?x))", t), IsEmpty());
  EXPECT_THAT(ways("(t (a ?x) (b ~?x))", t), ElementsAre("x=1"));
  EXPECT_THAT(ways("(t (a ?x) (c ~?x))", t), IsEmpty());
  Bindings bound;
  bound.bind("x", Value::integer(2));
  EXPECT_THAT(ways("(t (a ?x))", t, bound), IsEmpty());
  EXPECT_THAT(ways("(t (b ?x))", t, bound), ElementsAre("x=2"));
}

TEST(Pattern, ConnectsConstraints) {
  const auto matches = [](const std::string& constraint, const std::string& word) {
    return !ways("(t (a " + constraint + "))", fact("t", {{"a", Value::symbol(word)}})).empty();
  };
  EXPECT_TRUE(matches("R|G", "G"));
  EXPECT_FALSE(matches("R|G", "B"));
  EXPECT_TRUE(matches("~R", "G"));
  EXPECT_FALSE(matches("~R&~G", "G"));
  EXPECT_TRUE(matches("~R&~G", "B"));
  EXPECT_TRUE(matches("?x&R|G", "G")) << "a variable that comes first holds beside all that follows";
  EXPECT_FALSE(matches("?x&R|G", "B"));
  EXPECT_TRUE(matches("?x&~R", "G"));
  EXPECT_FALSE(matches("R&G|B", "R"));
  EXPECT_TRUE(matches("R&G|B", "B"));
}

TEST(Pattern, SplitsMultifieldsInEachWay) {
  const FactCopy t = fact("t", {{"a", list({1, 2, 1})}});
  EXPECT_THAT(ways("(t (a $?x ?y))", t), ElementsAre("x=(1 2) y=1"));
  EXPECT_THAT(ways("(t (a $?x 1 $?y))", t), ElementsAre("x=() y=(2 1)", "x=(1 2) y=()"));
  EXPECT_THAT(ways("(t (a ?x $? ?x))", t), ElementsAre("x=1"));
  EXPECT_THAT(ways("(t (a))", t), IsEmpty());
  EXPECT_THAT(ways("(t (a))", fact("t", {{"a", list({})}})), SizeIs(1));
}

TEST(Pattern, AnOrderedPatternIsTheWholeFact) {
  const FactCopy t = fact("t", {{"implied", list({1, 2})}});
  EXPECT_THAT(ways("(t 1 ?x)", t), ElementsAre("x=2"));
  EXPECT_THAT(ways("(t 1)", t), IsEmpty());
  EXPECT_THAT(ways("(t)", t), IsEmpty());
  EXPECT_THAT(ways("(t)", fact("t", {{"implied", list({})}})), SizeIs(1));
  EXPECT_THAT(ways("(t)", fact("t", {{"a", Value::integer(1)}})), SizeIs(1)) << "a template without its slots";
}

TEST(Pattern, NamesEachSlotThatDiffers) {
  const FactCopy t = fact("t", {{"a", Value::integer(1)}, {"b", Value::symbol("RED")}, {"c", list({1, 2})}});
  const auto differences = [&](const std::string& text, const Bindings& bindings = {}) {
    std::vector<std::string> out;
    for (const Mismatch& m : pattern(text).mismatches(t, bindings)) out.push_back(m.print());
    return out;
  };
  EXPECT_THAT(differences("(t (a 1))"), IsEmpty());
  EXPECT_THAT(differences("(t (b GREEN|BLUE) (a 1) (c 1))"),
              ElementsAre("b is RED, not GREEN|BLUE", "c is 1 2, not 1"));
  EXPECT_THAT(differences("(t (a ?x) (b ?x))"), ElementsAre("b is RED, not ?x")) << "a has bound it";
  EXPECT_THAT(differences("(t (d 1))"), ElementsAre("there is no slot d"));
  Bindings bound;
  bound.bind("x", Value::integer(7));
  EXPECT_THAT(differences("(t (a ?x))", bound), ElementsAre("a is 1, not ?x with ?x = 7"));
  EXPECT_THAT(pattern("(t 1)").mismatches(fact("t", {{"implied", list({2})}})).front().print(),
              "its fields are 2, not 1");
  EXPECT_EQ(print(pattern("(t (a 2) (b RED) (c))").mismatches(t)), "a is 1, not 2, and c is 1 2, not empty");
}

TEST(Pattern, TheNearestFactFailsInTheFewestSlotsTheLastOfSeveral) {
  const std::vector<FactCopy> facts{fact("t", {{"a", Value::integer(1)}, {"b", Value::integer(0)}}),
                                    fact("t", {{"a", Value::integer(0)}, {"b", Value::integer(2)}}),
                                    fact("t", {{"a", Value::integer(0)}, {"b", Value::integer(0)}}),
                                    fact("u", {{"a", Value::integer(1)}, {"b", Value::integer(2)}})};
  std::vector<const FactCopy*> pointers;
  for (const FactCopy& f : facts) pointers.push_back(&f);
  const Nearest found = nearest(pattern("(t (a 1) (b 2))"), pointers);
  EXPECT_EQ(found.fact, &facts[1]);
  ASSERT_THAT(found.mismatches, SizeIs(1));
  EXPECT_EQ(found.mismatches[0].slot, "a");
  EXPECT_EQ(nearest(pattern("(v)"), pointers).fact, nullptr);
}

TEST(Pattern, OfFactsThatFailInAsManySlotsTheNearestHasWordsThatMayBeMisspelt) {
  const auto robot = [](const char* name, const char* state) {
    return fact("robot", {{"name", Value::symbol(name)}, {"state", Value::symbol(state)}});
  };
  const auto nearest_of = [](const std::string& text, const std::vector<FactCopy>& facts) {
    std::vector<const FactCopy*> pointers;
    for (const FactCopy& f : facts) pointers.push_back(&f);
    return nearest(pattern(text), pointers).fact - facts.data();
  };
  const std::vector<FactCopy> facts{robot("harvester", "WAITING"), robot("harvester", "BROKEN"),
                                    robot("carrier", "CLEANING")};
  EXPECT_EQ(nearest_of("(robot (name harvester) (state WAITNG))", facts), 0)
      << "not the later one, whose state is no word near";
  EXPECT_EQ(nearest_of("(robot (name harvester) (state BROKN))", facts), 1);
  EXPECT_EQ(nearest_of("(robot (name harvester) (state CHARGING))", facts), 1) << "no word is near: the last one";
  EXPECT_EQ(nearest_of("(robot (name carrer) (state CLEANING))", facts), 2);
  EXPECT_EQ(nearest_of("(robot (name harvester) (state CLEANIN))", facts), 1) << "fewer slots that fail come first";
}

// --- Left-hand sides

TEST(LeftHandSide, IsATreeOfConditions) {
  const auto read = conditions_of(R"x((defrule r "A comment."
  (declare (salience 5))
  ?f <- (t (a ?x&:(> ?x 3)) (b "s;)"))   ; a comment (with a form)
  (not (and (u ?x) (test (eq ?x 1))))
  (logical (or (v) (exists (w))))
  (forall (m ?y) (n ?y))
  (test (> ?x 4))
  => (assert (done))))x");
  ASSERT_TRUE(read.ok());
  std::vector<std::string> texts;
  for (const Condition& c : *read) texts.push_back(c.text);
  EXPECT_THAT(texts, ElementsAre("?f <- (t (a ?x&:(> ?x 3)) (b \"s;)\"))", "(not (and (u ?x) (test (eq ?x 1))))",
                                 "(logical (or (v) (exists (w))))", "(forall (m ?y) (n ?y))", "(test (> ?x 4))"));
  EXPECT_EQ((*read)[0].fact_variable, "f");
  EXPECT_EQ((*read)[0].pattern.template_name(), "t");
  EXPECT_EQ((*read)[1].parts[0].parts[1].kind, Condition::Kind::kTest);
  EXPECT_EQ((*read)[2].parts[0].kind, Condition::Kind::kOr);
  EXPECT_EQ((*read)[4].expression.print(), "(> ?x 4)");
}

TEST(LeftHandSide, WhatIsNoRuleIsAnError) {
  EXPECT_FALSE(conditions_of("(deffacts f (a))").ok());
  EXPECT_FALSE(conditions_of("(defrule r (a").ok());
  EXPECT_FALSE(conditions_of("").ok());
}

}  // namespace
}  // namespace cxlab::explain
