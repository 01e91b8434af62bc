// What the rules of an environment have done, as its inspector answers from the records.

#include "cx/inspect/inspector.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cx/engine/engine.h"
#include "cx/journal/journal.h"

namespace cxlab::inspect {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr SimTime kSecond = std::chrono::seconds(1), kInstant{1};

constexpr const char* kTable = R"(
(defmodule MAIN (export ?ALL))
(deftemplate job (slot id) (slot tries (default 0)))
(deffacts table (note))
(defrule order (declare (salience 1)) (go ?) (not (job)) => (assert (job (id 1))))
(defrule try (go ?) ?j <- (job (id ?id) (tries ?n)) ?g <- (go ?) => (retract ?g) (modify ?j (tries (+ ?n 1))) (assert (tried ?n)))
(defmodule SIDE (import MAIN ?ALL))
(defrule SIDE::look (declare (auto-focus TRUE)) (tried ?) => )
)";

/// Rules that run once a second. In the second second a note is taken away before anything else happens.
class InspectorTest : public testing::Test {
 protected:
  InspectorTest() {
    journal_.observe(timelines_);
    EngineOptions options;
    options.journal = &journal_;
    options.now = [this] { return now_; };
    engine_ = *RuleEngine::create(std::move(options));
    const LoadReport loaded = engine_->load_text(kTable, "table.clp", LoadMode::kConstructs);
    EXPECT_TRUE(loaded.ok()) << loaded.status().error().text();
    engine_->reset();
    for (int i = 1; i <= 3; ++i) {
      now_ = i * kSecond;
      if (i == 2) {
        EXPECT_TRUE(engine_->retract(engine_->facts("note").at(0).index));
      }
      EXPECT_TRUE(engine_->assert_string("(go " + std::to_string(i) + ")").ok());
      EXPECT_THAT(engine_->run().errors, IsEmpty());
    }
    inspector_.emplace("main", *engine_, timelines_.of("env/main"), [](const std::string& file) { return file; });
  }
  const Inspector& inspector() const { return *inspector_; }

  std::vector<double> times_of(const std::string& rule, SimTime from = {}, SimTime to = 9 * kSecond) {
    std::vector<double> times;
    const auto firings = inspector().firings(rule, from, to);
    EXPECT_TRUE(firings) << firings.error().text();
    for (const FiringCopy& firing : *firings) times.push_back(to_seconds(firing.t));
    return times;
  }

  SimTime now_{};
  Journal journal_;
  Timelines timelines_;
  std::unique_ptr<RuleEngine> engine_;
  std::optional<Inspector> inspector_;
};

TEST_F(InspectorTest, AFactBelongsToEachStretchInWhichItWasThereForAnInstant) {
  const std::pair<SimTime, std::size_t> rows[] = {
      {{}, 1}, {kSecond, 1}, {2 * kSecond, 1}, {2 * kSecond + kInstant, 0}, {3 * kSecond, 0}};
  for (const auto& [from, notes] : rows) {
    const auto found = inspector().facts("note", from, 9 * kSecond);
    ASSERT_TRUE(found) << found.error().text();
    EXPECT_EQ(found->size(), notes) << to_seconds(from);
  }
}

TEST_F(InspectorTest, AFiringBelongsToAStretchThatBeginsOrEndsWithIt) {
  EXPECT_THAT(times_of("try"), ElementsAre(1, 2, 3));
  EXPECT_THAT(times_of("try", kSecond, 2 * kSecond), ElementsAre(1, 2));
  EXPECT_THAT(times_of("try", kSecond + kInstant, 3 * kSecond - kInstant), ElementsAre(2));
  EXPECT_THAT(times_of("try", 2 * kSecond, 2 * kSecond), ElementsAre(2));
}

TEST_F(InspectorTest, ARuleHasItsNameWithAndWithoutItsModule) {
  for (const char* name : {"try", "MAIN::try", "look", "SIDE::look"}) {
    EXPECT_EQ(times_of(name).size(), 3u) << name;
    EXPECT_TRUE(inspector().last_firing(name)) << name;
  }
  for (const char* name : {"MAIN::look", "SIDE::try"}) EXPECT_FALSE(inspector().last_firing(name)) << name;
}

TEST_F(InspectorTest, ARuleHasTheTimesOfItsFirstAndItsLastFiring) {
  const std::vector<RuleUse> uses = inspector().rules(false);
  const auto use = std::ranges::find(uses, "try", &RuleUse::rule);
  ASSERT_NE(use, uses.end());
  EXPECT_EQ(use->fired, 3);
  EXPECT_EQ(use->first, kSecond);
  EXPECT_EQ(use->last, 3 * kSecond);
}

TEST_F(InspectorTest, AFiringHasTheFactsAsTheyWereThen) {
  const auto firings = inspector().firings("try", {}, 9 * kSecond);
  ASSERT_TRUE(firings);
  std::vector<std::string> jobs;
  for (const FiringCopy& firing : *firings) jobs.push_back(firing.facts.at(1).print());
  EXPECT_THAT(jobs, ElementsAre("(job (id 1) (tries 0))", "(job (id 1) (tries 1))", "(job (id 1) (tries 2))"));
}

TEST_F(InspectorTest, OnlyAFactAsItIsNowHasAnIndexAndOnlyTheOneAskedForHasItsAssertion) {
  const auto why = inspector().why("(tried 2)");
  ASSERT_TRUE(why) << why.error().text();
  const std::int64_t job = engine_->facts("job").at(0).index;
  const auto asked = inspector().why("(job (id 1))");
  ASSERT_TRUE(asked) << asked.error().text();
  EXPECT_EQ(asked->steps.at(0).text, "(job (id 1) (tries 3))");
  EXPECT_EQ(asked->steps.at(0).index, job);
  ASSERT_TRUE(asked->steps.at(0).asserted);
  EXPECT_EQ(asked->steps.at(0).asserted->by.name, "order");
  for (const Derivation& derivation : {*why, *asked})
    for (std::size_t i = 0; i < derivation.steps.size(); ++i) {
      const Derivation::Step& step = derivation.steps[i];
      if (!step.text.starts_with("(job ")) continue;
      EXPECT_EQ(step.index, step.text.ends_with("(tries 3))") ? job : 0) << step.text;
      EXPECT_EQ(step.asserted.has_value(), i == 0) << step.text;
    }
}

}  // namespace
}  // namespace cxlab::inspect
