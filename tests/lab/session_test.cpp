#include "lab/session.h"

#include <gmock/gmock.h>

#include <set>

#include "folder.h"
#include "lab/replay.h"
#include "lab/rerun.h"

namespace cxlab::lab {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

using SessionTest = FolderTest;

struct Watch final : ProgressSink, cx::LogSink {
  std::vector<std::string> notes, lines;
  double done = 0, total = 0;
  std::atomic<bool> stop = false;
  double stop_at = 1e9;

  void progress(double d, double t) override {
    done = d;
    total = t;
    if (d >= stop_at) stop = true;
  }
  void note(std::string_view text) override { notes.emplace_back(text); }
  void line(const cx::LogLine& line) override { lines.emplace_back(line.text); }
  Host host() { return {.log = this, .progress = this, .stop = &stop}; }
};

TEST_F(SessionTest, PlaysAScenarioIntoAFolder) {
  scenario("game", "(defrule once => (printout t \"hello\" crlf))\n");
  Watch watch;
  const Played played = play("game", {}, watch.host());
  EXPECT_FALSE(played.failure);
  EXPECT_THAT(played.errors, IsEmpty());
  EXPECT_EQ(played.result.status, RunStatus::kCompleted);
  EXPECT_EQ(played.folder, path("out"));
  for (const char* file : {"result.json", "manifest.json", "journal.jsonl", "inputs.bin"})
    EXPECT_TRUE(std::filesystem::exists(played.folder / file)) << file;
  EXPECT_THAT(watch.notes, ElementsAre("run: " + path("out").string()));
  EXPECT_EQ(watch.total, 2);
  EXPECT_NEAR(watch.done, 2, 0.03);
}

TEST_F(SessionTest, WritesNothingWhereNothingIsAsked) {
  scenario("game", kQuietRules);
  const Played played = play("game", {.out = "none"});
  EXPECT_EQ(played.result.status, RunStatus::kCompleted);
  EXPECT_TRUE(played.folder.empty());
}

TEST_F(SessionTest, EndsAtTheTickAfterAStop) {
  scenario("game", kQuietRules);
  Watch watch;
  watch.stop_at = 0.5;
  const Played played = play("game", {}, watch.host());
  EXPECT_EQ(played.result.status, RunStatus::kInterrupted);
  EXPECT_FALSE(played.failure);
  EXPECT_NEAR(to_seconds(played.result.sim_time), 0.5, 0.03);
}

TEST_F(SessionTest, AnErrorOfARuleIsTheFailureOfTheRun) {
  scenario("game", "(defrule wrong (time ?) => (+ 1 (nth$ 1 (create$ one))))\n");
  const Played played = play("game");
  ASSERT_TRUE(played.failure);
  EXPECT_EQ(played.failure->kind, ErrorKind::kRun);
  EXPECT_EQ(played.errors.size(), 1u);
  EXPECT_EQ(played.result.status, RunStatus::kFailed);
}

TEST_F(SessionTest, AnErrorWhileLoadingIsReportedOnce) {
  scenario("game", "(defrule wrong (no-such-template (slot 1)) => (no-such-function))\n");
  PlayOptions options;
  options.spec.keep_going = true;
  const Played played = play("game", options);
  ASSERT_TRUE(played.failure);
  EXPECT_EQ(played.failure->kind, ErrorKind::kInput);
  std::set<std::string> texts;
  for (const Error& error : played.errors) EXPECT_TRUE(texts.insert(error.text()).second) << error.text();
}

TEST_F(SessionTest, AFolderInUseIsWrongUsage) {
  scenario("game", kQuietRules);
  play("game");
  const PlayOptions options{.out = path("out").string()};
  const auto again = play_scenario(options, loaded("game"));
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().kind, ErrorKind::kUsage);
}

TEST_F(SessionTest, ReportsEachFileThatIsRead) {
  scenario("game", kQuietRules);
  std::set<std::string> names;
  play("game", {.out = "none", .file_read = [&](const auto& file) { names.insert(file.filename().string()); }});
  EXPECT_TRUE(names.contains("agent.yaml"));
  EXPECT_TRUE(names.contains("rules.clp"));
}

TEST_F(SessionTest, TwoEpisodesInterleavedGiveTheirOwnHashes) {
  const auto file = scenario("game", "(defrule draw (time ?) => (assert (drawn (random))))\n");
  const auto load = [&](std::uint64_t seed) {
    auto scenario = Scenario::load(file, shipped(), {"seed=" + std::to_string(seed)});
    return *Episode::load(*std::move(scenario), shared_episode_options());
  };
  const auto alone = [&](std::uint64_t seed) {
    auto episode = load(seed);
    EXPECT_TRUE(episode->start());
    while (!episode->over()) EXPECT_TRUE(episode->tick());
    return episode->close(RunStatus::kCompleted).journal_hash;
  };
  auto first = load(1), second = load(2);
  ASSERT_TRUE(first->start());
  ASSERT_TRUE(second->start());
  while (!first->over()) {
    ASSERT_TRUE(first->tick());
    ASSERT_TRUE(second->tick());
  }
  EXPECT_EQ(first->close(RunStatus::kCompleted).journal_hash, alone(1));
  EXPECT_EQ(second->close(RunStatus::kCompleted).journal_hash, alone(2));
}

TEST_F(SessionTest, AReplayOfTheRulesAgrees) {
  scenario("game", "(defrule draw (time ?) => (assert (drawn (random))))\n");
  const auto run = Run::open(play("game").folder);
  ASSERT_TRUE(run) << run.error().text();
  const auto outcome = replay_rules(*run);
  ASSERT_TRUE(outcome) << outcome.error().text();
  EXPECT_TRUE(outcome->agrees());
  EXPECT_THAT(outcome->same, ElementsAre("env/main"));
  const auto physics = replay_physics(*run);
  ASSERT_FALSE(physics);
  EXPECT_EQ(physics.error().kind, ErrorKind::kInput);
}

TEST_F(SessionTest, AReplayEndsAtAStopAndComparesNothing) {
  scenario("game", kQuietRules);
  const auto run = Run::open(play("game").folder);
  Watch watch;
  watch.stop = true;
  const auto outcome = replay_rules(*run, watch.host());
  ASSERT_TRUE(outcome);
  EXPECT_TRUE(outcome->stopped);
  EXPECT_THAT(outcome->same, IsEmpty());
  EXPECT_THAT(outcome->differ, IsEmpty());
}

TEST_F(SessionTest, ARerunAgreesUntilAFileChanges) {
  scenario("game", "(defrule draw (time ?) => (assert (drawn (random))))\n");
  const auto run = Run::open(play("game").folder);
  auto again = rerun(*run, {path("again").string()});
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_THAT(again->differ, IsEmpty());
  EXPECT_THAT(again->changed_files, IsEmpty());
  write("rules/rules.clp", "(defrule draw (time ?) => (assert (drawn 1)))\n");
  again = rerun(*run, {path("changed").string()});
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_THAT(again->differ, ElementsAre("env/main"));
  EXPECT_THAT(again->changed_files, ElementsAre(HasSubstr("rules.clp")));
}

TEST_F(SessionTest, ARerunPlaysFromTheCopiesIfFilesHaveGone) {
  scenario("game", "(defrule draw (time ?) => (assert (drawn (random))))\n");
  const auto run = Run::open(play("game").folder);
  std::filesystem::remove_all(path("rules"));
  Watch watch;
  const auto again = rerun(*run, {path("again").string()}, watch.host());
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_THAT(again->differ, IsEmpty());
  EXPECT_THAT(watch.notes.front(), HasSubstr("cxlab uses the run's own copies of all files"));
}

}  // namespace
}  // namespace cxlab::lab
