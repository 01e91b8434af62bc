// Robots that stand in the way of an opponent, and maintenance at the ticks at which something is due.

#include "scenarios/rcll/rules/maintenance.h"

#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

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

TEST(Maintenance, EachRecordNamesTheTeamOfTheRobot) {
  GameStory story(both_teams());
  const bus::MessageType& type = **story.registry().message("rcll_interfaces/msg/SetRobotMaintenance");
  const auto ask = [&](const char* team, int robot, bool begins) {
    const bus::EndpointId requests =
        *story.bus().advertise(story.agent(), std::string(team) + "/set_robot_maintenance", type);
    bus::Message message(type);
    message->set("team_color", team == std::string("/cyan") ? "CYAN" : "MAGENTA");
    message->set("robot_number", robot).set("maintenance", begins);
    story.bus().publish(requests, std::make_shared<bus::Message>(std::move(message)));
    story.run_for(0.06);
  };
  for (const char* team : {"/cyan", "/magenta"})
    for (const int robot : {1, 2, 1, 2}) ask(team, robot, true);  // the second time refused
  story.run_for(110);
  for (const char* team : {"/cyan", "/magenta"}) ask(team, 1, false);
  story.run_for(40);
  std::map<std::string, std::set<std::string>> robots;  // by team and state
  for (const auto& record : story.records().of(RecordKind::kReferee)) {
    const auto data = nlohmann::json::from_msgpack(record.data);
    if (data.at("event") == "maintenance")
      robots[data.at("team").get<std::string>() + ' ' + data.at("state").get<std::string>()].insert(
          data.value("robot", "number " + std::to_string(data.value("number", 0))));
  }
  using Names = std::set<std::string>;
  const std::map<std::string, Names> wanted{{"CYAN begin", {"robot1", "robot2"}},
                                            {"CYAN refused", {"number 1", "number 2"}},
                                            {"CYAN warning", {"robot1", "robot2"}},
                                            {"CYAN end", {"robot1"}},
                                            {"CYAN disqualified", {"robot2"}},
                                            {"MAGENTA begin", {"robot4", "robot5"}},
                                            {"MAGENTA refused", {"number 1", "number 2"}},
                                            {"MAGENTA warning", {"robot4", "robot5"}},
                                            {"MAGENTA end", {"robot4"}},
                                            {"MAGENTA disqualified", {"robot5"}}};
  EXPECT_EQ(robots, wanted);
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

TEST(MachineFaults, APieceThatComesAfterTheFaultIsDueIsTakenAfterASecond) {
  std::vector<sim::Fault> faults(1);
  faults[0].kind = sim::FaultKind::kPieceTaken;
  faults[0].at = std::chrono::seconds(2);
  faults[0].machine = "C-BS";
  GameStory story(GameStory::quiet_game(), 1, std::chrono::milliseconds(20), faults);
  const auto lay = [&] {
    const sim::Spot& spot = story.world().plan().spot(story.spot("C-BS-OUTPUT"));
    EXPECT_TRUE(story.world().dispense(spot.station, spot.rest_in_station.x(), sim::Stack{1, {}, 0}));
  };
  story.run_until(5);
  lay();
  story.run_for(0.5);
  EXPECT_FALSE(story.nothing_at("C-BS-OUTPUT"));
  story.take("C-BS-OUTPUT");
  story.world().drop(sim::RobotId{0});
  story.run_until(8);
  lay();
  story.run_for(0.9);
  EXPECT_FALSE(story.nothing_at("C-BS-OUTPUT")) << "another piece lies as long";
  story.run_for(0.2);
  EXPECT_TRUE(story.nothing_at("C-BS-OUTPUT"));
}

/// Each instruction of two stations comes 4 s late.
std::vector<sim::Fault> instructions_held_up() {
  std::vector<sim::Fault> faults(2);
  for (sim::Fault& fault : faults) {
    fault.kind = sim::FaultKind::kInstructionLate;
    fault.probability = 1;
    fault.duration = std::chrono::seconds(4);
  }
  faults[0].machine = "C-BS";
  faults[1].machine = "C-CS1";
  return faults;
}

TEST(MachineFaults, OfInstructionsThatAreHeldUpOnlyTheCancelledOneIsNotAnswered) {
  GameStory story(GameStory::quiet_game(), 1, std::chrono::milliseconds(20), instructions_held_up());
  const std::size_t base = story.instruct("{machine: C-BS, side: OUTPUT, base_color: BASE_RED}");
  const std::size_t cap = story.instruct("{machine: C-CS1, operation: RESET}");
  story.run_for(1);
  story.cancel(base);
  story.run_for(4);
  EXPECT_EQ(story.outcome(base).status, bus::GoalStatus::kCanceled);
  EXPECT_EQ(story.state("C-BS"), "PROCESSING") << "it comes all the same";
  EXPECT_EQ(story.state("C-CS1"), "BROKEN");
  EXPECT_TRUE(story.outcome(cap).ended);
  EXPECT_EQ(story.outcome(cap).code, 0) << story.outcome(cap).error;
}

TEST(Pause, AnInstructionThatAFaultHoldsUpIsHeldUpInTheGamesTime) {
  WorldConfig config = GameStory::quiet_game();
  config.pauses = {{2, 10}};
  GameStory story(config, 1, std::chrono::milliseconds(20), instructions_held_up());
  story.set_jumping(true);
  const std::size_t first = story.instruct("{machine: C-BS, side: OUTPUT, base_color: BASE_RED}");
  story.run_until(13.9);
  EXPECT_EQ(story.state("C-BS"), "IDLE");
  story.run_until(14.2);
  EXPECT_EQ(story.state("C-BS"), "PROCESSING");
  EXPECT_FALSE(story.outcome(first).ended) << "it was given once";
  story.run_until(30);
  EXPECT_EQ(story.outcome(first).code, 0) << story.outcome(first).error;
  story.instruct("{machine: C-CS1, operation: RETRIEVE_CAP}");
  story.run_until(33.9);
  EXPECT_EQ(story.state("C-CS1"), "IDLE");
  story.run_until(34.2);
  EXPECT_EQ(story.state("C-CS1"), "PREPARED");
}

}  // namespace
}  // namespace cxlab::rcll
