// Limits: memory, and a stop in the middle of what rules do.

#include "cx/base/charge.h"
#include "tests/support/engine_test.h"

namespace cxlab {
namespace {

using testing::AllOf;
using testing::Ge;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Le;

struct LimitsTest : EngineTest {
  LimitsTest() { limits.memory = 20'000'000; }
  void SetUp() override {
    EngineOptions o = options();
    o.limits = &limits;
    engine_ = make(std::move(o));
  }
  void TearDown() override { engine_.reset(); }
  LimitsInUse limits;
};

TEST_F(LimitsTest, WhatWasTakenBeforeTheRulesCameIsNotTheirs) {
  Charge::written(50'000'000);
  Charge::allocated(50'000'000);
  limits = LimitsInUse();
  limits.memory = 20'000'000;
  limits.disk = 5'000'000;
  SetUp();
  given("(defrule modest (go) => (assert (done)))");
  ASSERT_TRUE(engine().assert_string("(go)").ok());
  engine().run();
  EXPECT_FALSE(limits.exceeded) << limits.exceeded->message;
  Charge::allocated(-50'000'000);
}

TEST_F(LimitsTest, EachWayToTakeMemoryEndsAtTheRule) {
  for (const char* actions : {
           "(bind ?i 0) (while TRUE (bind ?i (+ ?i 1)) (assert (x ?i)))",
           "(assert (x 0)) (do-for-all-facts ((?f x)) TRUE (assert (x (+ (nth$ 1 ?f:implied) 1))))",
           "(bind ?s \"abcdefgh\") (while TRUE (bind ?s (str-cat ?s ?s)))",
           "(bind ?s (create$ a b c)) (while TRUE (bind ?s (create$ ?s ?s)))",
           "(bind ?i 0) (while TRUE (bind ?i (+ ?i 1)) (make-instance of thing (n ?i)))",
           "(bind ?i 0) (while TRUE (bind ?i (+ ?i 1)) (bind ?g (str-cat symbol ?i)) (assert (y ?g)))",
           "(again 1 (create$ a b c))",
       }) {
    limits = LimitsInUse();
    limits.memory = 20'000'000;
    SetUp();
    given(
        "(defclass thing (is-a USER) (slot n) (multislot m (default a b)))\n"
        "(deffunction again (?n ?list) (assert (z ?n)) (again (+ ?n 1) (create$ ?list ?list)))\n"
        "(defrule greedy (go) =>\n  " +
        std::string(actions) + ")");
    ASSERT_TRUE(engine().assert_string("(go)").ok());
    engine().run();
    ASSERT_TRUE(limits.exceeded) << actions;
    EXPECT_EQ(limits.exceeded->kind, ErrorKind::kResource);
    EXPECT_EQ(limits.exceeded->text(),
              "rules.clp:3: environment 'main': rule greedy: rules hold more than 20 MB of memory; if they are right, "
              "allow more with --memory");
  }
}

TEST_F(LimitsTest, FactsOfManyFiringsCountToo) {
  given("(defrule grow (n ?n) => (assert (n (+ ?n 1))))");
  ASSERT_TRUE(engine().assert_string("(n 0)").ok());
  const RunReport report = engine().run();
  ASSERT_TRUE(limits.exceeded);
  EXPECT_GT(report.fired, 1000);
  const std::int64_t held = limits.held + Charge::memory() - limits.before->memory;
  EXPECT_GT(held, limits.memory);
  EXPECT_LT(held, limits.memory + 1'000'000);
}

TEST_F(LimitsTest, AFactThatDoublesWithEachFiringEndsInTime) {
  given("(defrule double ?f <- (list $?all) => (retract ?f) (assert (list ?all ?all)))");
  ASSERT_TRUE(engine().assert_string("(list a b c)").ok());
  EXPECT_LT(engine().run().fired, 25);
  ASSERT_TRUE(limits.exceeded);
  EXPECT_LT(limits.held, 4 * limits.memory);
}

TEST_F(LimitsTest, AllEnvironmentsShareThem) {
  EngineOptions o = options();
  o.name = "second";
  o.limits = &limits;
  const auto second = make(std::move(o));
  const char* grow = "(deffunction grow (?to) (loop-for-count (?i 1 ?to) (assert (x ?i))))";
  given(grow);
  ASSERT_TRUE(second->load_text(grow, "second.clp", LoadMode::kConstructs).ok());
  ASSERT_TRUE(engine().eval("(grow 20000)").ok());
  const std::int64_t first = limits.held;
  EXPECT_GT(first, 2'000'000);
  ASSERT_TRUE(second->eval("(grow 20000)").ok());
  EXPECT_GT(limits.held, first * 3 / 2);
  ASSERT_FALSE(limits.exceeded);
  limits.memory = limits.held + 100'000;
  (void)second->eval("(grow 40000)");
  ASSERT_TRUE(limits.exceeded);
  EXPECT_THAT(limits.exceeded->message, HasSubstr("environment 'second': "));
  // From now on no rule of either acts.
  const std::size_t facts = engine().fact_count();
  given("(defrule more (x ?) => (assert (more)))");
  engine().run();
  EXPECT_EQ(engine().fact_count(), facts);
}

TEST_F(LimitsTest, WithoutALimitNothingEnds) {
  limits.memory = 0;
  ASSERT_TRUE(engine().eval("(loop-for-count (?i 1 100000) (assert-string (str-cat \"(x \" ?i \")\")))").ok());
  EXPECT_FALSE(limits.exceeded);
}

TEST_F(LimitsTest, WhatFunctionsAllocateForRulesCountsUntilItIsFreed) {
  std::vector<std::string> texts;
  const auto add = [&](FunctionSpec spec, Function function) {
    ASSERT_TRUE(engine().add_function(std::move(spec), std::move(function)).ok());
  };
  add({.name = "keep-text", .min_args = 0, .max_args = 0, .owner = "test"},
      [&](Call& call) { texts.emplace_back(1'000'000, 'x'), call.give_boolean(true); });
  add({.name = "drop-texts", .min_args = 0, .max_args = 0, .owner = "test"},
      [&](Call& call) { texts.clear(), call.give_boolean(true); });
  given(
      "(deffunction some () (loop-for-count 10 (keep-text)) (drop-texts))\n(defrule greedy => (while TRUE "
      "(keep-text)))");
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(engine().call("some", {}).ok());
  ASSERT_FALSE(limits.exceeded);
  engine().run();
  ASSERT_TRUE(limits.exceeded);
  EXPECT_EQ(limits.exceeded->text(),
            "rules.clp:2: environment 'main': rule greedy: rules hold more than 20 MB of memory; if they are right, "
            "allow more with --memory");
  EXPECT_THAT(texts.size(), AllOf(Ge(17), Le(21)));
  const std::int64_t held = Charge::memory();
  texts = {};  // freed while no rule is at work
  EXPECT_LT(Charge::memory(), held - 17'000'000);
}

TEST_F(LimitsTest, WhatIsAllocatedBesideRulesDoesNotCount) {
  const std::int64_t before = Charge::memory();
  const std::string mine(1'000'000, 'x');
  EXPECT_EQ(Charge::memory(), before);
  const Charge on;
  const std::string theirs(1'000'000, 'x');
  EXPECT_GE(Charge::memory(), before + 1'000'000);
  const Charge off(false);
  const std::string not_theirs(1'000'000, 'x');
  EXPECT_LT(Charge::memory(), before + 2'000'000);
}

TEST_F(LimitsTest, WhatIsWrittenForRulesCounts) {
  limits.disk = 5'000'000;
  engine().begin_tick();
  Charge::written(6'000'000);
  given("(defrule any => (assert (a)))");
  engine().run();
  ASSERT_TRUE(limits.exceeded);
  EXPECT_EQ(limits.exceeded->kind, ErrorKind::kResource);
  EXPECT_THAT(limits.exceeded->message, HasSubstr("rules have written more than 5 MB to the disk"));
}

TEST_F(LimitsTest, StepsEndAMatchAndNameItsRule) {
  limits.steps = 1'000'000;
  engine().begin_tick();
  given(
      "(deffunction fill (?n) (loop-for-count (?i 1 ?n) (assert (x ?i))))\n"
      "(defrule few (x ?a) => (assert (y)))\n"
      "(defrule many (x ?a) (x ?b&:(< ?b ?a)) (x ?c&:(< (+ ?a ?b ?c) 0)) =>)");
  ASSERT_TRUE(engine().eval("(fill 50)").ok());
  EXPECT_FALSE(limits.exceeded);
  (void)engine().eval("(fill 1000)");
  ASSERT_TRUE(limits.exceeded);
  EXPECT_EQ(limits.exceeded->kind, ErrorKind::kRun);
  EXPECT_EQ(limits.exceeded->code, "rule_loop");
  EXPECT_EQ(
      limits.exceeded->text(),
      "rules.clp:3: environment 'main': rule many: its conditions are tried in many combinations of facts: rules have "
      "taken more than 1000000 steps in one tick; if they are right, allow more with --steps");
  EXPECT_LE(engine().run().fired, 1);
}

TEST_F(LimitsTest, StepsOfReadingNameThePlaceThatWasRead) {
  limits.steps = 1000;
  engine().begin_tick();
  std::string text;
  for (int i = 0; i < 1000; ++i) text += "(deftemplate t" + std::to_string(i) + " (slot a))\n";
  (void)engine().load_text(text, "many.clp", LoadMode::kConstructs);
  ASSERT_TRUE(limits.exceeded);
  EXPECT_GT(limits.exceeded->line, 1);
  EXPECT_LT(limits.exceeded->line, 1000);
  EXPECT_EQ(limits.exceeded->text(),
            "many.clp:" + std::to_string(limits.exceeded->line) +
                ": environment 'main': rules have taken more than 1000 steps in one tick; if they are right, allow "
                "more with --steps");
}

TEST_F(LimitsTest, StepsAreThoseOfATick) {
  limits.steps = 100'000;
  for (int tick = 0; tick < 10; ++tick) {
    engine().begin_tick();
    ASSERT_TRUE(engine().eval("(loop-for-count 20000 (+ 1 1))").ok());
    ASSERT_FALSE(limits.exceeded) << tick;
  }
  for (int i = 0; i < 10; ++i) (void)engine().eval("(loop-for-count 20000 (+ 1 1))");
  EXPECT_TRUE(limits.exceeded);
}

TEST_F(LimitsTest, ATextThatIsMadeIsTwoSteps) {
  limits.steps = 100'000;
  for (const auto& [call, too_many] : {std::pair("(+ 1 1)", false),
                                       {"(str-compare a b)", false},
                                       {"(str-cat a b)", true},
                                       {"(sub-string 1 1 ab)", true}}) {
    engine().begin_tick();
    (void)engine().eval("(loop-for-count 24000 " + std::string(call) + ")");
    EXPECT_EQ(limits.exceeded.has_value(), too_many) << call;
    limits.exceeded.reset();
  }
}

TEST_F(LimitsTest, ARunThatStaysBelowEndsAtTheSameStep) {
  std::vector<std::int64_t> facts;
  for (const std::int64_t steps : {50'000, 50'000, 100'000}) {
    limits = LimitsInUse();
    limits.steps = steps;
    SetUp();
    given("(defrule again (n ?n) => (assert (n (+ ?n 1))))");
    ASSERT_TRUE(engine().assert_string("(n 0)").ok());
    engine().run();
    ASSERT_TRUE(limits.exceeded);
    facts.push_back(static_cast<std::int64_t>(engine().fact_count()));
  }
  EXPECT_EQ(facts[0], facts[1]);
  EXPECT_GT(facts[2], facts[1] * 3 / 2);
}

/// Rules that go round: each turn asserts a fact more, which `compared` tries with all others.
constexpr const char* kDearRound =
    "(deffacts start (next 1))\n"
    "(defrule compared (order ?a) (order ?b&:(> ?b ?a)) (never ?a ?b) =>)\n"
    "(defrule plan (next ?n) => (assert (planned ?n)))\n"
    "(defrule carry-out ?p <- (planned ?n) ?f <- (next ?n) => (retract ?p ?f) (assert (order ?n) (next (+ ?n 1))))";

TEST_F(LimitsTest, RulesThatGoRoundAreNamedLongBeforeTheStepsEnd) {
  limits.memory = 0;
  given(kDearRound);
  engine().reset();
  engine().run();
  ASSERT_TRUE(limits.exceeded);
  EXPECT_EQ(limits.exceeded->code, "rule_loop");
  EXPECT_THAT(limits.exceeded->text(),
              AllOf(HasSubstr("rules go round in a loop"), HasSubstr("plan ("), HasSubstr("rules.clp:3"),
                    HasSubstr("carry-out ("), HasSubstr("rules.clp:4"), HasSubstr("next ("), HasSubstr("--steps"),
                    Not(HasSubstr("compared"))));
}

TEST_F(LimitsTest, ARoundIsTheSameAtEachTime) {
  limits.memory = 0;
  std::vector<std::string> said;
  for (int i = 0; i < 2; ++i) {
    limits = LimitsInUse();
    SetUp();
    given(kDearRound);
    engine().reset();
    engine().run();
    ASSERT_TRUE(limits.exceeded);
    said.push_back(limits.exceeded->text() + std::to_string(engine().fact_count()));
  }
  EXPECT_EQ(said[0], said[1]);
}

/// A look walks along all firings of a tick, so there is work of rules between two of them.
TEST_F(LimitsTest, RulesAreLookedAtNowAndThenOnly) {
  limits.memory = 0;
  given(
      "(deffacts start (load 1) (load 2) (load 3) (load 4) (load 5) (load 6) (load 7) (load 8) (load 9) (n 0))\n"
      "(defrule work (declare (salience 1)) (load ?) =>"
      " (bind ?i 0) (loop-for-count 600000 (bind ?i (+ ?i 1))))\n"
      "(defrule again ?f <- (n ?n) => (retract ?f) (assert (n (+ ?n 1))))");
  engine().reset();
  const std::int64_t turns = engine().run().fired - 9;
  ASSERT_TRUE(limits.exceeded);
  EXPECT_THAT(limits.exceeded->text(), AllOf(HasSubstr("rules go round in a loop"), HasSubstr("again (")));
  EXPECT_GE(turns, 1000) << "the first look comes before there is a round, the second one long after it";
  EXPECT_LE(turns, 10000) << "and soon enough";
}

TEST_F(LimitsTest, ARoundThatEndsIsNone) {
  limits.memory = 0;
  given(
      "(deffacts start (n 0))\n"
      "(defrule again ?f <- (n ?n&:(< ?n 90000)) => (retract ?f) (assert (n (+ ?n 1))))");
  engine().reset();
  EXPECT_EQ(engine().run().fired, 90000);
  EXPECT_FALSE(limits.exceeded);
}

TEST_F(LimitsTest, AnAgendaThatIsDrainedIsNoRound) {
  limits.memory = 0;
  given("(defrule each (x ?i) => (bind ?n 0) (loop-for-count 2000 (bind ?n (+ ?n 1))) (assert (y ?i)))");
  for (int i = 0; i < 5000; ++i) ASSERT_TRUE(engine().assert_string("(x " + std::to_string(i) + ")").ok());
  EXPECT_EQ(engine().run().fired, 5000) << "with 30 million steps";
  EXPECT_FALSE(limits.exceeded);
}

TEST_F(LimitsTest, AnActionThatDoesNotEndIsNamed) {
  given("(defrule before => (assert (go)))\n(defrule spin (go) => (bind ?i 0) (while TRUE (bind ?i (+ ?i 1))))");
  const RunReport report = engine().run();
  ASSERT_EQ(report.errors.size(), 1u);
  EXPECT_THAT(report.errors[0].text(),
              AllOf(HasSubstr("rules.clp:2: rule spin, RHS: "), HasSubstr("Still looping after ")));
}

TEST_F(LimitsTest, ManyFactsAreManySteps) {
  limits.memory = 0;
  given(
      "(deftemplate p (slot id) (slot x))\n"
      "(defrule fill (go) => (loop-for-count (?i 1 100000) (assert (p (id ?i) (x (mod ?i 317))))))\n"
      "(defrule pair (p (id ?i) (x 5)) (p (id ?j&:(> ?j ?i)) (x 7)) => )");
  ASSERT_TRUE(engine().assert_string("(go)").ok());
  engine().run();
  EXPECT_FALSE(limits.exceeded) << limits.exceeded->text();
}

TEST_F(LimitsTest, AStopEndsAMatch) {
  std::atomic<bool> stop = false;
  limits.stop = &stop;
  limits.steps = 0;
  given(
      "(defrule many (x ?a) (x ?b&:(< ?b ?a)) (x ?c&:(< (+ ?a ?b ?c) 0)) =>)\n(deffunction fill (?n) "
      "(loop-for-count (?i 1 ?n) (assert (x ?i))))");
  ASSERT_TRUE(engine().eval("(fill 300)").ok());
  stop = true;
  (void)engine().eval("(assert (x 301))");
  ASSERT_TRUE(limits.exceeded);
  EXPECT_EQ(limits.exceeded->code, kStoppedCode);
}

TEST_F(LimitsTest, AStopEndsALoopInTheMiddle) {
  std::atomic<bool> stop = false;
  limits.stop = &stop;
  given("(defrule before => (assert (done)))\n(defrule endless (done) => (while TRUE (bind ?x 1)) (assert (after)))");
  stop = true;
  engine().run();
  ASSERT_TRUE(limits.exceeded);
  EXPECT_EQ(limits.exceeded->code, kStoppedCode);
  EXPECT_THAT(limits.exceeded->text(), HasSubstr("stopped by a signal in the middle of a tick"));
  EXPECT_THAT(fact_texts("after"), IsEmpty());
}

TEST_F(LimitsTest, AFunctionThatTheHostCallsIsNamed) {
  given("\n(deffunction grow (?to) (loop-for-count (?i 1 ?to) (assert (x ?i))))");
  const Value many[] = {Value::integer(1'000'000)};
  (void)engine().call("grow", many);
  ASSERT_TRUE(limits.exceeded);
  EXPECT_EQ(limits.exceeded->message,
            "environment 'main': grow: rules hold more than 20 MB of memory; if they are right, allow more with "
            "--memory");
}

TEST_F(LimitsTest, WhereThereAreNoneNothingIsExceeded) {
  engine_ = make(options());
  engine().exceed_limits(resource_error("first"));
  ASSERT_TRUE(engine().assert_string("(a)").ok());
  given("(defrule go (a) => (assert (b)))");
  EXPECT_EQ(engine().run().fired, 1);
}

TEST_F(LimitsTest, TheFirstReasonStays) {
  engine().exceed_limits(resource_error("first"));
  engine().exceed_limits(resource_error("second"));
  ASSERT_TRUE(limits.exceeded);
  EXPECT_EQ(limits.exceeded->message, "environment 'main': first");
}

TEST_F(LimitsTest, CallsOfTheHostAreCounted) {
  given("(deffunction f () 1)");
  EXPECT_EQ(engine().take_call_count(), 0);
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(engine().call("f", {}).ok());
  EXPECT_EQ(engine().take_call_count(), 3);
  EXPECT_EQ(engine().take_call_count(), 0);
}

}  // namespace
}  // namespace cxlab
