// Coverage of small rule bases that a person can judge.

#include "cx/explain/coverage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cx/engine/engine.h"

namespace cxlab::explain {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

Coverage play(const std::string& rules, std::initializer_list<const char*> facts) {
  const auto engine = *RuleEngine::create({});
  engine->count(Counting::kUse);
  const LoadReport report = engine->load_text(rules, "/agent/r.clp", LoadMode::kConstructs);
  for (const RuleError& error : report.errors) ADD_FAILURE() << error.text();
  for (const char* fact : facts) EXPECT_TRUE(engine->assert_string(fact).ok());
  EXPECT_TRUE(engine->run().errors.empty());
  return coverage_of(engine->counts(), [](const std::string& file) { return file.substr(6); });
}

std::vector<std::int64_t> passed(const Coverage::Rule& rule) {
  std::vector<std::int64_t> all;
  for (std::size_t i = 0; i < rule.conditions.size(); ++i) all.push_back(rule.passed(i));
  return all;
}

const char* kFourRules =
    R"((deffunction f () 1) (deffunction g () 2) (defrule fires "a comment" (declare (salience 5)) (a ?x)
  (test (> ?x 1)) (test (< ?x 9)) => (f))
(defrule loses ?a <- (a 2) => (retract ?a))
(defrule late (declare (salience -1)) (a 2) =>)
(defrule fails (a ?x)
  ?b <- (b ?x)
  (not (c))
  (d) =>)
)";

TEST(CoverageOf, ConditionsHaveTheirPlacesAndWhatGotPast) {
  const Coverage coverage = play(kFourRules, {"(a 1)", "(a 2)", "(b 2)"});
  ASSERT_EQ(coverage.rules.size(), 4u);
  const Coverage::Rule &fires = coverage.rules[0], &fails = coverage.rules[3];
  EXPECT_EQ(fires.file, "/r.clp");
  EXPECT_STREQ(fires.state(), "fired");
  EXPECT_THAT(passed(fires), ElementsAre(2, 1, 1));
  EXPECT_EQ(fires.conditions[2].number, 3);
  EXPECT_EQ(fires.conditions[2].line, 2);
  EXPECT_EQ(fires.text.substr(fires.conditions[2].begin, fires.conditions[2].end - fires.conditions[2].begin),
            "(test (< ?x 9))");
  EXPECT_THAT(passed(fails), ElementsAre(2, 1, 1, 0));
  EXPECT_STREQ(fails.state(), "never matched");
  EXPECT_EQ(fails.failed_at(), 3u);
  EXPECT_EQ(fails.conditions[1].line, 6);
  EXPECT_EQ(fails.text.substr(fails.conditions[1].begin, fails.conditions[1].end - fails.conditions[1].begin),
            "?b <- (b ?x)");
  EXPECT_STREQ(coverage.rules[2].state(), "activated but never fired");
  EXPECT_EQ(coverage.functions[0].calls, 1);
  EXPECT_EQ(coverage.functions[1].calls, 0);
}

TEST(CoverageOf, ATextNamesWhatIsMissing) {
  EXPECT_EQ(text_of(play(kFourRules, {"(a 1)", "(a 2)", "(b 2)"})),
            "/r.clp:4: late: activated but never fired\n"
            "/r.clp:5: fails: never matched: nothing got past condition 4, (d)\n"
            "/r.clp:1: g: never called\n"
            "rules: 2 fired, 1 activated but never fired, 1 never matched\n"
            "rules: 2 of 4 fired (50.0 %), conditions: 8 of 9 passed (88.9 %), functions: 1 of 2 called (50.0 %)\n");
}

TEST(CoverageOf, TheWayThatGotFurthestSaysWhereItFailed) {
  const Coverage coverage = play("(defrule r (or (a) (and (b) (c))) (d) (e) =>)", {"(b)", "(c)", "(d)"});
  const Coverage::Rule& rule = coverage.rules[0];
  EXPECT_THAT(passed(rule), ElementsAre(0, 1, 1, 1, 0));
  EXPECT_EQ(rule.conditions[rule.failed_at()].text, "(e)");
  EXPECT_EQ(rule.conditions[2].number, 1);
  EXPECT_EQ(rule.conditions[4].number, 3);
}

TEST(CoverageOf, AConditionBeforeAnOrIsCountedOnce) {
  const Coverage coverage = play("(defrule r (a ?) (or (b) (c)) =>)", {"(a 1)", "(a 2)", "(b)", "(c)"});
  EXPECT_THAT(passed(coverage.rules[0]), ElementsAre(2, 2, 2));
  EXPECT_EQ(coverage.rules[0].fired, 4);
}

TEST(CoverageOf, ATestThatFailsIsNotTheFaultOfItsPattern) {
  const Coverage coverage = play(
      "(defrule t (a ?x) (test (and (> ?x 0) (> ?x 5))) (test (< ?x 7)) (b) =>)\n"
      "(defrule n (a ?x) (not (z ?x)) (test (> ?x 5)) =>)\n(defrule first (test (> 1 2)) (a ?) =>)",
      {"(a 1)", "(a 8)", "(b)"});
  EXPECT_THAT(passed(coverage.rules[0]), ElementsAre(2, 1, 0, 0));
  EXPECT_EQ(coverage.rules[0].failed_at(), 2u);
  EXPECT_THAT(passed(coverage.rules[1]), ElementsAre(2, 2, 1));
  EXPECT_THAT(passed(coverage.rules[2]), ElementsAre(0, 0));
  EXPECT_EQ(coverage.rules[2].failed_at(), 0u);
}

TEST(CoverageOf, SumsAreThoseOfTheParts) {
  Coverage sum = play(kFourRules, {"(a 1)", "(a 2)", "(b 2)"});
  sum.add(play(kFourRules, {"(a 2)", "(b 2)", "(d)"}));
  EXPECT_EQ(sum.rules.size(), 4u);
  EXPECT_EQ(sum.rules[0].fired, 2);
  EXPECT_THAT(passed(sum.rules[3]), ElementsAre(3, 2, 2, 1));
  EXPECT_STREQ(sum.rules[3].state(), "fired");
  EXPECT_EQ(sum.functions[0].calls, 2);
  sum.add(play("(defrule fires (a ?) =>)", {}));
  EXPECT_EQ(sum.rules.size(), 5u) << "another rule of that name and place";
}

}  // namespace
}  // namespace cxlab::explain
