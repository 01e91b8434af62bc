// What must not move anything: another episode beside this one, another environment, another run.

#include <malloc.h>

#include "tests/support/episode_test.h"

namespace cxlab {
namespace {

using Apart = EpisodeTest;

const std::string kSay = R"((deffacts start (open))
(defrule open (open) => (ros-msgs-create-publisher "/word" "words/msg/Word") (ros-msgs-create-subscription "/word" "words/msg/Word"))
(defrule say (time ?t) => (bind ?m (ros-msgs-create-message "words/msg/Word")) (println ?m)
  (ros-msgs-set-field ?m "number" (random 1 1000)) (ros-msgs-publish ?m "/word") (ros-msgs-destroy-message ?m))
(defrule hear ?f <- (ros-msgs-message (msg-ptr ?m)) => (println "heard " (ros-msgs-get-field ?m "number")) (ros-msgs-destroy-message ?m) (retract ?f))
)";

std::filesystem::path game() { return source_dir() / "scenarios/rcll/game.yaml"; }

TEST_F(Apart, SameSeedSameBytes) {
  const auto file = scenario("same", {{"a", kSay, 10}, {"b", kSay, 7}}, "duration_s: 5\n");
  const Result one = whole(file, {}, "one"), two = whole(file, {}, "two"), other = whole(file, {"seed=2"}, "other");
  EXPECT_EQ(one.journal_hash, two.journal_hash);
  EXPECT_NE(one.journal_hash, other.journal_hash) << "chance comes from the seed";
  for (const char* name : {"journal.jsonl", "inputs.bin", "logs/a.log"}) {
    const std::string bytes = read(folder_ / "one" / name);
    EXPECT_GT(bytes.size(), 100u) << name;
    EXPECT_TRUE(bytes == read(folder_ / "two" / name)) << name;
    EXPECT_EQ(bytes.find(folder_.string()), std::string::npos) << name << " has no path of this machine";
  }
}

TEST_F(Apart, WhatHappensInOneEnvironmentMovesNothingInAnother) {
  const std::string quiet =
      R"((deffacts start (open)) (defrule open (open) => (ros-msgs-create-subscription "/elsewhere" "words/msg/Word")))";
  const std::string noisy = R"((deffacts start (open))
(defrule draw (declare (salience 10)) (time ?t) => (println (random 1 100)))
(defrule more (open) => (ros-msgs-create-subscription "/third" "std_msgs/msg/String") (ros-msgs-create-message "words/msg/Word")
  (ros-msgs-create-publisher "/elsewhere" "words/msg/Word") (ros-msgs-create-subscription "/word" "words/msg/Word"))
)";
  const std::string stimuli =
      "duration_s: 5\nstimuli:\n  - {at: 2, publish: /word, type: words/msg/Word, data: {number: 7}}\n";
  const auto before = streams(whole(scenario("p", {{"b", quiet, 10}, {"a", kSay, 7}}, stimuli)));
  write("words/p/b.clp", noisy);
  const auto after = streams(whole(folder_ / "p.yaml"));
  EXPECT_NE(before.at("env/b"), after.at("env/b"));
  for (const char* stream : {"env/a", "node/stimuli"}) EXPECT_EQ(before.at(stream), after.at(stream)) << stream;
}

TEST_F(Apart, EpisodesSideBySideAreAsEachAlone) {
  const std::vector<Override> first{"tier=timed", "duration_s=120"},
      second{"tier=timed", "duration_s=120", "seed=2", "world.team=MAGENTA"};
  const Result alone_a = whole(game(), first), alone_b = whole(game(), second);
  auto a = load(game(), first), b = load(game(), second);
  begin(*a);
  begin(*b);
  while (!a->over() || !b->over()) {
    if (!a->over()) {
      ASSERT_TRUE(a->tick().ok());
    }
    for (int i = 0; i < 3 && !b->over(); ++i) ASSERT_TRUE(b->tick().ok());
  }
  const Result beside_a = a->close(RunStatus::kCompleted), beside_b = b->close(RunStatus::kCompleted);
  EXPECT_EQ(beside_a.stream_hashes, alone_a.stream_hashes);
  EXPECT_EQ(beside_b.stream_hashes, alone_b.stream_hashes);
  EXPECT_NE(alone_a.journal_hash, alone_b.journal_hash);
}

TEST_F(Apart, PhysicsSideBySideIsAsAlone) {
  const std::vector<Override> set{"duration_s=4"};
  const Result alone = whole(game(), set);
  auto a = load(game(), set), b = load(game(), {"duration_s=4", "seed=2"});
  begin(*a);
  begin(*b);
  while (!a->over()) {
    ASSERT_TRUE(a->tick().ok());
    ASSERT_TRUE(b->tick().ok());
  }
  const Result beside = a->close(RunStatus::kCompleted);
  EXPECT_FALSE(alone.physics_hash.empty());
  EXPECT_EQ(beside.physics_hash, alone.physics_hash);
  EXPECT_EQ(beside.stream_hashes, alone.stream_hashes);
}

TEST_F(Apart, ManyEpisodesLeaveTheMemoryFlat) {
  const auto play_some = [&](int n) {
    for (int i = 0; i < n; ++i) (void)whole(game(), {"tier=timed", "duration_s=60"});
    log_.all = {};
    return mallinfo2().uordblks;
  };
  const std::size_t before = play_some(5), after = play_some(20);
  EXPECT_LT(after, before + 64 * 1024);
}

}  // namespace
}  // namespace cxlab
