#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>
#include <map>

#include "cx/engine/engine.h"
#include "cx/engine/form_reader.h"

namespace cxlab {

/// Keeps records as they come, of all streams.
class RecordingSink : public RecordSink {
 public:
  struct Record {
    StreamId stream{};
    SimTime t{};
    RecordKind kind{};
    std::string data;
    std::vector<RecordRef> causes;
  };

  StreamId open_stream(std::string_view name) override {
    names.emplace_back(name);
    return StreamId{static_cast<std::uint16_t>(names.size() - 1)};
  }
  RecordRef write(StreamId stream, SimTime t, RecordKind kind, const RecordData& data,
                  std::span<const RecordRef> causes) override {
    records.push_back({stream, t, kind, std::string(data.bytes()), {causes.begin(), causes.end()}});
    return {stream, counts[stream]++};
  }
  std::vector<Record> of(RecordKind kind) const {
    std::vector<Record> found;
    for (const Record& record : records) {
      if (record.kind == kind) found.push_back(record);
    }
    return found;
  }
  std::vector<Record> of(StreamId stream) const {
    std::vector<Record> found;
    for (const Record& record : records) {
      if (record.stream == stream) found.push_back(record);
    }
    return found;
  }

  std::vector<std::string> names;
  std::vector<Record> records;
  std::map<StreamId, std::uint64_t> counts;
};

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
