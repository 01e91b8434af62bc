// Episodes that stop where rules leave a choice to the caller: the example of docs/reference/learning.md.

#include "lab/choices.h"

#include <gmock/gmock.h>

#include <set>

#include "folder.h"
#include "lab/replay.h"
#include "scenarios/share.h"

namespace cxlab::lab {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr const char* kDoors = R"(
(deftemplate opened (slot door) (slot at))
(deffacts rooms (room 1 left right wall) (room 2 left right wall))
(defrule ask-which-door
  (room ?number $?doors)
  (time ?now&:(>= ?now (* 0.5 ?number)))
  (not (asked ?number))
  =>
  (assert (asked ?number))
  (assert (choice (id (new-choice)) (kind open-door) (who (str-cat "robot" ?number)) (items ?doors) (options "to the left" "to the right" "none")
                  (allowed TRUE TRUE FALSE) (preferred 1) (situation 0.5) (features 1.0 0.25 0.0 0.75 0.0 0.0) (since ?now))))
(defrule open-the-door-that-was-chosen
  ?choice <- (choice (id ?id))
  (choice-made (choice ?id) (option ?option))
  (time ?now)
  =>
  (assert (opened (door (made-item ?choice ?option)) (at ?now)))
  (retract ?choice))
)";

class ChoicesTest : public FolderTest {
 protected:
  ChoicesTest() {
    scenario("doors", content_of(find_share().packages / "cxlab_choices/clips/choices.clp") + kDoors, {"ros_msgs"});
  }

  std::unique_ptr<ChoiceEpisode> episode(const std::string& out) const {
    PlayOptions options{.out = path(out).string()};
    options.spec.journal = JournalLevel::kFull;
    auto episode = ChoiceEpisode::load(options, loaded("doors"));
    EXPECT_TRUE(episode) << (episode ? "" : episode.error().text());
    return *std::move(episode);
  }
  /// The open choice, a copy of it; one without a kind: the episode is over.
  static Choice next(ChoiceEpisode& episode) {
    const auto open = episode.next_choice();
    EXPECT_TRUE(open) << (open ? "" : open.error().text());
    return *open ? **open : Choice();
  }
};

TEST_F(ChoicesTest, TheEpisodeStopsAtEachChoiceAndItsAnswerIsTaken) {
  const auto doors = episode("run");
  const Choice first = next(*doors);
  EXPECT_EQ(first.kind, "open-door");
  EXPECT_EQ(first.who, "robot1");
  EXPECT_THAT(first.options, ElementsAre("to the left", "to the right", "none"));
  EXPECT_THAT(first.allowed, ElementsAre(true, true, false));
  EXPECT_EQ(first.preferred, 0);
  EXPECT_THAT(first.situation, ElementsAre(0.5));
  EXPECT_THAT(first.features, ElementsAre(1.0, 0.25, 0.0, 0.75, 0.0, 0.0));
  EXPECT_LT(to_seconds(doors->session().episode().now()), 0.6);
  ASSERT_TRUE(doors->choose(1));
  EXPECT_EQ(next(*doors).who, "robot2");
  ASSERT_TRUE(doors->choose(0));
  EXPECT_EQ(next(*doors).kind, "");
  EXPECT_EQ(to_seconds(doors->session().episode().now()), 2.0);
}

TEST_F(ChoicesTest, AnOptionThatMayNotBeChosenIsRefusedAndTheChoiceStaysOpen) {
  const auto doors = episode("run");
  EXPECT_THAT(doors->choose(0).error().text(), HasSubstr("call next_choice() first"));
  (void)next(*doors);
  for (const std::int64_t option : {-1, 2, 3}) {
    const Status refused = doors->choose(option);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, ErrorKind::kUsage);
    EXPECT_THAT(refused.error().text(), HasSubstr("option " + std::to_string(option) + " of choice 1 (open-door)"));
  }
  EXPECT_EQ(next(*doors).who, "robot1");
}

TEST_F(ChoicesTest, TheRunReplaysWithoutTheCallerAndDependsOnWhatWasChosen) {
  std::vector<std::string> journals;
  for (const auto& [out, option] : {std::pair("left", 0), std::pair("right", 1), std::pair("again", 1)}) {
    const auto doors = episode(out);
    while (!next(*doors).kind.empty()) ASSERT_TRUE(doors->choose(option));
    ASSERT_FALSE(doors->session().close().failure);
    const auto replayed = replay_rules(run(out));
    ASSERT_TRUE(replayed) << replayed.error().text();
    EXPECT_TRUE(replayed->agrees()) << replayed->first_difference;
    journals.push_back(read(std::string(out) + "/journal.jsonl"));
    EXPECT_THAT(journals.back(), HasSubstr(option == 0 ? R"("door":"left")" : R"("door":"right")"));
  }
  EXPECT_NE(journals[0], journals[1]);
  EXPECT_EQ(journals[1], journals[2]);
}

TEST_F(ChoicesTest, ManyEpisodesArePlayedOnInAnyNumberOfThreads) {
  const auto alone = episode("alone");
  while (!next(*alone).kind.empty()) ASSERT_TRUE(alone->choose(1));
  ASSERT_FALSE(alone->session().close().failure);
  for (const std::size_t threads : {0u, 1u, 2u, 3u, 9u}) {
    std::vector<std::unique_ptr<ChoiceEpisode>> all;
    std::vector<ChoiceEpisode*> open;
    for (int i = 0; i < 5; ++i)
      open.push_back(all.emplace_back(episode(std::to_string(threads) + "-" + std::to_string(i))).get());
    int choices = 0;
    for (; !open.empty(); ++choices) {
      ASSERT_TRUE(ChoiceEpisode::play_on(open, threads));
      std::erase_if(open, [](ChoiceEpisode* one) { return one->session().over(); });
      for (ChoiceEpisode* one : open) ASSERT_TRUE(one->choose(1)) << "it has a choice that nobody played to";
    }
    EXPECT_EQ(choices, 3);
    for (int i = 0; i < 5; ++i) {
      ASSERT_FALSE(all[static_cast<std::size_t>(i)]->session().close().failure);
      EXPECT_EQ(read(std::to_string(threads) + "-" + std::to_string(i) + "/journal.jsonl"),
                read("alone/journal.jsonl"));
    }
  }
  EXPECT_TRUE(ChoiceEpisode::play_on({}, 2));
}

TEST_F(ChoicesTest, OfManyEpisodesTheFirstErrorIsToldAndTheOthersArePlayedOn) {
  const auto first = episode("first"), last = episode("last");
  scenario("failing",
           content_of(find_share().packages / "cxlab_choices/clips/choices.clp") +
               "(defrule fails (time ?t&:(> ?t 0.7)) => (+ (nth$ 1 (create$ a)) 1))\n",
           {"ros_msgs"});
  auto failing = ChoiceEpisode::load({.out = "none"}, loaded("failing"));
  ASSERT_TRUE(failing) << failing.error().text();
  const std::vector<ChoiceEpisode*> all = {first.get(), failing->get(), last.get()};
  const Status played = ChoiceEpisode::play_on(all, 2);
  ASSERT_FALSE(played);
  EXPECT_EQ(played.error().kind, ErrorKind::kRun) << played.error().text();
  for (const auto* one : {&first, &last}) EXPECT_TRUE((*one)->choose(0));
}

TEST_F(ChoicesTest, APauseEndsAllThreadsAndTheyGoOnFromThere) {
  const auto one = episode("one"), two = episode("two");
  const std::vector<ChoiceEpisode*> all = {one.get(), two.get()};
  ASSERT_TRUE(ChoiceEpisode::play_on(all, 2, [] { return true; }));
  for (ChoiceEpisode* each : all) {
    EXPECT_FALSE(each->choose(0)) << "one tick is too early for a choice";
    EXPECT_GE(each->session().episode().now(), SimTime::zero());
  }
  ASSERT_TRUE(ChoiceEpisode::play_on(all, 2));
  for (ChoiceEpisode* each : all) EXPECT_TRUE(each->choose(0));
}

TEST(Choices, APathOfTheResultOfAGameIsAtEachChoiceThatOfTheWholeResult) {
  auto scenario =
      Scenario::load(*find_scenario("rcll/external"), shipped(), {{"tier=timed", "test"}, {"seed=1", "test"}});
  ASSERT_TRUE(scenario) << scenario.error().text();
  PlayOptions options{.out = "none"};
  options.spec.journal = JournalLevel::kNone;
  auto game = ChoiceEpisode::load(options, *std::move(scenario));
  ASSERT_TRUE(game) << game.error().text();
  const Episode& episode = (*game)->session().episode();
  std::set<std::string> points;
  for (auto choice = (*game)->next_choice(); choice && *choice; choice = (*game)->next_choice()) {
    const Result whole = episode.result();
    for (const char* path : {"teams", "teams.CYAN.points", "teams.CYAN.by_kind.ring", "teams.PINK.points", "orders",
                             "orders[0].points", "deliveries", "deliveries[0].time", "robots", "robots[2].skills",
                             "ticks", "sim_time_s", "journal_hash", "warnings", "nothing.here", ""})
      ASSERT_EQ(episode.result_at(path), whole.at(path)) << path << " at " << to_seconds(episode.now()) << " s";
    points.insert(whole.at("teams.CYAN.points"));
    ASSERT_TRUE((*game)->choose((*choice)->preferred));
  }
  EXPECT_GT(points.size(), 10u);
}

}  // namespace
}  // namespace cxlab::lab
