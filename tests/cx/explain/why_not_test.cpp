// Why a rule has not fired, for every form of a left-hand side.

#include "cx/explain/why_not.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "cx/explain/json.h"
#include "cx/journal/journal.h"

namespace cxlab::explain {
namespace {

using testing::AnyOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Pair;
using testing::StartsWith;

class WhyNotTest : public testing::Test {
 protected:
  WhyNotTest() {
    journal_.observe(histories_);
    EngineOptions options;
    options.journal = &journal_;
    options.now = [this] { return now_; };
    engine_ = *RuleEngine::create(std::move(options));
  }
  void load(const std::string& rules) {
    const LoadReport report = engine_->load_text(rules, "rules.clp", LoadMode::kConstructs);
    ASSERT_TRUE(report.ok()) << report.status().error().text();
    engine_->reset();
  }
  void run() { ASSERT_THAT(engine_->run().errors, IsEmpty()); }
  WhyNot why(const std::string& rule, const Wanted& wanted = {}) {
    const ConstructInfo* info = engine_->find_construct("defrule", rule);
    if (!info) {
      ADD_FAILURE() << rule;
      return {};
    }
    auto answer = why_not(*engine_, *info, histories_.of("env/main"), wanted);
    EXPECT_TRUE(answer.ok()) << answer.error().text();
    return answer.ok() ? *answer : WhyNot();
  }
  UnmetCondition unmet(const std::string& rule, const Wanted& wanted = {}) {
    const WhyNot answer = why(rule, wanted);
    EXPECT_EQ(answer.verdict, Verdict::kCondition) << rule;
    return answer.unmet.value_or(UnmetCondition());
  }

  SimTime now_{};
  Journal journal_;
  Histories histories_{{.past_facts = false, .rule = "fires"}};
  std::unique_ptr<RuleEngine> engine_;
};

const char* const kParts = R"(
(deftemplate part (slot id) (slot state) (slot owner))
(deffacts d (part (id 1) (state READY) (owner ann)) (part (id 2) (state READY) (owner bob)) (part (id 3) (state BUSY))
  (limit 2) (robot x))
)";

TEST_F(WhyNotTest, ALookChangesNothingForTheRules) {
  load(
      "(deftemplate order (slot id))\n(deffacts start (order (id 1)))\n"
      "(defrule lucky (order (id ?i&:(> (random 1 1000) 1000))) =>)\n");
  RandomStream before = engine_->random();
  why("lucky");
  RandomStream after = engine_->random();
  EXPECT_EQ(before.next(), after.next());
  (void)engine_->eval("(clear)");
  EXPECT_FALSE(engine_->has("deftemplate", "order")) << "nothing counts as in use";
}

TEST_F(WhyNotTest, APatternNamesTheNearestFactAndItsSlot) {
  load(std::string(kParts) + "(defrule r (robot x) (part (id 2) (state BUSY) (owner bob)) =>)");
  const UnmetCondition found = unmet("r");
  EXPECT_EQ(found.number, 2);
  EXPECT_EQ(found.text, "(part (id 2) (state BUSY) (owner bob))");
  EXPECT_EQ(found.fact, "(part (id 2) (state READY) (owner bob))");
  EXPECT_EQ(found.slot, "state");
  EXPECT_EQ(found.because, "in the nearest fact state is READY, not BUSY");
  EXPECT_EQ(found.matches_alone, 0u);
}

TEST_F(WhyNotTest, AllSlotsAreNamedInWhichTheNearestFactDiffers) {
  load(std::string(kParts) + "(defrule r (part (id 4) (state LOST) (owner bob)) =>)");
  const UnmetCondition found = unmet("r");
  EXPECT_EQ(found.because, "in the nearest fact id is 2, not 4, and state is READY, not LOST");
  EXPECT_EQ(found.slot, "id");
}

TEST_F(WhyNotTest, ATestShowsTheGlobalsThatItUses) {
  load(std::string(kParts) + "(defglobal ?*most* = 7)(defrule r (limit ?l) (test (> ?l (+ ?*most* ?*most*))) =>)");
  EXPECT_THAT(unmet("r").values, ElementsAre(Pair("l", "2"), Pair("*most*", "7")));
}

TEST_F(WhyNotTest, APatternWithoutAnyFactOfItsTemplate) {
  load(std::string(kParts) + "(defrule r (robot ?) (wheel ?) =>)");
  EXPECT_EQ(unmet("r").because, "there is no fact of wheel");
  EXPECT_EQ(unmet("r").number, 2);
}

TEST_F(WhyNotTest, VariablesThatDoNotAgreeHaveTheirValues) {
  load(std::string(kParts) + "(defrule r (robot ?n) (part (id ?i) (owner ?n)) =>)");
  const UnmetCondition found = unmet("r");
  EXPECT_EQ(found.matches_alone, 3u);
  EXPECT_THAT(found.because, HasSubstr("3 facts match it alone, none of them together with the conditions before"));
  EXPECT_THAT(found.because, HasSubstr("owner is nil, not ?n with ?n = x"));
  EXPECT_THAT(found.values, ElementsAre(Pair("n", "x")));
}

TEST_F(WhyNotTest, ATestIsNamedNotThePatternBeforeIt) {
  load(std::string(kParts) + "(defrule r (part (id ?i) (state READY)) (limit ?l) (test (> ?i ?l)) =>)");
  const UnmetCondition found = unmet("r");
  EXPECT_EQ(found.number, 3);
  EXPECT_EQ(found.text, "(test (> ?i ?l))");
  EXPECT_EQ(found.because, "the test fails for each of the 2 combinations that the conditions before it match");
  EXPECT_THAT(found.values, ElementsAre(Pair("i", "2"), Pair("l", "2")));
}

TEST_F(WhyNotTest, ATestThatRaisesAnErrorSaysSo) {
  load("(deffacts d (a x))(defrule r (a ?v) (test (> ?v 1)) =>)");
  EXPECT_THAT(unmet("r").because, HasSubstr("it raises an error: "));
}

TEST_F(WhyNotTest, AnOrIsToldByTheAlternativeThatGotFurthest) {
  load(std::string(kParts) + "(defrule r (or (part (state LOST)) (and (robot x) (limit 9))) =>)");
  const UnmetCondition found = unmet("r");
  EXPECT_EQ(found.number, 1);
  EXPECT_EQ(found.text, "(limit 9)");
  EXPECT_EQ(found.because, "in the nearest fact its fields are 2, not 9");
  load("(defrule both (or (part (state LOST)) (robot z)) =>)");
  EXPECT_EQ(unmet("both").text, "(part (state LOST))") << "none got further: the first";
  EXPECT_THAT(unmet("both").because, StartsWith("nor does its alternative hold: (robot z); in the nearest fact"));
  load("(defrule many (limit 2) (or (robot z) (limit 9) (robot y) (limit 8) (limit 7)) (robot v) =>)");
  EXPECT_THAT(unmet("many").because,
              StartsWith("nor do its alternatives hold: (limit 9), (robot y), (limit 8) and 1 more; in the nearest"));
}

TEST_F(WhyNotTest, ANotNamesTheFactThatForbidsIt) {
  load(std::string(kParts) + "(defrule r (not (part (state READY) (owner bob))) =>)");
  EXPECT_EQ(unmet("r").because, "a fact forbids it");
  EXPECT_EQ(unmet("r").fact, "(part (id 2) (state READY) (owner bob))");
  EXPECT_EQ(unmet("r").fact_number, engine_->facts("part")[1].number);
}

TEST_F(WhyNotTest, ANotOfSeveralConditionsNamesAllFacts) {
  load(std::string(kParts) + R"(
(defrule both (robot x) (not (and (part (state READY)) (limit 2))) =>)
(defrule later (robot x) (not (and (part (state LOST)) (limit 2))) (robot z) =>))");
  EXPECT_EQ(unmet("both").number, 2);
  EXPECT_EQ(unmet("both").because, "facts that hold together forbid it");
  EXPECT_EQ(unmet("both").fact, "(part (id 1) (state READY) (owner ann)) (limit 2)");
  EXPECT_EQ(unmet("both").fact_number, 0u) << "several";
  EXPECT_EQ(unmet("later").number, 3) << "the not holds, (robot z) is missing";
  EXPECT_EQ(unmet("later").text, "(robot z)");
}

TEST_F(WhyNotTest, AnExistsNamesWhatIsMissingInIt) {
  load(std::string(kParts) + "(defrule r (limit ?l) (exists (part (id ?l) (state BUSY)) (robot x)) =>)");
  const UnmetCondition found = unmet("r");
  EXPECT_EQ(found.number, 2);
  EXPECT_THAT(found.because, HasSubstr("in the nearest fact state is READY, not BUSY"))
      << "the part 2, not another one";
}

TEST_F(WhyNotTest, TheNearestFactIsTheOneThatIsMeantInAnotherState) {
  load(std::string(kParts) + "(defrule r (limit ?l) (part (id ?l) (state BUSY)) =>)");
  EXPECT_EQ(unmet("r").fact, "(part (id 2) (state READY) (owner bob))");
  EXPECT_EQ(unmet("r").slot, "state");
}

TEST_F(WhyNotTest, OfFactsThatAreEquallyNearTheFirstIsNamed) {
  load(std::string(kParts) + "(defrule r (part (id ?id) (state READY)) (part (id ?id) (owner eve)) =>)");
  EXPECT_EQ(unmet("r").fact, "(part (id 1) (state READY) (owner ann))");
  EXPECT_THAT(unmet("r").values, ElementsAre(Pair("id", "1")));
}

TEST_F(WhyNotTest, AForallNamesTheFactWithoutAPartner) {
  load(std::string(kParts) +
       "(defrule r (robot ?r) (forall (part (id ?i) (state READY)) (part (id ?i) (owner ann))) =>)");
  const UnmetCondition found = unmet("r");
  EXPECT_EQ(found.number, 2);
  EXPECT_EQ(found.fact, "(part (id 2) (state READY) (owner bob))");
  EXPECT_THAT(found.because,
              StartsWith("each match of (part (id ?i) (state READY)) needs (part (id ?i) (owner ann)), and this one "
                         "lacks it: one fact matches it alone"));
}

TEST_F(WhyNotTest, ExpressionsInPatternsAreEvaluated) {
  load(std::string(kParts) + R"(
(deffunction double (?x) (* 2 ?x))
(defglobal ?*most* = 7)
(defrule predicate (limit ?l) (part (id ?i&:(> ?i (double ?l)))) =>)
(defrule returned (limit ?l) (robot =(double ?l)) =>)
(defrule global (limit ?l&:(> ?l ?*most*)) =>)
(defrule many (list $?a&:(> (length$ ?a) 2)) =>))");
  EXPECT_THAT(unmet("predicate").because, HasSubstr("id is 3, not ?i&:(> ?i (double ?l)) with ?l = 2"));
  EXPECT_THAT(unmet("returned").because, HasSubstr("its fields are x, not =(double ?l) with ?l = 2"));
  EXPECT_THAT(unmet("global").because, HasSubstr("its fields are 2, not ?l&:(> ?l ?*most*) with ?*most* = 7"));
  ASSERT_TRUE(engine_->assert_string("(list 1 2)").ok());
  EXPECT_THAT(unmet("many").because, HasSubstr("its fields are 1 2, not $?a&:(> (length$ ?a) 2)"));
  EXPECT_THAT(engine_->constructs(),
              testing::Each(testing::Field(&ConstructInfo::name, testing::Not(HasSubstr("explain")))))
      << "what was defined to evaluate has gone";
}

TEST_F(WhyNotTest, FactAddressesReachTests) {
  load("(deftemplate t (slot a)) (deffacts d (t (a 1)))(defrule r ?f <- (t) (test (= 2 (fact-slot-value ?f a))) =>)");
  EXPECT_EQ(unmet("r").number, 2);
  EXPECT_THAT(unmet("r").because, HasSubstr("the test fails for what the conditions before it match"));
}

TEST_F(WhyNotTest, APatternOfObjectsNamesTheNearestInstance) {
  load(
      R"((defclass P (is-a USER) (slot a)) (defclass Q (is-a P)) (defclass OTHER (is-a USER)) (definstances i (p of P (a 1)) (q of Q (a 3)))
(defrule r (limit ?l) (object (is-a Q) (name ?n) (a ?l)) =>)
(defrule none (object (is-a ~P)) =>)
(defrule tested ?p <- (object (is-a P) (a ?a&:(> ?a 2))) (test (eq (send ?p get-a) 4)) =>)
(deffacts d (limit 2)))");
  const UnmetCondition found = unmet("r");
  EXPECT_EQ(found.number, 2);
  EXPECT_EQ(found.fact, "[q] of Q (a 3)");
  EXPECT_THAT(found.because, HasSubstr("one instance matches it alone"));
  EXPECT_THAT(found.because, HasSubstr("a is 3, not ?l with ?l = 2"));
  EXPECT_EQ(unmet("none").slot, "is-a");
  EXPECT_EQ(unmet("tested").number, 2);
}

TEST_F(WhyNotTest, AnAlternativeThatSatisfiesALaterConditionGotFurther) {
  load("(deffacts d (a) (b) (d))(defrule r (or (and (a) (b) (missing)) (d)) (late) =>)");
  EXPECT_EQ(unmet("r").number, 2);
  EXPECT_EQ(unmet("r").text, "(late)") << "the or holds: (d) is there";
}

TEST_F(WhyNotTest, ANotOfANotNamesWhatIsMissing) {
  load(std::string(kParts) + R"(
(defrule r (not (not (part (id 2) (state BUSY)))) =>)
(defrule s (not (exists (part (state READY)) (limit ?))) =>))");
  EXPECT_EQ(unmet("r").because, "in the nearest fact id is 3, not 2");
  EXPECT_EQ(unmet("s").because, "facts that hold together forbid it");
  EXPECT_EQ(unmet("s").fact, "(part (id 1) (state READY) (owner ann)) (limit 2)");
}

TEST_F(WhyNotTest, QueriesAndLoopsInATestHaveVariablesOfTheirOwn) {
  load(std::string(kParts) + R"(
(defrule r (limit ?l) (test (any-factp ((?p part)) (> ?p:id ?l))) (test (any-factp ((?p part)) (> ?p:id (+ ?l 1)))) =>))");
  EXPECT_EQ(unmet("r").number, 3);
  EXPECT_EQ(unmet("r").because, "the test fails for what the conditions before it match");
}

TEST_F(WhyNotTest, WhatIsAskedForOneBindingIsAnsweredForIt) {
  load(std::string(kParts) + R"(
(defrule fires (part (id ?id) (state READY)) (not (part (id ?other&~?id) (state LOST))) =>)
(defrule named ?p <- (part (id ?id) (owner ?o)) (or (robot ?o) (limit ?other)) =>))");
  EXPECT_EQ(why("fires", {{"id", "1"}}).verdict, Verdict::kWaiting);
  EXPECT_THAT(why("fires", {{"id", "2"}}).values, ElementsAre(Pair("id", "2")));
  const UnmetCondition found = unmet("fires", {{"id", "3"}});
  EXPECT_EQ(found.number, 1);
  EXPECT_EQ(found.fact, "(part (id 3) (state BUSY) (owner nil))");
  EXPECT_EQ(
      unmet("fires", {{"id", "7"}}).because,
      "2 facts match it alone, none of them with what is asked for; in the nearest fact id is 2, not ?id with ?id = 7");
  EXPECT_EQ(why("named", {{"id", "1"}, {"o", "ann"}}).combinations, 1u);
  EXPECT_EQ(why("named", {{"p", "f-2"}}).combinations, 1u);
  EXPECT_EQ(why("named", {{"other", "2"}}).combinations, 3u);
  const auto wrong =
      why_not(*engine_, *engine_->find_construct("defrule", "fires"), histories_.of("env/main"), {{"other", "2"}});
  EXPECT_THAT(wrong.error().message,
              HasSubstr("no pattern of rule 'fires' outside of not, exists and forall binds ?other"));
}

TEST_F(WhyNotTest, WhatStandsOnTheAgendaWaits) {
  load("(deffacts d (a) (b)) (defrule low (declare (salience -5)) (a) =>) (defrule high (b) =>)");
  const WhyNot answer = why("low");
  EXPECT_EQ(answer.verdict, Verdict::kWaiting);
  EXPECT_EQ(answer.salience, -5);
  EXPECT_EQ(answer.above, 1u);
  EXPECT_THAT(answer.first_above, ElementsAre(Pair("high", 0)));
}

TEST_F(WhyNotTest, WhatHasFiredHasItsTimesAndFacts) {
  load(
      "(deftemplate t (slot a)) (deffacts d (t (a 1)))(defrule fires ?f <- (t (a ?a&:(< ?a 3))) => (modify ?f (a (+ ?a "
      "1))))");
  now_ = from_seconds(2);
  run();
  const WhyNot answer = why("fires");
  EXPECT_EQ(answer.verdict, Verdict::kCondition);
  EXPECT_EQ(answer.fired, 2u);
  EXPECT_EQ(answer.last_fired, from_seconds(2));
  EXPECT_THAT(answer.last_facts, ElementsAre("(t (a 2))")) << "as it was then";
  const auto json = to_json(answer);
  EXPECT_EQ(json["fired"], 2);
  EXPECT_EQ(json["last_fired_s"], 2.0);
  EXPECT_EQ(json["first_unmet"]["fact"], "(t (a 3))");
}

TEST_F(WhyNotTest, WhatANotBindsInsideIsItsOwn) {
  load("(deffacts d (a 1) (b 5))(defrule r (not (a ?x)) (b ?x) =>)(defrule s (exists (a ?x)) (b ?x) =>)");
  EXPECT_EQ(unmet("r", {{"x", "5"}}).number, 1) << "(a 1) forbids it, whatever ?x is outside";
  EXPECT_EQ(why("s", {{"x", "5"}}).verdict, Verdict::kWaiting);
}

TEST_F(WhyNotTest, WhatHoldsAndHasFiredIsDone) {
  load(
      "(deftemplate t (slot id) (slot v)) (deffacts d (t (id 1) (v 1)) (t (id 2) (v 1))) (defrule fires (t (id ?id) (v "
      "1)) =>)");
  now_ = from_seconds(2);
  run();
  const WhyNot answer = why("fires", {{"id", "1"}});
  EXPECT_EQ(answer.verdict, Verdict::kFired);
  EXPECT_EQ(answer.fired_for_it, from_seconds(2));
  EXPECT_THAT(answer.facts, ElementsAre("(t (id 1) (v 1))"));
  const std::int64_t second = engine_->facts("t").back().index;
  const RuleEngine::Slot zero{"v", Value::integer(0)}, one{"v", Value::integer(1)};
  ASSERT_TRUE(engine_->modify_fact(second, {&zero, 1}).ok());
  EXPECT_EQ(unmet("fires", {{"id", "2"}}).slot, "v");
  ASSERT_TRUE(engine_->modify_fact(second, {&one, 1}).ok());
  EXPECT_EQ(why("fires", {{"id", "1"}}).verdict, Verdict::kFired);
  EXPECT_EQ(why("fires", {{"id", "2"}}).verdict, Verdict::kWaiting) << "it fires again for a fact that has changed";
}

TEST_F(WhyNotTest, ATestOfWhichNoFactHasChangedIsNotEvaluatedAgain) {
  load("(defglobal ?*least* = 5)(deffacts d (a 3))(defrule fires (a ?v&:(> ?v ?*least*)) =>)");
  run();
  ASSERT_TRUE(engine_->eval("(bind ?*least* 1)").ok());
  EXPECT_EQ(why("fires").verdict, Verdict::kTaken);
}

TEST_F(WhyNotTest, ARuleOfAModuleWaitsForItsFocus) {
  load(R"((defmodule MAIN (export ?ALL)) (deftemplate job (slot id)) (defmodule A (import MAIN ?ALL))
(defmodule B (import MAIN ?ALL)) (deffacts MAIN::d (job (id 1)))
(defrule A::first (job) =>) (defrule A::go (job (id ?id)) =>) (defrule B::go (job (id 2)) =>) (defrule MAIN::go (job) =>))");
  const WhyNot answer = why("A::go");
  EXPECT_EQ(answer.verdict, Verdict::kFocus);
  EXPECT_THAT(answer.focus, ElementsAre("MAIN"));
  EXPECT_EQ(why("MAIN::go").verdict, Verdict::kWaiting);
  ASSERT_TRUE(engine_->eval("(focus A)").ok());
  EXPECT_EQ(why("A::go").verdict, Verdict::kWaiting);
  EXPECT_EQ(why("MAIN::go").above, 2u) << "those of the module above";
  EXPECT_THAT(why("MAIN::go").first_above, testing::Contains(Pair("A::first", 0)));
  run();
  EXPECT_EQ(why("A::go").fired, 1u);
  EXPECT_EQ(why("MAIN::go").fired, 1u) << "firings of one name are counted by module";
  EXPECT_EQ(why("B::go").fired, 0u);
  EXPECT_EQ(unmet("B::go").slot, "id");
}

TEST_F(WhyNotTest, FactsAreThoseOfTheTemplateThatTheModuleSees) {
  load(R"((defmodule A (export ?ALL)) (deftemplate A::part (slot id)) (defmodule B (import A ?ALL)) (defmodule C)
(deftemplate C::part (slot id)) (deffacts A::d (part (id 1))) (deffacts C::d (part (id 2)))
(defrule B::go (part (id 2)) =>))");
  EXPECT_EQ(unmet("B::go").fact, "(part (id 1))");
}

TEST_F(WhyNotTest, RulesOfModulesAreFoundByTheirNames) {
  load(R"((defmodule A (export ?ALL)) (defmodule B)
(defrule A::go (a) =>) (defrule B::stay (b) =>) (deffacts A::d (a)))");
  EXPECT_EQ(why("A::go").verdict, Verdict::kFocus);
  EXPECT_EQ(why("go").module, "A") << "a bare name finds it, too";
  EXPECT_EQ(why("B::stay").verdict, Verdict::kCondition);
}

}  // namespace
}  // namespace cxlab::explain
