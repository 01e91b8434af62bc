// Robots that stand in the way of an opponent, and maintenance at the ticks at which something is due.

#include "scenarios/rcll/rules/maintenance.h"

#include "scenarios/rcll/rules/layout.h"
#include "tests/support/game_story.h"

namespace cxlab::rcll {
namespace {

WorldConfig both_teams() {
  WorldConfig config = GameStory::quiet_game();
  config.team = "BOTH";
  return config;
}

/// Cyan's robot 1 and magenta's robot 4 stand somewhere for a while.
struct Standing {
  const char* what;
  sim::Pose2 cyan, magenta;  ///< before the input of M-CS1: x along the face, y away from it
  double seconds;
  bool blocks;
};

TEST(Maintenance, WhoBlocksAnOpponentAtItsMachineForMoreThanTenSecondsMustLeave) {
  const Standing kCases[] = {
      {"it stands where the opponent would work", {0, 0, 0}, {0, 0.8, 0}, 10.2, true},
      {"that stands elsewhere", {0, 0, 0}, {0, 3, 0}, 10.2, false},
      {"only for a while", {0, 0, 0}, {0, 0.8, 0}, 9.9, false},
      {"it stands far enough away", {0, 0.7, 0}, {0, 1.3, 0}, 10.2, false},
  };
  for (const Standing& c : kCases) {
    SCOPED_TRACE(c.what);
    GameStory story(both_teams());
    const sim::Pose2 align = story.world().plan().spot(story.spot("M-CS1-INPUT")).align_in_world;
    const auto before = [&](const sim::Pose2& p) { return sim::compose(align, {-p.y, p.x, 0}); };
    story.set_robot(0, before(c.cyan));
    story.set_robot(3, before(c.magenta));
    story.run_for(c.seconds);
    story.set_robot(0, {1, 6, 0});
    story.run_for(20);
    const auto& robots = story.factory().maintenance().robots();
    EXPECT_EQ(robots[0].cycles, c.blocks ? 1 : 0);
    EXPECT_EQ(robots[3].cycles, 0) << "it stands at its own machine";
  }
}

TEST(Maintenance, WhoFindsAllPlacesOfItsTeamTakenWaitsThoughThoseOfTheOthersAreFree) {
  std::vector<sim::Fault> faults(1);
  sim::Fault& fault = faults.front();
  fault.kind = sim::FaultKind::kRobotMaintenance;
  fault.at = std::chrono::seconds(10);
  fault.duration = std::chrono::seconds(20);
  fault.robot = "robot1";
  GameStory story(both_teams(), 1, std::chrono::milliseconds(20), faults);
  story.set_robot(1, {5, 0.5, 0});  // at the places of robots 1 and 2; robot 3 stands at its own
  for (const int magenta : {3, 4, 5}) story.set_robot(magenta, {-2.0 * magenta + 5, 4, 0});
  const auto first = [&] { return story.world().robot(sim::RobotId{0}).pose_in_world; };
  story.run_until(35);
  EXPECT_EQ(story.factory().maintenance().robots()[0].duty, RobotDuty::kMaintenance);
  EXPECT_LT(first().y, 0);
  story.set_robot(1, {3, 4, 0});
  story.run_for(1);
  EXPECT_EQ(story.factory().maintenance().robots()[0].duty, RobotDuty::kActive);
  EXPECT_NEAR(first().x, 4.5, 1e-9);
}

TEST(Maintenance, JumpsFromEventToEventAndEndsInTheSameTick) {
  std::vector<sim::Fault> faults(3);
  for (std::size_t i = 0; i < faults.size(); ++i) {
    faults[i].kind = sim::FaultKind::kRobotMaintenance;
    faults[i].mean = from_seconds(90);
    faults[i].duration = from_seconds(i == 0 ? 20 : i == 1 ? 110 : 140);
    faults[i].number = i;
  }
  faults[2].from = from_seconds(300);
  const auto play = [&](bool jumping) {
    GameStory story(GameStory::quiet_game(), 3, std::chrono::milliseconds(20), faults);
    story.set_jumping(jumping);
    std::string text;
    // A jump ends early enough to tell a return at once, not only when the topic comes anyway.
    EXPECT_TRUE(story.bus().subscribe(
        story.agent(), "/robot_info", **story.registry().message("rcll_interfaces/msg/RobotInfo"),
        [&](const bus::Delivery&) { text += "heard at " + std::to_string(story.world().now().count()) + '\n'; }));
    story.run_until(900);
    for (const auto& record : story.records().of(RecordKind::kReferee))
      text += std::to_string(record.t.count()) + ' ' + record.data + '\n';
    return std::pair(text, story.ticks());
  };
  const auto [text, ticks] = play(false);
  const auto [jumped, fewer] = play(true);
  EXPECT_EQ(text, jumped);
  EXPECT_LT(fewer, ticks / 10);
  for (const char* state : {"begin", "warning", "end", "disqualified"})
    EXPECT_NE(text.find(state), std::string::npos) << state;
}

TEST(Pause, AnInstructionThatAFaultHoldsUpIsHeldUpInTheGamesTime) {
  std::vector<sim::Fault> faults(2);
  for (sim::Fault& fault : faults) {
    fault.kind = sim::FaultKind::kInstructionLate;
    fault.probability = 1;
    fault.duration = std::chrono::seconds(4);
  }
  faults[0].machine = "C-BS";
  faults[1].machine = "C-CS1";
  WorldConfig config = GameStory::quiet_game();
  config.pauses = {{2, 10}};
  GameStory story(config, 1, std::chrono::milliseconds(20), faults);
  story.set_jumping(true);
  story.instruct("{machine: C-BS, side: OUTPUT, base_color: BASE_RED}");
  story.run_until(13.9);
  EXPECT_EQ(story.state("C-BS"), "IDLE");
  story.run_until(14.2);
  EXPECT_EQ(story.state("C-BS"), "PROCESSING");
  story.run_until(30);
  story.instruct("{machine: C-CS1, operation: RETRIEVE_CAP}");
  story.run_until(33.9);
  EXPECT_EQ(story.state("C-CS1"), "IDLE");
  story.run_until(34.2);
  EXPECT_EQ(story.state("C-CS1"), "PREPARED");
}

}  // namespace
}  // namespace cxlab::rcll
