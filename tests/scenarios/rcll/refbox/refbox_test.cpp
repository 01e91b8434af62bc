// The protocol of the league: what goes out on which channel and when, and what comes of what teams send.

#include <algorithm>
#include <cmath>
#include <random>

#include "refbox_story.h"

namespace cxlab::rcll {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;
using ::testing::StartsWith;

/// From `first` in steps of `period`, each a tick later: what nodes send reaches environments at the next one.
std::vector<double> every(double period, double first, double last) {
  std::vector<double> times;
  for (int k = 0; first + k * period <= last + 1e-6; ++k) times.push_back(first + k * period + 0.02);
  return times;
}
auto at_times(const std::vector<double>& times) { return ::testing::Pointwise(::testing::DoubleNear(0.0201), times); }
int count(const std::string& text, const std::string& part) {
  int n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

// --- What the referee box says

TEST(Refbox, SpeaksAtTheRatesOfTheLeague) {
  WorldConfig config = RefboxStory::game();
  OrderConfig later = config.orders[0];
  later.activate_at = 10.2;
  config.orders.push_back(later);
  RefboxStory story(config);
  auto& all = story.open(kPublicWay);
  auto& cyan = story.open(kCyanWay, kLeagueKey);
  story.run_until(30);
  EXPECT_THAT(all.times("BeaconSignal"), at_times(every(1, 0, 29.9)));
  EXPECT_THAT(all.times("GameState"), at_times(every(1, 0, 29.9)));
  EXPECT_THAT(all.times("RobotInfo"), at_times(every(2.5, 0, 29.9)));
  EXPECT_THAT(all.times("VersionInfo"), at_times(every(5, 0, 29.9)));
  std::vector<double> orders = every(0.5, 0, 4.5);  // of the first order: ten
  for (const double t : every(2, 6.5, 8.5)) orders.push_back(t);
  for (const double t : every(0.5, 10.2, 14.7)) orders.push_back(t);
  for (const double t : every(2, 16.7, 29.9)) orders.push_back(t);
  EXPECT_THAT(all.times("OrderInfo"), at_times(orders));
  EXPECT_THAT(all.heard, SizeIs(30 + 30 + 12 + 6 + orders.size())) << "and nothing else";
  std::vector<double> machines = every(0.5, 0, 14.5);  // the first thirty
  for (const double t : every(2, 16.5, 29.9)) machines.push_back(t);
  EXPECT_THAT(cyan.times("MachineInfo"), at_times(machines));
  EXPECT_THAT(cyan.times("RingInfo"), at_times(every(2, 0, 29.9)));
  EXPECT_THAT(cyan.heard, SizeIs(machines.size() + 15));
}

/// Programs come at times of their own: what is due to one of them is due to no other part of the game.
TEST(Refbox, SaysTheSameAtTheSameTimesWhereTimeJumps) {
  WorldConfig config = RefboxStory::game();
  OrderConfig later = config.orders[0];
  later.activate_at = 20.4;
  config.orders.push_back(later);
  const auto play = [&config](bool every_tick, std::int64_t& ticks) {
    RefboxStory story(config, LeagueClientConfig{.port_shift = 1000});
    if (every_tick) story.take_every_tick();
    story.run_until(0.3);
    std::vector<RefboxStory::Program*> programs{&story.open(kPublicWay), &story.open(kCyanWay, kLeagueKey),
                                                &story.open(kRobot1), &story.open({5444, 5445})};
    story.run_until(0.46);
    programs.push_back(&story.open_stream());
    story.run_until(1.26);
    story.say(*programs[1], "PrepareMachine",
              "team_color: CYAN machine: 'C-BS' instruction_bs { side: OUTPUT color: BASE_RED }");
    story.run_until(40);
    ticks = story.ticks();
    std::vector<std::string> said;
    for (std::size_t i = 0; i < programs.size(); ++i) {
      EXPECT_THAT(programs[i]->heard, Not(IsEmpty())) << i;
      for (const RefboxStory::Heard& heard : programs[i]->heard)
        said.push_back(std::to_string(i) + " at " + std::to_string(heard.at) + ": " + heard.type + ' ' + heard.text);
    }
    return said;
  };
  std::int64_t all = 0, few = 0;
  const std::vector<std::string> said = play(true, all);
  EXPECT_THAT(play(false, few), ::testing::ElementsAreArray(said));
  EXPECT_LT(few * 3, all);
}

TEST(Refbox, SaysWhatTheFactorySays) {
  RefboxStory story;
  auto& all = story.open(kPublicWay);
  auto& cyan = story.open(kCyanWay, kLeagueKey);
  story.run_until(3);
  EXPECT_EQ(all.last_text("GameState"),
            "game_time { sec: 2 nsec: 0 } state: RUNNING phase: PRODUCTION points_cyan: 0 team_cyan: \"CYAN\" "
            "points_magenta: 0 field_height: 8 field_width: 7 field_mirrored: true");
  EXPECT_EQ(all.last_text("OrderInfo"),
            "orders { id: 1 complexity: C0 base_color: BASE_RED cap_color: CAP_GREY quantity_requested: 1 "
            "quantity_delivered_cyan: 0 quantity_delivered_magenta: 0 delivery_period_begin: 0 delivery_period_end: "
            "1200 delivery_gate: 1 competitive: false }");
  EXPECT_THAT(all.last_text("RobotInfo"),
              StartsWith("robots { name: \"robot1\" team: \"CYAN\" host: \"127.0.0.1\" last_seen { sec: 1767225602 "
                         "nsec: 500000000 } number: 1 state: ACTIVE maintenance_time_remaining: 0 "
                         "maintenance_cycles: 0 team_color: CYAN }"));
  EXPECT_EQ(all.last_text("BeaconSignal"),
            "time { sec: 1767225602 nsec: 0 } seq: 3 team_name: \"LLSF\" peer_name: \"RefBox\" number: 0");
  EXPECT_THAT(all.last_text("VersionInfo"), HasSubstr("name: \"field_width\" type: INTEGER integer_value: 7"));
  EXPECT_EQ(count(cyan.last_text("RingInfo"), "raw_material: 0"), 2);
  EXPECT_EQ(count(cyan.last_text("RingInfo"), "rings {"), 4);
}

TEST(Refbox, TellsATeamWhatTheLeagueTells) {
  for (const std::string information : {"league", "all"}) {
    WorldConfig config = RefboxStory::game();
    config.information = information;
    config.exploration = true;
    config.team = "BOTH";
    RefboxStory story(config);
    auto& cyan = story.open(kCyanWay, kLeagueKey);
    auto& magenta = story.open(kMagentaWay, kLeagueKey);
    story.run_until(5);
    const std::string machines = cyan.last_text("MachineInfo");
    EXPECT_EQ(count(machines, "machines {"), 7) << machines;
    EXPECT_EQ(count(machines, "name: \"C-"), 7);
    EXPECT_EQ(count(magenta.last_text("MachineInfo"), "name: \"M-"), 7);
    for (const char* hidden : {"zone:", "rotation:", "pose", "lights", "loaded_with"})
      EXPECT_THAT(machines, Not(HasSubstr(std::string(" ") + hidden + ' '))) << information;
    EXPECT_EQ(count(machines, "correctly_reported: false"), 7);
    EXPECT_EQ(count(machines, "exploration_zone_state: NO_REPORT"), 7);
    EXPECT_THAT(cyan.times("MachineReportInfo"), at_times(every(1, 0, 4.9)));
    story.run_until(185);
    EXPECT_EQ(count(cyan.last_text("MachineInfo"), " zone: C_Z") + count(cyan.last_text("MachineInfo"), " zone: M_Z"),
              7);
    EXPECT_LT(cyan.times("MachineReportInfo").back(), 180.1);
  }
}

TEST(Refbox, IsSilentWhereNobodyListens) {
  RefboxStory story;
  story.run_until(30);
  const auto& names = story.records().names();
  const auto stream = std::ranges::find(names, "node/refbox") - names.begin();
  EXPECT_THAT(story.records().of(static_cast<StreamId>(stream)), SizeIs(3)) << "it has joined, with its host";
  EXPECT_LT(story.ticks(), 200) << "and time jumps";
}

TEST(Refbox, SpeaksToAgentsThatSendAndReceiveOnOnePort) {
  RefboxStory story;
  auto& all = story.open({4444, 4444});
  auto& cyan = story.open({4441, 4441}, kLeagueKey);
  story.run_until(3);
  EXPECT_THAT(all.times("GameState"), SizeIs(3));
  story.say(cyan, "PrepareMachine", "team_color: CYAN machine: 'C-BS' instruction_bs { side: OUTPUT color: BASE_RED }");
  story.run_for(0.2);
  EXPECT_THAT(cyan.last_text("MachineInfo"), HasSubstr("state: \"PROCESSING\""));
  EXPECT_THAT(story.warnings(), IsEmpty());
}

TEST(Refbox, SpeaksToStreams) {
  RefboxStory story;
  auto& controller = story.open_stream();
  story.run_until(3);
  EXPECT_THAT(controller.times("GameState"), SizeIs(2)) << "from the next one on";
  story.say(controller, "SetTeamName", "team_color: CYAN team_name: 'Carologistics'");
  story.say(controller, "SetRobotMaintenance", "team_color: CYAN robot_number: 2 maintenance: true");
  story.say(controller, "SetTeamName", "team_color: MAGENTA team_name: 'GRIPS'");
  story.run_until(8);
  EXPECT_THAT(controller.last_text("GameState"), HasSubstr("team_cyan: \"Carologistics\""));
  EXPECT_THAT(controller.last_text("RobotInfo"), HasSubstr("number: 2 state: MAINTENANCE"));
  EXPECT_THAT(story.warnings(), ElementsAre("stream: a llsf_msgs.SetTeamName is refused: MAGENTA does not play"));
  for (const auto& [type, count] :
       {std::pair{"MachineInfo", 32}, {"RobotInfo", 32}, {"WorkpieceInfo", 4}, {"RingInfo", 4}, {"VersionInfo", 1}})
    EXPECT_NEAR(static_cast<double>(controller.times(type).size()), count, 1) << type;
  story.send(controller, "GET / HTTP/1.1\r\n");
  story.run_until(10);
  EXPECT_THAT(story.warnings().back(), HasSubstr("found frame header version 71"));
  EXPECT_LT(controller.times("GameState").back(), 8.5) << "it was closed";
}

TEST(Refbox, HasThirtyTwoStreamsAtMost) {
  RefboxStory story;
  std::vector<RefboxStory::Program*> controllers;
  for (int i = 0; i < 33; ++i) controllers.push_back(&story.open_stream());
  story.run_until(3);
  for (int i = 0; i < 33; ++i)
    EXPECT_EQ(controllers[static_cast<std::size_t>(i)]->times("GameState").empty(), i == 32) << i;
}

TEST(Refbox, TellsControllersWhatMachinesAreToldToDo) {
  RefboxStory story;
  auto& controller = story.open_stream();
  auto& cyan = story.open(kCyanWay, kLeagueKey);
  story.run_until(1);
  EXPECT_THAT(controller.last_text("MachineInfo"), Not(HasSubstr("instruction")));
  for (const auto& [machine, instruction] : {std::pair{"C-BS", "instruction_bs { side: OUTPUT color: BASE_BLACK }"},
                                             {"C-CS1", "instruction_cs { operation: RETRIEVE_CAP }"},
                                             {"C-RS1", "instruction_rs { ring_color: RING_ORANGE }"},
                                             {"C-DS", "instruction_ds { order_id: 1 }"},
                                             {"C-SS", "instruction_ss { operation: RETRIEVE shelf: 0 slot: 1 }"}}) {
    story.say(cyan, "PrepareMachine", std::string("team_color: CYAN machine: '") + machine + "' " + instruction);
    story.run_for(0.5);
    EXPECT_THAT(controller.last_text("MachineInfo"), HasSubstr(instruction));
    EXPECT_THAT(cyan.last_text("MachineInfo"), Not(HasSubstr("instruction_bs")));
  }
  story.run_for(60);
  EXPECT_THAT(controller.last_text("MachineInfo"), Not(HasSubstr("instruction_bs"))) << "done";
}

TEST(Refbox, TellsControllersWhatLiesOnBelts) {
  RefboxStory story;
  auto& controller = story.open_stream();
  auto& robot = story.open(kRobot1);
  auto& cyan = story.open(kCyanWay, kLeagueKey);
  story.run_until(1);
  story.say(cyan, "PrepareMachine",
            "team_color: CYAN machine: 'C-BS' instruction_bs { side: OUTPUT color: BASE_BLACK }");
  story.say(robot, "AgentTask",
            "team_color: CYAN robot_id: 1 task_id: 1 buffer { machine_id: 'C-CS1' shelf_number: 2 }");
  story.run_until(90);
  const std::string said = controller.last_text("WorkpieceInfo");
  EXPECT_EQ(count(said, "workpieces {"), 2) << said;
  EXPECT_THAT(said, HasSubstr("at_machine: \"C-BS\""));
  EXPECT_THAT(said, HasSubstr("base_color: BASE_BLACK"));
  EXPECT_THAT(said, HasSubstr("at_machine: \"C-CS1\""));
  EXPECT_THAT(said, HasSubstr("base_color: BASE_CLEAR"));
  EXPECT_EQ(count(said, "cap_color: CAP_GREY"), 1) << said;
}

TEST(Refbox, TellsControllersWhoseBeltAPieceLiesOn) {
  WorldConfig config = RefboxStory::game();
  config.team = "BOTH";
  RefboxStory story(config);
  auto& controller = story.open_stream();
  for (const auto& [way, machine] :
       {std::pair{kCyanWay, "CYAN machine: 'C-BS'"}, {kMagentaWay, "MAGENTA machine: 'M-BS'"}}) {
    auto& team = story.open(way, kLeagueKey);
    story.run_for(0.5);
    story.say(team, "PrepareMachine",
              std::string("team_color: ") + machine + " instruction_bs { side: OUTPUT color: BASE_BLACK }");
  }
  story.run_until(20);
  const std::string said = controller.last_text("WorkpieceInfo");
  const std::size_t magenta = said.find("\"M-BS\"");
  ASSERT_NE(magenta, std::string::npos) << said;
  EXPECT_EQ(count(said, "team_color: CYAN"), 1) << said;
  EXPECT_EQ(count(said, "team_color: MAGENTA"), 1) << said;
  EXPECT_LT(said.find("team_color: CYAN"), said.find("team_color: MAGENTA")) << "as their machines come: " << said;
}

TEST(Refbox, AnInstructionThatIsSaidAgainIsNoComplaint) {
  RefboxStory story;
  auto& controller = story.open_stream();
  auto& cyan = story.open(kCyanWay, kLeagueKey);
  story.run_until(1);
  const auto say = [&](const char* machine) {
    story.say(
        cyan, "PrepareMachine",
        std::string("team_color: CYAN machine: '") + machine + "' instruction_bs { side: OUTPUT color: BASE_RED }");
    story.run_for(0.1);
  };
  for (int times = 0; times < 3; ++times) say("C-BS");
  EXPECT_THAT(story.warnings(), IsEmpty());
  say("C-XS");
  EXPECT_THAT(story.warnings(), ElementsAre(HasSubstr("no machine 'C-XS'")));
  EXPECT_THAT(controller.last_text("AttentionMessage"), HasSubstr("C-XS: no machine"));
}

TEST(Refbox, ControllersCommandAPausedGame) {
  WorldConfig config = RefboxStory::game();
  config.setup_s = 100;
  RefboxStory story(config);
  auto& controller = story.open_stream();
  story.run_until(1);
  story.say(controller, "SetGamePhase", "phase: PRODUCTION");
  story.run_until(3);
  EXPECT_THAT(controller.last_text("GameState"), HasSubstr("state: RUNNING phase: PRODUCTION"));
  story.say(controller, "SetGameState", "state: PAUSED");
  story.run_until(20);
  EXPECT_THAT(controller.last_text("GameState"), HasSubstr("state: PAUSED phase: PRODUCTION"));
  EXPECT_THAT(controller.last_text("GameState"), HasSubstr("game_time { sec: 2 ")) << "its time stands";
  story.say(controller, "SetMachineState", "machine_name: 'C-BS' state: RESET");
  story.run_until(60);
  EXPECT_THAT(controller.last_text("MachineInfo"), HasSubstr("name: \"C-BS\" type: \"BS\" state: \"BROKEN\""));
  story.say(controller, "SetMachineState", "machine_name: 'C-BS' state: IDLE");
  story.say(controller, "SetGameState", "state: RUNNING");
  story.run_until(62);
  EXPECT_THAT(controller.last_text("GameState"), HasSubstr("state: RUNNING"));
  EXPECT_THAT(controller.last_text("MachineInfo"), Not(HasSubstr("BROKEN")));
  story.say(controller, "SetGameState", "state: PAUSED");
  story.run_until(63);
  story.say(controller, "SetGamePhase", "phase: POST_GAME");
  story.run_until(65);
  EXPECT_THAT(controller.last_text("GameState"), HasSubstr("phase: POST_GAME"));
  EXPECT_THAT(story.warnings(), ElementsAre(HasSubstr("nobody has taken the field for 60 s")));
}

TEST(Refbox, SaysOnceThatNobodyTookTheFieldAndHowTheTeamsAreCalled) {
  for (const auto& [team, names, settings] :
       {std::tuple{"CYAN", "the teams CYAN. ", "set refbox.team_cyan ("},
        std::tuple{"BOTH", "the teams CYAN and MAGENTA. ", "set refbox.team_cyan, refbox.team_magenta ("}}) {
    WorldConfig config = RefboxStory::game();
    config.team = team;
    RefboxStory story(config);
    story.open_stream();
    story.run_until(59.9);
    EXPECT_THAT(story.warnings(), IsEmpty());
    story.run_until(150);
    EXPECT_THAT(story.warnings(), ElementsAre(AllOf(HasSubstr(names), HasSubstr(settings))));
  }
}

TEST(Refbox, WaitsSixtySecondsForATeamFromWhenSomebodyListens) {
  RefboxStory story;
  story.run_until(40);
  story.open_stream();
  story.run_until(99.9);
  EXPECT_THAT(story.warnings(), IsEmpty());
  story.run_until(101);
  EXPECT_THAT(story.warnings(), SizeIs(1));
}

TEST(Refbox, SaysNothingWhereATeamHasItsName) {
  WorldConfig config = RefboxStory::game();
  config.refbox.team_cyan = "Carologistics";
  RefboxStory story(config);
  story.open_stream();
  story.run_until(150);
  EXPECT_THAT(story.warnings(), IsEmpty());
}

TEST(Refbox, TellsControllersWhatPeopleShouldLookAfter) {
  RefboxStory story;
  auto& all = story.open(kPublicWay);
  auto& controller = story.open_stream();
  story.run_until(1);
  const std::string beacon =
      "time { sec: 1 nsec: 0 } seq: 1 team_name: 'CYAN' peer_name: 'R' team_color: CYAN number: ";
  story.say(all, "BeaconSignal", beacon + '1');
  story.say(controller, "SetRobotMaintenance", "team_color: CYAN robot_number: 2 maintenance: true");
  story.say(all, "BeaconSignal", beacon + '2');
  story.run_until(5.9);
  EXPECT_THAT(controller.times("AttentionMessage"), IsEmpty());
  story.run_until(100);
  EXPECT_EQ(controller.last_text("AttentionMessage"),
            "message: \"robot 1 of CYAN is lost: no beacon for 5 s\" team_color: CYAN");
  EXPECT_THAT(controller.times("AttentionMessage"), SizeIs(1)) << "once; a robot in maintenance is not lost";
  story.run_until(107);
  EXPECT_EQ(controller.last_text("AttentionMessage"),
            "message: \"robot 2 of CYAN has to be back from maintenance soon\" team_color: CYAN");
  EXPECT_THAT(controller.times("AttentionMessage"), ElementsAre(testing::_, testing::DoubleNear(106.25, 0.3)));
  story.say(all, "BeaconSignal", beacon + '1');
  story.run_for(8);
  EXPECT_THAT(controller.times("AttentionMessage"), SizeIs(3)) << "lost again";
  EXPECT_THAT(all.times("AttentionMessage"), IsEmpty());

  auto& cyan = story.open(kCyanWay, kLeagueKey);
  for (int times = 0; times < 2; ++times) {
    const double asked = story.now();
    story.say(cyan, "PrepareMachine", "team_color: CYAN machine: 'C-CS1' instruction_cs { operation: RETRIEVE_CAP }");
    story.run_for(15);
    EXPECT_EQ(controller.last_text("AttentionMessage"),
              "message: \"C-CS1 is in the same state for 10 s, and breaks after 20 s\" team_color: CYAN");
    EXPECT_NEAR(controller.times("AttentionMessage").back(), asked + 10, 0.4);
    story.run_for(40);
  }
}

TEST(Refbox, LearnsTheNameOfATeamFromItsBeacons) {
  RefboxStory story;
  auto& all = story.open(kPublicWay);
  story.say(all, "BeaconSignal",
            "time { sec: 1 nsec: 0 } seq: 1 number: 2 team_name: '' team_color: CYAN peer_name: 'R-2'");
  story.run_until(2);
  EXPECT_THAT(all.last_text("GameState"), HasSubstr("team_cyan: \"CYAN\"")) << "a beacon without a name tells none";
  story.say(all, "BeaconSignal", "time { sec: 1 nsec: 0 } seq: 1 number: 2 team_name: 'Rules' peer_name: 'R-2'");
  story.run_until(6);
  EXPECT_THAT(all.last_text("GameState"), HasSubstr("team_cyan: \"Rules\""));
  EXPECT_THAT(
      all.last_text("RobotInfo"),
      HasSubstr(
          "name: \"R-2\" team: \"Rules\" host: \"127.0.0.1\" last_seen { sec: 1767225602 nsec: 20000000 } number: 2"));
  story.say(all, "BeaconSignal", "time { sec: 1 nsec: 0 } seq: 2 number: 1 team_name: 'Others' peer_name: 'X'");
  story.say(all, "BeaconSignal",
            "time { sec: 1 nsec: 0 } seq: 3 number: 1 team_name: 'Others' team_color: CYAN peer_name: 'X'");
  story.run_until(8);
  EXPECT_THAT(all.last_text("GameState"), HasSubstr("team_cyan: \"Rules\"")) << "it has its name";
}

TEST(Refbox, NamesWithoutAColourAreForTheTeamsThatHaveNone) {
  WorldConfig config = RefboxStory::game();
  config.team = "BOTH";
  RefboxStory story(config);
  auto& all = story.open(kPublicWay);
  auto& controller = story.open_stream();
  for (const char* team :
       {"number: 1 team_name: 'First' peer_name: 'F-1'", "number: 2 team_name: 'Second' peer_name: 'S-2'",
        "number: 3 team_name: 'Third' peer_name: 'T-3'"}) {
    story.say(all, "BeaconSignal", std::string("time { sec: 1 nsec: 0 } seq: 1 ") + team);
    story.run_for(0.1);
  }
  story.run_until(6);
  EXPECT_THAT(all.last_text("GameState"),
              AllOf(HasSubstr("team_cyan: \"First\""), HasSubstr("team_magenta: \"Second\"")));
  EXPECT_THAT(all.last_text("RobotInfo"), AllOf(HasSubstr("name: \"F-1\" team: \"First\""),
                                                HasSubstr("name: \"S-2\" team: \"Second\""), Not(HasSubstr("T-3"))));
  story.say(controller, "SetTeamName", "team_color: MAGENTA team_name: 'Others'");
  story.run_until(8);
  EXPECT_THAT(all.last_text("GameState"),
              AllOf(HasSubstr("team_cyan: \"First\""), HasSubstr("team_magenta: \"Others\"")));
}

TEST(Refbox, ForgetsARobotEighteenMinutesAfterItsLastBeacon) {
  RefboxStory story;
  auto& all = story.open(kPublicWay);
  story.say(all, "BeaconSignal", "time { sec: 1 nsec: 0 } seq: 1 number: 1 team_name: 'Rules' peer_name: 'R-1'");
  story.run_until(1079);
  EXPECT_THAT(all.last_text("RobotInfo"), AllOf(HasSubstr("number: 1"), HasSubstr("number: 2")));
  story.run_until(1085);
  EXPECT_THAT(all.last_text("RobotInfo"), AllOf(Not(HasSubstr("number: 1")), HasSubstr("number: 2"))) << "never met";
  story.say(all, "BeaconSignal", "time { sec: 2 nsec: 0 } seq: 2 number: 1 team_name: 'Rules' peer_name: 'R-1'");
  story.run_until(1090);
  EXPECT_THAT(all.last_text("RobotInfo"), HasSubstr("number: 1"));
}

// --- What teams ask for

TEST(Refbox, MachineInfoFollowsEachStateOfAMachine) {
  RefboxStory story;
  auto& cyan = story.open(kCyanWay, kLeagueKey);
  story.run_until(20);
  const std::size_t before = cyan.times("MachineInfo").size();
  story.say(cyan, "PrepareMachine",
            "team_color: CYAN machine: 'C-BS' instruction_bs { side: OUTPUT color: BASE_BLACK } sent_at: 20");
  story.run_until(30);
  std::vector<std::string> states;
  std::vector<double> times;
  for (const auto& heard : cyan.heard) {
    if (heard.type != "MachineInfo" || heard.at <= 20) continue;
    const std::string bs = heard.text.substr(heard.text.find("\"C-BS\""));
    const std::string rest = bs.substr(bs.find("state: \"") + 8), state = rest.substr(0, rest.find('"'));
    if (states.empty() || states.back() != state) states.push_back(state), times.push_back(heard.at);
  }
  EXPECT_THAT(states, ElementsAre("PROCESSING", "PROCESSED", "READY-AT-OUTPUT"));
  EXPECT_THAT(times, ElementsAre(::testing::DoubleNear(20.06, 0.021), ::testing::DoubleNear(21.16, 0.041),
                                 ::testing::DoubleNear(23.84, 0.061)));
  EXPECT_EQ(cyan.times("MachineInfo").size() - before, 3u + 5) << "the periodic ones go on";
  EXPECT_THAT(story.warnings(), IsEmpty());
}

TEST(Refbox, InstructsEachKindOfMachine) {
  RefboxStory story;
  auto& cyan = story.open(kCyanWay, kLeagueKey);
  story.run_until(1);
  const auto prepare = [&](const std::string& machine, const std::string& instruction) {
    story.say(cyan, "PrepareMachine", "team_color: CYAN machine: '" + machine + "' " + instruction);
  };
  prepare("C-BS", "instruction_bs { side: INPUT color: BASE_SILVER }");
  prepare("C-CS1", "instruction_cs { operation: RETRIEVE_CAP }");
  prepare("C-RS1", "instruction_rs { ring_color: RING_BLUE }");  // which it has not
  prepare("C-SS", "instruction_ss { operation: RETRIEVE shelf: 2 slot: 1 }");
  prepare("C-DS", "instruction_ds { order_id: 1 }");
  prepare("C-CS2", "instruction_ss { operation: RETRIEVE shelf: 2 slot: 1 }");  // not its instruction
  story.run_for(1);
  const std::string info = cyan.last_text("MachineInfo");
  const auto state = [&](const std::string& machine) {
    const std::string rest = info.substr(info.find('"' + machine + '"'));
    const std::string from = rest.substr(rest.find("state: \"") + 8);
    return from.substr(0, from.find('"'));
  };
  EXPECT_EQ(state("C-BS"), "PROCESSING");
  EXPECT_EQ(state("C-CS1"), "PREPARED");
  EXPECT_EQ(state("C-RS1"), "BROKEN");
  EXPECT_EQ(state("C-SS"), "PROCESSING");
  EXPECT_EQ(state("C-DS"), "PROCESSING");
  EXPECT_EQ(state("C-CS2"), "BROKEN");
  EXPECT_THAT(story.warnings(), SizeIs(2)) << "of the two that broke";
  prepare("C-RS2", "");
  story.say(cyan, "ResetMachine", "team_color: CYAN machine: 'C-SS'");
  prepare("C-XX", "");
  story.run_for(1);
  EXPECT_THAT(story.warnings(), Contains(HasSubstr("C-XX: ")));
  EXPECT_EQ(count(cyan.last_text("MachineInfo"), "BROKEN"), 4);
  story.say(cyan, "PrepareMachine", "team_color: CYAN machine: 'C-DS'");
  story.run_for(1);
  EXPECT_EQ(count(cyan.last_text("MachineInfo"), "BROKEN"), 4) << "it is busy";
}

TEST(Refbox, ADeliveryStationWithoutInstructionBreaks) {
  RefboxStory story;
  auto& cyan = story.open(kCyanWay, kLeagueKey);
  story.run_until(1);
  story.say(cyan, "PrepareMachine", "team_color: CYAN machine: 'C-DS'");
  story.run_for(1);
  EXPECT_EQ(count(cyan.last_text("MachineInfo"), "BROKEN"), 1);
}

TEST(Refbox, TakesReports) {
  WorldConfig config = RefboxStory::game();
  config.exploration = true;
  config.layout = {{"C-BS", "C_Z13", 0},    {"C-CS1", "M_Z24", 180}, {"C-CS2", "C_Z35", 90},  {"C-RS1", "C_Z72", 270},
                   {"C-RS2", "M_Z63", 180}, {"C-SS", "C_Z77", 270},  {"C-DS", "C_Z48", 270},  {"M-BS", "M_Z13", 0},
                   {"M-CS1", "C_Z24", 0},   {"M-CS2", "M_Z35", 180}, {"M-RS1", "M_Z72", 270}, {"M-RS2", "C_Z63", 180},
                   {"M-SS", "M_Z77", 270},  {"M-DS", "M_Z48", 135}};
  RefboxStory story(config);
  auto& cyan = story.open(kCyanWay, kLeagueKey);
  auto& all = story.open(kPublicWay);
  story.run_until(1);
  story.say(cyan, "PrepareMachine", "team_color: CYAN machine: 'C-BS' instruction_bs { side: INPUT color: BASE_RED }");
  story.run_for(1);
  EXPECT_THAT(story.warnings(), SizeIs(1)) << "it is not reported";
  EXPECT_THAT(cyan.last_text("MachineInfo"), Not(HasSubstr("PROCESSING")));
  story.say(cyan, "MachineReport",
            "team_color: CYAN machines { name: 'C-BS' type: 'BS' zone: C_Z13 rotation: 0 } machines { name: 'C-SS' "
            "type: 'SS' zone: C_Z76 rotation: 270 } machines { type: 'DS' zone: C_Z48 }");
  story.run_for(1.2);
  EXPECT_THAT(all.last_text("GameState"), HasSubstr("points_cyan: 1")) << "2 for the BS, -1 for the SS";
  EXPECT_EQ(cyan.last_text("MachineReportInfo"),
            "reported_machines: \"C-BS\" team_color: CYAN reported_types { type: \"DS\" zone: C_Z48 name: \"C-DS\" "
            "team_color: CYAN }");
  EXPECT_THAT(cyan.last_text("MachineInfo"),
              HasSubstr("correctly_reported: true team_color: CYAN zone: C_Z13 rotation: 0"));
  EXPECT_EQ(count(cyan.last_text("MachineInfo"), " rotation: "), 1);
  story.say(cyan, "PrepareMachine", "team_color: CYAN machine: 'C-BS' instruction_bs { side: INPUT color: BASE_RED }");
  story.run_for(0.5);
  EXPECT_THAT(cyan.last_text("MachineInfo"), HasSubstr("PROCESSING"));
}

TEST(Refbox, DropsInstructionsThatCameLate) {
  RefboxStory story;
  auto& cyan = story.open(kCyanWay, kLeagueKey);
  story.run_until(10);
  // The team's clock is not the one of the referee box.
  story.say(cyan, "PrepareMachine",
            "team_color: CYAN machine: 'C-CS1' instruction_cs { operation: RETRIEVE_CAP } sent_at: 1000");
  story.run_until(12);
  EXPECT_EQ(count(cyan.last_text("MachineInfo"), "PREPARED"), 1);
  story.say(cyan, "PrepareMachine",
            "team_color: CYAN machine: 'C-CS2' instruction_cs { operation: RETRIEVE_CAP } sent_at: 996");
  story.run_until(13);
  EXPECT_EQ(count(cyan.last_text("MachineInfo"), "PREPARED"), 1) << "6 s late";
  EXPECT_THAT(story.warnings(), ElementsAre(HasSubstr("sent more than 5 s ago")));
  story.say(cyan, "PrepareMachine",
            "team_color: CYAN machine: 'C-CS2' instruction_cs { operation: RETRIEVE_CAP } sent_at: 998");
  story.run_until(14);
  EXPECT_EQ(count(cyan.last_text("MachineInfo"), "PREPARED"), 2) << "5 s late";
}

// --- Strangers

TEST(Refbox, RefusesWhatIsNotForItsTeam) {
  WorldConfig config = RefboxStory::game();
  config.team = "BOTH";
  config.refbox.key_magenta = "";
  RefboxStory story(config);
  auto& cyan = story.open(kCyanWay, kLeagueKey);
  auto& magenta = story.open(kMagentaWay);
  auto& all = story.open(kPublicWay);
  auto& plain = story.open({4446, 1});
  auto& wrong_key = story.open({4446, 2}, "another");
  story.run_until(1);
  const std::string bs = "instruction_bs { side: OUTPUT color: BASE_RED }";
  for (int i = 0; i < 3; ++i) {
    story.say(magenta, "PrepareMachine", "team_color: CYAN machine: 'C-BS' " + bs);
    story.say(all, "PrepareMachine", "team_color: CYAN machine: 'C-BS' " + bs);
    story.say(plain, "PrepareMachine", "team_color: CYAN machine: 'C-BS' " + bs);
    story.say(wrong_key, "PrepareMachine", "team_color: CYAN machine: 'C-BS' " + bs);
    story.say(cyan, "GameState", "game_time { sec: 0 nsec: 0 } state: PAUSED phase: POST_GAME");
    story.run_for(1);
  }
  EXPECT_THAT(cyan.last_text("MachineInfo"), Not(HasSubstr("PROC")));
  EXPECT_THAT(story.warnings(),
              ElementsAre("channel of MAGENTA: found a llsf_msgs.PrepareMachine of CYAN",
                          "public channel: found a llsf_msgs.PrepareMachine, expected a llsf_msgs.BeaconSignal",
                          HasSubstr("channel of CYAN: "), HasSubstr("channel of CYAN: Decryption failed"),
                          HasSubstr("channel of CYAN: found a llsf_msgs.GameState, expected a PrepareMachine")))
      << "each once";
  story.say(magenta, "PrepareMachine", "team_color: MAGENTA machine: 'C-BS' " + bs);
  story.run_for(1);
  EXPECT_THAT(cyan.last_text("MachineInfo"), Not(HasSubstr("PROC"))) << "it is not magenta's";
  story.say(magenta, "PrepareMachine", "team_color: MAGENTA machine: 'M-BS' " + bs);
  story.run_for(1);
  EXPECT_THAT(magenta.last_text("MachineInfo"), HasSubstr("PROC"));
}

TEST(Refbox, ATeamAndAControllerCallARobotOfThatTeamToMaintenance) {
  WorldConfig config = RefboxStory::game();
  config.team = "BOTH";
  config.refbox.key_cyan = config.refbox.key_magenta = "";
  const auto in_maintenance = [&](const std::string& team, bool by_controller) {
    RefboxStory story(config);
    auto& cyan = story.open(kCyanWay);
    auto& magenta = story.open(kMagentaWay);
    auto& controller = story.open_stream();
    story.run_until(1);
    story.say(by_controller    ? controller
              : team == "CYAN" ? cyan
                               : magenta,
              "SetRobotMaintenance", "team_color: " + team + " robot_number: 2 maintenance: true");
    story.run_for(4);
    EXPECT_THAT(story.warnings(), IsEmpty());
    const std::string told = controller.last_text("RobotInfo");
    EXPECT_EQ(count(told, "MAINTENANCE"), 1) << told;
    // The robot's part of the text ends with its state.
    const std::string part = told.substr(0, told.find("MAINTENANCE"));
    EXPECT_EQ(part.substr(part.rfind("number: "), 9), "number: 2") << told;
    const std::string colour = part.substr(part.rfind("team_color: ") + 12);
    return colour.substr(0, colour.find(' '));
  };
  for (const char* team : {"CYAN", "MAGENTA"})
    for (const bool by_controller : {false, true}) EXPECT_EQ(in_maintenance(team, by_controller), team);
}

TEST(Refbox, AnyBytesChangeNothing) {
  RefboxStory story;
  auto& cyan = story.open(kCyanWay, kLeagueKey);
  std::vector<RefboxStory::Program*> ways{&cyan, &story.open(kPublicWay), &story.open(kRobot1), &story.open_stream()};
  story.run_until(20);
  const std::string before = cyan.last_text("MachineInfo");
  std::mt19937 random(7);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random()) % n; };
  const std::string frames[]{
      *pb::Types::write(*story.message("PrepareMachine", "team_color: CYAN machine: 'C-BS'")),
      *pb::Types::write(*story.message("BeaconSignal",
                                       "time { sec: 1 nsec: 0 } seq: 1 number: 2 team_name: 'Rules' "
                                       "peer_name: 'R-2' team_color: MAGENTA")),
      *pb::Types::write(*story.message("AgentTask", "team_color: CYAN task_id: 1 robot_id: 3 move { waypoint: 'x' }"))};
  for (int i = 0; i < 2000; ++i) {
    std::string bytes = frames[below(3)];
    if (below(4) == 0) bytes.resize(below(bytes.size() + 20), 'x');
    for (std::size_t changes = below(4); changes > 0 && !bytes.empty(); --changes)
      bytes[below(bytes.size())] = static_cast<char>(below(256));
    if (below(10) == 0)
      for (char& c : bytes) c = static_cast<char>(below(256));
    story.send(*ways[below(4)], bytes);
    if (i % 100 == 0) story.run_for(0.02);
  }
  story.run_for(2);
  EXPECT_EQ(cyan.last_text("MachineInfo"), before);
  EXPECT_LE(story.warnings().size(), 101u);
}

// --- Robots

TEST(RefboxRobots, CarryOutTasks) {
  RefboxStory story;
  auto& robot = story.open(kRobot1);
  story.run_until(1);
  const std::string head = "team_color: CYAN robot_id: 1 ";
  story.say(robot, "AgentTask", head + "task_id: 0 move { waypoint: 'C-CS1' machine_point: 'INPUT' }");
  story.run_for(0.1);
  EXPECT_THAT(robot.times("AgentTask"), IsEmpty());
  story.run_for(60);
  EXPECT_EQ(robot.last_text("AgentTask"),
            "team_color: CYAN task_id: 0 robot_id: 1 move { waypoint: \"C-CS1\" machine_point: \"INPUT\" } "
            "successful: true canceled: false error_code: 0");
  const auto first = robot.times("AgentTask");
  EXPECT_GT(first.size(), 20u) << "again every second";
  EXPECT_THAT(robot.last_text("BeaconSignal"), HasSubstr("number: 1 finished_tasks { TaskId: 0 successful: true }"));
  story.say(robot, "AgentTask", head + "task_id: 1 buffer { machine_id: 'C-CS1' shelf_number: 2 }");
  story.run_for(10);
  EXPECT_THAT(robot.last_text("BeaconSignal"), HasSubstr("task { team_color: CYAN task_id: 1"));
  story.run_for(50);
  EXPECT_THAT(robot.last_text("AgentTask"), HasSubstr("task_id: 1 robot_id: 1 buffer { machine_id: \"C-CS1\" "
                                                      "shelf_number: 2 } successful: true"));
  // The left and right slots have a piece; the belt has that of the middle.
  for (const std::string task : {"retrieve { machine_id: 'C-CS1' machine_point: 'SHELF' }",
                                 "deliver { machine_id: 'C-RS1' machine_point: 'SLIDE' }",
                                 "retrieve { machine_id: 'c-cs1' machine_point: 'shelf' }"}) {
    static int id = 1;
    story.say(robot, "AgentTask", head + "task_id: " + std::to_string(++id) + ' ' + task);
    story.run_for(80);
    EXPECT_THAT(robot.last_text("AgentTask"), HasSubstr("successful: true")) << task;
  }
  EXPECT_THAT(story.warnings(), IsEmpty());
}

TEST(RefboxRobots, WaitThirtySecondsForAPieceAtABelt) {
  RefboxStory story;
  auto& robot = story.open(kRobot1);
  story.run_until(1);
  const std::string head = "team_color: CYAN robot_id: 1 ", output = "{ waypoint: 'C-BS' machine_point: 'OUTPUT' }";
  story.say(robot, "AgentTask", head + "task_id: 1 move " + output);
  story.run_for(60);
  ASSERT_THAT(robot.last_text("AgentTask"), HasSubstr("task_id: 1 robot_id: 1 move { waypoint: \"C-BS\" machine_point: "
                                                      "\"OUTPUT\" } successful: true"));
  story.say(robot, "AgentTask", head + "task_id: 2 retrieve { machine_id: 'C-BS' machine_point: 'OUTPUT' }");
  story.run_for(29);
  EXPECT_THAT(robot.last_text("BeaconSignal"), HasSubstr("task { team_color: CYAN task_id: 2"));
  story.run_for(16);
  EXPECT_THAT(robot.last_text("AgentTask"), AllOf(HasSubstr("task_id: 2"), HasSubstr("successful: false")));
}

TEST(RefboxRobots, OfBothTeamsHaveTheirNumbersAndPorts) {
  WorldConfig config = RefboxStory::game();
  config.team = "BOTH";
  RefboxStory story(config);
  auto& first = story.open({2129, 2119});  // robot4
  auto& third = story.open({2131, 2121});  // robot6
  story.run_until(1);
  story.say(first, "AgentTask", "team_color: MAGENTA robot_id: 1 task_id: 5 move { waypoint: 'M_Z52' }");
  story.say(third, "AgentTask", "team_color: MAGENTA robot_id: 1 task_id: 5 move { waypoint: 'M_Z52' }");
  story.run_for(20);
  EXPECT_THAT(first.last_text("AgentTask"),
              HasSubstr("task_id: 5 robot_id: 1 move { waypoint: \"M_Z52\" } successful: true"));
  EXPECT_THAT(first.last_text("BeaconSignal"), HasSubstr("peer_name: \"robot4\" team_color: MAGENTA"));
  EXPECT_THAT(third.last_text("AgentTask"), HasSubstr("error_code: 102"));
  EXPECT_THAT(third.last_text("BeaconSignal"), HasSubstr("number: 3"));
  story.say(first, "AgentTask",
            "team_color: MAGENTA robot_id: 1 task_id: 6 explore_machine { machine_id: '' machine_point: '' waypoint: "
            "'M_Z52' }");
  story.run_for(40);
  EXPECT_EQ(first.last_text("MachineReport"), "machines { zone: M_Z52 } team_color: MAGENTA");
}

TEST(RefboxRobots, SayWhatIsWrongWithATask) {
  RefboxStory story;
  auto& robot = story.open(kRobot1);
  story.run_until(1);
  int id = 0;
  const auto error_of = [&](const std::string& task, const std::string& head = "team_color: CYAN robot_id: 1 ") {
    story.say(robot, "AgentTask", head + "task_id: " + std::to_string(++id) + ' ' + task);
    story.run_for(90);
    const std::string text = robot.last_text("AgentTask");
    EXPECT_THAT(text, HasSubstr("task_id: " + std::to_string(id)));
    EXPECT_THAT(text, HasSubstr("successful: false canceled: false"));
    return text.substr(text.find("error_code"));
  };
  const std::string move = "move { waypoint: 'C_Z52' }";
  EXPECT_EQ(error_of(move, "team_color: MAGENTA robot_id: 1 "), "error_code: 101");
  EXPECT_EQ(error_of(move, "team_color: CYAN robot_id: 2 "), "error_code: 102");
  EXPECT_EQ(error_of("move { waypoint: 'C_Z99' }"), "error_code: 103");
  EXPECT_EQ(error_of("buffer { machine_id: 'C-CS1' shelf_number: 4 }"), "error_code: 103");
  EXPECT_EQ(error_of(""), "error_code: 104");
  EXPECT_EQ(error_of("retrieve { machine_id: 'C-BS' machine_point: 'OUTPUT' }"), "error_code: 202");
  EXPECT_EQ(error_of("deliver { machine_id: 'C-BS' machine_point: 'INPUT' }"), "error_code: 208");
  EXPECT_EQ(error_of("explore_machine { machine_id: '' machine_point: '' waypoint: 'C_Z52' }"), "error_code: 203");
  auto& team = story.open(kCyanWay, kLeagueKey);
  story.say(team, "SetRobotMaintenance", "team_color: CYAN robot_number: 1 maintenance: true");
  story.run_for(1);
  EXPECT_EQ(error_of(move), "error_code: 220") << "the league has no code for a robot that is off the field";
}

TEST(RefboxRobots, TellTheirLastTenTasksInBeacons) {
  RefboxStory story;
  auto& robot = story.open(kRobot1);
  story.run_until(1);
  for (int id = 1; id <= 12; ++id) {  // none that the league knows: each ends at once
    story.say(robot, "AgentTask", "team_color: CYAN robot_id: 1 task_id: " + std::to_string(id));
    story.run_for(0.1);
  }
  story.run_for(3);
  const std::string beacon = robot.last_text("BeaconSignal");
  EXPECT_EQ(count(beacon, "finished_tasks"), 10) << beacon;
  EXPECT_THAT(beacon,
              AllOf(HasSubstr("{ TaskId: 3 successful: false }"), HasSubstr("{ TaskId: 12 successful: false }")));
}

TEST(RefboxRobots, DoOneTaskAtATime) {
  RefboxStory story;
  auto& robot = story.open(kRobot1);
  story.run_until(1);
  const std::string head = "team_color: CYAN robot_id: 1 ";
  const std::string far = "move { waypoint: 'M-Z75' }", near = "move { waypoint: 'C_Z52' }";
  story.say(robot, "AgentTask", head + "task_id: 1 " + far);
  story.run_for(5);
  story.say(robot, "AgentTask", head + "task_id: 1 " + near);  // the same task
  story.run_for(5);
  EXPECT_THAT(robot.times("AgentTask"), IsEmpty());
  story.say(robot, "AgentTask", head + "task_id: 2 " + near);
  story.run_for(5);
  EXPECT_THAT(robot.heard, Contains(::testing::Field(
                               &RefboxStory::Heard::text,
                               "team_color: CYAN task_id: 1 robot_id: 1 move { waypoint: \"M-Z75\" } successful: false "
                               "canceled: true error_code: 0")));
  EXPECT_THAT(robot.last_text("BeaconSignal"), HasSubstr("task { team_color: CYAN task_id: 2"));
  story.say(robot, "AgentTask", head + "task_id: 1 cancel_task: true");
  story.say(robot, "AgentTask", head + "task_id: 2 pause_task: true");
  story.say(robot, "AgentTask", head + "task_id: 1 pause_task: true");
  story.run_for(40);
  EXPECT_THAT(robot.last_text("AgentTask"), HasSubstr("task_id: 1")) << "task 2 rests";
  story.say(robot, "AgentTask", head + "task_id: 2 " + near);
  story.run_for(40);
  EXPECT_THAT(robot.last_text("AgentTask"), HasSubstr("task_id: 2"));
  EXPECT_THAT(robot.last_text("AgentTask"), HasSubstr("successful: true"));
  story.say(robot, "AgentTask", head + "task_id: 3 " + far);
  story.run_for(5);
  story.say(robot, "AgentTask", head + "task_id: 3 cancel_task: true");
  story.run_for(5);
  EXPECT_THAT(robot.last_text("AgentTask"),
              HasSubstr("task_id: 3 robot_id: 1 move { waypoint: \"M-Z75\" } successful: false canceled: true"));
  EXPECT_THAT(story.warnings(), ElementsAre(HasSubstr("a pause of a task that is not running")));
}

TEST(RefboxRobots, TasksThatRestAreCanceledAndReplacedAtOnce) {
  RefboxStory story;
  auto& robot = story.open(kRobot1);
  story.run_until(1);
  const std::string head = "team_color: CYAN robot_id: 1 ", far = "move { waypoint: 'M-Z75' }";
  const auto say = [&](const std::string& text) { story.say(robot, "AgentTask", head + text); };
  const auto rest = [&](const std::string& id) {
    say("task_id: " + id + ' ' + far);
    story.run_for(4);
    say("task_id: " + id + " pause_task: true");
    story.run_for(6);
  };
  rest("1");
  EXPECT_THAT(robot.times("AgentTask"), IsEmpty());
  EXPECT_THAT(robot.last_text("BeaconSignal"), HasSubstr("task { team_color: CYAN task_id: 1"));
  say("task_id: 1 cancel_task: true");
  story.run_for(0.2);
  EXPECT_THAT(robot.last_text("AgentTask"), HasSubstr("task_id: 1 robot_id: 1 move { waypoint: \"M-Z75\" } successful: "
                                                      "false canceled: true error_code: 0"));
  rest("2");
  say("task_id: 3 move { waypoint: 'C_Z52' }");
  story.run_for(0.2);
  EXPECT_THAT(robot.last_text("AgentTask"), HasSubstr("task_id: 2"));
  story.run_for(40);
  EXPECT_THAT(robot.last_text("AgentTask"), HasSubstr("task_id: 3"));
  EXPECT_THAT(robot.last_text("AgentTask"), HasSubstr("successful: true"));

  // It goes on before the skill has ended.
  say("task_id: 4 " + far);
  story.run_for(4);
  say("task_id: 4 pause_task: true");
  say("task_id: 4 " + far);
  story.run_for(60);
  EXPECT_THAT(robot.last_text("AgentTask"), HasSubstr("task_id: 4"));
  EXPECT_THAT(robot.last_text("AgentTask"), HasSubstr("successful: true"));
  EXPECT_THAT(story.warnings(), IsEmpty());
}

TEST(RefboxRobots, AreStoppedOnceHoweverOftenThatIsSaid) {
  RefboxStory story;
  auto& robot = story.open(kRobot1);
  story.run_until(1);
  const std::string head = "team_color: CYAN robot_id: 1 task_id: 1 ";
  story.say(robot, "AgentTask", head + "move { waypoint: 'M-Z75' }");
  story.run_for(4);
  for (int i = 0; i < 2; ++i) {
    story.say(robot, "AgentTask", head + "pause_task: true");
    story.say(robot, "AgentTask", head + "cancel_task: true");
    story.run_for(0.1);
  }
  story.run_for(5);
  EXPECT_THAT(robot.last_text("AgentTask"), HasSubstr("canceled: true"));
  EXPECT_EQ(std::ranges::count_if(story.records().all(),
                                  [](const auto& record) {
                                    return record.data.find(
                                               "op\xa6"
                                               "cancel") != std::string::npos;
                                  }),
            1)
      << "requests to cancel the skill";
}

TEST(RefboxRobots, OfTasksThatWaitTheLastIsDoneAndTheOthersAreCanceled) {
  RefboxStory story;
  auto& robot = story.open(kRobot1);
  story.run_until(1);
  for (const std::string task :
       {"1 move { waypoint: 'M-Z75' }", "2 move { waypoint: 'M-Z71' }", "3 move { waypoint: 'C_Z52' }"}) {
    story.say(robot, "AgentTask", "team_color: CYAN robot_id: 1 task_id: " + task);
    if (task.starts_with('1')) story.run_for(4);
  }
  story.run_for(40);
  std::vector<std::string> ends;
  for (const RefboxStory::Heard& heard : robot.heard)
    if (heard.type == "AgentTask" && heard.text.find("task_id: 3") == std::string::npos) ends.push_back(heard.text);
  EXPECT_THAT(ends, ElementsAre(AllOf(HasSubstr("task_id: 2"), HasSubstr("canceled: true")),
                                AllOf(HasSubstr("task_id: 1"), HasSubstr("canceled: true"))));
  EXPECT_THAT(robot.last_text("AgentTask"), AllOf(HasSubstr("task_id: 3"), HasSubstr("successful: true")));
}

TEST(RefboxRobots, TellWhatTheySee) {
  WorldConfig config = RefboxStory::game();
  config.exploration = true;
  config.information = "league";
  RefboxStory story(config);
  auto& robot = story.open(kRobot1);
  story.run_until(1);
  story.say(robot, "AgentTask", "team_color: CYAN robot_id: 1 task_id: 1 move { waypoint: 'C_Z55' }");
  story.run_for(40);
  EXPECT_THAT(robot.last_text("MachineReport"), HasSubstr("machines { zone: C_Z"));
}

// --- The other side

constexpr const char* kInstruct = "rcll_interfaces/action/InstructMachine";

TEST(LeagueClientTest, InstructionsEndAsTheirMachinesSay) {
  RefboxStory story(RefboxStory::game(), LeagueClientConfig{});
  const auto instruct = [&](const std::string& yaml) {
    return story.send_goal("/outside/factory/instruct_machine", kInstruct, yaml);
  };
  const auto early = instruct("{machine: C-BS, side: OUTPUT, base_color: BASE_RED}");
  story.run_until(4);
  EXPECT_EQ(early->code, 203) << "nothing is known of machines yet";
  const auto bs = instruct("{machine: C-BS, side: OUTPUT, base_color: BASE_RED}");
  const auto cs = instruct("{machine: C-CS1, operation: RETRIEVE_CAP}");
  const auto rs = instruct("{machine: C-RS1, ring_color: RING_BLUE}");  // it has not
  const auto nothing = instruct("{machine: C-RS2, ring_color: GREEN}");
  const auto unknown = instruct("{machine: C-XX}");
  story.run_for(2);
  EXPECT_FALSE(bs->ended);
  EXPECT_EQ(rs->code, 1);
  EXPECT_EQ(nothing->code, 103);
  EXPECT_EQ(unknown->code, 203);
  const auto again = instruct("{machine: C-BS, side: OUTPUT, base_color: BASE_RED}");
  story.run_for(3);
  EXPECT_EQ(again->code, 209) << "it is at work";
  EXPECT_EQ(bs->status, bus::GoalStatus::kSucceeded);
  EXPECT_THAT(bs->feedback, Contains(HasSubstr("READY-AT-OUTPUT")));
  EXPECT_FALSE(cs->ended);
  story.cancel(*cs);
  const auto reset = instruct("{machine: C-CS1, operation: RESET}");
  story.run_for(1);
  EXPECT_EQ(cs->status, bus::GoalStatus::kCanceled);
  EXPECT_EQ(reset->code, 0);
  const auto gone = instruct("{machine: C-DS, order_id: 1}");
  story.run_for(25);
  EXPECT_EQ(gone->code, 1) << "no product came";
}

TEST(LeagueClientTest, SkillsAreTasks) {
  RefboxStory story(RefboxStory::game(), LeagueClientConfig{});
  const auto skill = [&](const std::string& name, const std::string& type, const std::string& yaml) {
    return story.send_goal("/outside/robot1/" + name, "cxlab_skills/action/" + type, yaml);
  };
  story.run_until(1);
  const auto transport = skill("transport", "Transport", "{from: C-CS1-SHELF-LEFT, to: C-CS1-INPUT}");
  story.run_for(1);
  const auto other = skill("drive_to", "DriveTo", "{target: C_Z52}");
  story.run_for(120);
  EXPECT_EQ(transport->code, 0) << transport->text;
  for (const char* part : {"drive_to", "pick", "place"})
    EXPECT_THAT(transport->text, Not(HasSubstr(part))) << "no part of it failed";
  ASSERT_THAT(transport->feedback, SizeIs(4));
  EXPECT_THAT(transport->feedback[2], HasSubstr("drive_to"));
  EXPECT_TRUE(other->rejected);
  const auto full = skill("transport", "Transport", "{from: C-CS1-SHELF-LEFT, to: C-CS1-INPUT}");
  story.run_for(90);
  EXPECT_EQ(full->code, 202) << "it is empty now";
  EXPECT_THAT(full->text, HasSubstr("sub_action: \"pick\""));
  const auto explore = skill("explore", "Explore", "{target: C_Z52}");
  story.run_for(40);
  EXPECT_EQ(explore->code, 203);
  const auto discard = skill("discard", "Discard", "{}");
  story.run_for(1);
  EXPECT_EQ(discard->code, 104);
  const auto pose = skill("drive_to", "DriveTo", "{target: '', pose: {x: -6.5, y: 4.5}}");
  story.run_for(5);
  story.cancel(*pose);
  story.run_for(5);
  EXPECT_EQ(pose->status, bus::GoalStatus::kCanceled);
  const auto near = skill("drive_to", "DriveTo", "{target: '', pose: {x: 4.5, y: 1.2}}");
  story.run_for(60);
  EXPECT_EQ(near->status, bus::GoalStatus::kSucceeded);
  EXPECT_THAT(story.warnings(), IsEmpty());
}

/// A league_client whose referee box and robot are programs of the test.
class OutsideLeague : public ::testing::Test {
 protected:
  void machine_is(const std::string& state) {
    story_.say(box_, "MachineInfo", "team_color: CYAN machines { name: 'C-BS' state: '" + state + "' }");
    story_.run_for(0.1);
  }
  auto instruct() {
    return story_.send_goal("/outside/factory/instruct_machine", kInstruct,
                            "{machine: C-BS, side: OUTPUT, base_color: BASE_RED}");
  }
  auto drive(const std::string& goal) {
    const auto outcome = story_.send_goal("/outside/robot1/drive_to", "cxlab_skills/action/DriveTo", goal);
    story_.run_for(0.1);
    ++task_;
    return outcome;
  }
  /// The robot says how the task ended; by default the one that was sent last.
  void answer(const std::string& how, int task = 0) {
    story_.say(robot_, "AgentTask",
               "team_color: CYAN robot_id: 1 task_id: " + std::to_string(task == 0 ? task_ : task) + ' ' + how);
    story_.run_for(0.1);
  }

  RefboxStory story_{RefboxStory::game(), LeagueClientConfig{.port_shift = 1000}};
  RefboxStory::Program& box_ = story_.open({5441, 5446}, kLeagueKey);
  RefboxStory::Program& robot_ = story_.open({3116, 3126});
  int task_ = 0;
};

TEST(LeagueClientTest, HearsAndInstructsOnThePortsOfItsTeam) {
  for (const auto& [team, way] : {std::pair{"CYAN", Way{5441, 5446}}, {"MAGENTA", Way{5442, 5447}}}) {
    RefboxStory story(RefboxStory::game(), LeagueClientConfig{.team = team, .port_shift = 1000});
    auto& box = story.open(way, kLeagueKey);
    story.run_for(0.1);
    story.say(box, "MachineInfo", std::string("team_color: ") + team + " machines { name: 'C-BS' state: 'IDLE' }");
    story.run_for(0.1);
    (void)story.send_goal("/outside/factory/instruct_machine", kInstruct, "{machine: C-BS, operation: RESET}");
    story.run_for(0.1);
    EXPECT_EQ(box.last_text("ResetMachine"), std::string("team_color: ") + team + " machine: \"C-BS\"");
  }
}

TEST_F(OutsideLeague, TimesAreSecondsOfTopics) {
  const auto state = story_.listen("/outside/game_state", "rcll_interfaces/msg/GameState");
  RefboxStory::Program& everybody = story_.open({5444, 5445});
  story_.run_for(0.1);
  story_.say(everybody, "GameState",
             "game_time { sec: 2 nsec: 500000000 } state: RUNNING phase: PRODUCTION points_cyan: 7");
  story_.run_for(0.1);
  EXPECT_THAT(*state, AllOf(HasSubstr("game_time: 2.5"), HasSubstr("points_cyan: 7")));
}

TEST_F(OutsideLeague, AnInstructionIsSaidEachSecondUntilItsMachineIsAtWork) {
  story_.run_for(0.1);
  machine_is("IDLE");
  const auto instruction = instruct();
  story_.run_for(3.5);
  EXPECT_THAT(box_.times("PrepareMachine"), SizeIs(4)) << "at once and three times more";
  machine_is("PROCESSING");
  story_.run_for(20);
  EXPECT_THAT(box_.times("PrepareMachine"), SizeIs(4));
  EXPECT_FALSE(instruction->ended);
  machine_is("IDLE");
  EXPECT_EQ(instruction->code, 0) << "somebody has taken what it made";
}

TEST_F(OutsideLeague, AnInstructionThatNoMachineTakesEndsAfterTenSeconds) {
  story_.run_for(0.1);
  machine_is("IDLE");
  const auto idle = instruct();
  story_.run_for(9);
  EXPECT_FALSE(idle->ended);
  story_.run_for(2);
  EXPECT_EQ(idle->code, 209);
  EXPECT_EQ(idle->status, bus::GoalStatus::kAborted);
  const auto down = instruct();
  machine_is("DOWN");
  story_.run_for(20);
  EXPECT_FALSE(down->ended) << "it may take it when it is up again";
  machine_is("IDLE");
  EXPECT_EQ(down->code, 209) << "a machine that was down has done nothing";
}

/// The client looks each second.
TEST_F(OutsideLeague, AnInstructionThatNoMachineTakesEndsAtTheFirstSecondAfterTen) {
  story_.run_for(0.1);
  machine_is("IDLE");
  story_.take_every_tick();
  const auto seconds_of = [&](const RefboxStory::Outcome& outcome) {
    const double sent = story_.now();
    while (!outcome.ended && story_.now() < sent + 20) story_.run_for(0.02);
    return story_.now() - sent;
  };
  const double way = seconds_of(*story_.send_goal("/outside/factory/instruct_machine", kInstruct, "{machine: C-XX}"));
  double shortest = 99, longest = 0;
  for (int phase = 0; phase < 50; ++phase) {  // the ticks of a second
    while (std::llround(story_.now() / 0.02) % 50 != phase) story_.run_for(0.02);
    const double lasted = seconds_of(*instruct()) - way;
    shortest = std::min(shortest, lasted);
    longest = std::max(longest, lasted);
  }
  EXPECT_NEAR(shortest, 10, 1e-6);
  EXPECT_NEAR(longest, 10.98, 1e-6);
}

TEST_F(OutsideLeague, ThatAPieceIsDescribedAnewIsSaidOnceAndDoneAtOnce) {
  story_.run_for(0.1);
  story_.say(box_, "MachineInfo", "team_color: CYAN machines { name: 'C-SS' state: 'IDLE' }");
  story_.run_for(0.1);
  const auto goal = story_.send_goal("/outside/factory/instruct_machine", kInstruct,
                                     "{machine: C-SS, operation: CHANGE_INFO, shelf: 2, slot: 3, description: red}");
  story_.run_for(0.1);
  EXPECT_EQ(goal->status, bus::GoalStatus::kSucceeded);
  EXPECT_EQ(goal->code, 0);
  story_.run_for(5);
  EXPECT_THAT(box_.times("PrepareMachine"), SizeIs(1));
  EXPECT_THAT(box_.last_text("PrepareMachine"), HasSubstr("wp_description: \"red\""));
}

TEST_F(OutsideLeague, APieceThatIsStoredIsNotWaitedForAtTheOutput) {
  const auto storage_is = [&](const std::string& state) {
    story_.say(box_, "MachineInfo", "team_color: CYAN machines { name: 'C-SS' state: '" + state + "' }");
    story_.run_for(0.1);
  };
  story_.run_for(0.1);
  for (const auto& [operation, ends_at_output] : {std::pair{"STORE", false}, {"RETRIEVE", true}}) {
    storage_is("IDLE");
    const auto goal = story_.send_goal("/outside/factory/instruct_machine", kInstruct,
                                       std::string("{machine: C-SS, operation: ") + operation + ", shelf: 2, slot: 3}");
    story_.run_for(0.1);
    storage_is("PROCESSING");
    storage_is("READY-AT-OUTPUT");
    EXPECT_EQ(goal->ended, ends_at_output) << operation;
    storage_is("IDLE");
    EXPECT_EQ(goal->status, bus::GoalStatus::kSucceeded) << operation;
  }
}

TEST_F(OutsideLeague, AnInstructionTellsWhenItWasSentWhichARepetitionDoesNotChange) {
  const auto sent_at = [&] {
    const std::string text = box_.last_text("PrepareMachine");
    const std::size_t at = text.find("sent_at: ");
    EXPECT_NE(at, std::string::npos) << text;
    return at == std::string::npos ? 0 : std::stoll(text.substr(at + 9));
  };
  story_.run_for(0.5);
  machine_is("IDLE");
  (void)instruct();
  story_.run_for(0.1);
  const long long first = sent_at();
  story_.run_for(5);
  EXPECT_EQ(sent_at(), first);
  story_.run_for(15);
  (void)instruct();
  story_.run_for(0.1);
  EXPECT_NEAR(static_cast<double>(sent_at() - first), 20, 1);
}

TEST_F(OutsideLeague, ATaskIsSaidEachSecondUntilItsAnswer) {
  story_.run_for(0.5);
  const auto goal = drive("{target: C_Z52}");
  story_.run_for(3.4);
  EXPECT_THAT(robot_.times("AgentTask"), SizeIs(4)) << "at once and three times more";
  answer("successful: true", 2);
  EXPECT_FALSE(goal->ended) << "this was the answer to another task";
  answer("successful: true");
  EXPECT_EQ(goal->status, bus::GoalStatus::kSucceeded);
  const std::size_t said = robot_.times("AgentTask").size();
  story_.run_for(3);
  EXPECT_THAT(robot_.times("AgentTask"), SizeIs(said));
}

TEST_F(OutsideLeague, AnswersOfTheRobotEndASkill) {
  struct Row {
    bool cancel;
    const char* answer;
    bus::GoalStatus status;
    int code;
  };
  using bus::GoalStatus;
  for (const Row& row : {Row{false, "successful: true", GoalStatus::kSucceeded, 0},
                         {false, "successful: false error_code: 201", GoalStatus::kAborted, 201},
                         {false, "successful: false", GoalStatus::kAborted, 1},
                         {false, "successful: false canceled: true", GoalStatus::kAborted, 1},
                         {true, "successful: false canceled: true", GoalStatus::kCanceled, 0},
                         {true, "successful: false error_code: 201", GoalStatus::kAborted, 201},
                         {true, "successful: true", GoalStatus::kSucceeded, 0}}) {
    const auto goal = drive("{target: C_Z52}");
    if (row.cancel) story_.cancel(*goal);
    story_.run_for(0.1);
    EXPECT_EQ(count(robot_.last_text("AgentTask"), "cancel_task: true"), row.cancel);
    answer(row.answer);
    EXPECT_EQ(goal->status, row.status) << row.answer;
    EXPECT_EQ(goal->code, row.code) << row.answer;
  }
}

TEST_F(OutsideLeague, AnExploreTellsWhatTheRobotReportsOfItsZone) {
  const auto sightings = story_.listen("/outside/robot1/sightings", "cxlab_skills/msg/Sightings");
  for (const char* seen : {"C-RS1", "C-CS2"}) {
    const auto goal = story_.send_goal("/outside/robot1/explore", "cxlab_skills/action/Explore", "{target: C_Z52}");
    story_.run_for(0.1);
    ++task_;
    story_.say(robot_, "MachineReport",
               "team_color: CYAN machines { name: 'C-BS' type: 'BS' zone: C_Z23 rotation: 45 } machines { name: '" +
                   std::string(seen) + "' type: 'CS' zone: C_Z52 rotation: 90 }");
    story_.run_for(0.1);
    EXPECT_THAT(*sightings, AllOf(HasSubstr("C-BS"), HasSubstr("C_Z23"), HasSubstr(seen), HasSubstr("C_Z52")));
    answer("successful: true");
    EXPECT_EQ(goal->status, bus::GoalStatus::kSucceeded);
    EXPECT_THAT(goal->text, AllOf(HasSubstr("zone: \"C_Z52\""), HasSubstr("machine: \"" + std::string(seen) + '"'),
                                  HasSubstr("rotation: 90")));
  }
}

TEST_F(OutsideLeague, APoseIsTheZoneAroundIt) {
  for (const auto& [pose, zone] : {std::pair{"{x: 0.2, y: 0.9}", "C_Z11"},
                                   {"{x: 4.5, y: 1.2}", "C_Z52"},
                                   {"{x: 6.9, y: 7.9}", "C_Z78"},
                                   {"{x: 9.0, y: 9.0}", "C_Z78"},
                                   {"{x: -0.2, y: -1.0}", "M_Z11"},
                                   {"{x: -6.5, y: 4.5}", "M_Z75"}}) {
    (void)drive(std::string("{target: '', pose: ") + pose + '}');
    EXPECT_THAT(robot_.last_text("AgentTask"), HasSubstr(std::string("waypoint: \"") + zone + '"'));
    answer("successful: true");
  }
}

}  // namespace
}  // namespace cxlab::rcll
