// The skills with motors on a floor whose bodies follow every command exactly, or are stuck: what a skill does, when,
// and how it ends.

#include "sim/skills/physics_skills.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace cxlab::sim::physics_skills_test {
namespace {

constexpr SimTime kTick{20'000'000};
constexpr RobotId kRobot1{0}, kRobot2{1};

FloorPlan small_floor() {
  FloorPlan plan;
  plan.stations = {{"C-BS", "BS", {1.5, 4, 0}, true}, {"C-RS1", "RS", {4.5, 4, 0}, true}};
  for (std::size_t i = 0; i < plan.stations.size(); ++i)
    for (Spot& spot : spots_of(plan.stations[i], static_cast<StationId>(i))) plan.spots.push_back(std::move(spot));
  plan.robots = {{"robot1", {0, 3, 0}}, {"robot2", {-5, 6, 0}}};
  return plan;
}

class Bodies final : public WorldView, public RobotBodies {
 public:
  Bodies() : WorldView(small_floor()) {
    for (const RobotStart& robot : plan_.robots) {
      robots_.emplace_back();
      robots_.back().state.pose_in_world = robot.pose_in_world;
      robots_.back().state.finger_opening = kRobot.fingers_open;
      robots_.back().fingers = kRobot.fingers_open;
    }
  }

  RobotState robot(RobotId id) const override { return robots_[index_of(id)].state; }
  RobotState& state(RobotId id) { return robots_[index_of(id)].state; }
  bool belt_running(StationId) const override { return false; }
  const Piece* on_belt(StationId, double) const override { return nullptr; }
  const Piece* at(SpotId id) const override {
    for (const Piece& piece : pieces_)
      if (piece.holder == Holder::kBelt && (piece.position_in_world - plan_.spot(id).rest_in_world).norm() < 0.01)
        return &piece;
    return nullptr;
  }
  void command_base(RobotId id, double vx, double vy, double omega) override {
    Robot& robot = robots_[index_of(id)];
    robot.state.vx = stuck_base ? 0 : vx;
    robot.state.vy = stuck_base ? 0 : vy;
    robot.state.omega = stuck_base ? 0 : omega;
  }
  void command_gripper(RobotId id, const Vec3& axes) override { robots_[index_of(id)].axes = axes; }
  void command_fingers(RobotId id, double opening) override { robots_[index_of(id)].fingers = opening; }

  void tick() {
    now_ += kTick;
    for (Robot& robot : robots_) {
      RobotState& s = robot.state;
      if (!stuck_base) {
        const double dt = to_seconds(kTick);
        s.pose_in_world = {s.pose_in_world.x + s.vx * dt, s.pose_in_world.y + s.vy * dt,
                           wrap_angle(s.pose_in_world.yaw + s.omega * dt)};
      }
      if (!stuck_arm)
        s.gripper += (robot.axes - s.gripper).cwiseMax(Vec3::Constant(-0.002)).cwiseMin(Vec3::Constant(0.002));
      if (!stuck_fingers) s.finger_opening += std::clamp(robot.fingers - s.finger_opening, -0.001, 0.001);
      const Vec3 under = transform(s.pose_in_world, Vec3(kRobot.home_forward, 0, kRobot.home_height) + s.gripper);
      if (s.held) {
        Piece& held = piece(*s.held);
        s.finger_opening = std::max(s.finger_opening, 0.02);
        held.position_in_world = under + transform({0, 0, s.pose_in_world.yaw}, grasped_at);
        if (s.finger_opening > 0.021) {
          pass(held, lands_on, 0);
          s.held.reset();
        }
      } else if (s.finger_opening <= 0.02 && !slips) {
        for (Piece& piece : pieces_)
          if ((piece.position_in_world - under).norm() < 0.02) {
            s.held = piece.id;
            pass(piece, Holder::kGripper, 0);
          }
      }
    }
  }
  PieceId put(const Vec3& position) { return add_piece({1, {}, 0}, {StationId{0}}, position, Holder::kBelt, 0).id; }
  void take_away(PieceId id) { remove(id); }
  void fill_gripper() {
    const PieceId id = put({0, 0, 0});
    pass(piece(id), Holder::kGripper, 0);
    state(kRobot1).held = id;
    state(kRobot1).finger_opening = 0.02;
    robots_[0].fingers = kRobot.fingers_squeeze;
  }

  bool stuck_base = false, stuck_arm = false, stuck_fingers = false, slips = false;
  Holder lands_on = Holder::kBelt;
  Vec3 grasped_at = Vec3::Zero();

 private:
  struct Robot {
    RobotState state;
    Vec3 axes = Vec3::Zero();
    double fingers = 0;
  };
  std::vector<Robot> robots_;
};

/// One robot with its skills, and what they do as text.
class Floor {
 public:
  Floor() : traffic(bodies.plan()), skills(kRobot1, bodies, bodies, traffic) {}

  const Spot& spot(const char* name) const { return bodies.plan().spot(*bodies.plan().find_spot(name)); }
  SkillGoal goal(SkillKind kind, const char* name) const {
    return {kind, name, bodies.plan().find_spot(name), spot(name).align_in_world};
  }
  RobotState& robot() { return bodies.state(kRobot1); }

  std::optional<SkillResult> tick() {
    bodies.tick();
    const SimTime now = bodies.now();
    traffic.settle(now);
    if (before_sense) before_sense(to_seconds(now - begin));
    auto result = skills.sense(now);
    traffic.observe(kRobot2, bodies.robot(kRobot2).pose_in_world, now);
    traffic.plan(now);
    skills.act(now);
    return result;
  }
  /// Each phase with the second at which it begins, then the result. `at_phase` runs as a phase begins.
  std::string play(const SkillGoal& goal, double limit = 130) {
    begin = bodies.now();
    (void)skills.sense(begin);
    skills.start(goal, begin);
    traffic.plan(begin);
    skills.act(begin);
    std::string log;
    std::optional<SkillPhase> phase;
    while (to_seconds(bodies.now() - begin) < limit) {
      if (phase != skills.phase()) {
        phase = skills.phase();
        log += std::string(to_string(*phase)) + at();
        if (at_phase) at_phase(*phase);
      }
      if (const auto result = tick())
        return log + (result->cancelled ? "cancelled" : std::to_string(static_cast<int>(result->code))) + at();
    }
    return log + "no end";
  }
  std::string at() const {
    char text[32];
    std::snprintf(text, sizeof text, " %.2f ", to_seconds(bodies.now() - begin));
    return text;
  }
  void stand_at(const Pose2& pose) {
    robot().pose_in_world = pose;
    traffic.observe(kRobot1, pose, bodies.now());
  }

  Bodies bodies;
  Traffic traffic;
  PhysicsSkills skills;
  SimTime begin{};
  std::function<void(SkillPhase)> at_phase;
  std::function<void(double)> before_sense;
};

struct Case {
  const char* name;
  SkillKind kind;
  std::function<void(Floor&)> prepare;  ///< the robot stands before C-BS-OUTPUT, where a piece lies for a pick
  const char* wanted;
  const char* spot = "C-BS-OUTPUT";
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

/// As that phase begins.
void when(Floor& f, SkillPhase phase, std::function<void()> then) {
  f.at_phase = [phase, then, before = f.at_phase](SkillPhase p) {
    if (before) before(p);
    if (p == phase) then();
  };
}
/// That long after the phase begins, once.
void after(Floor& f, SkillPhase phase, double wait, std::function<void()> then) {
  auto due = std::make_shared<double>(std::numeric_limits<double>::infinity());
  when(f, phase, [&f, due, wait] { *due = to_seconds(f.bodies.now() - f.begin) + wait; });
  f.before_sense = [due, then](double now) {
    if (now < *due - 1e-9) return;
    *due = std::numeric_limits<double>::infinity();
    then();
  };
}
/// Where the robot stands in relation to the place before its spot.
void shift(Floor& f, const char* spot, double dy, double turn, double dx = 0) {
  const Pose2& place = f.spot(spot).align_in_world;
  f.stand_at({place.x + dx, place.y + dy, wrap_angle(place.yaw + turn)});
}
/// As the drive is over; the robot stays there.
void arrive_at(Floor& f, double dy, double turn, bool stuck = true) {
  f.stand_at({-2, 4, 1});
  f.before_sense = [&f, dy, turn, stuck, there = false](double) mutable {
    if (!f.traffic.arrived(kRobot1) || std::exchange(there, true)) return;
    shift(f, "C-BS-OUTPUT", dy, turn);
    f.bodies.stuck_base = stuck;
    if (stuck) f.robot().vx = f.robot().vy = 0;
  };
}
void cancel_in(Floor& f, SkillPhase phase, double wait) {
  after(f, phase, wait, [&f] { f.skills.cancel(f.bodies.now()); });
}
/// robot2 works at the spot for that long.
void occupy(Floor& f, double time_s) {
  f.traffic.request(kRobot2, f.spot("C-BS-OUTPUT").align_in_world, f.spot("C-BS-OUTPUT").footprint(), {});
  f.bodies.state(kRobot2).pose_in_world = f.spot("C-BS-OUTPUT").align_in_world;
  f.before_sense = [&f, time_s, left = false](double now) mutable {
    if (now < time_s || std::exchange(left, true)) return;
    f.traffic.withdraw(kRobot2, f.bodies.now());
    f.bodies.state(kRobot2).pose_in_world = {-5, 6, 0};
  };
}

constexpr SkillKind kPick = SkillKind::kPick, kPlace = SkillKind::kPlace, kDriveTo = SkillKind::kDriveTo,
                    kDiscard = SkillKind::kDiscard;

const std::vector<Case>& cases() {
  using enum SkillPhase;
  static const std::vector<Case> all{
      {"Pick", kPick, [](Floor&) {},
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 grip 9.92 lift 10.32 back_off 10.68 check 12.02 0 "
       "14.02 holds opening 0.020 gripper 0.000 0.000 0.057 base off 0.000"},
      {"Place", kPlace, [](Floor&) {},
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 release 10.32 back_off 10.62 check 11.96 0 13.96 "
       "empty opening 0.035 gripper 0.000 0.000 0.057 base off 0.000 piece off 0.000 0.000 0.001"},
      {"PickOfAPieceThatLiesAskew", kPick,
       [](Floor& f) {
         f.bodies.take_away(PieceId{1});
         f.bodies.put(f.spot("C-BS-OUTPUT").rest_in_world + Vec3(0.004, 0.005, 0.007));
       },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 grip 9.92 lift 10.32 back_off 10.68 check 12.06 0 "
       "14.06 holds opening 0.020 gripper 0.000 0.000 0.057 base off 0.000"},
      {"PlaceOfAPieceThatIsHeldAskew", kPlace, [](Floor& f) { f.bodies.grasped_at = {0.004, 0.006, 0.002}; },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 release 10.34 back_off 10.64 check 11.98 0 13.98 "
       "empty opening 0.035 gripper 0.000 0.000 0.057 base off 0.000 piece off 0.000 0.000 0.001"},
      {"PlaceOfAPieceThatIsHeldAskewAtTheInput", kPlace, [](Floor& f) { f.bodies.grasped_at = {0.004, 0.006, 0.002}; },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 release 10.34 back_off 10.64 check 11.98 0 13.98 "
       "empty opening 0.035 gripper 0.000 0.000 0.057 base off 0.000 piece off 0.000 0.000 0.001",
       "C-BS-INPUT"},
      {"PlaceOnASlide", kPlace, [](Floor&) {},
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 release 10.22 back_off 10.52 check 11.96 0 13.96 "
       "empty opening 0.035 gripper 0.000 0.000 0.057 base off 0.000 piece off 0.000 0.000 0.012",
       "C-RS1-SLIDE"},
      {"PickAtTheInput", kPick, [](Floor&) {},
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 grip 9.92 lift 10.32 back_off 10.68 check 12.02 0 "
       "14.02 holds opening 0.020 gripper 0.000 0.000 0.057 base off 0.000",
       "C-BS-INPUT"},
      {"PickTurnedALittle", kPick, [](Floor& f) { shift(f, "C-BS-OUTPUT", 0, 0.015); },
       "drive 0.00 align 0.26 look 0.28 approach 8.28 lower 10.12 grip 10.16 lift 10.56 back_off 10.92 check 12.26 0 "
       "14.26 holds opening 0.020 gripper 0.000 0.000 0.057 base off 0.000"},
      {"PickTurnedALittleTheOtherWay", kPick, [](Floor& f) { shift(f, "C-BS-INPUT", 0, -0.015); },
       "drive 0.00 align 0.26 look 0.28 approach 8.28 lower 10.12 grip 10.16 lift 10.56 back_off 10.92 check 12.26 0 "
       "14.26 holds opening 0.020 gripper 0.000 0.000 0.057 base off 0.000",
       "C-BS-INPUT"},
      {"PickWithAFullGripper", kPick,
       [](Floor& f) {
         f.play(f.goal(kPick, "C-BS-OUTPUT"));
         f.bodies.put(f.spot("C-BS-OUTPUT").rest_in_world);
       },
       "drive 0.00 207 0.06 holds opening 0.020 gripper 0.000 0.000 0.057 base off 0.000 piece off 0.000 0.000 0.000"},
      {"PickOfNothing", kPick, [](Floor& f) { f.bodies.take_away(PieceId{1}); },
       "drive 0.00 202 0.02 empty opening 0.035 gripper 0.000 0.000 0.052 base off 0.000"},
      {"PlaceOfNothing", kPlace,
       [](Floor& f) {
         f.robot().held.reset();
         f.bodies.take_away(PieceId{1});
       },
       "drive 0.00 208 0.02 empty opening -0.006 gripper 0.000 0.000 0.057 base off 0.000"},
      {"PlaceBesideAnother", kPlace,
       [](Floor& f) { f.bodies.put(f.spot("C-BS-OUTPUT").rest_in_world + Vec3(0.043, 0, 0)); },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 release 10.32 back_off 10.62 check 11.96 0 13.96 "
       "empty opening 0.035 gripper 0.000 0.000 0.057 base off 0.000 piece off 0.000 0.000 0.001 piece off 0.043 0.000 "
       "0.000"},
      {"PlaceOnto", kPlace, [](Floor& f) { f.bodies.put(f.spot("C-BS-OUTPUT").rest_in_world + Vec3(0.041, 0, 0)); },
       "drive 0.00 209 0.02 holds opening 0.020 gripper 0.000 0.000 0.057 base off 0.000 piece off 0.041 0.000 0.000"},
      {"PlaceUnderAnother", kPlace,
       [](Floor& f) { f.bodies.put(f.spot("C-BS-OUTPUT").rest_in_world + Vec3(0, 0, 0.043)); },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 release 10.32 back_off 10.62 check 11.96 0 13.96 "
       "empty opening 0.035 gripper 0.000 0.000 0.057 base off 0.000 piece off 0.000 0.000 0.001 piece off 0.000 0.000 "
       "0.043"},
      {"PlaceOntoOneThatLiesHigher", kPlace,
       [](Floor& f) { f.bodies.put(f.spot("C-BS-OUTPUT").rest_in_world + Vec3(0, 0, 0.041)); },
       "drive 0.00 209 0.02 holds opening 0.020 gripper 0.000 0.000 0.057 base off 0.000 piece off 0.000 0.000 0.041"},
      {"AlignStuck", kPick,
       [](Floor& f) {
         when(f, kAlign, [&f] {
           f.robot().pose_in_world.y += 0.02;
           f.bodies.stuck_base = true;
         });
       },
       "drive 0.00 align 0.02 back_off 8.04 201 9.30 empty opening 0.035 gripper 0.035 0.000 0.057 base off 0.020 "
       "piece off 0.000 0.000 0.000"},
      {"AlignNearEnough", kPick,
       [](Floor& f) {
         when(f, kAlign, [&f] {
           f.robot().pose_in_world.y += 0.011;
           f.bodies.stuck_base = true;
         });
       },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 back_off 16.06 201 17.32 empty opening 0.035 gripper 0.035 0.000 "
       "0.057 base off 0.011 piece off 0.000 0.000 0.000"},
      {"AlignTurned", kPick,
       [](Floor& f) {
         when(f, kAlign, [&f] { f.robot().pose_in_world.yaw = wrap_angle(f.robot().pose_in_world.yaw + 0.3); });
       },
       "drive 0.00 align 0.02 look 0.96 approach 8.96 lower 10.80 grip 10.84 lift 11.24 back_off 11.60 check 12.94 0 "
       "14.94 holds opening 0.020 gripper 0.000 0.000 0.057 base off 0.000"},
      {"ApproachBaseStuck", kPick, [](Floor& f) { when(f, kApproach, [&f] { f.bodies.stuck_base = true; }); },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 back_off 16.06 201 17.32 empty opening 0.035 gripper 0.035 0.000 "
       "0.057 base off 0.000 piece off 0.000 0.000 0.000"},
      {"ApproachArmStuck", kPick, [](Floor& f) { when(f, kApproach, [&f] { f.bodies.stuck_arm = true; }); },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 10.32 back_off 12.84 201 20.86 empty opening 0.035 gripper "
       "0.211 0.000 0.015 base off 0.000 piece off 0.000 0.000 0.000"},
      {"ApproachArmStuckThenFree", kPick,
       [](Floor& f) {
         when(f, kApproach, [&f] { f.bodies.stuck_arm = true; });
         when(f, kBackOff, [&f] { f.bodies.stuck_arm = false; });
       },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 10.32 back_off 12.84 206 14.24 empty opening 0.035 gripper "
       "0.021 0.000 0.057 base off 0.028 piece off 0.000 0.000 0.000"},
      {"ApproachOfAPlaceArmStuck", kPlace, [](Floor& f) { when(f, kApproach, [&f] { f.bodies.stuck_arm = true; }); },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 10.32 back_off 12.84 201 20.86 holds opening 0.020 gripper "
       "0.211 0.000 0.057 base off 0.000"},
      {"ApproachSwaying", kPick,
       [](Floor& f) {
         f.before_sense = [&f](double now) {
           if (now > 8 && now < 12) f.robot().vx = 0.04;
         };
       },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 12.00 grip 12.04 lift 12.44 back_off 12.80 check 14.22 0 "
       "16.22 holds opening 0.020 gripper 0.000 0.000 0.057 base off 0.000"},
      {"LowerStuck", kPick,
       [](Floor& f) {
         when(f, kLower, [&f] { f.bodies.stuck_arm = true; });
         when(f, kBackOff, [&f] { f.bodies.stuck_arm = false; });
       },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 back_off 12.40 206 13.74 empty opening 0.035 gripper "
       "0.035 0.000 0.057 base off 0.029 piece off 0.000 0.000 0.000"},
      {"LowerOfAPlaceStuck", kPlace,
       [](Floor& f) {
         when(f, kLower, [&f] { f.bodies.stuck_arm = true; });
         when(f, kBackOff, [&f] { f.bodies.stuck_arm = false; });
       },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 back_off 12.40 209 13.74 holds opening 0.020 gripper "
       "0.035 0.000 0.057 base off 0.029"},
      {"GripSlips", kPick, [](Floor& f) { f.bodies.slips = true; },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 grip 9.92 lift 10.32 approach 10.68 lower 10.98 grip "
       "11.02 lift 11.42 back_off 11.78 206 13.16 empty opening 0.035 gripper 0.026 0.000 0.057 base off 0.029 piece "
       "off 0.000 0.000 0.000"},
      {"GripSlipsOnce", kPick,
       [](Floor& f) {
         f.bodies.slips = true;
         after(f, kLift, 0.3, [&f] { f.bodies.slips = false; });
       },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 grip 9.92 lift 10.32 approach 10.68 lower 10.98 grip "
       "11.02 lift 11.42 back_off 11.78 check 13.16 0 15.16 holds opening 0.020 gripper 0.000 0.000 0.057 base off "
       "0.000"},
      {"GripSlipsAndThePieceIsGone", kPick,
       [](Floor& f) {
         f.bodies.slips = true;
         when(f, kLift, [&f] {
           if (!f.bodies.pieces().empty()) f.bodies.take_away(PieceId{1});
         });
       },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 grip 9.92 lift 10.32 back_off 10.68 206 12.02 empty "
       "opening 0.035 gripper 0.035 0.000 0.057 base off 0.029"},
      {"LiftStuck", kPick, [](Floor& f) { when(f, kLift, [&f] { f.bodies.stuck_arm = true; }); },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 grip 9.92 lift 10.32 back_off 18.34 201 26.36 holds "
       "opening 0.020 gripper 0.219 0.000 0.010 base off 0.162"},
      {"LiftStuckThenFree", kPick,
       [](Floor& f) {
         when(f, kLift, [&f] { f.bodies.stuck_arm = true; });
         when(f, kBackOff, [&f] { f.bodies.stuck_arm = false; });
       },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 grip 9.92 lift 10.32 back_off 18.34 check 20.04 0 "
       "22.04 holds opening 0.020 gripper 0.000 0.000 0.057 base off 0.000"},
      {"ReleaseStuck", kPlace, [](Floor& f) { when(f, kRelease, [&f] { f.bodies.stuck_fingers = true; }); },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 release 10.32 back_off 18.34 check 20.02 204 22.02 "
       "holds opening 0.020 gripper 0.000 0.000 0.057 base off 0.000"},
      {"ReleaseStuckHalfOpen", kPlace,
       [](Floor& f) { after(f, kRelease, 0.1, [&f] { f.bodies.stuck_fingers = true; }); },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 release 10.32 back_off 18.34 check 20.02 0 22.02 "
       "empty opening 0.025 gripper 0.000 0.000 0.057 base off 0.000 piece off 0.000 0.000 0.001"},
      {"ReleaseOntoTheFloor", kPlace, [](Floor& f) { f.bodies.lands_on = Holder::kFloor; },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 release 10.32 back_off 10.62 check 11.96 204 13.96 "
       "empty opening 0.035 gripper 0.000 0.000 0.057 base off 0.000 piece off 0.000 0.000 0.001"},
      {"ReleaseAndTakenOn", kPlace, [](Floor& f) { when(f, kBackOff, [&f] { f.bodies.take_away(PieceId{1}); }); },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 release 10.32 back_off 10.62 check 11.96 0 13.96 "
       "empty opening 0.035 gripper 0.000 0.000 0.057 base off 0.000"},
      {"BackOffStuck", kPick, [](Floor& f) { when(f, kBackOff, [&f] { f.bodies.stuck_base = true; }); },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 grip 9.92 lift 10.32 back_off 10.68 201 18.70 holds "
       "opening 0.020 gripper 0.000 0.000 0.057 base off 0.162"},
      {"BackOffArmStuck", kPick, [](Floor& f) { when(f, kBackOff, [&f] { f.bodies.stuck_arm = true; }); },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 grip 9.92 lift 10.32 back_off 10.68 201 18.70 holds "
       "opening 0.020 gripper 0.219 0.000 0.046 base off 0.000"},
      {"LostOnTheWayBack", kPick, [](Floor& f) { when(f, kBackOff, [&f] { f.skills.drop(f.bodies.now()); }); },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 grip 9.92 lift 10.32 back_off 10.68 check 12.02 206 "
       "14.02 empty opening 0.035 gripper 0.000 0.000 0.057 base off 0.000 piece off -0.008 0.000 0.040"},
      {"CancelledAlign", kPick, [](Floor& f) { cancel_in(f, kAlign, 0); },
       "drive 0.00 align 0.02 cancelled 0.04 empty opening 0.035 gripper 0.000 0.000 0.054 base off 0.000 piece off "
       "0.000 0.000 0.000"},
      {"CancelledLook", kPick, [](Floor& f) { cancel_in(f, kLook, 4); },
       "drive 0.00 align 0.02 look 0.04 stop 4.04 cancelled 5.30 empty opening 0.035 gripper 0.035 0.000 0.057 base "
       "off 0.000 piece off 0.000 0.000 0.000"},
      {"CancelledApproach", kPick, [](Floor& f) { cancel_in(f, kApproach, 1.5); },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 stop 9.54 cancelled 11.10 empty opening 0.035 gripper 0.005 "
       "0.000 0.057 base off 0.009 piece off 0.000 0.000 0.000"},
      {"CancelledTwice", kPick,
       [](Floor& f) {
         after(f, kApproach, 1.5, [&f] {
           f.skills.cancel(f.bodies.now());
           f.before_sense = [&f](double) { f.skills.cancel(f.bodies.now()); };
         });
       },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 stop 9.54 cancelled 11.10 empty opening 0.035 gripper 0.005 "
       "0.000 0.057 base off 0.009 piece off 0.000 0.000 0.000"},
      {"CancelledLower", kPick, [](Floor& f) { cancel_in(f, kLower, 0.04); },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 stop 9.92 cancelled 11.62 empty opening 0.035 gripper "
       "0.000 0.000 0.057 base off 0.009 piece off 0.000 0.000 0.000"},
      {"CancelledGripEarly", kPick, [](Floor& f) { cancel_in(f, kGrip, 0.18); },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 grip 9.92 stop 10.10 cancelled 11.86 empty opening "
       "0.035 gripper 0.000 0.000 0.057 base off 0.009 piece off 0.000 0.000 0.000"},
      {"CancelledGripLate", kPick, [](Floor& f) { cancel_in(f, kGrip, 0.2); },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 grip 9.92 stop 10.12 cancelled 12.18 holds opening "
       "0.020 gripper 0.000 0.000 0.057 base off 0.009"},
      {"CancelledLift", kPick, [](Floor& f) { cancel_in(f, kLift, 0.2); },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 grip 9.92 lift 10.32 stop 10.52 cancelled 12.38 holds "
       "opening 0.020 gripper 0.000 0.000 0.057 base off 0.009"},
      {"CancelledBackOff", kPick, [](Floor& f) { cancel_in(f, kBackOff, 0.2); },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 grip 9.92 lift 10.32 back_off 10.68 stop 10.88 "
       "cancelled 12.38 holds opening 0.020 gripper 0.000 0.000 0.057 base off 0.009"},
      {"CancelledCheck", kPick, [](Floor& f) { cancel_in(f, kCheck, 1); },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 grip 9.92 lift 10.32 back_off 10.68 check 12.02 "
       "cancelled 13.02 holds opening 0.020 gripper 0.000 0.000 0.057 base off 0.001"},
      {"CancelledPlaceInLower", kPlace, [](Floor& f) { cancel_in(f, kLower, 0.2); },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 stop 10.08 cancelled 11.88 holds opening 0.020 "
       "gripper 0.000 0.000 0.057 base off 0.009"},
      {"CancelledPlaceInRelease", kPlace, [](Floor& f) { cancel_in(f, kRelease, 0.04); },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 release 10.32 stop 10.36 cancelled 12.18 empty "
       "opening 0.035 gripper 0.000 0.000 0.057 base off 0.009 piece off 0.000 0.000 0.001"},
      {"CancelledAndStuck", kPick,
       [](Floor& f) {
         after(f, kApproach, 1.5, [&f] {
           f.skills.cancel(f.bodies.now());
           f.bodies.stuck_base = true;
         });
       },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 stop 9.54 cancelled 17.56 empty opening 0.035 gripper 0.000 "
       "0.000 0.057 base off 0.148 piece off 0.000 0.000 0.000"},
      {"CancelledWithTheArmStuck", kPick,
       [](Floor& f) {
         after(f, kApproach, 1.5, [&f] {
           f.skills.cancel(f.bodies.now());
           f.bodies.stuck_arm = true;
         });
       },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 stop 9.54 cancelled 17.56 empty opening 0.035 gripper 0.211 "
       "0.000 0.015 base off 0.000 piece off 0.000 0.000 0.000"},
      {"Discard", kDiscard, [](Floor& f) { f.bodies.lands_on = Holder::kFloor; },
       "drive 0.00 approach 1.96 release 4.34 back_off 4.64 check 6.20 0 8.20 empty opening 0.035 gripper "
       "0.000 0.000 0.057 base off 0.000 piece off -0.330 -0.328 0.047"},
      {"DiscardOnFreeFloor", kDiscard,
       [](Floor& f) {
         f.bodies.lands_on = Holder::kFloor;
         f.stand_at({-2, 4, 1});
       },
       "drive 0.00 approach 0.02 release 2.40 back_off 2.70 check 4.26 0 6.26 empty opening 0.035 gripper "
       "0.000 0.000 0.057 base off 2.825 piece off -3.140 0.344 0.047"},
      {"DiscardOfNothing", kDiscard,
       [](Floor& f) {
         f.robot().held.reset();
         f.bodies.take_away(PieceId{1});
       },
       "drive 0.00 208 1.96 empty opening -0.010 gripper 0.000 0.000 0.057 base off 0.000"},
      {"DiscardWithTheFingersStuck", kDiscard, [](Floor& f) { f.bodies.stuck_fingers = true; },
       "drive 0.00 approach 1.96 release 4.34 back_off 12.36 check 13.92 204 15.92 holds opening 0.020 "
       "gripper 0.000 0.000 0.057 base off 0.000"},
      {"DiscardWithTheArmStuck", kDiscard, [](Floor& f) { f.bodies.stuck_arm = true; },
       "drive 0.00 approach 1.96 back_off 9.98 201 10.00 holds opening 0.020 gripper 0.000 0.000 0.057 base "
       "off 0.000"},
      {"DiscardThatIsCancelled", kDiscard, [](Floor& f) { cancel_in(f, kApproach, 1.5); },
       "drive 0.00 approach 1.96 stop 3.46 cancelled 4.12 holds opening 0.020 gripper 0.034 0.000 0.057 base"
       " off 0.000"},
      {"DiscardThatIsCancelledTooLate", kDiscard, [](Floor& f) { cancel_in(f, kRelease, 0.04); },
       "drive 0.00 approach 1.96 release 4.34 stop 4.38 cancelled 5.94 empty opening 0.035 gripper 0.034 "
       "0.000 0.057 base off 0.000 piece off -0.330 -0.328 0.047"},
      {"Drive", kDriveTo, [](Floor& f) { f.stand_at({-2, 4, 1}); },
       "drive 0.00 0 7.02 empty opening 0.035 gripper 0.000 0.000 0.057 base off 0.009"},
      {"DriveThatIsCancelled", kDriveTo,
       [](Floor& f) {
         f.stand_at({-2, 4, 1});
         after(f, kDrive, 2, [&f] { f.skills.cancel(f.bodies.now()); });
       },
       "drive 0.00 stop 2.00 cancelled 2.58 empty opening 0.035 gripper 0.000 0.000 0.057 base off 2.075"},
      {"DriveThatEndsBeside", kDriveTo, [](Floor& f) { arrive_at(f, 0.059, 0); },
       "drive 0.00 0 8.16 empty opening 0.035 gripper 0.000 0.000 0.057 base off 0.059"},
      {"DriveThatEndsTooFarBeside", kDriveTo, [](Floor& f) { arrive_at(f, 0.061, 0); },
       "drive 0.00 201 8.16 empty opening 0.035 gripper 0.000 0.000 0.057 base off 0.061"},
      {"DriveThatEndsTurned", kDriveTo, [](Floor& f) { arrive_at(f, 0, 0.099); },
       "drive 0.00 0 8.16 empty opening 0.035 gripper 0.000 0.000 0.057 base off 0.000"},
      {"DriveThatEndsMoving", kDriveTo,
       [](Floor& f) {
         f.stand_at({-2, 4, 1});
         f.before_sense = [&f](double now) {
           if (f.traffic.arrived(kRobot1) && now < 7.9) f.robot().vy = 0.04;
         };
       },
       "drive 0.00 0 7.90 empty opening 0.035 gripper 0.000 0.000 0.057 base off 0.001"},
      {"DriveThatIsBlocked", kDriveTo,
       [](Floor& f) {
         occupy(f, 1000);
         f.stand_at({-2, 4, 1});
       },
       "drive 0.00 wait 0.42 drive 0.44 wait 6.12 201 95.02 empty opening 0.035 gripper 0.000 0.000 0.057 base off "
       "0.725"},
      {"PickAfterALongWait", kPick,
       [](Floor& f) {
         occupy(f, 90);
         f.stand_at({-2, 4, 1});
         when(f, kApproach, [&f] {
           f.robot().pose_in_world.y += 0.1;
           f.bodies.stuck_base = true;
         });
       },
       "drive 0.00 wait 0.42 drive 0.44 wait 6.12 drive 90.02 align 92.46 look 92.74 approach 100.74 back_off 108.76 "
       "201 115.02 empty opening 0.035 gripper 0.000 0.000 0.057 base off 0.100 piece off 0.000 0.000 0.000"},
      {"PickThatIsCancelledLate", kPick,
       [](Floor& f) {
         occupy(f, 90);
         f.stand_at({-2, 4, 1});
         when(f, kApproach, [&f] {
           f.robot().pose_in_world.y += 0.1;
           f.bodies.stuck_base = true;
         });
         f.before_sense = [&f, before = f.before_sense](double now) {
           before(now);
           if (now > 113.99) f.skills.cancel(f.bodies.now());
         };
       },
       "drive 0.00 wait 0.42 drive 0.44 wait 6.12 drive 90.02 align 92.46 look 92.74 approach 100.74 back_off 108.76 "
       "stop 114.00 cancelled 122.02 empty opening 0.035 gripper 0.000 0.000 0.057 base off 0.100 piece off 0.000 "
       "0.000 0.000"},
      {"PickTurnedMore", kPick, [](Floor& f) { shift(f, "C-BS-OUTPUT", 0, 0.025); },
       "drive 0.00 align 0.30 look 0.32 approach 8.32 lower 10.16 grip 10.20 lift 10.60 back_off 10.96 check 12.30 0 "
       "14.30 holds opening 0.020 gripper 0.000 0.000 0.057 base off 0.000"},
      {"PickTurnedAtTheInput", kPick, [](Floor& f) { shift(f, "C-BS-INPUT", 0, 0.015); },
       "drive 0.00 align 0.26 look 0.28 approach 8.28 lower 10.12 grip 10.16 lift 10.56 back_off 10.92 check 12.26 0 "
       "14.26 holds opening 0.020 gripper 0.000 0.000 0.057 base off 0.000",
       "C-BS-INPUT"},
      {"PickFarFromTheLine", kPick, [](Floor& f) { shift(f, "C-BS-OUTPUT", 0.08, 0); },
       "drive 0.00 align 0.80 look 0.82 approach 8.82 lower 10.66 grip 10.70 lift 11.10 back_off 11.46 check 12.80 0 "
       "14.80 holds opening 0.020 gripper 0.000 0.000 0.057 base off 0.000"},
      {"ArmStuck", kPick, [](Floor& f) { f.bodies.stuck_arm = true; },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 back_off 16.06 201 17.48 empty opening 0.035 gripper 0.000 0.000 "
       "0.000 base off 0.028 piece off 0.000 0.000 0.000"},
      {"ArmOfAPlaceStuck", kPlace, [](Floor& f) { f.bodies.stuck_arm = true; },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 back_off 16.06 201 17.48 holds opening 0.020 gripper 0.000 0.000 "
       "0.057 base off 0.028"},
      {"ApproachBaseStuckOnTheWay", kPick,
       [](Floor& f) {
         after(f, kApproach, 0.5, [&f] { f.bodies.stuck_base = true; });
         when(f, kBackOff, [&f] { f.bodies.stuck_base = false; });
       },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 back_off 16.06 201 17.32 empty opening 0.035 gripper 0.035 0.000 "
       "0.057 base off 0.001 piece off 0.000 0.000 0.000"},
      {"ReleaseStuckOpenEnough", kPlace,
       [](Floor& f) { after(f, kRelease, 0.2, [&f] { f.bodies.stuck_fingers = true; }); },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 lower 9.88 release 10.32 back_off 10.62 check 11.96 0 13.96 "
       "empty opening 0.030 gripper 0.000 0.000 0.057 base off 0.000 piece off 0.000 0.000 0.001"},
      {"DriveThatEndsNear", kDriveTo, [](Floor& f) { arrive_at(f, 0.029, 0); },
       "drive 0.00 0 6.66 empty opening 0.035 gripper 0.000 0.000 0.057 base off 0.029"},
      {"DriveThatEndsTurnedALittle", kDriveTo, [](Floor& f) { arrive_at(f, 0, 0.049); },
       "drive 0.00 0 6.66 empty opening 0.035 gripper 0.000 0.000 0.057 base off 0.000"},
      {"DriveThatEndsTurnedTooFar", kDriveTo, [](Floor& f) { arrive_at(f, 0, 0.101); },
       "drive 0.00 201 8.16 empty opening 0.035 gripper 0.000 0.000 0.057 base off 0.000"},
      {"DriveThatIsPushedAtItsEnd", kDriveTo, [](Floor& f) { arrive_at(f, 0.1, 0, false); },
       "drive 0.00 0 7.74 empty opening 0.035 gripper 0.000 0.000 0.057 base off 0.009"},
      {"AlignTurnedThroughTheHalfCircle", kPick,
       [](Floor& f) {
         when(f, kAlign, [&f] {
           f.robot().pose_in_world.yaw = wrap_angle(f.robot().pose_in_world.yaw + 0.01);
           f.bodies.stuck_base = true;
         });
       },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 back_off 16.06 201 17.32 empty opening 0.035 gripper 0.035 0.000 "
       "0.057 base off 0.000 piece off 0.000 0.000 0.000",
       "C-BS-INPUT"},
      {"AlignTurnedBackThroughTheHalfCircle", kPick,
       [](Floor& f) {
         when(f, kAlign, [&f] {
           f.robot().pose_in_world.yaw = wrap_angle(f.robot().pose_in_world.yaw - 0.01);
           f.bodies.stuck_base = true;
         });
       },
       "drive 0.00 align 0.02 look 0.04 approach 8.04 back_off 16.06 201 17.32 empty opening 0.035 gripper 0.035 0.000 "
       "0.057 base off 0.000 piece off 0.000 0.000 0.000",
       "C-BS-INPUT"},
  };
  return all;
}

class SkillOfBodies : public testing::TestWithParam<Case> {};

TEST_P(SkillOfBodies, PassesThroughItsPhasesAndEnds) {
  const Case& c = GetParam();
  Floor f;
  f.stand_at(f.spot(c.spot).align_in_world);
  if (c.kind != kDriveTo) f.bodies.put(f.spot(c.spot).rest_in_world);
  if (c.kind == kPlace || c.kind == kDiscard) {
    f.play(f.goal(kPick, c.spot));
    f.stand_at(f.spot(c.spot).align_in_world);
  }
  c.prepare(f);
  SkillGoal goal = f.goal(c.kind, c.spot);
  if (c.kind == kDiscard) goal.target.clear();
  std::string log = f.play(goal);
  for (int i = 0; i < 25; ++i) EXPECT_FALSE(f.tick());
  char text[160];
  const RobotState& robot = f.robot();
  std::snprintf(text, sizeof text, "%s opening %.3f gripper %.3f %.3f %.3f base off %.3f",
                robot.held ? "holds" : "empty", robot.finger_opening, robot.gripper.x(), robot.gripper.y(),
                robot.gripper.z(), distance(robot.pose_in_world.position(), f.spot(c.spot).align_in_world.position()));
  log += text;
  for (const Piece& piece : f.bodies.pieces()) {
    const Vec3 off = piece.position_in_world - f.spot(c.spot).rest_in_world;
    std::snprintf(text, sizeof text, " piece off %.3f %.3f %.3f", off.x(), off.y(), off.z());
    if (piece.holder != Holder::kGripper) log += text;
  }
  for (std::size_t i = log.find("-0.000"); i != std::string::npos; i = log.find("-0.000")) log.erase(i, 1);
  EXPECT_EQ(log, c.wanted);
}

/// What pushes the robot aside would let it drive back while its fingers or its arm work.
TEST(PhysicsSkills, TheBaseStandsWhileArmOrFingersWorkAtAPiece) {
  using enum SkillPhase;
  for (const SkillKind kind : {kPick, kPlace, kDiscard}) {
    Floor f;
    const char* spot = "C-BS-OUTPUT";
    f.stand_at(f.spot(spot).align_in_world);
    f.bodies.put(f.spot(spot).rest_in_world);
    if (kind != kPick) f.play(f.goal(kPick, spot));
    SkillGoal goal = f.goal(kind, spot);
    if (kind == kDiscard) goal.target.clear();
    std::vector<SkillPhase> stood;
    SkillPhase last = kDrive;
    Pose2 before, at_work;
    double began = 0;
    f.before_sense = [&](double now) {
      const SkillPhase phase = f.skills.phase();
      Pose2& here = f.robot().pose_in_world;
      if (phase == kApproach) {
        if (last != kApproach) began = now;
        // Where it works it is pushed on and on, less than would be too far.
        if (kind != kDiscard)
          at_work = f.spot(spot).work_in_world;
        else if (now < began + 1.5)
          at_work = here;
        if (now >= began + 1.5 && distance(here.position(), at_work.position()) < 0.008)
          here = {at_work.x, at_work.y + 0.006, at_work.yaw};
      }
      if (phase == last && (phase == kLower || phase == kGrip || phase == kLift || phase == kRelease)) {
        EXPECT_EQ(here.y, before.y) << to_string(phase) << " at " << now;
        if (stood.empty() || stood.back() != phase) stood.push_back(phase);
      }
      before = here;
      last = phase;
    };
    f.play(goal);
    const auto phases = kind == kPick    ? std::vector{kLower, kGrip, kLift}
                        : kind == kPlace ? std::vector{kLower, kRelease}
                                         : std::vector{kRelease};
    EXPECT_EQ(stood, phases);
  }
}

INSTANTIATE_TEST_SUITE_P(Table, SkillOfBodies, testing::ValuesIn(cases()),
                         [](const auto& row) { return std::string(row.param.name); });

}  // namespace
}  // namespace cxlab::sim::physics_skills_test
