// Names that people write in patterns, beside those that the engine has.

#include "cx/explain/names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cxlab::explain {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::unique_ptr<RuleEngine> engine_with(const std::string& text) {
  auto engine = *RuleEngine::create({});
  const LoadReport report = engine->load_text(text, "rules.clp", LoadMode::kConstructs);
  EXPECT_TRUE(report.ok()) << report.status().error().text();
  engine->reset();
  return engine;
}

/// The error for the names of a pattern; empty if they are right.
std::string wrong(const RuleEngine& engine, const std::string& pattern) {
  const Status status = check_names(*Pattern::parse(tree_of(read_forms(pattern, "f").forms.at(0))), engine);
  return status.ok() ? "" : status.error().text();
}

constexpr const char* kRules =
    "(deftemplate robot \"(slot comment)\" (slot name (type STRING)) (multislot tasks (default 1)))"
    "(deftemplate old (field state) (multifield parts))"
    "(deffacts start (count 1))";

TEST(Names, SlotsAreThoseOfTheDeftemplateInEachOfItsFourSpellings) {
  const auto engine = engine_with(kRules);
  EXPECT_EQ(wrong(*engine, "(robot (name ?) (tasks $?))"), "");
  EXPECT_EQ(wrong(*engine, "(old (state ?) (parts $?))"), "");
  EXPECT_EQ(wrong(*engine, "(robot)"), "");
}

TEST(Names, SlotThatTheTemplateDoesNotHaveIsNamedWithTheNearestOne) {
  const auto engine = engine_with(kRules);
  EXPECT_THAT(wrong(*engine, "(robot (nmae ?))"),
              testing::AllOf(HasSubstr("template 'robot' has no slot 'nmae'"), HasSubstr("'name'")));
  EXPECT_THAT(wrong(*engine, "(robot (name ?) (task $?))"),
              testing::AllOf(HasSubstr("no slot 'task'"), HasSubstr("'tasks'")));
  EXPECT_THAT(wrong(*engine, "(old (sate ?))"), testing::AllOf(HasSubstr("no slot 'sate'"), HasSubstr("'state'")));
  for (const char* other : {"slot", "type", "comment", "deftemplate", "robot"})
    EXPECT_THAT(wrong(*engine, "(robot (" + std::string(other) + " ?))"), HasSubstr("no slot")) << other;
}

TEST(Names, TemplateIsADeftemplateOrThatOfAnOrderedFact) {
  const auto engine = engine_with(kRules);
  EXPECT_EQ(wrong(*engine, "(count ?)"), "");
  EXPECT_THAT(wrong(*engine, "(coutn ?)"),
              testing::AllOf(HasSubstr("there is no template 'coutn'"), HasSubstr("'count'")));
  EXPECT_THAT(wrong(*engine, "(robto (name ?))"), HasSubstr("'robot'"));
  EXPECT_THAT(wrong(*engine, "(count (name 1))"), HasSubstr("template 'count' has no slots"));
}

TEST(Names, TemplatesOfRulesAreNearBeforeThereIsAFactOfThem) {
  const auto engine = engine_with("(defrule open (person-at ?x) => (assert (door-open ?x)))");
  EXPECT_THAT(wrong(*engine, "(persn-at ?)"), HasSubstr("did you mean 'person-at'?"));
  EXPECT_THAT(wrong(*engine, "(door-opne ?)"), HasSubstr("did you mean 'door-open'?"));
}

TEST(Names, TemplatesThatARuleHasBuiltAreKnown) {
  const auto engine = engine_with("(defrule make => (build \"(deftemplate made (slot size))\"))");
  engine->run();
  EXPECT_EQ(wrong(*engine, "(made (size ?))"), "");
  EXPECT_THAT(wrong(*engine, "(made (sise ?))"), HasSubstr("no slot 'sise', did you mean 'size'?"));
  EXPECT_THAT(wrong(*engine, "(made 3)"), HasSubstr("write (made (SLOT VALUE)), with one of size"));
}

TEST(Names, ATemplateOfAModuleThatIsNotVisibleIsNotMeant) {
  const auto engine = engine_with("(defmodule NAV)\n(defrule NAV::go (ways) => (printout t a))\n");
  engine->use_module("MAIN");
  EXPECT_EQ(wrong(*engine, "(ways)"), "there is no template 'ways'");
  EXPECT_THAT(wrong(*engine, "(wasy)"), HasSubstr("did you mean 'ways'?"));
}

TEST(Names, SlotStandsInAPatternOnceAndWithItsName) {
  const auto engine = engine_with(kRules);
  EXPECT_THAT(wrong(*engine, "(robot (name \"a\") (name \"b\"))"), HasSubstr("slot 'name' is in the pattern twice"));
  EXPECT_THAT(wrong(*engine, "(robot 3)"), HasSubstr("write (robot (SLOT VALUE)), with one of name, tasks"));
}

TEST(Names, ValueThatNoFactCanHaveIsAgainstItsTypeItsAllowedValuesOrItsQuotes) {
  const auto engine = engine_with(
      "(deftemplate order (slot id (type INTEGER)) (slot state (type SYMBOL) (allowed-values OPEN DONE)) (slot cap)"
      " (slot part (type STRING)) (slot any (type ?VARIABLE)) (slot both (type SYMBOL STRING) (allowed-symbols a)))"
      "(deffacts start (order (id 1) (state OPEN) (cap \"CAP_GREY\") (part \"x\")) (name robot1))");
  const auto found = [&](const std::string& pattern) {
    const Status status = check_values(*Pattern::parse_plain(pattern, "f", 1), *engine, engine->facts());
    return status.ok() ? "" : status.error().text();
  };
  for (const char* possible :
       {"(order (id 3))", "(order (id 1.0))", "(order (state DONE))", "(order (cap ?))", "(order (cap CAP_BLACK))",
        "(order (part \"y\"))", "(order (any 3))", "(order (both a))", "(order (both \"b\"))", "(name robot2)"})
    EXPECT_EQ(found(possible), "") << possible;
  EXPECT_THAT(found("(order (id three))"),
              HasSubstr("slot 'id' of template 'order' cannot be three; its type is INTEGER"));
  EXPECT_THAT(found("(order (state OPENED))"),
              HasSubstr("cannot be OPENED; it holds OPEN, DONE; did you mean 'OPEN'?"));
  EXPECT_THAT(found("(order (state \"OPEN\"))"), HasSubstr("its type is SYMBOL"));
  EXPECT_THAT(found("(order (both b))"), HasSubstr("it holds a"));
  EXPECT_THAT(found("(order (part x))"), HasSubstr("write \"x\""));
  EXPECT_THAT(found("(order (cap CAP_GREY))"), HasSubstr("cap holds \"CAP_GREY\", which is not CAP_GREY to CLIPS"));
  EXPECT_THAT(found("(order (id 1) (cap CAP_GREY))"), HasSubstr("which is not CAP_GREY"));
  EXPECT_THAT(found("(name \"robot1\")"), HasSubstr("one is a string, the other a symbol"));
}

TEST(Names, PatternOfAnInstanceIsNotLookedAt) {
  const auto engine = engine_with(kRules);
  EXPECT_EQ(wrong(*engine, "(object (is-a NOBODY) (nmae ?))"), "");
}

TEST(Names, ConstructsAreListedByTheirKind) {
  const auto engine = engine_with("(defrule go (a) =>) (deffunction stop () 1) (defrule wait (b) =>)");
  EXPECT_THAT(names_of(*engine, "defrule"), ElementsAre("go", "wait"));
  EXPECT_THAT(names_of(*engine, "deffunction"), ElementsAre("stop"));
}

}  // namespace
}  // namespace cxlab::explain
