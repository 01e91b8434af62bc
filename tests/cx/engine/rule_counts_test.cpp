// The counts of rules agree with CLIPS and with combinations counted by hand, and counting changes nothing.

#include <numeric>
#include <set>

#include "tests/support/engine_test.h"

namespace cxlab {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

struct RuleCountsOf : EngineTest {
  RuleCounts rule(const std::string& name) {
    for (const RuleCounts& one : engine().counts().rules)
      if (one.info.name == name) return one;
    ADD_FAILURE() << "there is no rule " << name;
    return {};
  }
  std::vector<std::int64_t> passed(const std::string& name, std::size_t disjunct = 0) {
    std::vector<std::int64_t> passed;
    const RuleCounts counts = rule(name);
    for (const JoinCounts& join : counts.disjuncts.at(disjunct)) passed.push_back(join.passed);
    return passed;
  }
  std::int64_t calls(const std::string& name) {
    for (const FunctionCounts& one : engine().counts().functions)
      if (one.info.name == name) return one.calls;
    return -1;
  }
  void assert_all(std::initializer_list<const char*> facts) {
    for (const char* fact : facts) ASSERT_TRUE(engine().assert_string(fact).ok()) << fact;
  }
};

TEST_F(RuleCountsOf, PartialMatchesAreThoseThatAPersonCounts) {
  engine().count(Counting::kUse);
  given("(defrule pairs (a ?x) (b ?y) (test (< ?x ?y)) (not (c ?x)) =>)");
  assert_all({"(a 1)", "(a 2)", "(a 3)", "(b 2)", "(b 3)", "(c 1)"});
  // (1 2) (1 3) (2 3) are in order; (1 2) and (1 3) got past the `not` before (c 1) came.
  EXPECT_THAT(passed("pairs"), ElementsAre(3, 3, 3));
  const auto joins = rule("pairs").disjuncts.at(0);
  EXPECT_THAT(joins.at(1).reached, ElementsAre(6)) << "all pairs reached the test";
  EXPECT_EQ(joins.at(1).compared, 6);
  EXPECT_EQ(joins.at(2).held, 1) << "(2 3)";
  EXPECT_EQ(rule("pairs").activated, 3);
  EXPECT_EQ(rule("pairs").fired, 0);
  engine().run();
  EXPECT_EQ(rule("pairs").fired, 1);
}

// The same numbers from the command of CLIPS: compares, adds and deletes of all joins of a rule.
TEST_F(RuleCountsOf, JoinsAgreeWithTheJoinActivityOfClips) {
  engine().count(Counting::kUse);
  given(
      "(defrule some (a ?x) (b ?x ?y) (not (and (c ?y) (d ?x))) (exists (e ?y)) =>)\n(defrule other (or (a 1) (b 1 ?)) "
      "(c ?) =>)");
  for (int x = 0; x < 4; ++x)
    for (int y = 0; y < 3; ++y) {
      const std::string both = std::to_string(x) + ' ' + std::to_string(y);
      ASSERT_TRUE(engine().assert_string("(a " + std::to_string(x) + ')'));
      ASSERT_TRUE(engine().assert_string("(b " + both + ')'));
      if (x == y) (void)engine().assert_string("(c " + std::to_string(y) + ')');
      if (x > 1) (void)engine().assert_string("(e " + std::to_string(y) + ')');
    }
  for (const char* name : {"some", "other"}) {
    const auto activity = engine().eval("(join-activity " + std::string(name) + " terse)");
    ASSERT_TRUE(activity.ok());
    std::int64_t compared = 0, passed = 0;
    for (const auto& disjunct : rule(name).disjuncts)
      for (const JoinCounts& join : disjunct) {
        compared += join.compared;
        passed += join.passed;
      }
    EXPECT_EQ(compared, activity->items()[0].as_integer()) << name;
    // CLIPS lists what is inside of the group, too.
    EXPECT_LE(passed, activity->items()[1].as_integer()) << name;
    if (std::string(name) == "other") {
      EXPECT_EQ(passed, activity->items()[1].as_integer());
    }
  }
}

TEST_F(RuleCountsOf, ARuleThatIsRemovedOrReplacedIsKept) {
  engine().count(Counting::kUse);
  given("(defrule go (a ?) =>)\n(defrule went (b ?) =>)");
  assert_all({"(a 1)", "(a 2)", "(b 1)"});
  engine().run();
  given("(defrule go (a ?) (b ?) =>)");
  ASSERT_TRUE(engine().undefine("defrule", "went").ok());
  engine().run();
  std::vector<std::pair<std::string, std::int64_t>> fired;
  for (const RuleCounts& one : engine().counts().rules) fired.emplace_back(one.info.text, one.fired);
  EXPECT_THAT(fired, ElementsAre(std::pair("(defrule go (a ?) =>)", 2), std::pair("(defrule went (b ?) =>)", 1),
                                 std::pair("(defrule go (a ?) (b ?) =>)", 2)));
}

TEST_F(RuleCountsOf, CallsOfDeffunctionsAreCounted) {
  given("(deffunction half (?x) (/ ?x 2))\n(deffunction never () 1)\n(deffunction sum (?x) (+ (half ?x) (half ?x)))");
  given("(defrule go (a ?x&:(> (sum ?x) 1)) => (half 3))");
  engine().count(Counting::kUse);
  assert_all({"(a 1)", "(a 2)", "(a 3)"});
  engine().run();
  EXPECT_EQ(calls("sum"), 3);
  EXPECT_EQ(calls("half"), 2 * 3 + 2);
  EXPECT_EQ(calls("never"), 0);
}

TEST_F(RuleCountsOf, NothingIsCountedUntilSomebodyAsks) {
  given("(defrule go (a ?) =>)");
  assert_all({"(a 1)"});
  engine().run();
  EXPECT_THAT(engine().counts().rules, IsEmpty());
}

/// The journal of rules that call, retract, modify and remove rules.
std::string journal_with(Counting counting) {
  KeptRecords records;
  EngineOptions options;
  options.journal = &records;
  const auto engine = *RuleEngine::create(std::move(options));
  engine->count(counting);
  const LoadReport report = engine->load_text(
      "(deftemplate t (slot n))\n(deffunction f (?x) (assert (called ?x)) ?x)\n"
      "(defrule make (seed ?n&:(< ?n 20)) => (assert (t (n (f (+ ?n (random 0 5)))))) (assert (seed (+ ?n 1))))\n"
      "(defrule change ?t <- (t (n ?n&:(> ?n 5))) (not (hold ?n)) => (modify ?t (n (- ?n 3))))\n"
      "(defrule drop (or (t (n 1)) (t (n 2))) ?c <- (called ?x) (exists (t (n ?y&:(< ?y ?x)))) => (retract ?c))\n"
      "(defrule gone (t (n 2)) => (undefrule drop))\n",
      "r.clp", LoadMode::kConstructs);
  EXPECT_TRUE(report.ok());
  EXPECT_TRUE(engine->assert_string("(seed 1)").ok());
  EXPECT_TRUE(engine->run(2000).errors.empty());
  return records.text();
}

TEST(RuleCounts, CountingChangesNoRecord) {
  const auto plain = journal_with(Counting::kNothing);
  EXPECT_GT(plain.size(), 5000u);
  EXPECT_EQ(journal_with(Counting::kUse), plain);
  EXPECT_EQ(journal_with(Counting::kTimes), plain);
}

// --- Times

double whole(const RuleCounts& rule) {
  double s = rule.acting.s + rule.activating.s;
  for (const auto& disjunct : rule.disjuncts)
    for (const JoinCounts& join : disjunct) s += join.time.s;
  return s;
}

const char* kSlow = R"(
(deffunction waste (?n) (loop-for-count (?i 1 ?n) (+ ?i 1)) TRUE)
(defrule slow-action (a ?x) => (waste 20000))
(defrule slow-test (a ?x) (b ?y) (test (waste 5000)) =>)
(defrule slow-pattern (a ?x&:(waste 20000)) =>)
(defrule quick (a ?x) (b ?y) =>)
)";

TEST_F(RuleCountsOf, TheTimeIsThatOfWhatIsSlow) {
  engine().count(Counting::kTimes);
  given(kSlow);
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(engine().assert_string("(a " + std::to_string(i) + ')'));
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(engine().assert_string("(b " + std::to_string(i) + ')'));
  engine().run();
  const double quick = whole(rule("quick"));
  for (const char* slow : {"slow-action", "slow-test", "slow-pattern"}) EXPECT_GT(whole(rule(slow)), 5 * quick) << slow;
  EXPECT_GT(rule("slow-action").acting.s, 0.9 * whole(rule("slow-action")));
  EXPECT_GT(rule("slow-test").disjuncts[0][1].time.s, 0.9 * whole(rule("slow-test"))) << "at its second condition";
  EXPECT_GT(rule("slow-pattern").disjuncts[0][0].time.s, 0.9 * whole(rule("slow-pattern")));
  for (const FunctionCounts& function : engine().counts().functions) {
    EXPECT_EQ(function.calls, 10 + 40 + 10);
    EXPECT_GT(function.time.s,
              0.8 * (whole(rule("slow-action")) + whole(rule("slow-test")) + whole(rule("slow-pattern"))));
  }
}

TEST_F(RuleCountsOf, TimesAreDividedAndSumUp) {
  engine().count(Counting::kTimes);
  given(
      "(deffunction waste (?n) (loop-for-count (?i 1 ?n) (+ ?i 1)) TRUE)\n"
      "(defrule one (a ?x) (b ?y&:(waste 5000)) (c) =>)\n(defrule two (a ?x) (b ?y&:(waste 5000)) (d) =>)");
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(engine().assert_string("(a " + std::to_string(i) + ')'));
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(engine().assert_string("(b " + std::to_string(i) + ')'));
  EXPECT_EQ(rule("one").disjuncts[0][1].sharers, 2u);
  EXPECT_DOUBLE_EQ(rule("one").disjuncts[0][1].time.s, rule("two").disjuncts[0][1].time.s);
}

TEST_F(RuleCountsOf, FiringsAreSpansInOrder) {
  engine().count(Counting::kTimes);
  given("(deffunction f (?x) (+ ?x 1))\n(defrule go (a ?x) => (f ?x))");
  now = from_seconds(3);
  assert_all({"(a 1)", "(a 2)"});
  engine().run();
  const EngineCounts counts = engine().counts();
  std::vector<std::string> names;
  double last = 0;
  for (const WorkSpan& span : counts.spans) {
    if (span.kind == WorkSpan::Kind::kMatching) continue;
    names.push_back(span.name);
    EXPECT_GE(span.end_s, span.begin_s);
    EXPECT_GE(span.end_s, last) << "in the order in which they end";
    EXPECT_EQ(span.t, from_seconds(3));
    last = span.end_s;
  }
  EXPECT_THAT(names, ElementsAre("f", "go", "f", "go"));
}

}  // namespace
}  // namespace cxlab
