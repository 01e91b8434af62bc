#pragma once
// An engine for a test.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "cx/engine/engine.h"
#include "cx/engine/form_reader.h"
#include "tests/support/records.h"

namespace cxlab {

/// An engine whose output is kept; `now` is set by hand.
struct EngineTest : testing::Test {
  EngineOptions options() {
    EngineOptions o;
    o.name = "main";
    o.seed = 7;
    o.now = [this] { return now; };
    o.on_output = [this](std::string_view name, std::string_view text) { output[std::string(name)] += text; };
    return o;
  }
  RuleEngine& engine() {
    if (!engine_) engine_ = make(options());
    return *engine_;
  }
  static std::unique_ptr<RuleEngine> make(EngineOptions o) {
    auto made = RuleEngine::create(std::move(o));
    EXPECT_TRUE(made.ok());
    return std::move(*made);
  }
  /// Loads text as "rules.clp" and fails the test on an error.
  void given(std::string_view rules) {
    const LoadReport report = engine().load_text(rules, "rules.clp", LoadMode::kConstructs);
    for (const RuleError& error : report.errors) ADD_FAILURE() << error.text() << "\n" << error.detail;
  }
  std::vector<std::string> load_errors(std::string_view rules, LoadMode mode = LoadMode::kConstructs,
                                       OnLoadError on_error = OnLoadError::kKeepGoing) {
    std::vector<std::string> texts;
    for (const RuleError& error : engine().load_text(rules, "rules.clp", mode, on_error).errors)
      texts.push_back(error.text());
    return texts;
  }
  std::vector<std::string> fact_texts(std::string_view template_name = {}) {
    std::vector<std::string> texts;
    for (const FactCopy& fact : engine().facts(template_name)) texts.push_back(fact.print());
    return texts;
  }

  SimTime now{};
  std::map<std::string, std::string> output;
  std::unique_ptr<RuleEngine> engine_;
};

}  // namespace cxlab
