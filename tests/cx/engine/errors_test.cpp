// Every error of rules has rule, file, line and side.

#include "tests/support/engine_test.h"

namespace cxlab {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using testing::StartsWith;

struct RuleErrors : EngineTest {
  std::vector<std::string> texts(const std::vector<RuleError>& errors) {
    std::vector<std::string> list;
    for (const RuleError& error : errors) list.push_back(error.text());
    return list;
  }
};

TEST_F(RuleErrors, ALoopWithoutEndInsideARuleIsStopped) {
  given("(defrule go (a) =>\n  (while TRUE do (bind ?x 1)))\n");
  ASSERT_TRUE(engine().assert_string("(a)").ok());
  EXPECT_THAT(texts(engine().run().errors), ElementsAre(AllOf(HasSubstr("rule go, RHS"), HasSubstr("Still looping"))));
}

TEST_F(RuleErrors, FactsOfTheStartThatBuildConstructsKeepTheirPlace) {
  given(
      "(deffunction grow ()\n  (loop-for-count (?i 1 500) do (build (str-cat \"(deffunction f\" ?i \" ())\")))\n  (/ 1 "
      "0))\n"
      "(deffacts start (a (grow)))\n");
  engine().reset();
  const auto count = engine().eval("(length$ (get-deffunction-list))");
  ASSERT_TRUE(count);
  EXPECT_EQ(count->print(), "501");
  EXPECT_THAT(texts(engine().take_errors()),
              ElementsAre(AllOf(StartsWith("rules.clp:4: deffacts start"), HasSubstr("zero"))));
}

TEST_F(RuleErrors, TurnsOfLoopsAreCountedByAction) {
  given("(deffacts f (a 1) (a 2))\n(defrule go (a ?) => (loop-for-count 6000000 do (bind ?x 1)))\n");
  engine().reset();
  EXPECT_THAT(texts(engine().run().errors), IsEmpty()) << "two actions of six million turns each";
}

TEST_F(RuleErrors, EachCallWithoutEndIsReported) {
  given("(deffunction fall (?x) (+ 1 (fall (+ ?x 1))))\n(defrule go (a) =>\n  (fall 1))\n");
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(engine().assert_string("(a)").ok());
    EXPECT_THAT(texts(engine().run().errors), ElementsAre(HasSubstr("'fall'"))) << i;
    engine().reset();
  }
}

TEST_F(RuleErrors, ADeffunctionThatCallsItselfWithoutEndIsStopped) {
  given(
      "(deffunction fall (?x) (+ 1 (fall (+ ?x 1))))\n"
      "(deffunction deep (?x) (if (> ?x 0) then (+ 1 (deep (- ?x 1))) else 0))\n"
      "(defrule go (a) =>\n  (fall 1)\n  (assert (never)))\n"
      "(defrule later (declare (salience -1)) (a) => (assert (depth (deep 1000))))\n");
  ASSERT_TRUE(engine().assert_string("(a)").ok());
  EXPECT_THAT(texts(engine().run().errors),
              ElementsAre(AllOf(StartsWith("rules.clp:4: rule go, RHS"), HasSubstr("'fall'"))));
  EXPECT_THAT(engine().run().errors, IsEmpty());
  EXPECT_THAT(fact_texts(), ElementsAre("(a)", "(depth 1000)")) << "the next run can call as before";
  EXPECT_LT(output["stderr"].size(), 1000u) << "not a line for each level";
}

TEST_F(RuleErrors, MethodsThatCallEachOtherWithoutEndAreStopped) {
  given(
      "(defgeneric there)\n(defmethod back ((?x INTEGER)) (there ?x))\n(defmethod there ((?x INTEGER)) (back ?x))\n"
      "(defrule go (a) => (back 1))\n");
  ASSERT_TRUE(engine().assert_string("(a)").ok());
  EXPECT_THAT(texts(engine().run().errors),
              ElementsAre(AllOf(HasSubstr("rule go, RHS"), HasSubstr("from within itself"))));
}

TEST_F(RuleErrors, MessageHandlersThatCallThemselvesWithoutEndAreStopped) {
  given("(defclass A (is-a USER) (role concrete) (slot s))\n(defrule go (a) =>)\n");
  const std::pair<const char*, const char*> kHandlers[] = {
      {"(defmessage-handler A turn () (send ?self turn))", "(send [x] turn)"},
      {"(defmessage-handler A init after () (make-instance of A))", "(make-instance of A)"},
      {"(defmessage-handler A create after () (make-instance of A))", "(make-instance of A)"},
      {"(defmessage-handler A direct-modify around (?o) (modify-instance ?self (s 1)))", "(modify-instance [x] (s 1))"},
      {"(defmessage-handler A direct-modify around (?o) (active-modify-instance ?self (s 1)))",
       "(active-modify-instance [x] (s 1))"},
      {"(defmessage-handler A message-modify around (?o) (message-modify-instance ?self (s 1)))",
       "(message-modify-instance [x] (s 1))"},
      {"(defmessage-handler A direct-duplicate around (?n ?o) (duplicate-instance ?self))", "(duplicate-instance [x])"},
      {"(defmessage-handler A direct-duplicate around (?n ?o) (active-duplicate-instance ?self to z))",
       "(active-duplicate-instance [x])"},
      {"(defmessage-handler A message-duplicate around (?n ?o) (message-duplicate-instance ?self))",
       "(message-duplicate-instance [x])"},
      {"(defmessage-handler A delete before () (unmake-instance ?self))", "(unmake-instance [x])"}};
  for (const auto& [handler, call] : kHandlers) {
    engine().reset();
    (void)engine().eval("(make-instance x of A)");
    ASSERT_TRUE(engine().build(handler).ok()) << handler;
    ASSERT_TRUE(engine().build(std::string("(defrule go (a) => ") + call + ")").ok());
    ASSERT_TRUE(engine().assert_string("(a)").ok());
    EXPECT_THAT(texts(engine().run().errors), ElementsAre(HasSubstr("from within itself"))) << handler;
    (void)engine().eval("(undefmessage-handler A * *)");
  }
}

TEST_F(RuleErrors, AnUnknownSlotHasTheLineWhereItStands) {
  EXPECT_THAT(
      load_errors("(deftemplate order (slot id))\n\n(defrule go\n  (order (id ?x)\n         (colour RED))\n  =>\n)\n"),
      ElementsAre(AllOf(StartsWith("rules.clp:5: [TMPLTDEF1]"), HasSubstr("'colour'"))));
}

TEST_F(RuleErrors, AnErrorOfALoadedFormIsToldOnce) {
  EXPECT_THAT(load_errors("(defrule go (a) => (no-such-function 1))"), SizeIs(1));
  EXPECT_EQ(output["stderr"], "") << "the lines of CLIPS beside it";
  given("(defrule go (a) => (build \"(defrule inner => (no-such-function 1))\"))");
  ASSERT_TRUE(engine().assert_string("(a)").ok());
  (void)engine().run();
  EXPECT_THAT(output["stderr"], HasSubstr("[EXPRNPSR3]")) << "of a rule's own call all is printed, as in CX";
}

TEST_F(RuleErrors, AnUnknownSlotGetsTheNearestOfItsDeftemplate) {
  given(
      "(deftemplate order (slot id) (slot color))\n(deftemplate other (slot colour))\n"
      "(defclass BOX (is-a USER) (role concrete) (pattern-match reactive) (slot width))");
  const auto error_of = [&](const std::string& form) {
    const std::vector<std::string> errors = load_errors(form);
    return errors.empty() ? "" : errors.front();
  };
  const std::string near =
      "Invalid slot 'colour' not defined in corresponding deftemplate 'order', did you mean 'color'?";
  EXPECT_THAT(error_of("(defrule r (order (colour RED)) =>)"), EndsWith(near));
  EXPECT_THAT(error_of("(defrule r (not (order (colour RED))) =>)"), EndsWith(near));
  EXPECT_THAT(error_of("(defrule r => (assert (order (colour RED))))"), EndsWith(near));
  EXPECT_THAT(error_of("(deffacts d (order (colour RED)))"), EndsWith(near));
  EXPECT_THAT(error_of("(defrule r (order (weight 3)) =>)"), EndsWith("deftemplate 'order'."));
  EXPECT_THAT(error_of("(defrule r (object (is-a BOX) (widht 3)) =>)"), EndsWith(", did you mean 'width'?"));
}

TEST_F(RuleErrors, AnImportOfWhatIsNotExportedSaysHowToExportIt) {
  given(
      "(defmodule SHOP (export deftemplate bill))\n(deftemplate bill (slot sum))\n(deftemplate order (slot id))\n"
      "(defmodule CLOSED)");
  const auto error_of = [&](const std::string& import) {
    const std::vector<std::string> errors = load_errors("(defmodule NAV (import " + import + "))");
    return errors.empty() ? "" : errors.front();
  };
  EXPECT_THAT(error_of("CLOSED ?ALL"), EndsWith("any constructs. It does with (defmodule CLOSED (export ?ALL))"));
  EXPECT_THAT(error_of("SHOP deffunction ?ALL"), EndsWith(" It does with (defmodule SHOP (export deffunction ?ALL))"));
  EXPECT_THAT(error_of("SHOP deftemplate order"),
              EndsWith(" It does with (defmodule SHOP (export deftemplate order))"));
  EXPECT_THAT(error_of("SHOP deftemplate ordre"),
              EndsWith(" There is no deftemplate 'ordre' in it, did you mean 'order'?"));
  EXPECT_THAT(error_of("SHPO ?ALL"), EndsWith("Unable to find defmodule 'SHPO', did you mean 'SHOP'?"));
}

TEST_F(RuleErrors, AnUnknownFunctionHasTheLineWhereItStands) {
  EXPECT_THAT(load_errors("(defrule go\n  (a)\n  =>\n  (assert (b))\n  (no-such-function 1))\n"),
              ElementsAre(AllOf(StartsWith("rules.clp:5: [EXPRNPSR3]"), HasSubstr("no-such-function"))));
}

TEST_F(RuleErrors, AnUnbalancedFormIsReportedAndTheOthersAreLoaded) {
  EXPECT_THAT(load_errors("(defrule one (a) => (b-undefined))\n(defrule two (a) =>\n\n(defrule three (a) =>)\n"),
              ElementsAre(StartsWith("rules.clp:1: [EXPRNPSR3]"), StartsWith("rules.clp:2: found no closing")));
  EXPECT_TRUE(engine().has("defrule", "three"));
}

TEST_F(RuleErrors, AnErrorLeavesTheCurrentModule) {
  ASSERT_THAT(load_errors("(defmodule A)\n(deftemplate order (slot id))\n(defmodule B)\n(defmodule C)\n"), IsEmpty());
  for (const char* wrong : {"(defrule wrong (ordr (id 1)) =>)", "(defrule wrong (a) => (assert (ordr (id 1))))",
                            "(defrule wrong (a) => (prinout t x))"}) {
    ASSERT_TRUE(engine().eval("(set-current-module A)").ok());
    EXPECT_THAT(load_errors(std::string(wrong) + "\n"), ElementsAre(HasSubstr("did you mean '"))) << wrong;
    EXPECT_EQ(engine().eval("(get-current-module)")->text(), "A") << wrong;
  }
}

TEST_F(RuleErrors, TheFirstErrorStopsALoadThatIsToStop) {
  EXPECT_THAT(load_errors("(defrule one (a) => (undefined))\n(defrule two (a) =>)\n", LoadMode::kConstructs,
                          OnLoadError::kStop),
              SizeIs(1));
  EXPECT_FALSE(engine().has("defrule", "two"));
}

TEST_F(RuleErrors, OnlyConstructsMayStandInAFileOfConstructs) {
  EXPECT_THAT(load_errors("(reset)\n(deffacts f (a))\nloose\n"),
              ElementsAre(StartsWith("rules.clp:1: [CSTRCPSR1]"), StartsWith("rules.clp:3: [CSTRCPSR1]")));
}

TEST_F(RuleErrors, ABatchFileHasConstructsCallsAndWords) {
  EXPECT_THAT(
      load_errors("(deftemplate order (slot id))\nTRUE\n(assert (order (id 1)))\n(bind ?x 2)\n(assert (order (id ?x)))",
                  LoadMode::kBatch),
      IsEmpty());
  EXPECT_THAT(fact_texts(), ElementsAre("(order (id 1))", "(order (id 2))"));
  EXPECT_THAT(output["stdout"], IsEmpty()) << "results are not echoed";
}

TEST_F(RuleErrors, ErrorsOfABatchFileHaveTheirLines) {
  EXPECT_THAT(load_errors("(deftemplate order (slot id))\n(assert (order (id 1)))\n(assert (order\n  (colour "
                          "1)))\n(undefined)\n(/ 1 0)\n",
                          LoadMode::kBatch),
              ElementsAre(StartsWith("rules.clp:4: [TMPLTDEF1]"), StartsWith("rules.clp:5: [EXPRNPSR3]"),
                          StartsWith("rules.clp:6: [PRNTUTIL7]")));
}

TEST_F(RuleErrors, DivisionByZeroOnTheRightHandSide) {
  given(
      "(deffacts f (a 0) (b))\n(defrule halves\n  (a ?x)\n  =>\n  (printout t\n    (/ 1 ?x) crlf))\n(defrule other (b) "
      "=> (assert (c)))");
  engine().reset();
  now = from_seconds(3);
  const RunReport report = engine().run();
  ASSERT_THAT(report.errors, SizeIs(1));
  const RuleError& error = report.errors[0];
  EXPECT_EQ(error.rule, "halves");
  EXPECT_EQ(error.file, "rules.clp");
  EXPECT_EQ(error.line, 6) << "the only division of the rule";
  EXPECT_EQ(error.side, ErrorSide::kRhs);
  EXPECT_EQ(error.t, from_seconds(3));
  EXPECT_THAT(error.message, StartsWith("[PRNTUTIL7]"));
  EXPECT_THAT(error.detail, HasSubstr("[PRCCODE4]"));
}

TEST_F(RuleErrors, TheNextRunGoesOnAfterAnErrorThatHalted) {
  given(
      "(deffacts f (a 0) (b))\n(defrule halves (declare (salience 1)) (a ?x) => (/ 1 ?x))\n(defrule other (b) => "
      "(assert (c)))");
  engine().reset();
  EXPECT_THAT(engine().run().errors, SizeIs(1));
  EXPECT_THAT(fact_texts("c"), IsEmpty());
  const RunReport next = engine().run();
  EXPECT_THAT(next.errors, IsEmpty());
  EXPECT_EQ(next.fired, 1);
  EXPECT_THAT(fact_texts("c"), ElementsAre("(c)"));
}

TEST_F(RuleErrors, DivisionByZeroInAJoinTest) {
  given("(defrule ratio\n  (a ?x)\n  (b ?y)\n  (test (> (/ ?x ?y) 1))\n  =>\n)");
  ASSERT_TRUE(engine().assert_string("(a 1)").ok());
  ASSERT_TRUE(engine().assert_string("(b 0)").ok());
  const RunReport report = engine().run();
  EXPECT_THAT(texts(report.errors), ElementsAre(StartsWith("rules.clp:4: rule ratio, LHS: [PRNTUTIL7]")));
}

TEST_F(RuleErrors, DivisionByZeroInAPatternTest) {
  given("(deftemplate order (slot amount))\n(defrule ratio\n  (order (amount ?x&:(> (/ 1 ?x) 0)))\n  =>\n)");
  ASSERT_TRUE(engine().assert_fact("order", {{"amount", Value::integer(0)}}).ok());
  EXPECT_THAT(texts(engine().run().errors), ElementsAre(StartsWith("rules.clp:3: rule ratio, LHS: [PRNTUTIL7]")));
}

TEST_F(RuleErrors, ATestThatFailsBecauseOfAnotherRulesAssertNamesTheRuleOfTheTest) {
  given(
      "(deffacts f (go))\n(defrule asserts (go) => (assert (amount 0)))\n\n(defrule tests\n  (amount ?x)\n  (test (> "
      "(/ 1 ?x) 1))\n  =>)");
  engine().reset();
  EXPECT_THAT(texts(engine().run().errors), ElementsAre(StartsWith("rules.clp:6: rule tests, LHS: [PRNTUTIL7]")));
}

TEST_F(RuleErrors, RulesOfOneNameInTwoModulesHaveTheirOwnPlaces) {
  given(
      "(defmodule MAIN (export ?ALL))\n(deftemplate n (slot v))\n"
      "(defmodule A (import MAIN ?ALL))\n(defmodule B (import MAIN ?ALL))\n"
      "(defrule A::go (n (v ?x)) =>\n  (/ 1 ?x))\n"
      "(defrule B::go (n (v ?x)) =>\n\n  (mod 1 ?x))\n"
      "(defrule A::ask (n (v ?x)) (n (v ?y&:(> (/ 1 ?x) ?y))) => )\n"
      "(defrule B::ask (n (v ?x))\n  (n (v ?y&:(> (mod 1 ?x) ?y))) => )\n");
  for (const auto& [module, line] : {std::pair{"A", ":6"}, std::pair{"B", ":9"}}) {
    engine().reset();
    ASSERT_TRUE(engine().assert_string("(n (v 0))").ok());
    EXPECT_THAT(texts(engine().take_errors()),
                testing::UnorderedElementsAre(StartsWith("rules.clp:10: rule ask, LHS"),
                                              StartsWith("rules.clp:12: rule ask, LHS")));
    ASSERT_TRUE(engine().eval(std::string("(focus ") + module + ")").ok());
    EXPECT_THAT(texts(engine().run().errors),
                ElementsAre(StartsWith(std::string("rules.clp") + line + ": rule go, RHS")));
  }
}

TEST_F(RuleErrors, TheSameErrorOverAndOverIsCounted) {
  given("(deftemplate order (slot amount) (slot id))\n(defrule ratio (order (amount ?x&:(> (/ 1 ?x) 0))) =>)");
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(engine().assert_fact("order", {{"amount", Value::integer(0)}, {"id", Value::integer(i)}}).ok());
  }
  const std::vector<RuleError> errors = engine().take_errors();
  ASSERT_THAT(errors, SizeIs(1));
  EXPECT_EQ(errors[0].count, 3);
}

TEST_F(RuleErrors, ACallbackHasTheNameAndThePlaceOfItsDeffunction) {
  given("\n(deffunction on-request (?x)\n  (/ 1 ?x))");
  const Value zero = Value::integer(0);
  const Expected<Value> result = engine().call("on-request", {&zero, 1});
  ASSERT_FALSE(result.ok());
  EXPECT_THAT(result.error().text(), StartsWith("rules.clp:3: on-request, callback: [PRNTUTIL7]"));
  EXPECT_THAT(texts(engine().take_errors()), ElementsAre(result.error().text()));
}

TEST_F(RuleErrors, AnErrorNamesTheCallsThatLedToIt) {
  given(
      "(deffunction inner (?x) (/ 1 ?x))\n(defmethod middle ((?x INTEGER)) (inner ?x))\n"
      "(deffunction outer (?x)\n  (middle ?x))\n"
      "(defrule act (a) => (outer 0))\n(defrule test (b ?x&:(outer ?x)) =>)");
  ASSERT_TRUE(engine().assert_string("(a)").ok());
  EXPECT_THAT(texts(engine().run().errors),
              ElementsAre(AllOf(StartsWith("rules.clp:5: rule act, RHS: [PRNTUTIL7]"),
                                EndsWith(" (rule act -> deffunction outer (rules.clp:3) -> generic function 'middle' "
                                         "method #1 -> deffunction inner (rules.clp:1))"))));
  ASSERT_TRUE(engine().assert_string("(b 0)").ok());
  EXPECT_THAT(texts(engine().take_errors()),
              ElementsAre(AllOf(StartsWith("rules.clp:6: rule test, LHS: [PRNTUTIL7]"),
                                HasSubstr("deffunction outer (rules.clp:3) -> generic"))));
  const Value zero = Value::integer(0);
  const Expected<Value> result = engine().call("outer", {&zero, 1});
  ASSERT_FALSE(result.ok());
  EXPECT_THAT(result.error().text(), HasSubstr(" (outer -> generic function 'middle' method #1"));
}

TEST_F(RuleErrors, ALongChainOfCallsIsShownAtItsEnds) {
  given("(deffunction deep (?x) (if (> ?x 0) then (deep (- ?x 1)) else (/ 1 ?x)))\n(defrule go (a) => (deep 29))");
  ASSERT_TRUE(engine().assert_string("(a)").ok());
  EXPECT_THAT(texts(engine().run().errors), ElementsAre(HasSubstr("deffunction deep (rules.clp:1) -> 20 more -> ")));
}

TEST_F(RuleErrors, AFunctionThatFailsIsAnErrorOfTheRuleThatCalledIt) {
  ASSERT_TRUE(engine()
                  .add_function({.name = "send-it", .max_args = 0, .owner = "test"},
                                [](Call& call) { call.fail("no such topic"); })
                  .ok());
  given("(deffacts f (a))\n(defrule go (a)\n  =>\n  (send-it)\n  (assert (after)))");
  engine().reset();
  EXPECT_THAT(texts(engine().run().errors),
              ElementsAre("rules.clp:4: rule go, RHS: [CXLAB1] Function 'send-it': no such topic"));
  EXPECT_THAT(fact_texts("after"), IsEmpty()) << "the rest of the rule is skipped";
}

TEST_F(RuleErrors, AnExceptionOfAFunctionStaysInside) {
  ASSERT_TRUE(
      engine().add_function({.name = "explode", .max_args = 0}, [](Call&) { throw std::runtime_error("boom"); }).ok());
  given("(deffacts f (a))\n(defrule go (a) => (explode))");
  engine().reset();
  EXPECT_THAT(texts(engine().run().errors), ElementsAre(HasSubstr("[CXLAB1] Function 'explode': boom")));
}

TEST_F(RuleErrors, AnArgumentOfTheWrongTypeIsAnErrorOfTheRule) {
  ASSERT_TRUE(engine()
                  .add_function({.name = "twice", .min_args = 1, .max_args = 1, .arg_types = "l"},
                                [](Call& call) { call.give_integer(2 * call.integer(0)); })
                  .ok());
  given("(deffacts f (a x))\n(defrule go (a ?x) => (twice ?x))");
  engine().reset();
  EXPECT_THAT(texts(engine().run().errors), ElementsAre(HasSubstr("rule go, RHS: [ARGACCES2] Function 'twice'")));
}

TEST_F(RuleErrors, PrintingToStderrIsNoError) {
  given("(deffacts f (a))\n(defrule go (a) => (printout stderr \"[ODD1] only text\" crlf))");
  engine().reset();
  EXPECT_THAT(engine().run().errors, IsEmpty());
  EXPECT_EQ(output["stderr"], "[ODD1] only text\n");
}

TEST_F(RuleErrors, AnUnknownLogicalNameIsAnError) {
  given("(deffacts f (a))\n(defrule go (a) => (printout nowhere \"x\" crlf))");
  engine().reset();
  EXPECT_THAT(texts(engine().run().errors), ElementsAre(HasSubstr("rule go, RHS: [ROUTER1]")));
}

TEST_F(RuleErrors, ActingFunctionsOnALeftHandSideAreErrorsAtLoad) {
  ASSERT_TRUE(engine().add_function({.name = "publish", .kind = FunctionKind::kActing}, [](Call&) {}).ok());
  ASSERT_TRUE(engine().add_function({.name = "look-up", .kind = FunctionKind::kPure}, [](Call&) {}).ok());
  EXPECT_THAT(load_errors("(deffunction inner (?x) (publish ?x))\n"
                          "(deffunction outer (?x) (inner ?x))\n"
                          "(defrule direct\n  (a ?x&:(publish ?x))\n  =>)\n"
                          "(defrule hidden\n  (a ?x)\n  (test (and TRUE (outer ?x)))\n  =>)\n"
                          "(defrule fine (a ?x&:(look-up ?x)) (publish) => (publish ?x))\n",
                          LoadMode::kConstructs, OnLoadError::kStop),
              ElementsAre(AllOf(StartsWith("rules.clp:4: "), HasSubstr("'publish' on its left-hand side"))));
  const LoadReport rest = engine().load_text(
      "(defrule hidden\n  (a ?x)\n  (test (and TRUE (outer ?x)))\n  =>)\n"
      "(defrule fine (a ?x&:(look-up ?x)) (publish) => (publish ?x))\n",
      "agent.clp", LoadMode::kConstructs, OnLoadError::kKeepGoing);
  EXPECT_TRUE(rest.ok()) << "only a note for an agent written for the CX";
  const std::vector<Error> notes = engine().take_notes();
  ASSERT_THAT(notes, SizeIs(1));
  EXPECT_THAT(notes[0].text(), AllOf(StartsWith("agent.clp:3: "), HasSubstr("'outer'")));
}

TEST_F(RuleErrors, AnActingFunctionIsFoundBehindCallsInACircle) {
  ASSERT_TRUE(engine().add_function({.name = "publish", .kind = FunctionKind::kActing}, [](Call&) {}).ok());
  given(
      "(defgeneric there)\n(defmethod back ((?x INTEGER)) (there ?x))\n"
      "(defmethod there ((?x INTEGER)) (back ?x))\n(deffunction start (?x) (back ?x))\n"
      "(defrule first (a ?x&:(start ?x)) =>)\n");
  EXPECT_THAT(engine().take_notes(), IsEmpty());
  ASSERT_TRUE(engine()
                  .load_text("(defmethod there ((?x SYMBOL)) (publish ?x))", "more.clp", LoadMode::kConstructs,
                             OnLoadError::kKeepGoing)
                  .ok());
  EXPECT_THAT(engine().take_notes(), SizeIs(1));
  ASSERT_TRUE(engine()
                  .load_text("(defrule second (a ?x&:(back ?x)) =>)", "more.clp", LoadMode::kConstructs,
                             OnLoadError::kKeepGoing)
                  .ok());
  EXPECT_THAT(engine().take_notes(), SizeIs(1));
}

TEST_F(RuleErrors, ActingFunctionsAreFoundInEveryConditionalElement) {
  ASSERT_TRUE(engine().add_function({.name = "publish", .kind = FunctionKind::kActing}, [](Call&) {}).ok());
  int number = 0;
  for (const char* left :
       {"(a)\n (test (publish 1))", "(or (a)\n (and (b) (test (publish 1))))", "(and (a)\n (test (publish 1)))",
        "(a)\n (not (and (b) (test (publish 1))))", "(a)\n (exists (b ?x) (test (publish ?x)))",
        "(forall (a ?x)\n (b ?y&:(publish ?y)))", "(logical (a)\n (test (publish 1)))", "(a)\n (b =(publish 1))",
        "(a)\n (b ~=(publish 1))", "(a)\n (b ?x&~:(publish ?x))", "(a)\n (order (id ?x&:(publish ?x)))"})
    EXPECT_THAT(
        load_errors("(deftemplate order (slot id)) (defrule go" + std::to_string(++number) + ' ' + left + " =>)",
                    LoadMode::kConstructs, OnLoadError::kStop),
        ElementsAre(AllOf(StartsWith("rules.clp:2: "), HasSubstr("'publish' on its left-hand side"))))
        << left;
  EXPECT_THAT(load_errors("(deftemplate publish (multislot assert)) (deftemplate retract (slot publish))\n"
                          "(defrule fine (publish (assert publish ?))\n (retract (publish publish)) (a publish)\n"
                          " (not (publish (assert))) =>)",
                          LoadMode::kConstructs, OnLoadError::kStop),
              IsEmpty())
      << "names of templates and slots";
}

TEST_F(RuleErrors, TheLineIsThatOfTheCallNotOfAWord) {
  given("(deffacts f (a))\n(defrule go (a) =>\n  (printout nil div)\n  (bind ?div div)\n  (bind ?x (div 1 0)))");
  engine().reset();
  const RunReport report = engine().run();
  ASSERT_THAT(report.errors, SizeIs(1));
  EXPECT_EQ(report.errors[0].line, 5);
}

TEST_F(RuleErrors, OfSeveralCallsOfOneFunctionTheOneThatFailedIsNamed) {
  const auto line = [&](const std::string& actions) {
    given(
        "(deftemplate item (slot name) (slot size))\n"
        "(deffunction half (?x)\n  (bind ?y (/ 2 2))\n  (/ 1 ?x))\n(deffacts f (a))\n(defrule go ?f <- (a)\n =>\n" +
        actions + ")");
    engine().reset();
    const RunReport report = engine().run();
    EXPECT_EQ(report.errors.size(), 1u) << actions;
    return report.errors.empty() ? 0 : report.errors[0].line - 7;  // 1: the first line of the actions
  };
  EXPECT_EQ(line("(bind ?a (/ 4 2))\n(bind ?b (/ 4 0))\n(bind ?c (/ 4 1))"), 2);
  EXPECT_EQ(line("(bind ?a (/ 4 2))\n(if (> ?a 1) then\n(create$ (/ 1 1)\n(/ 1 0)))"), 4);
  EXPECT_EQ(line("(assert-string \"(b 1)\")\n(assert-string \"(b 2)\")\n(assert-string \"(b\")"), 3);
  EXPECT_EQ(line("(eval \"(+ 1 1)\")\n(eval \"(/ 1 0)\")\n(eval \"(+ 1 1)\")"), 2);
  EXPECT_EQ(line("(eval \"(+ 1 1)\")\n(eval \"(create$ (eval \\\"1\\\") (/ 1 0))\")\n(eval \"(+ 1 1)\")"), 2);
  EXPECT_EQ(line("(half 1)\n(half 2)\n(create$\n(half 0))\n(half 3)"), 4) << "the call of a deffunction";
  EXPECT_EQ(line("(bind ?x (/ 2 1))\n(half 0)"), 2) << "not the call of '/' in the rule";
  EXPECT_EQ(line("(modify ?f)\n(bind ?g 99)\n(modify ?g\n(size 1))"), 3);
  EXPECT_EQ(line("(assert (b (/ 1 1)))\n(assert (b\n(/ 1 0)))"), 3);
  EXPECT_EQ(line("(loop-for-count (?i 1 2) do\n(create$ (/ 1 1))\n(/ 1 (- 2 ?i)))"), 3);
  EXPECT_EQ(line("(do-for-all-facts ((?i a)) (> (/ 1 1) 0)\n(/ 1 1)\n(/ 1 0))"), 3);
  EXPECT_EQ(line("(switch 1\n(case 1 then\n(create$ (/ 3 3))\n(/ 1 0)))"), 4);
  EXPECT_EQ(line("(bind ?x (create$ a))\n(+ (nth$ 1 ?x)\n1)\n(+ 1 1)"), 2);
  EXPECT_EQ(line("(assert (item\n(size (/ 1 0))\n(name (/ 1 1))))"), 1) << "CLIPS sorts slots: the line of the fact";
}

TEST_F(RuleErrors, InACallbackToo) {
  given("(deffunction back (?x) \"comment\"\n  (bind ?y (/ 2 2))\n  (create$\n    (/ 1 ?x))\n  ?x)");
  const Value zero = Value::integer(0);
  (void)engine().call("back", {&zero, 1});
  const std::vector<RuleError> errors = engine().take_errors();
  ASSERT_THAT(errors, SizeIs(1));
  EXPECT_EQ(errors[0].line, 4);
}

TEST_F(RuleErrors, AFunctionThatBecomesActingIsReportedForTheRulesThatReachIt) {
  ASSERT_TRUE(engine().add_function({.name = "publish", .kind = FunctionKind::kActing}, [](Call&) {}).ok());
  given(
      "(deffunction inner (?x) ?x)\n(deffunction outer (?x) (inner ?x))\n(deffunction other (?x) ?x)\n"
      "(defrule reaches (a ?x&:(outer ?x)) =>)\n(defrule does-not (a ?x&:(other ?x)) =>)\n");
  EXPECT_THAT(engine().take_notes(), IsEmpty());
  const LoadReport again = engine().load_text("(deffunction inner (?x) (publish ?x))", "again.clp",
                                              LoadMode::kConstructs, OnLoadError::kKeepGoing);
  EXPECT_TRUE(again.ok());
  const std::vector<Error> notes = engine().take_notes();
  ASSERT_THAT(notes, SizeIs(2)) << "it is defined twice, too";
  EXPECT_THAT(notes[1].text(), AllOf(HasSubstr("rule 'reaches'"), HasSubstr("'outer'")));
}

TEST_F(RuleErrors, AnUnboundVariableAsArgumentIsAnErrorOnceAndTheFunctionIsNotCalled) {
  int calls = 0;
  const auto count = [&calls](Call&) { ++calls; };
  ASSERT_TRUE(engine().add_function({.name = "take", .min_args = 1, .max_args = 1, .arg_types = ";e"}, count).ok());
  ASSERT_TRUE(engine().add_function({.name = "take-any", .min_args = 1, .max_args = 1}, count).ok());
  given(
      "(defrule typed (go) => (bind ?x (nth$ 1 (create$ 1))) (bind ?x) (take ?x))\n(defrule any (go) => (bind ?x (nth$ "
      "1 (create$ 1))) (bind ?x) (take-any ?x))");
  ASSERT_TRUE(engine().assert_string("(go)").ok());
  for (int rule = 0; rule < 2; ++rule) {
    const RunReport report = engine().run();
    EXPECT_EQ(report.fired, 1);
    ASSERT_FALSE(report.errors.empty());
    const std::string& said = report.errors.front().detail;
    EXPECT_THAT(said, HasSubstr("Variable ?x unbound"));
    EXPECT_EQ(said.find("unbound"), said.rfind("unbound")) << said;
  }
  EXPECT_EQ(calls, 0);
}

TEST_F(RuleErrors, ALoopIsStoppedAndExplained) {
  given("(deffacts f (count 0))\n(defrule endless ?c <- (count ?n) => (retract ?c) (assert (count (+ ?n 1))))");
  engine().reset();
  const RunReport report = engine().run(1000);
  EXPECT_EQ(report.fired, 1000);
  EXPECT_TRUE(report.loop);
  EXPECT_THAT(
      report.loop_report.text(),
      AllOf(HasSubstr("after 1000 firings"), HasSubstr("endless (1000 x, rules.clp:2)"), HasSubstr("count (2000 x)")));
}

TEST_F(RuleErrors, ALoopIsReportedByItsOwnFiringsTheMostFrequentFirst) {
  given(
      "(deffacts f (count 0))\n"
      "(defrule often ?c <- (count ?n&~500) => (retract ?c) (assert (count (mod (+ ?n 1) 501))))\n"
      "(defrule seldom ?c <- (count 500) => (retract ?c) (assert (count 0)))");
  engine().reset();
  for (int i = 0; i < 2; ++i) {
    const RunReport report = engine().run(1002);
    ASSERT_TRUE(report.loop);
    ASSERT_EQ(report.loop_report.rules.size(), 2u);
    EXPECT_EQ(report.loop_report.rules[0].name, "often");
    EXPECT_EQ(report.loop_report.rules[0].count, 1000) << "of this run";
    EXPECT_EQ(report.loop_report.rules[1].count, 2);
  }
  ASSERT_TRUE(engine().eval("(undefrule often)").ok());
  EXPECT_FALSE(engine().run(1000).loop) << "the report of the last run is over";
}

TEST_F(RuleErrors, TheReportOfALoopHasItsFiveMostFrequent) {
  std::string rules = "(deffacts f (count 0))\n";
  for (int i = 0; i < 6; ++i)
    rules += "(deftemplate t" + std::to_string(i) + ")\n(defrule r" + std::to_string(i) + " (declare (salience " +
             std::to_string(i) + ")) ?c <- (count ?n&:(= 0 (mod ?n " + std::to_string(1 << i) +
             "))) => (retract ?c) (assert (count (+ ?n 1))) (retract (assert (t" + std::to_string(i) + "))))\n";
  given(rules);
  engine().reset();
  const LoopReport report = engine().run(1000).loop_report;
  ASSERT_THAT(report.rules, SizeIs(5));
  ASSERT_THAT(report.templates, SizeIs(5));
  EXPECT_EQ(report.rules[0].name, "r0");
  EXPECT_EQ(report.rules[4].name, "r5") << "32 times; r4 31 times";
  EXPECT_EQ(report.templates[0].name, "count");
  for (std::size_t i = 1; i < 5; ++i) {
    EXPECT_GE(report.rules[i - 1].count, report.rules[i].count);
    EXPECT_GE(report.templates[i - 1].count, report.templates[i].count);
  }
}

TEST_F(RuleErrors, ARunInAFileThatNeverEndsIsStoppedAtItsLine) {
  EngineOptions options;
  options.max_load_firings = 1000;
  const auto engine = RuleEngine::create(options);
  ASSERT_TRUE(engine.ok());
  const LoadReport report = (*engine)->load_text(
      "(deftemplate n (slot x))\n(defrule endless ?n <- (n (x ?x)) => (modify ?n (x (+ ?x 1))))\n"
      "(assert (n (x 1)))\n(run)\n(deffacts more (a))",
      "calls.bat", LoadMode::kBatch, OnLoadError::kKeepGoing);
  ASSERT_EQ(report.errors.size(), 1u);
  EXPECT_THAT(report.errors[0].text(), AllOf(HasSubstr("calls.bat:4: "), HasSubstr("after 1000 firings"),
                                             HasSubstr("endless (1000 x, calls.bat:2)")));
  EXPECT_NE((*engine)->find_construct("deffacts", "more"), nullptr) << "the rest is loaded";
}

TEST_F(RuleErrors, ARunThatEndsAtItsLimitIsNoLoop) {
  given("(deffacts f (a 1) (a 2) (a 3))\n(defrule go (a ?) =>)");
  engine().reset();
  const RunReport report = engine().run(3);
  EXPECT_EQ(report.fired, 3);
  EXPECT_FALSE(report.loop);
  EXPECT_EQ(output["stdout"], "");
}

TEST_F(RuleErrors, AnUnknownDeftemplateOrFunctionGetsTheNearestName) {
  given("(deftemplate robot (slot name))\n(deffunction drive-to (?x) ?x)");
  const auto error_of = [&](const std::string& actions) {
    const std::vector<std::string> errors = load_errors("(defrule r => " + actions + ")");
    return errors.empty() ? "" : errors.front();
  };
  const std::string at = "rules.clp:1: [EXPRNPSR3] Missing function declaration for ";
  EXPECT_EQ(error_of("(assert (robto (name x)))"),
            at + "'name'. There is no deftemplate 'robto', did you mean 'robot'?");
  EXPECT_EQ(error_of("(if TRUE then (assert (robot (name a)) (robt (name x))))"),
            at + "'name'. There is no deftemplate 'robt', did you mean 'robot'?");
  EXPECT_EQ(error_of("(assert (quite-another (name x)))"), at + "'name'. There is no deftemplate 'quite-another'");
  EXPECT_EQ(error_of("(pritnout t x)"), at + "'pritnout', did you mean 'printout'?");
  EXPECT_EQ(error_of("(drive-ot 1)"), at + "'drive-ot', did you mean 'drive-to'?");
  EXPECT_EQ(error_of("(assert (robot (name (zzzzzzzz))))"), at + "'zzzzzzzz'.");

  given("(defrule later => (assert-string \"(robto (name x))\"))");
  const RunReport report = engine().run();
  ASSERT_EQ(report.errors.size(), 1U);
  EXPECT_EQ(
      report.errors.front().text(),
      "rules.clp:1: rule later, RHS: [EXPRNPSR3] Missing function declaration for 'name'. There is no deftemplate "
      "'robto', did you mean 'robot'?");
}

}  // namespace
}  // namespace cxlab
