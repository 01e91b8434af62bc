// Limits: memory, and a stop in the middle of what rules do.

#include "tests/support/engine_test.h"

namespace cxlab {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

struct LimitsTest : EngineTest {
  LimitsTest() { limits.memory = 20'000'000; }
  void SetUp() override {
    EngineOptions o = options();
    o.limits = &limits;
    engine_ = make(std::move(o));
  }
  void TearDown() override { engine_.reset(); }
  Limits limits;
};

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
    limits = Limits();
    limits.memory = 20'000'000;
    SetUp();
    given(
        "(defclass thing (is-a USER) (slot n))\n"
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
  EXPECT_GT(limits.held, limits.memory);
  EXPECT_LT(limits.held, limits.memory + 1'000'000);
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
