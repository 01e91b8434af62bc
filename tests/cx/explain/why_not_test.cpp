// Why a rule has not fired, for every form of a left-hand side.

#include "cx/explain/why_not.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <random>

#include "cx/explain/json.h"
#include "cx/explain/matcher.h"
#include "cx/journal/journal.h"

namespace cxlab::explain {
namespace {

using testing::AnyOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Pair;

class WhyNotTest : public testing::Test {
 protected:
  WhyNotTest() {
    journal_.set_listener(&histories_);
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
  WhyNot why(const std::string& rule) {
    auto answer = why_not(*engine_, rule, histories_.of("env/main"));
    EXPECT_TRUE(answer.ok()) << answer.error().text();
    return answer.ok() ? *answer : WhyNot();
  }
  UnmetCondition unmet(const std::string& rule) {
    const WhyNot answer = why(rule);
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
  EXPECT_EQ(found.because, "in the nearest fact it is 2, not 9");
  load("(defrule both (or (part (state LOST)) (robot z)) =>)");
  EXPECT_EQ(unmet("both").text, "(part (state LOST))") << "none got further: the first";
}

TEST_F(WhyNotTest, ANotNamesTheFactThatForbidsIt) {
  load(std::string(kParts) + "(defrule r (not (part (state READY) (owner bob))) =>)");
  EXPECT_EQ(unmet("r").because, "a fact forbids it");
  EXPECT_EQ(unmet("r").fact, "(part (id 2) (state READY) (owner bob))");
}

TEST_F(WhyNotTest, ANotOfSeveralConditionsNamesAllFacts) {
  load(std::string(kParts) + R"(
(defrule both (robot x) (not (and (part (state READY)) (limit 2))) =>)
(defrule later (robot x) (not (and (part (state LOST)) (limit 2))) (robot z) =>))");
  EXPECT_EQ(unmet("both").number, 2);
  EXPECT_EQ(unmet("both").because, "facts that hold together forbid it");
  EXPECT_EQ(unmet("both").fact, "(part (id 1) (state READY) (owner ann)) (limit 2)");
  EXPECT_EQ(unmet("later").number, 3) << "the not holds, (robot z) is missing";
  EXPECT_EQ(unmet("later").text, "(robot z)");
}

TEST_F(WhyNotTest, AnExistsNamesWhatIsMissingInIt) {
  load(std::string(kParts) + "(defrule r (limit ?l) (exists (part (id ?l) (state BUSY)) (robot x)) =>)");
  const UnmetCondition found = unmet("r");
  EXPECT_EQ(found.number, 2);
  EXPECT_THAT(found.because, HasSubstr("id is 3, not ?l with ?l = 2"));
}

TEST_F(WhyNotTest, AForallNamesTheFactWithoutAPartner) {
  load(std::string(kParts) +
       "(defrule r (robot ?r) (forall (part (id ?i) (state READY)) (part (id ?i) (owner ann))) =>)");
  const UnmetCondition found = unmet("r");
  EXPECT_EQ(found.number, 2);
  EXPECT_EQ(found.fact, "(part (id 2) (state READY) (owner bob))");
  EXPECT_THAT(found.because, HasSubstr("not for this fact: (part (id ?i) (owner ann)), "));
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
  EXPECT_THAT(unmet("returned").because, HasSubstr("it is x, not =(double ?l) with ?l = 2"));
  EXPECT_THAT(unmet("global").because, HasSubstr("it is 2, not ?l&:(> ?l ?*most*)"));
  ASSERT_TRUE(engine_->assert_string("(list 1 2)").ok());
  EXPECT_THAT(unmet("many").because, HasSubstr("it is 1 2, not $?a&:(> (length$ ?a) 2)"));
  EXPECT_THAT(engine_->constructs(),
              testing::Each(testing::Field(&ConstructInfo::name, testing::Not(HasSubstr("explain")))))
      << "what was defined to evaluate has gone";
}

TEST_F(WhyNotTest, FactAddressesReachTests) {
  load("(deftemplate t (slot a)) (deffacts d (t (a 1)))(defrule r ?f <- (t) (test (= 2 (fact-slot-value ?f a))) =>)");
  EXPECT_EQ(unmet("r").number, 2);
  EXPECT_THAT(unmet("r").because, HasSubstr("the test fails for what the conditions before it match"));
}

TEST_F(WhyNotTest, ObjectsAreCountedByClips) {
  load(
      "(defclass P (is-a USER) (slot a)) (definstances i (p of P (a 1)))(defrule r (initial) (object (is-a P) (a 2)) "
      "=>)(deffacts d (initial))");
  EXPECT_EQ(unmet("r").number, 2);
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

TEST_F(WhyNotTest, WhatHoldsAndHasFiredIsDone) {
  load("(deffacts d (a)) (defrule fires (a) =>)");
  run();
  EXPECT_EQ(why("fires").verdict, Verdict::kFired);
}

TEST_F(WhyNotTest, RulesOfModulesAreFoundByTheirNames) {
  load(R"((defmodule A (export ?ALL)) (defmodule B)
(defrule A::go (a) =>) (defrule B::stay (b) =>) (deffacts A::d (a)))");
  EXPECT_EQ(why("A::go").verdict, Verdict::kWaiting);
  EXPECT_EQ(why("go").module, "A") << "a bare name finds it, too";
  EXPECT_EQ(why("B::stay").verdict, Verdict::kCondition);
  EXPECT_FALSE(why_not(*engine_, "B::go", histories_.of("env/main")).ok());
}

TEST_F(WhyNotTest, AnUnknownRuleIsAnError) {
  load("(defrule go (a) =>)");
  EXPECT_FALSE(why_not(*engine_, "gone", histories_.of("env/main")).ok());
}

// --- Against CLIPS itself

/// Left-hand sides by chance, of two templates and an ordered fact with few values.
class RandomRules {
 public:
  explicit RandomRules(std::uint32_t seed) : random_(seed) {}

  std::string facts() {
    std::string out = "(deffacts d";
    for (int i = below(7); i > 0; --i) out += " (a (x " + number() + ") (y " + number() + "))";
    for (int i = below(5); i > 0; --i) out += " (b (z " + number() + ' ' + number() + "))";
    for (int i = below(4); i > 0; --i) out += " (c " + number() + ")";
    return out + ')';
  }
  std::string left_hand_side() {
    known_.clear();
    fresh_ = 0;
    std::string out = "(c ?)";
    for (int i = 1 + below(4); i > 0; --i) out += ' ' + condition(2, known_);
    return out;
  }

 private:
  using Names = std::vector<std::string>;

  int below(int n) { return static_cast<int>(random_() % static_cast<std::uint32_t>(n)); }
  std::string number() { return std::to_string(below(3)); }
  std::string fresh(Names& known) {
    known.push_back("v" + std::to_string(fresh_++));
    return '?' + known.back();
  }
  std::string any(const Names& known) {
    return '?' + known[static_cast<std::size_t>(below(static_cast<int>(known.size())))];
  }
  std::string comparison(const Names& known) {
    static constexpr const char* kOperators[] = {"<", ">", "=", "<>"};
    return '(' + std::string(kOperators[below(4)]) + ' ' + any(known) + ' ' + (below(2) ? any(known) : number()) + ')';
  }
  std::string constraint(Names& known) {
    switch (below(9)) {
      case 0: return number();
      case 1: return number() + '|' + number();
      case 2: return '~' + number();
      case 3: return "?";
      case 4: return known.empty() ? "?" : any(known);
      case 5: return known.empty() ? number() : '~' + any(known);
      case 6: {
        const std::string name = fresh(known);
        return name + "&:" + comparison(known);
      }
      case 7: {
        const std::string name = fresh(known);
        return name + "&~" + number() + '|' + number();
      }
      default: return fresh(known);
    }
  }
  std::string pattern(Names& known) {
    switch (below(4)) {
      case 0: return "(c " + constraint(known) + ')';
      case 1: {
        const std::string first = constraint(known);
        return "(b (z " + first + ' ' + constraint(known) + "))";
      }
      case 2: return "(b (z $? " + constraint(known) + " $?))";
      default: {
        const std::string first = constraint(known);
        return "(a (x " + first + ')' + (below(2) ? " (y " + constraint(known) + ')' : "") + ')';
      }
    }
  }
  std::string condition(int depth, Names& known) {
    Names inside = known;
    switch (depth == 0 ? 9 : below(12)) {
      case 0: return "(not " + pattern(inside) + ')';
      case 1: {
        const std::string first = pattern(inside);
        return "(not (and " + first + ' ' + condition(depth - 1, inside) + "))";
      }
      case 2: return "(exists " + pattern(inside) + ')';
      case 3: {
        const std::string first = pattern(inside);
        return "(exists " + first + ' ' + pattern(inside) + ')';
      }
      case 4: {
        const std::string first = pattern(inside);
        return "(forall " + first + ' ' + pattern(inside) + ')';
      }
      case 5: {
        Names other = known;
        const std::string first = pattern(inside);
        return "(or " + first + ' ' + pattern(other) + ')';  // what they bind is not used later
      }
      case 6: return known.empty() ? pattern(known) : "(test " + comparison(known) + ')';
      case 7: {
        const std::string first = pattern(known);
        return "(and " + first + ' ' + condition(depth - 1, known) + ')';
      }
      default: return pattern(known);
    }
  }

  std::mt19937 random_;
  Names known_;
  int fresh_ = 0;
};

TEST_F(WhyNotTest, FindsTheCombinationsThatClipsFinds) {
  int held = 0, not_held = 0, refused = 0;
  for (std::uint32_t seed = 0; seed < 2000; ++seed) {
    RandomRules random(seed);
    EngineOptions options;
    engine_ = *RuleEngine::create(std::move(options));
    const std::string facts = random.facts(), rule = "(defrule r " + random.left_hand_side() + " =>)";
    load("(deftemplate a (slot x) (slot y)) (deftemplate b (multislot z)) " + facts);
    if (!engine_->build(rule)) {
      ++refused;
      continue;
    }
    engine_->reset();
    const auto conditions = conditions_of(rule);
    ASSERT_TRUE(conditions.ok()) << rule;
    const Facts known(*engine_);
    Evaluator evaluator(*engine_, "MAIN");
    Matcher matcher(known, evaluator);
    std::size_t found = 0;
    for (const Alternative& alternative : alternatives_of(*conditions)) {
      const auto reach = matcher.reach(alternative.conditions, {});
      found += reach.depth == alternative.conditions.size() ? reach.count : 0;
    }
    ASSERT_EQ(found, engine_->agenda().size()) << seed << ": " << facts << '\n' << rule;
    ++(found > 0 ? held : not_held);
    const WhyNot answer = why("r");
    ASSERT_EQ(answer.verdict, found > 0 ? Verdict::kWaiting : Verdict::kCondition);
  }
  EXPECT_GT(held, 400);
  EXPECT_GT(not_held, 400);
  EXPECT_LT(refused, 200);
}

}  // namespace
}  // namespace cxlab::explain
