// A game as an episode has it: the places that robots know, and what the result says of each robot.

#include <numbers>

#include "cx/bus/bus.h"
#include "scenarios/rcll/game/floor_plan.h"
#include "scenarios/rcll/game/game.h"
#include "scenarios/rcll/game/result.h"
#include "scenarios/view.h"
#include "tests/support/episode_test.h"

namespace cxlab::rcll {
namespace {

class GameStage : public EpisodeTest {
 protected:
  GameStage() {
    const auto scenario = Scenario::parse("schema: 1\nworld: {kind: rcll, robots: 1, down: false}\ntier: timed\n",
                                          folder_ / "game.yaml", shipped());
    EXPECT_TRUE(scenario.ok()) << scenario.error().text();
    episode_ = load(*scenario);
    begin(*episode_);
    bus::Bus& bus = episode_->bus();
    driver_ =
        bus.join(bus::ParticipantKind::kNode, {"driver", "/", {}}, episode_->journal().open_stream("node/driver"));
    drive_ = *bus.registry().action("cxlab_skills/action/DriveTo");
    client_ = *bus.create_action_client(
        driver_, "/robot1/drive_to", *drive_,
        {nullptr, nullptr, [this](const bus::Delivery& d) { code_ = d.message->view().integer("error_code"); },
         nullptr});
  }

  bus::GoalId drive_to(const std::string& target) {
    code_ = -1;
    return episode_->bus().send_goal(
        client_, std::make_shared<bus::Message>(*bus::Message::from_yaml(*drive_->goal, "{target: " + target + "}")));
  }
  void tick() {
    const Status ticked = episode_->tick();
    ASSERT_TRUE(ticked.ok()) << ticked.error().text();
    episode_->bus().deliver(driver_);
  }
  /// The code of the goal, once it has ended.
  std::int64_t code() {
    for (int i = 0; i < 5000 && code_ < 0; ++i) tick();
    return code_;
  }

  std::unique_ptr<Episode> episode_;
  bus::ParticipantId driver_{};
  const bus::ActionType* drive_ = nullptr;
  bus::EndpointId client_{};
  std::int64_t code_ = -1;
};

TEST_F(GameStage, ARobotKnowsEveryZoneOfTheField) {
  constexpr int kInvalidTarget = 103;
  for (const std::string half : {"C", "M"})
    for (int column = 1; column <= 7; ++column)
      for (int row = 1; row <= 8; ++row) {
        const std::string zone = half + "_Z" + std::to_string(column) + std::to_string(row);
        const bus::GoalId goal = drive_to(zone);
        tick();
        episode_->bus().cancel_goal(client_, goal);
        EXPECT_NE(code(), kInvalidTarget) << zone;
      }
  drive_to("C_Z81");
  EXPECT_EQ(code(), kInvalidTarget);
  drive_to("C_Z19");
  EXPECT_EQ(code(), kInvalidTarget);
}

TEST_F(GameStage, ARobotInAZoneStandsInItsMiddleAndFacesTheOppositeWall) {
  drive_to("C_Z52");
  EXPECT_EQ(code(), 0);
  const auto& floor = dynamic_cast<const sim::World&>(*episode_->stage().worlds.front());
  const sim::Pose2 pose = floor.robot(sim::RobotId{0}).pose_in_world;
  EXPECT_NEAR(pose.x, 4.5, 1e-6);
  EXPECT_NEAR(pose.y, 1.5, 1e-6);
  EXPECT_NEAR(pose.yaw, std::numbers::pi / 2, 1e-6);
}

/// A floor on which robot n has had n contacts.
class Bumps final : public sim::World {
 public:
  /// After 120 s of game and 30 s of a pause.
  Bumps() : World(floor_plan_of(WorldConfig{}, game_of(WorldConfig{}, 1)->layout)) {
    now_ = from_seconds(100);
    halt();
    now_ = from_seconds(130);
    go_on();
    now_ = from_seconds(150);
  }
  sim::RobotState robot(sim::RobotId id) const override {
    sim::RobotState state;
    state.robot_contacts = static_cast<std::uint32_t>(id) + 1;
    return state;
  }
  bool belt_running(sim::StationId) const override { return false; }
  const sim::Piece* at(sim::SpotId) const override { return nullptr; }
  const sim::Piece* on_belt(sim::StationId, double) const override { return nullptr; }
  Status advance(SimTime) override { return {}; }
  SimTime next_event() const override { return kNever; }
  Expected<sim::PieceId> bring_out(const Source&, double, const sim::Stack&) override { return negative("full"); }
  Expected<sim::PieceId> dispense(sim::SpotId, const sim::Stack&) override { return negative("full"); }
  void run_belt(sim::StationId, double, double) override {}
  void stop_belt(sim::StationId) override {}
  void mount(sim::PieceId, sim::Part, std::uint8_t) override {}
  void unmount_cap(sim::PieceId) override {}
  void retire(sim::PieceId, sim::Holder) override {}
  void set_down(sim::RobotId, const sim::Pose2&) override {}
  void set_lights(sim::StationId, const sim::Lights&) override {}
  sim::Lights lights(sim::StationId) const override { return {}; }
};

TEST(GameResult, CountsWhatEachRobotDid) {
  std::vector<sim::RobotStats> robots(2);
  robots[0] = {.name = "robot1", .busy_s = 30, .drive_s = 15, .wait_s = 5, .skills = 4, .failures = 1};
  robots[1] = {.name = "robot2", .busy_s = 60, .drive_s = 6, .wait_s = 0, .skills = 2, .failures = 0};
  Result result;
  result.sim_time = from_seconds(150);
  std::vector<rcll::Maintenance::Robot> duties(2);
  duties[1].cycles = 2;
  duties[1].duty = rcll::RobotDuty::kDisqualified;
  report_robots(robots, duties, Bumps(), result);
  EXPECT_EQ(
      result.at("robots"),
      R"([{"name":"robot1","busy_s":30.0,"drive_s":15.0,"wait_s":5.0,"skills":4,"failures":1,"contacts":1,"state":"ACTIVE","maintenances":0},)"
      R"({"name":"robot2","busy_s":60.0,"drive_s":6.0,"wait_s":0.0,"skills":2,"failures":0,"contacts":2,"state":"DISQUALIFIED","maintenances":2}])");
  EXPECT_EQ(result.score_board,
            "robot1   at work  25 %, driving  12 %, 4 skills, 1 failed, 1 contacts\n"
            "robot2   at work  50 %, driving   5 %, 2 skills, 0 failed, 2 contacts, 2 in maintenance, disqualified\n");
}

TEST_F(GameStage, TheTimedTierIsDrawnFromItsScene) {
  const auto view = view_of(episode_->stage(), 64, 64);
  ASSERT_TRUE(view.ok()) << view.error().text();
  EXPECT_THAT((*view)->cameras(), testing::ElementsAre("field", "top"));
  for (const char* camera : {"field", "follow-robot1", "robot1"}) EXPECT_TRUE((*view)->draw(camera).ok()) << camera;
  EXPECT_EQ((*view)->headline().back().text, "CYAN 0");
}

TEST_F(GameStage, NeedsEachOfItsInterfaces) {
  const auto scenario = Scenario::parse("schema: 1\nworld: {kind: rcll, transforms: true}\ntier: timed\n",
                                        folder_ / "game.yaml", shipped());
  ASSERT_TRUE(scenario.ok()) << scenario.error().text();
  EpisodeOptions options;
  options.interfaces = folder_ / "interfaces";
  std::filesystem::copy(interfaces_dir(), options.interfaces, std::filesystem::copy_options::recursive);
  EXPECT_TRUE(Episode::load(*scenario, options).ok());
  for (const std::string name :
       {"rcll_interfaces/action/InstructMachine.action", "rcll_interfaces/msg/GameState.msg",
        "rcll_interfaces/msg/OrderInfo.msg", "rcll_interfaces/msg/MachineInfo.msg", "rcll_interfaces/msg/RingInfo.msg",
        "rcll_interfaces/msg/RobotInfo.msg", "cxlab_skills/action/DriveTo.action", "cxlab_skills/action/Pick.action",
        "cxlab_skills/action/Place.action", "tf2_msgs/msg/TFMessage.msg"}) {
    std::filesystem::rename(options.interfaces / name, folder_ / "away");
    const auto episode = Episode::load(*scenario, options);
    ASSERT_FALSE(episode.ok()) << name;
    EXPECT_THAT(episode.error().text(), testing::HasSubstr(name.substr(0, name.find('.')))) << name;
    std::filesystem::rename(folder_ / "away", options.interfaces / name);
  }
}

TEST_F(GameStage, PhysicsTakesTheStepsOfTheScenario) {
  for (const auto& [step, steps] : {std::pair{"0.005", 400}, std::pair{"0.02", 100}}) {
    const auto scenario =
        Scenario::parse("schema: 1\nworld: {kind: rcll, robots: 1}\nphysics_step_s: " + std::string(step) + "\n",
                        folder_ / "game.yaml", shipped());
    ASSERT_TRUE(scenario.ok()) << scenario.error().text();
    const auto episode = load(*scenario);
    begin(*episode);
    play(*episode, 2);
    Result result;
    episode->stage().report(result);
    EXPECT_NEAR(static_cast<double>(result.steps), steps, 4) << step;
  }
}

TEST_F(GameStage, PhysicsWithoutItsModelsIsAnErrorThatNamesTheFolder) {
  const auto scenario = Scenario::parse("schema: 1\nworld: {kind: rcll}\n", folder_ / "game.yaml", shipped());
  ASSERT_TRUE(scenario.ok());
  EpisodeOptions options;
  options.interfaces = interfaces_dir();
  options.models = folder_ / "nowhere";
  const auto episode = Episode::load(*scenario, options);
  ASSERT_FALSE(episode.ok());
  EXPECT_EQ(episode.error().kind, ErrorKind::kResource);
  EXPECT_THAT(episode.error().text(), testing::HasSubstr("there is no folder of models at " + options.models.string()));
}

}  // namespace
}  // namespace cxlab::rcll
