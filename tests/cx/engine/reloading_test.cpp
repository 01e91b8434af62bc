// The constructs that a load remembers from before, and the places that errors name.

#include "tests/support/engine_test.h"

namespace cxlab {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class Reloading : public EngineTest {
 protected:
  std::vector<std::string> errors_of(std::string_view rules) {
    return load_errors(rules, LoadMode::kConstructs, OnLoadError::kStop);
  }
};

TEST_F(Reloading, AChangedTemplateReplacesTheFormerOneAlsoWhereTheSameAreKept) {
  given("(deftemplate a (slot x))");
  engine().keep_same_constructs(KeepSame::kTypes);
  given("(deftemplate a (slot y))");
  engine().keep_same_constructs(KeepSame::kNothing);
  EXPECT_TRUE(engine().assert_fact("a", {{"y", Value::integer(1)}}).ok());
}

TEST_F(Reloading, TheSameConstructsOfAModuleAreKeptInTheirModule) {
  const char* rules =
      "(defmodule A (export ?ALL))\n(deftemplate t (slot x))\n(defclass C (is-a USER))\n(defrule r (t) =>)\n"
      "(defmodule B (import A ?ALL))\n(defrule s (t) =>)\n";
  given(rules);
  ASSERT_TRUE(engine().assert_fact("A::t", {{"x", Value::integer(1)}}).ok());
  engine().keep_same_constructs(KeepSame::kTypes);
  given(rules);
  engine().keep_same_constructs(KeepSame::kNothing);
  EXPECT_THAT(fact_texts(), ElementsAre("(t (x 1))")) << "the template was not undefined";
  EXPECT_TRUE(engine().has("defrule", "A::r"));
  EXPECT_TRUE(engine().has("defrule", "B::s"));
  EXPECT_FALSE(engine().has("defrule", "B::r"));
  EXPECT_FALSE(engine().has("defrule", "MAIN::r"));
  EXPECT_THAT(engine().find_constructs("deftemplate", "t"), SizeIs(1));
  EXPECT_THAT(engine().find_constructs("defclass", "C"), SizeIs(1));
  EXPECT_THAT(engine().find_constructs("defrule", "r"), SizeIs(1));
}

TEST_F(Reloading, WhereAllAreKeptOnlyWhatHasChangedIsDefinedAgain) {
  const std::string rules =
      "(deftemplate a (slot x))\n(defglobal ?*n* = 1)\n(deffunction twice (?x) (* 2 ?x))\n(deffacts f (a (x 1)))\n"
      "(defrule same (a (x ?x)) => (bind ?*n* (+ ?*n* 1)))\n(defrule other (a (x 2)) => (bind ?*n* 100))\n"
      "(defmodule B)\n(defrule same => )\n";
  given(rules);
  engine().reset();
  engine().run();
  EXPECT_EQ(engine().eval("?*n*")->as_integer(), 2);
  std::string changed = rules;
  changed.replace(changed.find("(x 2)"), 5, "(x 1)");
  engine().keep_same_constructs(KeepSame::kAll);
  given(changed);
  engine().keep_same_constructs(KeepSame::kNothing);
  EXPECT_EQ(engine().run().fired, 1) << "the rule that is the same has fired for its fact";
  ASSERT_TRUE(engine().use_module("MAIN"));
  EXPECT_EQ(engine().eval("?*n*")->as_integer(), 100) << "the global kept its value until then";
  EXPECT_THAT(engine().find_constructs("defrule", "same"), SizeIs(2));
  // One of another module is another one.
  engine().keep_same_constructs(KeepSame::kAll);
  given("(defrule same => )");
  engine().keep_same_constructs(KeepSame::kNothing);
  EXPECT_EQ(engine().find_construct("defrule", "MAIN::same")->text, "(defrule same => )");
}

TEST_F(Reloading, ARuleOfTooManyAlternativesIsRefused) {
  std::string many = "(or";
  for (int i = 0; i < 11; ++i) many += " (a " + std::to_string(i) + ")";
  many += ") ";
  const std::string rule = "(defrule many " + many + many + many + many + "=>)";
  EXPECT_THAT(errors_of(rule + "(defrule after =>)"),
              ElementsAre(HasSubstr("'or' conditions have 14641 combinations, each of which would be a rule")));
  EXPECT_FALSE(engine().has("defrule", "many"));
  EXPECT_FALSE(engine().has("defrule", "after")) << "the first error stops the load";
  EXPECT_THAT(load_errors("(defrule deep (logical (and " + many + many + many + many + ")) =>)"), SizeIs(1));
  EXPECT_THAT(load_errors("(defrule sum (or (and (b) " + many + many + ") (not (and (c) " + many + "))) =>)"),
              IsEmpty());
}

TEST_F(Reloading, ALocalVariableIsNoEffect) {
  EXPECT_THAT(errors_of("(deffunction two () (bind ?x 2) ?x)\n(defrule go (test (> (two) 1)) =>)"), IsEmpty());
}

TEST_F(Reloading, AnActingFunctionIsFoundAfterAnEqualsSign) {
  EXPECT_THAT(errors_of("(deffunction make () (assert (b)) 1)\n(defrule go (a =(make)) =>)"),
              ElementsAre(HasSubstr("rule 'go' calls 'make' on its left-hand side")));
}

TEST_F(Reloading, AFunctionThatActsNoMoreMayBeCalled) {
  EXPECT_THAT(errors_of("(deffunction ready () (assert (a)))\n(deffunction ready () TRUE)\n"
                        "(defrule go (test (ready)) =>)"),
              IsEmpty());
}

TEST_F(Reloading, AConstructOfALineHasTheErrorsOfThatLine) {
  const Status built = engine().build("(defrule go (a) =>\n (no-such-function))", "rules.clp", 5);
  ASSERT_FALSE(built.ok());
  EXPECT_EQ(built.error().file, "rules.clp");
  EXPECT_EQ(built.error().line, 6);
}

TEST_F(Reloading, AnErrorIsReportedAgainByTheNextRun) {
  given("(deffacts f (a))\n(defrule go (a) =>\n  (/ 1 0))");
  for (int i = 0; i < 2; ++i) {
    engine().reset();
    const RunReport report = engine().run();
    ASSERT_THAT(report.errors, SizeIs(1)) << i;
    EXPECT_EQ(report.errors[0].line, 3);
  }
}

TEST_F(Reloading, AnErrorOfAFunctionHasItsLineOnTheSideWhereItFailed) {
  given("(deffacts f (a 1))\n(defrule go (a ?x&:(> (/ 2 1) 1)) =>\n  (/ 1 0))");
  engine().reset();
  const RunReport report = engine().run();
  ASSERT_THAT(report.errors, SizeIs(1));
  EXPECT_EQ(report.errors[0].line, 3);
}

TEST_F(Reloading, FactsFromOutsideKeepTheirKindAndTheCurrentModule) {
  given("(deftemplate list (multislot items))\n(defmodule A)\n(deftemplate A::t (slot x))\n(defmodule B)");
  ASSERT_TRUE(engine().eval("(set-current-module B)").ok());
  ASSERT_TRUE(engine().assert_fact("t", {{"x", Value::integer(1)}}).ok());
  EXPECT_EQ(engine().eval("(get-current-module)")->text(), "B");
  ASSERT_TRUE(engine().assert_fact("list", {{"items", Value::integer(3)}}).ok());
  EXPECT_THAT(fact_texts("list"), ElementsAre("(list (items 3))"));
  EXPECT_FALSE(engine().assert_ordered("list", std::vector<Value>{Value::integer(3)}).ok());
}

TEST_F(Reloading, EqualBoundsLeaveNoChance) { EXPECT_EQ(engine().eval("(random 3 3)")->as_integer(), 3); }

}  // namespace
}  // namespace cxlab
