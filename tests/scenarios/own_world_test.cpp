// The grid of docs/examples/own_world, compiled into this test: its errors, its chance, its picture and its robot.
// tests/app/own_plugins.py builds it as a user does.

#include <set>

#include "docs/examples/own_world/grid.h"
#include "tests/support/episode_test.h"

namespace cxlab {
namespace {

class OwnWorldExample : public EpisodeTest {
 protected:
  OwnWorldExample() { catalogue_.worlds.push_back(&grid::kWorld); }

  Expected<Scenario> maze(const std::vector<Override>& set = {}) const {
    return Scenario::load(folder_of_example_ / "maze.yaml", catalogue_, set);
  }
  /// The error of a scenario with these keys below `world:`, of which the first is in line 4.
  std::string error_of(const std::string& keys) const {
    const auto scenario = Scenario::parse("schema: 1\nworld:\n  kind: grid\n" + keys, "s.yaml", catalogue_);
    return scenario ? std::string() : scenario.error().text();
  }
  Result played(const std::vector<Override>& set) {
    const auto scenario = maze(set);
    EXPECT_TRUE(scenario.ok()) << scenario.error().text();
    auto episode = load(*scenario);
    begin(*episode);
    play(*episode, 1e9);
    return episode->close(RunStatus::kCompleted);
  }

  const std::filesystem::path folder_of_example_ = source_dir() / "docs/examples/own_world";
  Catalogue catalogue_ = shipped();
};

TEST_F(OwnWorldExample, ExplorerFindsTheGoalFromWhereverTheSeedPutsIt) {
  std::set<std::string> hashes;
  for (const char* seed : {"seed=1", "seed=2", "seed=3"}) {
    const Result result = played({seed});
    EXPECT_EQ(result.at("grid.reached"), "true") << result.score_board;
    EXPECT_TRUE(result.rule_errors.empty());
    hashes.insert(result.journal_hash);
  }
  EXPECT_EQ(hashes.size(), 3u);
  EXPECT_TRUE(hashes.contains(played({"seed=1"}).journal_hash)) << "the same seed is the same run";
}

TEST_F(OwnWorldExample, StepsAndBumpsAreCounted) {
  const Result result = played({"world.map=['#####', '#S.G#', '#####']"});
  EXPECT_EQ(result.at("grid.steps"), "2");
  EXPECT_LE(std::stoi(result.at("grid.bumps")), 5) << "at most the walls around the two cells before the goal";
  EXPECT_EQ(result.at("grid.points"), std::to_string(-2 - std::stoi(result.at("grid.bumps"))));
  EXPECT_EQ(result.score_board, "at the goal after 2 steps and " + result.at("grid.bumps") + " bumps\n");
}

TEST_F(OwnWorldExample, GoalBehindWallsIsGivenUp) {
  const Result result = played({"world.map=['S.#G']"});
  EXPECT_EQ(result.at("grid.reached"), "false");
  EXPECT_EQ(log_.with("there is no way to the goal").size(), 1u);
  EXPECT_LT(result.sim_time, from_seconds(30));
}

TEST_F(OwnWorldExample, UnknownDirectionIsAnsweredWithWhatIsExpected) {
  auto episode = load(*maze());
  bus::Bus& bus = episode->bus();
  const auto me = bus.join(bus::ParticipantKind::kNode, {"me", "/", {}}, episode->journal().open_stream("node/me"));
  const bus::ServiceType& move = **bus.registry().service("grid/srv/Move");
  std::string error;
  const auto client = bus.create_client(me, "/grid/move", move,
                                        [&](const bus::Delivery& d) { error = d.message->view().text("error"); });
  begin(*episode);
  bus::Message request(*move.request);
  request->set("direction", "up");
  bus.call(*client, std::make_shared<const bus::Message>(std::move(request)));
  while (error.empty() && episode->now() < from_seconds(5)) {
    ASSERT_TRUE(episode->tick().ok());
    bus.deliver(me);
  }
  EXPECT_EQ(error, "direction: found 'up', expected north, east, south, west or stay");
}

TEST_F(OwnWorldExample, ErrorsNameTheLineOfTheRow) {
  EXPECT_EQ(error_of("  map:\n    - \"S.G\"\n    - \"....\"\n"),
            "s.yaml:6: world.map[1]: found 4 cells, expected 3 as in the first row");
  EXPECT_EQ(error_of("  map:\n    - \"S.G\"\n    - \".x.\"\n"),
            "s.yaml:6: world.map[1]: found 'x', expected # (wall), . (free), S (start) or G (goal)");
  EXPECT_EQ(error_of("  map: [\"S..\"]\n"), "s.yaml:4: world.map: found 0 goals (G), expected one");
  EXPECT_EQ(error_of("  map: [\"SSG\"]\n"), "s.yaml:4: world.map: found 2 starts (S), expected at most one");
  EXPECT_EQ(error_of("  map: [\"G#\"]\n"), "s.yaml:4: world.map: expected a cell to start from, S or .");
  EXPECT_EQ(error_of("  map: []\n"), "s.yaml:4: world.map: expected at least one row");
  EXPECT_EQ(error_of("  map: [\"\"]\n"), "s.yaml:4: world.map[0]: found 0 cells, expected some");
  EXPECT_EQ(error_of("  map: [\"SG\"]\n  step_s: 0\n"), "s.yaml:5: world.step_s: expected more than 0");
}

TEST_F(OwnWorldExample, SceneHasTheRobotTheGoalAndTheWalls) {
  auto episode = load(*maze({"world.map=['S.#', '#.G']"}), "run");
  begin(*episode);
  play(*episode, 1e9);
  const Scene last = episode->scene();
  std::map<std::string, int> kinds;
  for (const Entity& entity : last.entities) ++kinds[entity.kind];
  EXPECT_EQ(kinds, (std::map<std::string, int>{{"robot", 1}, {"goal", 1}, {"wall", 2}}));
  EXPECT_EQ(last.find("robot")->pose.position, last.find("goal")->pose.position);
  EXPECT_EQ(last.find("goal")->pose.position, sim::Vec3(2.5, 0.5, 0));
  (void)episode->close(RunStatus::kCompleted);
  auto recorded = SceneReader::open(folder_ / "run/scene.bin");
  ASSERT_TRUE(recorded.ok()) << recorded.error().text();
  EXPECT_EQ(recorded->at({})->find("robot")->pose.position, sim::Vec3(0.5, 1.5, 0));
  EXPECT_EQ(recorded->at(recorded->end())->entities, last.entities);
}

TEST_F(OwnWorldExample, PageHasALaneWithEachStepAndBump) {
  const auto scenario = maze();
  const Result result = played({});
  std::vector<JournalRecord> records(3);
  for (JournalRecord& record : records) record.stream = "node/grid";
  records[0].data.value = RecordValue::Map{{"event", {"step"}}, {"to", {"east"}}, {"begin_s", {1.0}}};
  records[0].t = from_seconds(1.5);
  records[1].data.value = RecordValue::Map{{"event", {"bump"}}, {"to", {"north"}}, {"begin_s", {1.5}}};
  records[1].t = from_seconds(2);
  records[2].stream = "node/other";
  const std::filesystem::path none;
  const auto page = grid::kWorld.page({none, *scenario, records, {}, from_seconds(9), true, {}}, result);
  ASSERT_TRUE(page.ok());
  const auto& lanes = std::get<PageLanes>(page->parts.back());
  ASSERT_EQ(lanes.lanes.size(), 1u);
  EXPECT_EQ(lanes.lanes[0].name, "robot") << "that of the entity of the scene";
  const auto& bars = lanes.lanes[0].bars;
  ASSERT_EQ(bars.size(), 2u);
  EXPECT_EQ(std::tie(bars[0].kind, bars[0].begin, bars[0].end, bars[0].text),
            std::make_tuple(std::string("step"), 1.0, 1.5, std::string("step east")));
  EXPECT_EQ(std::tie(bars[1].kind, bars[1].begin, bars[1].end, bars[1].text),
            std::make_tuple(std::string("bump"), 1.5, 2.0, std::string("bump north")));
  for (const PageBar& bar : bars)
    EXPECT_NE(std::ranges::find(page->kinds, bar.kind, &PageKind::name), page->kinds.end());
}

TEST_F(OwnWorldExample, PictureShowsRobotGoalAndWalls) {
  auto scenario = maze({"world.map=['SG', '#.']"});
  auto episode = load(*scenario);
  begin(*episode);
  auto view = view_of(episode->stage(), 21, 20);
  ASSERT_TRUE(view.ok()) << view.error().text();
  EXPECT_EQ((*view)->cameras(), std::vector<std::string>{"grid"});
  const sim::Picture& picture = **(*view)->draw("grid");
  ASSERT_EQ(picture.width, 20);
  ASSERT_EQ(picture.height, 20);
  std::set<std::uint8_t> reds;
  for (const std::size_t y : {5u, 15u})
    for (const std::size_t x : {5u, 15u}) reds.insert(picture.rgb[3 * (y * 20 + x)]);
  EXPECT_EQ(reds.size(), 4u) << "robot, goal, wall and free cell have a colour each";
  EXPECT_FALSE((*view)->draw("field").ok());
}

}  // namespace
}  // namespace cxlab
