// What faults do to a skill: each call that reaches the skill below, each result and each record, with its time.

#include "sim/skills/faulty_skills.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "sim/skills/destination.h"

namespace cxlab::sim::faulty_skills_test {
namespace {

constexpr SimTime kTick{500'000'000};

std::string seconds(SimTime t) {
  if (t == kNever) return "never";
  const auto tenths = std::lround(to_seconds(t) * 10);
  return std::to_string(tenths / 10) + (tenths % 10 != 0 ? "." + std::to_string(tenths % 10) : "");
}

using Log = std::vector<std::string>;

FloorPlan two_robots() {
  FloorPlan plan;
  plan.robots = {{"robot1", {}}, {"robot2", {}}};
  plan.spots.resize(2);
  plan.spots[0].align_in_world = {0.2, 0, 0.3};
  plan.spots[1].align_in_world = {3, 0, 0};
  return plan;
}

class Hand final : public WorldView {
 public:
  Hand() : WorldView(two_robots()) {}
  RobotState robot(RobotId id) const override {
    RobotState state;
    if (id == RobotId{0} && holds) state.held = PieceId{1};
    state.pose_in_world = stands;
    return state;
  }
  bool belt_running(StationId) const override { return false; }
  const Piece* at(SpotId) const override { return nullptr; }
  const Piece* on_belt(StationId, double) const override { return nullptr; }
  bool holds = false;
  Pose2 stands;
};

/// A skill that takes `lasts` and half a second to stop, and grasps as it ends if it is a pick; a transport is a pick
/// for half of the time, then a place.
class Plain final : public RobotSkills {
 public:
  Plain(Log& log, Hand& hand, SimTime lasts) : log_(log), hand_(hand), lasts_(lasts) {}
  void start(const SkillGoal& goal, SimTime now) override {
    log_.push_back("start " + goal.target);
    begun = goal;
    kind_ = goal.kind;
    part_ = kind_ == SkillKind::kTransport ? SkillKind::kPick : kind_;
    ends_at_ = now + lasts_;
    cancelled_ = false;
  }
  void cancel(SimTime now) override {
    log_.push_back("cancel");
    if (ends_at_ > now + kTick) {
      ends_at_ = now + kTick;
      cancelled_ = true;
    }
  }
  void abandon(SimTime) override {
    log_.push_back("abandon");
    ends_at_ = kNever;
  }
  void resume(SimTime) override { log_.push_back("resume"); }
  std::optional<SkillResult> sense(SimTime now) override {
    if (ends_at_ == kNever) log_.push_back("idle");
    if (now >= next_due() && part_ != kind_) {
      log_.push_back("took");
      part_ = SkillKind::kPlace;
      hand_.holds = true;
      kind_ = SkillKind::kPlace;
    }
    if (now < ends_at_) return std::nullopt;
    ends_at_ = kNever;
    log_.push_back(hand_.holds ? "over, holds" : "over");
    if (cancelled_) return SkillResult::cancel();
    if (kind_ == SkillKind::kPick) hand_.holds = true;
    return SkillResult::of(SkillCode::kNone);
  }
  void act(SimTime) override { log_.push_back("act"); }
  void drop(SimTime) override {
    log_.push_back("drop");
    hand_.holds = false;
  }
  std::optional<RobotId> waits_for(SimTime) const override { return std::nullopt; }
  SkillPhase phase() const override { return SkillPhase::kHandle; }
  SkillKind part() const override { return part_; }
  double remaining(SimTime) const override { return 3; }
  SimTime next_due() const override { return part_ == kind_ || ends_at_ == kNever ? ends_at_ : ends_at_ - lasts_ / 2; }
  SkillGoal begun;

 private:
  Log& log_;
  Hand& hand_;
  SimTime lasts_;
  SkillKind kind_{}, part_{};
  SimTime ends_at_ = kNever;
  bool cancelled_ = false;
};

/// Logs the fault that a record is about; "?" if the record is not exactly the expected one.
class FaultLog final : public RecordSink {
 public:
  FaultLog(Log& log, const std::vector<Fault>& faults) : log_(log), faults_(faults) {}
  StreamId open_stream(std::string_view name) override { return name == "faults" ? StreamId{1} : StreamId{}; }
  RecordRef write(StreamId stream, SimTime t, RecordKind kind, const RecordData& data,
                  std::span<const RecordRef> causes) override {
    std::string what = "?";
    for (const Fault& fault : faults_) {
      RecordData wanted;
      wanted.begin()
          .field("fault", to_string(fault.kind))
          .field("number", static_cast<std::int64_t>(fault.number))
          .field("robot", "robot1");
      if (wanted.bytes() == data.bytes() && stream == StreamId{1} && kind == RecordKind::kControl && causes.empty())
        what = std::to_string(fault.number);
    }
    log_.push_back("fault " + what + (t == now ? "" : " at another time"));
    return {};
  }
  SimTime now{};

 private:
  Log& log_;
  const std::vector<Fault>& faults_;
};

/// A transport that was never begun has not come to the part in which the last one ended.
TEST(FaultySkills, AGoalThatIsLostOrCancelledBeforeItBeginsIsAtItsBeginning) {
  for (const FaultKind kind : {FaultKind::kGoalLost, FaultKind::kSkillStalls}) {
    Log calls;
    Hand hand;
    std::vector<Fault> faults(1);
    faults[0].kind = kind;
    faults[0].at = from_seconds(3);
    faults[0].duration = from_seconds(5);
    FaultLog sink(calls, faults);
    Traffic traffic(hand.plan());
    FaultySkills skills(std::make_unique<Plain>(calls, hand, from_seconds(1)), RobotId{0}, hand, traffic, faults, 1,
                        sink);
    const SkillGoal transport{SkillKind::kTransport, "A to B", SpotId{0}, {}, SpotId{1}};
    skills.start(transport, {});
    (void)skills.sense(from_seconds(0.5));
    ASSERT_TRUE(skills.sense(from_seconds(1)));
    EXPECT_EQ(skills.part(), SkillKind::kPlace);
    skills.start(transport, from_seconds(3));
    EXPECT_EQ(skills.part(), SkillKind::kTransport);
    if (kind == FaultKind::kSkillStalls) skills.cancel(from_seconds(4));
    ASSERT_TRUE(skills.sense(from_seconds(30)));
    EXPECT_EQ(skills.part(), SkillKind::kTransport) << to_string(kind);
  }
}

TEST(FaultySkills, AreForgottenWhenTheRobotIsCarriedAway) {
  Log calls;
  Hand hand;
  std::vector<Fault> faults;
  for (const FaultKind kind : {FaultKind::kSkillFails, FaultKind::kSkillStalls, FaultKind::kGoalLost,
                               FaultKind::kResultLate, FaultKind::kRobotHalts, FaultKind::kRobotSlow}) {
    faults.assign(1, {});
    faults[0].kind = kind;
    faults[0].at = SimTime{};
    faults[0].factor = 0.5;
    faults[0].after = faults[0].duration = from_seconds(3);
    FaultLog sink(calls, faults);
    Traffic traffic(hand.plan());
    FaultySkills skills(std::make_unique<Plain>(calls, hand, from_seconds(1)), RobotId{0}, hand, traffic, faults, 1,
                        sink);
    const SkillGoal drive{SkillKind::kDriveTo, "A", std::nullopt, {}};
    skills.start(drive, {});
    EXPECT_FALSE(skills.sense(from_seconds(0.5)));
    if (kind == FaultKind::kResultLate) {
      EXPECT_FALSE(skills.sense(from_seconds(1)));
    }
    skills.abandon(from_seconds(1.5));
    EXPECT_EQ(skills.next_due(), kNever);
    EXPECT_EQ(calls.back(), "abandon");
    skills.start(drive, from_seconds(2));
    EXPECT_EQ(skills.next_due(), from_seconds(3));
    EXPECT_FALSE(skills.sense(from_seconds(2.5)));
    const auto result = skills.sense(from_seconds(3));
    ASSERT_TRUE(result);
    EXPECT_EQ(result->code, SkillCode::kNone);
  }
}

TEST(FaultySkills, OfASkillThatWasCancelledNoResultIsLate) {
  Log calls;
  Hand hand;
  std::vector<Fault> faults(1);
  faults[0].kind = FaultKind::kResultLate;
  faults[0].probability = 1;
  faults[0].duration = from_seconds(5);
  FaultLog sink(calls, faults);
  Traffic traffic(hand.plan());
  FaultySkills skills(std::make_unique<Plain>(calls, hand, from_seconds(10)), RobotId{0}, hand, traffic, faults, 1,
                      sink);
  skills.start({SkillKind::kDriveTo, "A", std::nullopt, {}}, {});
  skills.cancel(from_seconds(1));
  const auto result = skills.sense(from_seconds(2));
  ASSERT_TRUE(result);
  EXPECT_TRUE(result->cancelled);
}

TEST(FaultySkills, AShortHaltEndsNoLongOne) {
  Log calls;
  Hand hand;
  std::vector<Fault> faults(2);
  for (Fault& fault : faults) fault.kind = FaultKind::kRobotHalts;
  faults[0].at = from_seconds(1);
  faults[0].duration = from_seconds(10);
  faults[1].at = from_seconds(3);
  faults[1].duration = from_seconds(2);
  FaultLog sink(calls, faults);
  Traffic traffic(hand.plan());
  FaultySkills skills(std::make_unique<Plain>(calls, hand, from_seconds(100)), RobotId{0}, hand, traffic, faults, 1,
                      sink);
  skills.start({SkillKind::kDriveTo, "A", std::nullopt, {}}, {});
  for (const double now : {1, 3}) (void)skills.sense(from_seconds(now));
  EXPECT_EQ(skills.next_due(), from_seconds(11));
}

/// The piece stays in the gripper, where the skill below has ended as a place.
TEST(FaultySkills, NothingHappensAfterAPlaceThatEndedBeforeItBegan) {
  for (const bool fails : {true, false}) {
    Log calls;
    Hand hand;
    std::vector<Fault> faults(fails ? 3 : 2);
    for (Fault& fault : faults) fault.at = from_seconds(3);
    faults[0].kind = FaultKind::kPieceMisplaced;
    faults[1].kind = FaultKind::kSkillStalls;
    faults[1].duration = from_seconds(5);
    if (fails) {
      faults[2].kind = FaultKind::kSkillFails;
      faults[2].after = from_seconds(1);
    }
    FaultLog sink(calls, faults);
    Traffic traffic(hand.plan());
    FaultySkills skills(std::make_unique<Plain>(calls, hand, from_seconds(1)), RobotId{0}, hand, traffic, faults, 1,
                        sink);
    const SkillGoal place{SkillKind::kPlace, "A", std::nullopt, {}};
    skills.start(place, {});
    ASSERT_TRUE(skills.sense(from_seconds(1)));
    hand.holds = true;
    skills.start(place, from_seconds(3));
    if (!fails) skills.cancel(from_seconds(4));
    const auto result = skills.sense(from_seconds(4));
    ASSERT_TRUE(result);
    EXPECT_EQ(result->cancelled, !fails);
    EXPECT_EQ(skills.next_due(), kNever);
    for (const double now : {5, 20}) EXPECT_FALSE(skills.sense(from_seconds(now)));
    EXPECT_TRUE(hand.holds);
  }
}

TEST(FaultySkills, AnExploreThatGoesAstrayMissesTheLookoutAndNotTheZone) {
  Log calls;
  Hand hand;
  std::vector<Fault> faults(1);
  faults[0].kind = FaultKind::kPoseNoise;
  faults[0].at = SimTime{};
  faults[0].sigma_m = 1e-6;
  FaultLog sink(calls, faults);
  Traffic traffic(hand.plan());
  auto plain = std::make_unique<Plain>(calls, hand, from_seconds(1));
  const Plain& below = *plain;
  FaultySkills skills(std::move(plain), RobotId{0}, hand, traffic, faults, 1, sink);
  const SkillGoal explore{SkillKind::kExplore, "A", std::nullopt, {3, 0, 0}};
  const Pose2 lookout = destination_of(explore, hand, traffic, RobotId{0}).pose;
  ASSERT_GT(distance(lookout.position(), explore.pose.position()), 0.9);
  skills.start(explore, {});
  EXPECT_EQ(below.begun.kind, SkillKind::kDriveTo);
  EXPECT_LT(distance(below.begun.pose.position(), lookout.position()), 1e-4);
  EXPECT_FALSE(skills.sense(from_seconds(1)));
  EXPECT_EQ(below.begun.kind, SkillKind::kExplore);
  EXPECT_EQ(below.begun.pose.x, 3);
}

TEST(FaultySkills, APlaceThatWentAstrayIsMisplacedOnceItGoesOn) {
  Log calls;
  Hand hand;
  hand.holds = true;
  std::vector<Fault> faults(2);
  for (Fault& fault : faults) fault.at = SimTime{};
  faults[0].kind = FaultKind::kPoseNoise;
  faults[0].sigma_m = 0.01;
  faults[1].kind = FaultKind::kPieceMisplaced;
  FaultLog sink(calls, faults);
  Traffic traffic(hand.plan());
  FaultySkills skills(std::make_unique<Plain>(calls, hand, from_seconds(2)), RobotId{0}, hand, traffic, faults, 1,
                      sink);
  skills.start({SkillKind::kPlace, "A", SpotId{1}, {3, 0, 0}}, {});
  EXPECT_FALSE(skills.sense(from_seconds(1)));
  EXPECT_TRUE(hand.holds) << "it drives";
  hand.stands = {3, 0, 0};
  EXPECT_FALSE(skills.sense(from_seconds(2)));
  EXPECT_FALSE(hand.holds);
  const auto result = skills.sense(from_seconds(4));
  ASSERT_TRUE(result);
  EXPECT_EQ(result->code, SkillCode::kSensorDisagreement);
}

struct Case {
  const char* name;
  std::vector<Fault> faults;
  std::vector<std::pair<double, SkillGoal>> goals;
  std::vector<double> cancels;
  double lasts, until;
  Log wanted;
};

/// All that happens; per tick also what is due, when that or the phase changes.
Log play(const Case& c) {
  Log calls, log;
  Hand hand;
  FaultLog sink(calls, c.faults);
  Traffic traffic(hand.plan());
  FaultySkills skills(std::make_unique<Plain>(calls, hand, from_seconds(c.lasts)), RobotId{0}, hand, traffic, c.faults,
                      1, sink);
  std::string last;
  bool active = false;
  for (SimTime now{}; now <= from_seconds(c.until); now += kTick) {
    sink.now = now;
    if (active) {
      if (const auto result = skills.sense(now)) {
        active = false;
        calls.push_back("end " + std::to_string(static_cast<int>(result->code)) +
                        (result->cancelled ? " cancelled" : "") + " '" + result->text + "'");
      }
    }
    for (const auto& [at, goal] : c.goals)
      if (from_seconds(at) == now) {
        skills.start(goal, now);
        active = true;
      }
    for (const double at : c.cancels)
      if (from_seconds(at) == now) skills.cancel(now);
    for (const std::string& call : calls) log.push_back(seconds(now) + " " + call);
    calls.clear();
    const std::string state = std::string(to_string(skills.phase())) + " " +
                              std::to_string(std::lround(skills.remaining(now))) + " m, due " +
                              seconds(skills.next_due());
    if (state != last) log.push_back(seconds(now) + " " + state);
    last = state;
  }
  return log;
}

Fault fails(double at, double after, int error = 0) {
  Fault fault;
  fault.kind = FaultKind::kSkillFails;
  fault.at = from_seconds(at);
  fault.after = from_seconds(after);
  fault.error = error;
  fault.number = 3;
  return fault;
}
Fault stalls(double at, double duration) {
  Fault fault;
  fault.kind = FaultKind::kSkillStalls;
  fault.at = from_seconds(at);
  fault.duration = from_seconds(duration);
  fault.number = 4;
  return fault;
}
Fault drops(double at) {
  Fault fault;
  fault.kind = FaultKind::kPieceDropped;
  fault.at = from_seconds(at);
  fault.number = 5;
  return fault;
}
Fault at(FaultKind kind, double at, double duration = 0) {
  Fault fault = stalls(at, duration);
  fault.kind = kind;
  fault.number = 6;
  return fault;
}
Fault slips(double at, double after) {
  Fault fault = fails(at, after);
  fault.kind = FaultKind::kGraspSlips;
  return fault;
}
Fault noise(double sigma_m, double sigma_deg) {
  Fault fault = fails(0, 0);
  fault.kind = FaultKind::kPoseNoise;
  fault.sigma_m = sigma_m;
  fault.sigma_deg = sigma_deg;
  return fault;
}
Fault of_robot(Fault fault, const char* robot) {
  fault.robot = robot;
  return fault;
}
Fault of_skill(Fault fault, const char* skill) {
  fault.skill = skill;
  return fault;
}
Fault machine(double at) {
  Fault fault = fails(at, 0);
  fault.kind = FaultKind::kMachineBreaks;
  fault.machine = "C-BS";
  return fault;
}

const SkillGoal kDrive{SkillKind::kDriveTo, "A", std::nullopt, {}}, kPick{SkillKind::kPick, "B", std::nullopt, {}},
    kPlace{SkillKind::kPlace, "C", std::nullopt, {}}, kNearPick{SkillKind::kPick, "B", SpotId{0}, {0.2, 0, 0.3}},
    kFarPick{SkillKind::kPick, "B", SpotId{0}, {3, 0, 0}},
    kCarry{SkillKind::kTransport, "D", SpotId{0}, {0.2, 0, 0.3}, SpotId{1}},
    kNearCarry{SkillKind::kTransport, "D", SpotId{0}, {0.2, 0, 0.3}, SpotId{0}},
    kFarCarry{SkillKind::kTransport, "D", SpotId{1}, {3, 0, 0}, SpotId{0}},
    kDiscardHere{SkillKind::kDiscard, "", std::nullopt, {}},
    kDiscardThere{SkillKind::kDiscard, "E", std::nullopt, {3, 0, 0}},
    kExplore{SkillKind::kExplore, "F", std::nullopt, {3, 0, 0}};

const std::vector<Case>& cases() {
  static const std::vector<Case> all{
      {"None",
       {},
       {{0, kDrive}},
       {},
       2,
       3,
       {"0 start A", "0 handle 3 m, due 2", "2 over", "2 end 0 ''", "2 handle 3 m, due never"}},
      {"OfAnotherRobot",
       {of_robot(fails(0, 1), "robot2")},
       {{0, kDrive}},
       {},
       2,
       3,
       {"0 start A", "0 handle 3 m, due 2", "2 over", "2 end 0 ''", "2 handle 3 m, due never"}},
      {"OfThisRobot",
       {of_robot(fails(0, 1), "robot1")},
       {{0, kDrive}},
       {},
       2,
       3,
       {"0 start A", "0 handle 3 m, due 1", "1 fault 3", "1 cancel", "1 handle 3 m, due 1.5", "1.5 over",
        "1.5 end 201 'unable to move'", "1.5 handle 3 m, due never"}},
      {"OfAMachine",
       {machine(0)},
       {{0, kDrive}},
       {},
       2,
       3,
       {"0 start A", "0 handle 3 m, due 2", "2 over", "2 end 0 ''", "2 handle 3 m, due never"}},
      {"ADriveFails",
       {fails(0, 1)},
       {{0, kDrive}, {3, kDrive}},
       {},
       4,
       8,
       {"0 start A", "0 handle 3 m, due 1", "1 fault 3", "1 cancel", "1 handle 3 m, due 1.5", "1.5 over",
        "1.5 end 201 'unable to move'", "1.5 handle 3 m, due never", "3 start A", "3 handle 3 m, due 7", "7 over",
        "7 end 0 ''", "7 handle 3 m, due never"}},
      {"APickFails",
       {fails(0, 1)},
       {{0, kPick}},
       {},
       4,
       3,
       {"0 start B", "0 handle 3 m, due 1", "1 fault 3", "1 cancel", "1 handle 3 m, due 1.5", "1.5 over",
        "1.5 end 206 'grasping failed'", "1.5 handle 3 m, due never"}},
      {"APlaceFails",
       {fails(0, 1)},
       {{0, kPlace}},
       {},
       4,
       3,
       {"0 start C", "0 handle 3 m, due 1", "1 fault 3", "1 cancel", "1 handle 3 m, due 1.5", "1.5 over",
        "1.5 end 204 'sensor disagreement'", "1.5 handle 3 m, due never"}},
      {"WithACode",
       {fails(0, 1, 300)},
       {{0, kPlace}},
       {},
       4,
       3,
       {"0 start C", "0 handle 3 m, due 1", "1 fault 3", "1 cancel", "1 handle 3 m, due 1.5", "1.5 over",
        "1.5 end 300 'no path'", "1.5 handle 3 m, due never"}},
      {"OfOneSkill",
       {of_skill(fails(0, 1), "pick")},
       {{0, kDrive}, {3, kPick}},
       {},
       2,
       6,
       {"0 start A", "0 handle 3 m, due 2", "2 over", "2 end 0 ''", "2 handle 3 m, due never", "3 start B",
        "3 handle 3 m, due 4", "4 fault 3", "4 cancel", "4 handle 3 m, due 4.5", "4.5 over",
        "4.5 end 206 'grasping failed'", "4.5 handle 3 m, due never"}},
      {"FailsAtOnce",
       {fails(0, 0)},
       {{0, kPick}},
       {},
       4,
       3,
       {"0 start B", "0 handle 3 m, due 0", "0.5 fault 3", "0.5 cancel", "0.5 handle 3 m, due 1", "1 over",
        "1 end 206 'grasping failed'", "1 handle 3 m, due never"}},
      {"FailsAfterItsEnd",
       {fails(0, 3)},
       {{0, kDrive}, {2.5, kDrive}},
       {},
       2,
       6,
       {"0 start A", "0 handle 3 m, due 2", "2 over", "2 end 0 ''", "2 handle 3 m, due never", "2.5 start A",
        "2.5 handle 3 m, due 4.5", "4.5 over", "4.5 end 0 ''", "4.5 handle 3 m, due never"}},
      {"FailsTooLateToBreakOff",
       {fails(0, 1.5)},
       {{0, kPick}},
       {},
       2,
       4,
       {"0 start B", "0 handle 3 m, due 1.5", "1.5 fault 3", "1.5 cancel", "1.5 handle 3 m, due 2", "2 over",
        "2 end 0 ''", "2 handle 3 m, due never"}},
      {"CancelledBeforeItFails",
       {fails(0, 2)},
       {{0, kDrive}, {4, kDrive}},
       {1.5},
       6,
       8,
       {"0 start A", "0 handle 3 m, due 2", "1.5 cancel", "2 over", "2 end 0 cancelled 'cancelled'",
        "2 handle 3 m, due never", "4 start A", "4 handle 3 m, due 10"}},
      {"CancelledWhileItIsBrokenOff",
       {fails(0, 1)},
       {{0, kDrive}},
       {1},
       6,
       4,
       {"0 start A", "0 handle 3 m, due 1", "1 fault 3", "1 cancel", "1 handle 3 m, due 1.5", "1.5 over",
        "1.5 end 201 'unable to move'", "1.5 handle 3 m, due never"}},
      {"Stalls",
       {stalls(0, 2)},
       {{0, kDrive}, {5, kDrive}},
       {},
       2,
       8,
       {"0 fault 4", "0 wait 0 m, due 2", "0.5 idle", "1 idle", "1.5 idle", "2 start A", "2 handle 3 m, due 4",
        "4 over", "4 end 0 ''", "4 handle 3 m, due never", "5 start A", "5 handle 3 m, due 7", "7 over", "7 end 0 ''",
        "7 handle 3 m, due never"}},
      {"CancelledWhileItStalls",
       {stalls(0, 3)},
       {{0, kDrive}, {3, kDrive}},
       {1},
       2,
       6,
       {"0 fault 4", "0 wait 0 m, due 3", "0.5 idle", "1 idle", "1 wait 0 m, due 1", "1.5 idle",
        "1.5 end 0 cancelled 'cancelled'", "1.5 handle 3 m, due never", "3 start A", "3 handle 3 m, due 5", "5 over",
        "5 end 0 ''", "5 handle 3 m, due never"}},
      {"CancelledAfterItStalled",
       {stalls(0, 1)},
       {{0, kDrive}},
       {2},
       4,
       5,
       {"0 fault 4", "0 wait 0 m, due 1", "0.5 idle", "1 start A", "1 handle 3 m, due 5", "2 cancel",
        "2 handle 3 m, due 2.5", "2.5 over", "2.5 end 0 cancelled 'cancelled'", "2.5 handle 3 m, due never"}},
      {"FailsWhileItStalls",
       {fails(0, 1), stalls(0, 3)},
       {{0, kPick}, {4, kPick}},
       {},
       2,
       8,
       {"0 fault 4", "0 wait 0 m, due 1", "0.5 idle", "1 fault 3", "1 idle", "1 end 206 'grasping failed'",
        "1 handle 3 m, due never", "4 start B", "4 handle 3 m, due 6", "6 over", "6 end 0 ''",
        "6 handle 3 m, due never"}},
      {"FailsAfterItStalled",
       {fails(0, 2), stalls(0, 1)},
       {{0, kPick}},
       {},
       4,
       5,
       {"0 fault 4", "0 wait 0 m, due 1", "0.5 idle", "1 start B", "1 handle 3 m, due 2", "2 fault 3", "2 cancel",
        "2 handle 3 m, due 2.5", "2.5 over", "2.5 end 206 'grasping failed'", "2.5 handle 3 m, due never"}},
      {"CancelledWhileItStallsAndWouldFail",
       {fails(0, 2), stalls(0, 3)},
       {{0, kPick}, {4, kPick}},
       {1},
       2,
       8,
       {"0 fault 4", "0 wait 0 m, due 2", "0.5 idle", "1 idle", "1 wait 0 m, due 1", "1.5 idle",
        "1.5 end 0 cancelled 'cancelled'", "1.5 handle 3 m, due never", "4 start B", "4 handle 3 m, due 6", "6 over",
        "6 end 0 ''", "6 handle 3 m, due never"}},
      {"DropsWhatIsHeld",
       {drops(3)},
       {{0, kPick}, {2.5, kDrive}},
       {},
       2,
       6,
       {"0 start B", "0 handle 3 m, due 2", "2 over", "2 end 0 ''", "2 handle 3 m, due 3", "2.5 start A", "3 fault 5",
        "3 drop", "3 handle 3 m, due 4.5", "4.5 over", "4.5 end 0 ''", "4.5 handle 3 m, due never"}},
      {"DropsWhatIsTakenLater",
       {drops(1)},
       {{0, kPick}, {3, kPick}},
       {},
       2,
       6,
       {"0 start B", "0 handle 3 m, due 2", "2 over", "2 fault 5", "2 drop", "2 end 0 ''", "2 handle 3 m, due never",
        "3 start B", "3 handle 3 m, due 5", "5 over", "5 end 0 ''", "5 handle 3 m, due never"}},
      {"FailsAfterOneThatWasCancelled",
       {fails(3, 1)},
       {{0, kDrive}, {3, kDrive}},
       {1},
       4,
       6,
       {"0 start A", "0 handle 3 m, due 4", "1 cancel", "1 handle 3 m, due 1.5", "1.5 over",
        "1.5 end 0 cancelled 'cancelled'", "1.5 handle 3 m, due never", "3 start A", "3 handle 3 m, due 4", "4 fault 3",
        "4 cancel", "4 handle 3 m, due 4.5", "4.5 over", "4.5 end 201 'unable to move'", "4.5 handle 3 m, due never"}},
      {"CancelledAfterOneThatFailed",
       {fails(0, 1)},
       {{0, kDrive}, {3, kDrive}},
       {4},
       4,
       6,
       {"0 start A", "0 handle 3 m, due 1", "1 fault 3", "1 cancel", "1 handle 3 m, due 1.5", "1.5 over",
        "1.5 end 201 'unable to move'", "1.5 handle 3 m, due never", "3 start A", "3 handle 3 m, due 7", "4 cancel",
        "4 handle 3 m, due 4.5", "4.5 over", "4.5 end 0 cancelled 'cancelled'", "4.5 handle 3 m, due never"}},
      {"DropsAsTheNextSkillEnds",
       {drops(4)},
       {{0, kPick}, {2, kDrive}},
       {},
       2,
       6,
       {"0 start B", "0 handle 3 m, due 2", "2 over", "2 end 0 ''", "2 start A", "2 handle 3 m, due 4", "4 fault 5",
        "4 drop", "4 over", "4 end 0 ''", "4 handle 3 m, due never"}},
      {"LosesAGoal",
       {at(FaultKind::kGoalLost, 1)},
       {{0, kDrive}, {2.5, kPick}},
       {},
       2,
       13,
       {"0 start A",
        "0 handle 3 m, due 2",
        "2 over",
        "2 end 0 ''",
        "2 handle 3 m, due never",
        "2.5 fault 6",
        "2.5 wait 0 m, due 12.5",
        "3 idle",
        "3.5 idle",
        "4 idle",
        "4.5 idle",
        "5 idle",
        "5.5 idle",
        "6 idle",
        "6.5 idle",
        "7 idle",
        "7.5 idle",
        "8 idle",
        "8.5 idle",
        "9 idle",
        "9.5 idle",
        "10 idle",
        "10.5 idle",
        "11 idle",
        "11.5 idle",
        "12 idle",
        "12.5 idle",
        "12.5 end 220 'no answer: the goal was lost'",
        "12.5 handle 3 m, due never"}},
      {"LosesAGoalThatIsCancelled",
       {at(FaultKind::kGoalLost, 0)},
       {{0, kDrive}, {3, kPick}},
       {1},
       1,
       5,
       {"0 fault 6", "0 wait 0 m, due 10", "0.5 idle", "1 idle", "1 wait 0 m, due 1", "1.5 idle",
        "1.5 end 0 cancelled 'cancelled'", "1.5 handle 3 m, due never", "3 start B", "3 handle 3 m, due 4", "4 over",
        "4 end 0 ''", "4 handle 3 m, due never"}},
      {"ReportsLate",
       {at(FaultKind::kResultLate, 0, 3)},
       {{0, kPick}, {6, kDrive}},
       {},
       2,
       9,
       {"0 start B", "0 handle 3 m, due 2", "2 over", "2 fault 6", "2 handle 3 m, due 5", "2.5 idle", "3 idle",
        "3.5 idle", "4 idle", "4.5 idle", "5 idle", "5 end 0 ''", "5 handle 3 m, due never", "6 start A",
        "6 handle 3 m, due 8", "8 over, holds", "8 end 0 ''", "8 handle 3 m, due never"}},
      {"ReportsLateAndIsCancelledMeanwhile",
       {at(FaultKind::kResultLate, 0, 3)},
       {{0, kDrive}},
       {3},
       2,
       6,
       {"0 start A", "0 handle 3 m, due 2", "2 over", "2 fault 6", "2 handle 3 m, due 5", "2.5 idle", "3 idle",
        "3.5 idle", "4 idle", "4.5 idle", "5 idle", "5 end 0 ''", "5 handle 3 m, due never"}},
      {"LosesWhatItTookAfterAWhile",
       {slips(0, 1.5)},
       {{0, kDrive}, {3, kPick}, {5, kDrive}},
       {},
       2,
       8,
       {"0 start A", "0 handle 3 m, due 2", "2 over", "2 end 0 ''", "2 handle 3 m, due never", "3 start B",
        "3 handle 3 m, due 5", "5 over", "5 end 0 ''", "5 start A", "5 handle 3 m, due 6.5", "6.5 fault 3", "6.5 drop",
        "6.5 handle 3 m, due 7", "7 over", "7 end 0 ''", "7 handle 3 m, due never"}},
      {"LosesWhatItTookAtOnce",
       {slips(0, 0)},
       {{0, kPick}},
       {},
       2,
       3,
       {"0 start B", "0 handle 3 m, due 2", "2 over", "2 fault 3", "2 drop", "2 end 0 ''", "2 handle 3 m, due never"}},
      {"HasPutItDownBeforeItSlips",
       {drops(2.5), slips(0, 2)},
       {{0, kPick}, {2, kDrive}},
       {},
       2,
       5,
       {"0 start B", "0 handle 3 m, due 2", "2 over", "2 end 0 ''", "2 start A", "2 handle 3 m, due 2.5", "2.5 fault 5",
        "2.5 drop", "2.5 handle 3 m, due 4", "4 over", "4 end 0 ''", "4 handle 3 m, due never"}},
      {"LosesWhatATransportTook",
       {slips(0, 0.5)},
       {{0, kCarry}},
       {},
       4,
       5,
       {"0 start D", "0 handle 3 m, due 2", "2 took", "2 handle 3 m, due 2.5", "2.5 fault 3", "2.5 drop",
        "2.5 handle 3 m, due 4", "4 over", "4 end 0 ''", "4 handle 3 m, due never"}},
      {"MisplacesInATransport",
       {at(FaultKind::kPieceMisplaced, 0)},
       {{0, kCarry}},
       {},
       4,
       5,
       {"0 start D", "0 handle 3 m, due 2", "2 took", "2 fault 6", "2 drop", "2 handle 3 m, due 4", "4 over",
        "4 end 204 'sensor disagreement'", "4 handle 3 m, due never"}},
      {"Misplaces",
       {at(FaultKind::kPieceMisplaced, 0)},
       {{0, kPick}, {3, kPlace}},
       {},
       2,
       6,
       {"0 start B", "0 handle 3 m, due 2", "2 over", "2 end 0 ''", "2 handle 3 m, due never", "3 start C",
        "3 handle 3 m, due 5", "3.5 fault 6", "3.5 drop", "5 over", "5 end 204 'sensor disagreement'",
        "5 handle 3 m, due never"}},
      {"MisplacesOnceItHasBegun",
       {at(FaultKind::kPieceMisplaced, 0), stalls(3, 1)},
       {{0, kPick}, {3, kPlace}},
       {},
       2,
       7,
       {"0 start B", "0 handle 3 m, due 2", "2 over", "2 end 0 ''", "2 handle 3 m, due never", "3 fault 4",
        "3 wait 0 m, due 4", "3.5 idle", "4 start C", "4 fault 6", "4 drop", "4 handle 3 m, due 6", "6 over",
        "6 end 204 'sensor disagreement'", "6 handle 3 m, due never"}},
      {"DrivesAstray",
       {noise(0.1, 5)},
       {{0, kDrive}, {3, kDrive}},
       {},
       2,
       6,
       {"0 fault 3", "0 start A", "0 handle 3 m, due 2", "2 over", "2 end 0 ''", "2 handle 3 m, due never", "3 start A",
        "3 handle 3 m, due 5", "5 over", "5 end 0 ''", "5 handle 3 m, due never"}},
      {"DrivesAstrayAndThenSeesWhereItIs",
       {noise(0.1, 5)},
       {{0, kFarPick}},
       {},
       2,
       12,
       {"0 fault 3",
        "0 start B",
        "0 handle 3 m, due 2",
        "2 over",
        "2 look 3 m, due 10",
        "2.5 idle",
        "3 idle",
        "3.5 idle",
        "4 idle",
        "4.5 idle",
        "5 idle",
        "5.5 idle",
        "6 idle",
        "6.5 idle",
        "7 idle",
        "7.5 idle",
        "8 idle",
        "8.5 idle",
        "9 idle",
        "9.5 idle",
        "10 idle",
        "10 end 201 'unable to move'",
        "10 handle 3 m, due never"}},
      {"TransportsAstray",
       {noise(0.1, 5), fails(0, 3, 300)},
       {{0, kFarCarry}},
       {},
       2,
       5,
       {"0 fault 3", "0 start D", "0 handle 3 m, due 2", "2 over", "2 look 3 m, due 3", "2.5 idle", "3 fault 3",
        "3 idle", "3 end 300 'no path'", "3 handle 3 m, due never"}},
      {"TransportsAstrayToItsSecondSpot",
       {noise(0.1, 5), fails(0, 5, 300)},
       {{0, kCarry}},
       {},
       2,
       6,
       {"0 start D", "0 handle 3 m, due 1", "1 took", "1 fault 3", "1 start D", "1 handle 3 m, due 3", "3 over, holds",
        "3 look 3 m, due 5", "3.5 idle", "4 idle", "4.5 idle", "5 fault 3", "5 idle", "5 end 300 'no path'",
        "5 handle 3 m, due never"}},
      {"TransportsToASecondSpotInSight",
       {noise(0.1, 5)},
       {{0, kNearCarry}},
       {},
       2,
       4,
       {"0 start D", "0 handle 3 m, due 1", "1 took", "1 handle 3 m, due 2", "2 over, holds", "2 end 0 ''",
        "2 handle 3 m, due never"}},
      {"TransportsAndIsCancelledAstray",
       {noise(0.1, 5)},
       {{0, kCarry}},
       {1.5},
       2,
       4,
       {"0 start D", "0 handle 3 m, due 1", "1 took", "1 fault 3", "1 start D", "1 handle 3 m, due 3", "1.5 cancel",
        "1.5 handle 3 m, due 2", "2 over, holds", "2 end 0 cancelled 'cancelled'", "2 handle 3 m, due never"}},
      {"ExploresFromWhereItHasCome",
       {noise(0.1, 5)},
       {{0, kExplore}},
       {},
       2,
       5,
       {"0 fault 3", "0 start F", "0 handle 3 m, due 2", "2 over", "2 start F", "2 handle 3 m, due 4", "4 over",
        "4 end 0 ''", "4 handle 3 m, due never"}},
      {"DiscardsWhereItHasCome",
       {noise(0.1, 5)},
       {{0, kDiscardThere}},
       {},
       2,
       5,
       {"0 fault 3", "0 start E", "0 handle 3 m, due 2", "2 over", "2 start ", "2 handle 3 m, due 4", "4 over",
        "4 end 0 ''", "4 handle 3 m, due never"}},
      {"DiscardsWhereItStands",
       {noise(0.1, 5)},
       {{0, kDiscardHere}},
       {},
       2,
       3,
       {"0 start ", "0 handle 3 m, due 2", "2 over", "2 end 0 ''", "2 handle 3 m, due never"}},
      {"SeesWhereItIsAtOnce",
       {noise(0.1, 5)},
       {{0, kNearPick}},
       {},
       2,
       5,
       {"0 start B", "0 handle 3 m, due 2", "2 over", "2 end 0 ''", "2 handle 3 m, due never"}},
      {"SearchesAndIsCancelled",
       {noise(0.1, 5)},
       {{0, kFarPick}},
       {3},
       2,
       5,
       {"0 fault 3", "0 start B", "0 handle 3 m, due 2", "2 over", "2 look 3 m, due 10", "2.5 idle", "3 idle",
        "3 look 3 m, due 3", "3.5 idle", "3.5 end 0 cancelled 'cancelled'", "3.5 handle 3 m, due never"}},
      {"SearchesAndFailsMeanwhile",
       {noise(0.1, 5), fails(0, 3, 300)},
       {{0, kFarPick}},
       {},
       2,
       5,
       {"0 fault 3", "0 start B", "0 handle 3 m, due 2", "2 over", "2 look 3 m, due 3", "2.5 idle", "3 fault 3",
        "3 idle", "3 end 300 'no path'", "3 handle 3 m, due never"}},
      {"DropsWhenASkillEnds",
       {drops(2)},
       {{0, kPick}},
       {},
       2,
       4,
       {"0 start B", "0 handle 3 m, due 2", "2 over", "2 fault 5", "2 drop", "2 end 0 ''", "2 handle 3 m, due never"}},
  };
  return all;
}

class FaultsOfSkills : public testing::TestWithParam<Case> {};

TEST_P(FaultsOfSkills, HaveTheseEffects) { EXPECT_EQ(play(GetParam()), GetParam().wanted); }

INSTANTIATE_TEST_SUITE_P(Table, FaultsOfSkills, testing::ValuesIn(cases()),
                         [](const auto& row) { return std::string(row.param.name); });

}  // namespace
}  // namespace cxlab::sim::faulty_skills_test
