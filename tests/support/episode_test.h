#pragma once
// Episodes on scenarios of the test's own: environments, rules and a message package written to a folder.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "scenarios/episode.h"
#include "scenarios/result.h"
#include "scenarios/shipped/catalogue.h"
#include "tests/support/agent_text.h"
#include "tests/support/files.h"

namespace cxlab {

/// Lines as "1.020 logger: text".
class Lines final : public cx::LogSink {
 public:
  void line(const cx::LogLine& l) override {
    char stamp[32];
    std::snprintf(stamp, sizeof stamp, "%.3f ", to_seconds(l.t));
    all.push_back(stamp + std::string(l.logger) + ": " + std::string(l.text));
  }
  /// Those with the text in them.
  std::vector<std::string> with(const std::string& text) const {
    std::vector<std::string> out;
    for (const std::string& l : all)
      if (l.find(text) != std::string::npos) out.push_back(l);
    return out;
  }
  std::vector<std::string> all;
};

/// An environment: its rules, and how often its executive runs.
struct Env {
  std::string name, rules;
  int rate = 50;
};

class EpisodeTest : public testing::Test {
 protected:
  EpisodeTest() { write("words/msg/Word.msg", "string text\nint32 number\n"); }

  std::filesystem::path write(const std::string& name, const std::string& text) {
    return put_file(folder_ / name, text);
  }
  static std::string read(const std::filesystem::path& path) { return content_of(path); }

  /// A scenario `name`.yaml with one agent; `more` are further lines of it.
  std::filesystem::path scenario(const std::string& name, const std::vector<Env>& envs, const std::string& more = {}) {
    std::vector<EnvText> texts;
    for (const Env& e : envs) {
      texts.push_back({e.name, name + '/' + e.name + ".clp", e.rate});
      write("words/" + texts.back().rules, e.rules);
    }
    write(name + "_agent.yaml", agent_text("words", {"ros_msgs"}, texts));
    return write(name + ".yaml",
                 "schema: 1\npackages: {words: words}\nagents: [{config: " + name + "_agent.yaml}]\n" + more);
  }

  std::unique_ptr<Episode> load(const std::filesystem::path& file, const std::vector<Override>& set = {},
                                const std::string& run = {}) {
    auto read_in = Scenario::load(file, shipped(), set);
    EXPECT_TRUE(read_in.ok()) << read_in.error().text();
    return read_in ? load(*read_in, run) : nullptr;
  }
  std::unique_ptr<Episode> load(const Scenario& scenario, const std::string& run = {}) {
    return load(scenario, options(run));
  }
  static std::unique_ptr<Episode> load(const Scenario& scenario, EpisodeOptions options) {
    auto episode = Episode::load(scenario, std::move(options));
    EXPECT_TRUE(episode.ok()) << episode.error().text();
    return episode ? *std::move(episode) : nullptr;
  }
  /// With the whole journal; in the folder `run`, if any.
  EpisodeOptions options(const std::string& run = {}) {
    EpisodeOptions options;
    options.interfaces = interfaces_dir();
    options.models = models_dir();
    options.log = &log_;
    options.spec.journal = JournalLevel::kFull;
    if (!run.empty()) {
      options.run_folder = folder_ / run;
      std::filesystem::create_directories(options.run_folder);
    }
    return options;
  }
  static void begin(Episode& episode) {
    const Status s = episode.start();
    ASSERT_TRUE(s.ok()) << s.error().text();
  }
  static void play(Episode& episode, double until) {
    while (!episode.over() && episode.now() < from_seconds(until)) {
      const Status s = episode.tick();
      ASSERT_TRUE(s.ok()) << s.error().text();
    }
  }
  /// Plays it to the end; what it ended with.
  Result whole(const std::filesystem::path& file, const std::vector<Override>& set = {}, const std::string& run = {}) {
    auto episode = load(file, set, run);
    begin(*episode);
    play(*episode, 1e9);
    return episode->close(RunStatus::kCompleted);
  }
  static std::map<std::string, std::string> streams(const Result& result) {
    return {result.stream_hashes.begin(), result.stream_hashes.end()};
  }

  TempFolder temp_;
  const std::filesystem::path folder_ = temp_.path();
  Lines log_;
};

}  // namespace cxlab
