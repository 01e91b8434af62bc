// Faults of a scenario: each kind acts, in both tiers, and moves nothing that it is not about.

#include <algorithm>
#include <cmath>

#include "cx/journal/journal_reader.h"
#include "scenarios/rcll/game/factory.h"
#include "sim/faults/fault.h"
#include "tests/support/episode_test.h"

namespace cxlab {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// Robots in a game without rules: stimuli send their goals.
class Faults : public EpisodeTest, public testing::WithParamInterface<const char*> {
 protected:
  std::filesystem::path floor(const std::string& name, const std::string& goals, const std::string& faults,
                              const std::string& tier, int duration_s = 60) {
    return write(name + ".yaml",
                 "schema: 1\nworld: {kind: rcll, down: false, orders: [{base_color: BASE_RED, cap_color: CAP_GREY}]}\n"
                 "tier: " +
                     tier + "\nduration_s: " + std::to_string(duration_s) + "\nstimuli:\n" + goals + "faults:\n" +
                     faults);
  }
  static std::string goal(double at, const std::string& robot, const std::string& skill, const std::string& target) {
    const std::string type = skill == "drive_to" ? "DriveTo" : skill == "pick" ? "Pick" : "Place";
    return "  - {at: " + std::to_string(at) + ", send_goal: /" + robot + '/' + skill + ", type: cxlab_skills/action/" +
           type + ", goal: {target: " + target + "}}\n";
  }
  /// How each skill of the robot ended: code and duration (s).
  std::vector<std::pair<int, double>> ends(const std::string& run, const std::string& robot) const {
    std::vector<std::pair<int, double>> out;
    for (const JournalRecord& r : records(run, "node/" + robot))
      if (r.kind == RecordKind::kSkill && r.data.text("event") == "end")
        out.emplace_back(static_cast<int>(r.data.integer("code")), std::get<double>(r.data.find("duration_s")->value));
    return out;
  }
  /// Times (s) at which that fault of the list struck.
  std::vector<double> strikes(const std::string& run, int number) const {
    std::vector<double> out;
    for (const JournalRecord& r : records(run, "faults"))
      if (r.data.integer("number") == number) out.push_back(to_seconds(r.t));
    return out;
  }
  std::vector<JournalRecord> records(const std::string& run, const std::string& stream) const {
    const auto all = read_journal(folder_ / run / "journal.jsonl");
    EXPECT_TRUE(all.ok());
    std::vector<JournalRecord> out;
    for (const JournalRecord& r : *all)
      if (r.stream == stream) out.push_back(r);
    return out;
  }
  static std::string state(Episode& episode, const std::string& machine) {
    for (const auto& m : dynamic_cast<rcll::Factory&>(*episode.stage().servers.back()).machines())
      if (m->name() == machine) return std::string(to_string(m->state()));
    return "no such machine";
  }
};

TEST_P(Faults, ASkillIsBrokenOffAndEndsWithTheCode) {
  const std::string goals = goal(1, "robot1", "drive_to", "C-BS-INPUT") + goal(10, "robot1", "drive_to", "C_Z11");
  (void)whole(
      floor("broken", goals, "  - {kind: skill_fails, at: 0.5, robot: robot1, error: 220, after_s: 3}\n", GetParam()),
      {}, "run");
  const auto ended = ends("run", "robot1");
  ASSERT_EQ(ended.size(), 2u);
  EXPECT_EQ(ended[0].first, 220);
  EXPECT_GE(ended[0].second, 3);
  EXPECT_LT(ended[0].second, 6);
  EXPECT_EQ(ended[1].first, 0) << "once";
  EXPECT_THAT(strikes("run", 0), ElementsAre(testing::DoubleNear(4, 0.05)));
}

TEST_P(Faults, AFaultOfOneSkillLeavesTheOthersAlone) {
  const std::string goals =
      goal(1, "robot1", "drive_to", "C-CS1-INPUT") + goal(12, "robot1", "pick", "C-CS1-SHELF-LEFT");
  (void)whole(floor("one", goals, "  - {kind: skill_fails, probability: 1, skill: pick}\n", GetParam()), {}, "run");
  const auto ended = ends("run", "robot1");
  ASSERT_EQ(ended.size(), 2u);
  EXPECT_EQ(ended[0].first, 0);
  EXPECT_EQ(ended[1].first, 206) << "what a pick ends with where nothing else is said";
}

TEST_P(Faults, AStalledRobotStandsAndThenDoesIt) {
  const std::string goals = goal(1, "robot1", "drive_to", "C-BS-INPUT");
  (void)whole(floor("quick", goals, "  - {kind: skill_stalls, at: 50, seconds: 7}\n", GetParam()), {}, "quick");
  (void)whole(floor("late", goals, "  - {kind: skill_stalls, at: 0, robot: robot1, seconds: 7}\n", GetParam()), {},
              "late");
  const auto quick = ends("quick", "robot1"), late = ends("late", "robot1");
  ASSERT_EQ(quick.size(), 1u);
  ASSERT_EQ(late.size(), 1u);
  EXPECT_EQ(late[0].first, 0);
  EXPECT_NEAR(late[0].second, quick[0].second + 7, 0.1);
}

TEST_P(Faults, ADroppedPieceLiesOnTheFloor) {
  const std::string goals =
      goal(1, "robot1", "pick", "C-CS1-SHELF-LEFT") + goal(35, "robot1", "place", "C-CS1-SHELF-LEFT");
  auto episode =
      load(floor("drop", goals, "  - {kind: piece_dropped, at: 30, robot: robot1}\n", GetParam()), {}, "run");
  begin(*episode);
  play(*episode, 60);
  const auto& floor = dynamic_cast<const sim::World&>(*episode->stage().worlds.front());
  EXPECT_FALSE(floor.robot(sim::RobotId{0}).held);
  EXPECT_GT(std::ranges::count(floor.pieces(), sim::Holder::kFloor, &sim::Piece::holder), 0);
  (void)episode->close(RunStatus::kCompleted);
  const auto struck = strikes("run", 0);
  EXPECT_THAT(struck, ElementsAre(30));
  const auto ended = ends("run", "robot1");
  ASSERT_EQ(ended.size(), 2u);
  EXPECT_EQ(ended[1].first, 208) << "nothing to place";
}

TEST_P(Faults, APieceSlipsOutAfterAPickThatEndedWell) {
  const std::string goals =
      goal(1, "robot1", "pick", "C-CS1-SHELF-LEFT") + goal(35, "robot1", "place", "C-CS1-SHELF-LEFT");
  (void)whole(floor("slip", goals, "  - {kind: grasp_slips, at: 0, robot: robot1, after_s: 4}\n", GetParam()), {},
              "run");
  const auto ended = ends("run", "robot1");
  ASSERT_EQ(ended.size(), 2u);
  EXPECT_EQ(ended[0].first, 0);
  EXPECT_EQ(ended[1].first, 208);
  EXPECT_THAT(strikes("run", 0), ElementsAre(testing::DoubleNear(1 + ended[0].second + 4, 0.1)));
}

TEST_P(Faults, AHaltedRobotStandsAndASlowOneIsLater) {
  const std::string goals = goal(1, "robot1", "drive_to", "C-BS-INPUT");
  const auto took = [&](const std::string& name, const std::string& fault) {
    (void)whole(floor(name, goals, "  - {" + fault + ", robot: robot1}\n", GetParam()), {}, name);
    const auto ended = ends(name, "robot1");
    EXPECT_EQ(ended.size(), 1u);
    EXPECT_EQ(ended.front().first, 0);
    return ended.front().second;
  };
  const double quick = took("quick", "kind: skill_stalls, at: 50, seconds: 7");
  EXPECT_NEAR(took("halted", "kind: robot_halts, at: 3, seconds: 20"), quick + 20, 3.5);
  EXPECT_GT(took("slow", "kind: robot_slow, at: 0, factor: 0.5, seconds: 100"), 1.5 * quick);
  EXPECT_THAT(strikes("halted", 0), ElementsAre(3));
}

TEST_P(Faults, AGoalIsLostAndAResultComesLate) {
  const std::string goals = goal(1, "robot1", "drive_to", "C-BS-INPUT") + goal(20, "robot1", "drive_to", "C_Z11");
  (void)whole(floor("plain", goals, "  - {kind: goal_lost, at: 0, robot: robot1}\n", GetParam()), {}, "plain");
  (void)whole(
      floor("lost", goals, "  - {kind: goal_lost, at: 0, robot: robot1}\n  - {kind: result_late, at: 15, seconds: 6}\n",
            GetParam()),
      {}, "lost");
  const auto plain = ends("plain", "robot1"), ended = ends("lost", "robot1");
  ASSERT_EQ(plain.size(), 2u);
  ASSERT_EQ(ended.size(), 2u);
  EXPECT_EQ(ended[0].first, 220);
  EXPECT_NEAR(ended[0].second, 10, 0.1);
  EXPECT_EQ(ended[1].first, 0);
  EXPECT_NEAR(ended[1].second, plain[1].second + 6, 0.1);
  EXPECT_THAT(strikes("lost", 0), ElementsAre(testing::DoubleNear(1, 0.05)));
  EXPECT_EQ(strikes("lost", 1).size(), 1u);
}

TEST_P(Faults, AMisplacedPieceFallsBeforeTheMachine) {
  const std::string goals =
      goal(1, "robot1", "pick", "C-CS1-SHELF-LEFT") + goal(35, "robot1", "place", "C-CS1-SHELF-LEFT");
  auto episode =
      load(floor("misplaced", goals, "  - {kind: piece_misplaced, at: 0, robot: robot1}\n", GetParam()), {}, "run");
  begin(*episode);
  play(*episode, 60);
  const auto& floor = dynamic_cast<const sim::World&>(*episode->stage().worlds.front());
  EXPECT_FALSE(floor.robot(sim::RobotId{0}).held);
  EXPECT_EQ(std::ranges::count(floor.pieces(), sim::Holder::kFloor, &sim::Piece::holder), 1);
  (void)episode->close(RunStatus::kCompleted);
  const auto ended = ends("run", "robot1");
  ASSERT_EQ(ended.size(), 2u);
  EXPECT_EQ(ended[0].first, 0);
  EXPECT_EQ(ended[1].first, 204);
  EXPECT_EQ(strikes("run", 0).size(), 1u);
}

TEST_P(Faults, APieceIsTakenOffTheShelf) {
  auto episode = load(floor("taken", "  - {at: 11, publish: /tick, type: std_msgs/msg/Empty}\n",
                            "  - {kind: piece_taken, at: 10, machine: C-CS1}\n"
                            "  - {kind: piece_taken, at: 10, machine: C-BS}\n",
                            GetParam()),
                      {}, "run");
  begin(*episode);
  play(*episode, 30);
  const auto& floor = dynamic_cast<const sim::World&>(*episode->stage().worlds.front());
  int lie_there = 0;
  std::string taken;
  for (const char* side : {"LEFT", "MIDDLE", "RIGHT"}) {
    const std::string name = std::string("C-CS1-SHELF-") + side;
    if (floor.at(*floor.plan().find_spot(name)) != nullptr)
      ++lie_there;
    else
      taken = name;
  }
  EXPECT_EQ(lie_there, 2);
  (void)episode->close(RunStatus::kCompleted);
  const auto struck = records("run", "faults");
  ASSERT_EQ(struck.size(), 1u) << "nothing lies at the base station";
  EXPECT_EQ(struck[0].data.text("spot"), taken);
  EXPECT_EQ(struck[0].data.text("machine"), "C-CS1");
  EXPECT_EQ(to_seconds(struck[0].t), 11);
}

TEST_P(Faults, APieceLiesForASecondBeforeItIsTakenAlsoAfterAnotherOne) {
  auto episode = load(floor("again", "  - {at: 9, publish: /tick, type: std_msgs/msg/Empty}\n",
                            "  - {kind: piece_taken, mean_s: 0.1, machine: C-CS1}\n", GetParam()),
                      {}, "run");
  begin(*episode);
  play(*episode, 10);
  (void)episode->close(RunStatus::kCompleted);
  const std::vector<double> taken = strikes("run", 0);
  ASSERT_EQ(taken.size(), 3u) << "as many as lie on the shelf";
  for (std::size_t i = 1; i < taken.size(); ++i) EXPECT_GE(taken[i] - taken[i - 1], 1);
}

TEST_P(Faults, APieceThatComesIsTakenWhenItsMachineHasSeenIt) {
  (void)whole(floor("seen",
                    "  - {at: 2, send_goal: /factory/instruct_machine, type: rcll_interfaces/action/InstructMachine, "
                    "goal: {machine: C-BS, side: OUTPUT, base_color: BASE_RED}}\n",
                    "  - {kind: piece_taken, at: 1, machine: C-BS}\n", GetParam()),
              {}, "run");
  std::vector<std::string> states;
  double ready_at = 0;
  for (const JournalRecord& r : records("run", "referee")) {
    if (r.data.text("event") == "machine") states.emplace_back(r.data.text("state"));
    if (!states.empty() && states.back() == "READY-AT-OUTPUT" && ready_at == 0) ready_at = to_seconds(r.t);
  }
  EXPECT_THAT(states, ElementsAre("PREPARED", "PROCESSING", "PROCESSED", "READY-AT-OUTPUT", "WAIT-IDLE", "IDLE"));
  EXPECT_THAT(strikes("run", 0), ElementsAre(testing::DoubleNear(ready_at + 1, 0.3)));
}

TEST_P(Faults, AnInstructionIsLostAndOneComesLate) {
  const auto instruct = [](double at) {
    return "  - {at: " + std::to_string(at) +
           ", send_goal: /factory/instruct_machine, type: rcll_interfaces/action/InstructMachine, goal: {machine: "
           "C-BS, side: OUTPUT, base_color: BASE_RED}}\n";
  };
  std::string ticks;
  for (const char* t : {"9", "14", "24.8", "26"})
    ticks += std::string("  - {at: ") + t + ", publish: /tick, type: std_msgs/msg/Empty}\n";
  auto episode = load(floor("instructions", instruct(2) + instruct(20) + ticks,
                            "  - {kind: instruction_lost, at: 0, machine: C-BS}\n  - {kind: instruction_late, at: 10, "
                            "machine: C-BS, seconds: 5}\n",
                            GetParam()),
                      {}, "run");
  begin(*episode);
  const auto at = [&](double t) {
    play(*episode, t);
    return state(*episode, "C-BS");
  };
  EXPECT_EQ(at(9), "IDLE");
  EXPECT_EQ(at(24.8), "IDLE");
  EXPECT_NE(at(26), "IDLE");
  (void)episode->close(RunStatus::kCompleted);
  EXPECT_THAT(strikes("run", 0), ElementsAre(testing::DoubleNear(2, 0.05)));
  EXPECT_THAT(strikes("run", 1), ElementsAre(testing::DoubleNear(20, 0.05)));
  EXPECT_EQ(std::get<double>(records("run", "faults").back().data.find("seconds")->value), 5);
  std::vector<std::pair<double, std::int64_t>> results;
  for (const JournalRecord& r : records("run", "node/factory"))
    if (r.kind == RecordKind::kBus && r.data.text("op") == "result")
      results.emplace_back(std::round(to_seconds(r.t)), r.data.find("result")->integer("error_code"));
  ASSERT_FALSE(results.empty());
  EXPECT_EQ(results.front(), (std::pair<double, std::int64_t>{12, 2}));
}

TEST_P(Faults, ARobotInMaintenanceLosesItsPieceAndItsGoalAndComesBack) {
  const std::string goals = goal(1, "robot1", "pick", "C-CS1-SHELF-LEFT") +
                            goal(30, "robot1", "drive_to", "C-BS-INPUT") +
                            goal(35, "robot1", "drive_to", "C-BS-INPUT") + goal(60, "robot1", "drive_to", "C-BS-INPUT");
  auto episode =
      load(floor("off", goals, "  - {kind: robot_maintenance, at: 33, robot: robot1, seconds: 20}\n", GetParam(), 90),
           {}, "run");
  begin(*episode);
  const auto& floor = dynamic_cast<const sim::World&>(*episode->stage().worlds.front());
  const auto y = [&] { return floor.robot(sim::RobotId{0}).pose_in_world.y; };
  play(*episode, 32.5);
  EXPECT_TRUE(floor.robot(sim::RobotId{0}).held);
  EXPECT_GT(y(), 1);
  play(*episode, 52);
  EXPECT_FALSE(floor.robot(sim::RobotId{0}).held);
  EXPECT_NEAR(y(), -0.6, 0.001);
  EXPECT_EQ(std::ranges::count(floor.pieces(), sim::Holder::kFloor, &sim::Piece::holder), 0);
  play(*episode, 53.5);
  EXPECT_NEAR(y(), 0.5, 0.001);
  play(*episode, 90);
  EXPECT_EQ(floor.robot(sim::RobotId{0}).robot_contacts, 0u);
  EXPECT_EQ(floor.robot(sim::RobotId{0}).static_contacts, 0u);
  (void)episode->close(RunStatus::kCompleted);
  EXPECT_THAT(strikes("run", 0), ElementsAre(33));
  const auto ended = ends("run", "robot1");
  ASSERT_EQ(ended.size(), 4u);
  EXPECT_EQ(ended[0].first, 0);
  EXPECT_EQ(ended[1].first, 210) << "under way";
  EXPECT_NEAR(ended[1].second, 3, 0.05);
  EXPECT_EQ(ended[2].first, 210) << "during maintenance";
  EXPECT_EQ(ended[2].second, 0);
  EXPECT_EQ(ended[3].first, 0) << "back on the field";
  std::string track;
  for (const JournalRecord& r : records("run", "referee"))
    if (r.data.text("event") == "piece" && r.data.text("to") == "crew")
      track += std::string(r.data.text("from")) + " " + std::string(r.data.text("from_name"));
  EXPECT_EQ(track, "gripper robot1");
}

TEST_P(Faults, ADriveEndsBesideItsGoalAndAPickFindsItsWay) {
  const std::string goals = goal(1, "robot1", "drive_to", "C_Z23") + goal(20, "robot1", "pick", "C-CS1-SHELF-LEFT");
  const auto play_with = [&](const std::string& name, const std::string& sigmas) {
    auto episode =
        load(floor(name, goals, "  - {kind: pose_noise, probability: 1, robot: robot1, " + sigmas + "}\n", GetParam()),
             {}, name);
    begin(*episode);
    play(*episode, 19);
    const auto& world = dynamic_cast<const sim::World&>(*episode->stage().worlds.front());
    const sim::Pose2 stands = world.robot(sim::RobotId{0}).pose_in_world;
    play(*episode, 60);
    EXPECT_EQ(world.robot(sim::RobotId{0}).static_contacts, 0u);
    (void)episode->close(RunStatus::kCompleted);
    return stands;
  };
  const sim::Pose2 exact = play_with("exact", "sigma_m: 0, sigma_deg: 0");
  const sim::Pose2 off = play_with("off", "sigma_m: 0.1, sigma_deg: 5");
  const double way = sim::distance(exact.position(), off.position());
  EXPECT_GT(way, 0.03);
  EXPECT_LT(way, 0.4);
  EXPECT_GT(std::abs(exact.yaw - off.yaw), 0.01);
  EXPECT_EQ(strikes("off", 0).size(), 2u) << "each time that it drives by its pose";
  const auto right = ends("exact", "robot1"), corrected = ends("off", "robot1");
  ASSERT_EQ(right.size(), 2u);
  ASSERT_EQ(corrected.size(), 2u);
  EXPECT_EQ(corrected[0].first, 0) << "it takes itself to be there";
  EXPECT_EQ(corrected[1].first, 0);
  EXPECT_GT(corrected[1].second, right[1].second + 0.3) << "it drives on when it sees the machine";
  (void)play_with("lost", "sigma_m: 0, sigma_deg: 90");
  const auto lost = ends("lost", "robot1");
  ASSERT_EQ(lost.size(), 2u);
  EXPECT_EQ(lost[1].first, 201) << "the machine is not in sight";
}

TEST_P(Faults, ATransportFindsItsWayToEachOfItsSpots) {
  const std::string goals =
      "  - {at: 1, send_goal: /robot1/transport, type: cxlab_skills/action/Transport, goal: {from: C-CS1-SHELF-LEFT, "
      "to: C-CS2-INPUT}}\n";
  const auto play_with = [&](const std::string& name, const std::string& when, const std::string& sigmas) {
    const std::string faults = "  - {kind: pose_noise, robot: robot1, " + when + ", " + sigmas + "}\n";
    auto episode = load(floor(name, goals, faults, GetParam(), 70), {}, name);
    begin(*episode);
    play(*episode, 70);
    const auto& world = dynamic_cast<const sim::World&>(*episode->stage().worlds.front());
    EXPECT_EQ(world.robot(sim::RobotId{0}).static_contacts, 0u);
    (void)episode->close(RunStatus::kCompleted);
  };
  play_with("exact", "probability: 1", "sigma_m: 0, sigma_deg: 0");
  play_with("off", "probability: 1", "sigma_m: 0.05, sigma_deg: 5");
  const auto struck = strikes("off", 0);
  ASSERT_EQ(struck.size(), 2u) << "once a drive";
  EXPECT_EQ(struck[0], 1);
  const auto exact = ends("exact", "robot1"), off = ends("off", "robot1");
  ASSERT_EQ(exact.size(), 1u);
  ASSERT_EQ(off.size(), 1u);
  EXPECT_EQ(exact[0].first, 0);
  EXPECT_EQ(off[0].first, 0);
  std::string track;
  for (const JournalRecord& r : records("off", "referee"))
    if (r.data.text("event") == "piece" && r.data.text("from") == "gripper")
      track += std::string(r.data.text("to")) + " " + std::string(r.data.text("to_name"));
  EXPECT_EQ(track, "belt C-CS2");
  play_with("lost", "probability: 1, from: 2", "sigma_m: 0, sigma_deg: 90");
  const auto lost = ends("lost", "robot1");
  ASSERT_EQ(lost.size(), 1u);
  EXPECT_EQ(lost[0].first, 201) << "the second machine is not in sight";
  EXPECT_EQ(strikes("lost", 0).size(), 1u);
}

TEST_P(Faults, DelaysOfAnInstructionAddUpAndOneThatIsLostAsWellIsAborted) {
  const auto instruct = [](double at) {
    return "  - {at: " + std::to_string(at) +
           ", send_goal: /factory/instruct_machine, type: rcll_interfaces/action/InstructMachine, goal: {machine: "
           "C-BS, side: OUTPUT, base_color: BASE_RED}}\n";
  };
  std::string ticks;
  for (const char* t : {"6.5", "8.8", "9.2"})
    ticks += std::string("  - {at: ") + t + ", publish: /tick, type: std_msgs/msg/Empty}\n";
  auto episode = load(floor("delays", instruct(2) + ticks + instruct(40),
                            "  - {kind: instruction_late, at: 0, machine: C-BS, seconds: 3}\n"
                            "  - {kind: instruction_late, at: 0, machine: C-BS, seconds: 4}\n"
                            "  - {kind: instruction_lost, at: 30, machine: C-BS}\n"
                            "  - {kind: instruction_late, at: 30, machine: C-BS, seconds: 4}\n",
                            GetParam()),
                      {}, "run");
  begin(*episode);
  const auto at = [&](double t) {
    play(*episode, t);
    return state(*episode, "C-BS");
  };
  EXPECT_EQ(at(6.5), "IDLE");
  EXPECT_EQ(at(8.8), "IDLE");
  EXPECT_NE(at(9.2), "IDLE");
  play(*episode, 55);
  (void)episode->close(RunStatus::kCompleted);
  std::vector<std::pair<double, std::int64_t>> results;
  for (const JournalRecord& r : records("run", "node/factory"))
    if (r.kind == RecordKind::kBus && r.data.text("op") == "result")
      results.emplace_back(std::round(to_seconds(r.t)), r.data.find("result")->integer("error_code"));
  ASSERT_FALSE(results.empty());
  EXPECT_EQ(results.back(), (std::pair<double, std::int64_t>{50, 2}));
}

TEST_P(Faults, AnInstructionThatIsCanceledOnItsWayComesAllTheSame) {
  auto episode = load(floor("canceled",
                            "  - {at: 2, send_goal: /factory/instruct_machine, type: "
                            "rcll_interfaces/action/InstructMachine, goal: {machine: C-BS, side: OUTPUT, base_color: "
                            "BASE_RED}}\n  - {at: 4, cancel_goal: /factory/instruct_machine}\n  - {at: 6, publish: "
                            "/tick, type: std_msgs/msg/Empty}\n  - {at: 8, publish: /tick, type: std_msgs/msg/Empty}\n",
                            "  - {kind: instruction_late, at: 0, machine: C-BS, seconds: 5}\n", GetParam()),
                      {}, "run");
  begin(*episode);
  play(*episode, 6);
  EXPECT_EQ(state(*episode, "C-BS"), "IDLE");
  play(*episode, 8);
  EXPECT_EQ(state(*episode, "C-BS"), "PROCESSING");
}

TEST_P(Faults, MachinesBreakAndGoDown) {
  std::string ticks;  // in the timed tier nothing else happens at these times
  for (const char* t : {"9.9", "10.1", "20.1", "36", "42"})
    ticks += std::string("  - {at: ") + t + ", publish: /tick, type: std_msgs/msg/Empty}\n";
  auto episode = load(floor("machines", ticks,
                            "  - {kind: machine_breaks, at: 10.04, machine: C-CS1}\n  - {kind: machine_down, at: 20, "
                            "machine: C-BS, seconds: 15}\n  - {kind: machine_breaks, at: 12, machine: C-CS1}\n",
                            GetParam()),
                      {}, "run");
  begin(*episode);
  const auto at = [&](double t) {
    play(*episode, t);
    return state(*episode, "C-CS1") + ' ' + state(*episode, "C-BS");
  };
  EXPECT_EQ(at(9.9), "IDLE IDLE");
  EXPECT_EQ(at(10.1), "BROKEN IDLE");
  EXPECT_EQ(at(20.1), "BROKEN DOWN");
  EXPECT_EQ(at(36), "BROKEN IDLE");
  EXPECT_EQ(at(42), "IDLE IDLE");
  (void)episode->close(RunStatus::kCompleted);
  EXPECT_THAT(strikes("run", 0), ElementsAre(10.04));
  std::vector<std::pair<std::int64_t, bool>> struck;
  for (const JournalRecord& r : records("run", "faults"))
    struck.emplace_back(r.data.integer("number"), std::get<bool>(r.data.find("acted")->value));
  EXPECT_THAT(struck, ElementsAre(std::pair{0, true}, std::pair{2, false}, std::pair{1, true}));
}

INSTANTIATE_TEST_SUITE_P(Tiers, Faults, testing::Values("physics", "timed"),
                         [](const auto& tier) { return std::string(tier.param); });

using FaultsAlone = Faults;

TEST_P(FaultsAlone, AFaultMovesNoOtherDraw) {
  // robot2 works far from robot1; its durations are drawn.
  const std::string goals =
      goal(1, "robot1", "drive_to", "C-CS1-SHELF-LEFT") + goal(1, "robot2", "pick", "C-CS2-SHELF-LEFT") +
      goal(60, "robot1", "pick", "C-CS1-SHELF-LEFT") + goal(100, "robot2", "place", "C-CS2-SHELF-LEFT");
  const std::string first = "  - {kind: machine_breaks, mean_s: 20, machine: C-DS}\n";
  const std::string none = first + "  - {kind: skill_fails, at: 1000}\n";
  const std::string more = first +
                           "  - {kind: skill_fails, probability: 1, robot: robot1, skill: pick, after_s: 3}\n  - "
                           "{kind: machine_down, mean_s: 50, machine: C-BS, seconds: 3}\n";
  const auto before = streams(whole(floor("a", goals, none, GetParam(), 200), {}, "before"));
  const auto after = streams(whole(floor("b", goals, more, GetParam(), 200), {}, "after"));
  EXPECT_NE(before.at("node/robot1"), after.at("node/robot1"));
  EXPECT_EQ(before.at("node/robot2"), after.at("node/robot2"));
  EXPECT_GT(strikes("before", 0).size(), 2u);
  EXPECT_EQ(strikes("before", 0), strikes("after", 0)) << "each fault has a stream of its own";
  const auto again = whole(folder_ / "b.yaml");
  EXPECT_EQ(streams(again), after);
}

INSTANTIATE_TEST_SUITE_P(Tiers, FaultsAlone, testing::Values("timed"),
                         [](const auto& tier) { return std::string(tier.param); });

TEST_F(Faults, WrongFaultsAreBadInputWithTheirPlace) {
  const std::pair<const char*, const char*> cases[] = {
      {"{kind: skill_fail, at: 1}", "expected one of: skill_fails, skill_stalls"},
      {"{kind: skill_fails}", "expected either at or probability"},
      {"{kind: skill_fails, at: 1, probability: 0.1}", "expected either at or probability"},
      {"{kind: skill_fails, probability: 1.5}", "expected a probability"},
      {"{kind: skill_fails, at: 1, error: 7}", "expected one of: 103"},
      {"{kind: skill_fails, at: 1, machine: C-BS}", "unknown key 'machine'"},
      {"{kind: skill_stalls, at: 1}", "key 'seconds' is missing"},
      {"{kind: machine_breaks, at: 1}", "key 'machine' is missing"},
      {"{kind: machine_down, mean_s: 0, machine: C-BS, seconds: 1}", "at least 0.001 s"},
      {"{kind: instruction_late, at: 1, machine: C-BS}", "key 'seconds' is missing"},
      {"{kind: piece_taken, at: 1}", "key 'machine' is missing"},
      {"{kind: robot_halts, at: 1}", "key 'seconds' is missing"},
      {"{kind: robot_slow, at: 1, seconds: 1}", "key 'factor' is missing"},
      {"{kind: robot_slow, at: 1, seconds: 1, factor: 2}", "expected a share of the speed"},
      {"{kind: pose_noise, at: 1, sigma_m: 0.1}", "key 'sigma_deg' is missing"},
      {"{kind: pose_noise, at: 1, sigma_m: -0.1, sigma_deg: 0}", "found -0.1, expected 0 to 2"},
      {"{kind: pose_noise, at: 1, sigma_m: 2.1, sigma_deg: 0}", "found 2.1, expected 0 to 2"},
      {"{kind: pose_noise, at: 1, sigma_m: 2, sigma_deg: 91}", "found 91, expected 0 to 90"},
      {"{kind: robot_maintenance, at: 1}", "key 'seconds' is missing"},
      {"{at: 1}", "key 'kind' is missing"},
      {"{at: 1, knd: skill_fails}", "key 'kind' is missing, did you mean it by 'knd'?"}};
  for (const auto& [text, what] : cases) {
    const auto read = Scenario::parse(std::string("schema: 1\nworld: {kind: rcll}\nfaults:\n  - ") + text + "\n",
                                      "s.yaml", shipped());
    ASSERT_FALSE(read.ok()) << text;
    EXPECT_THAT(read.error().text(), HasSubstr("s.yaml:4: ")) << text;
    EXPECT_THAT(read.error().text(), HasSubstr(what)) << text;
  }
  const auto empty = Scenario::parse("schema: 1\nfaults:\n  - {kind: skill_fails, at: 1}\n", "s.yaml", shipped());
  ASSERT_FALSE(empty.ok());
  EXPECT_THAT(empty.error().text(), HasSubstr("this world has neither robots nor machines"));
  for (const char* text :
       {"{kind: machine_breaks, at: 1, machine: C-CSS1}", "{kind: piece_dropped, at: 1, robot: robt1}"}) {
    const auto file =
        write("names.yaml", std::string("schema: 1\nworld: {kind: rcll}\ntier: timed\nfaults:\n  - ") + text + "\n");
    const auto episode = Episode::load(*Scenario::load(file, shipped()), options());
    ASSERT_FALSE(episode.ok());
    EXPECT_THAT(episode.error().text(), testing::AllOf(HasSubstr("names.yaml:5: "), HasSubstr("did you mean")));
  }
}

TEST(FaultTimer, SkipsWhatChanceWouldHaveBroughtMeanwhile) {
  sim::Fault fault;
  fault.mean = from_seconds(10);
  fault.times = 2;
  sim::FaultTimer timer(fault, 1, "robot1");
  timer.skip_until(from_seconds(1000));
  EXPECT_GE(timer.due(), from_seconds(1000));
  EXPECT_LT(timer.due(), from_seconds(1100));
  timer.struck(timer.due());
  EXPECT_NE(timer.due(), kNever) << "what is skipped does not count";
  timer.struck(timer.due());
  EXPECT_EQ(timer.due(), kNever);
  timer.skip_until(from_seconds(5000));
  EXPECT_EQ(timer.due(), kNever);

  fault.at = from_seconds(5);
  sim::FaultTimer once(fault, 1, "robot1");
  once.skip_until(from_seconds(1000));
  EXPECT_EQ(once.due(), from_seconds(5));
}

TEST(FaultTimer, StrikesAsOftenAsItIsAskedFor) {
  sim::Fault fault;
  fault.probability = 0.2;
  sim::FaultTimer often(fault, 1, "robot1");
  int struck = 0;
  for (int i = 0; i < 2000; ++i) struck += often.strikes_occasion(from_seconds(i));
  EXPECT_NEAR(struck, 400, 60);

  fault.times = 3;
  fault.from = from_seconds(10);
  fault.until = from_seconds(1000);
  fault.probability = 1;
  sim::FaultTimer few(fault, 1, "robot1");
  std::vector<int> at;
  for (int i = 0; i < 2000; ++i)
    if (few.strikes_occasion(from_seconds(i))) at.push_back(i);
  EXPECT_THAT(at, ElementsAre(10, 11, 12));

  sim::Fault machine;
  machine.kind = sim::FaultKind::kMachineBreaks;
  machine.mean = from_seconds(50);
  machine.until = from_seconds(50000);
  sim::FaultTimer now_and_then(machine, 1, "C-BS");
  int times = 0;
  for (; now_and_then.due() != kNever; ++times) now_and_then.struck(now_and_then.due());
  EXPECT_NEAR(times, 1000, 100);
  machine.from = from_seconds(10000);
  EXPECT_GE(sim::FaultTimer(machine, 1, "C-BS").due(), machine.from);
}

}  // namespace
}  // namespace cxlab
