#include "scenarios/rcll/rules/maintenance.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scenarios/rcll/rules/layout.h"

namespace cxlab::rcll {
namespace {

constexpr std::int64_t kSecondMaintenancePoints = -5;
constexpr SimTime kRetry = std::chrono::milliseconds(500);
constexpr double kOutsideY = -0.6;                      ///< m: where robots stand that people have taken away
constexpr double kEntryGap = 0.75;                      ///< m between centres: who comes by can still brake
constexpr double kTouch = 2 * sim::kRobot.hull_radius;  ///< m between the centres of two robots
constexpr double kAtSpot = 0.1;                         ///< m from where a robot works
constexpr double kWaitingRange = 1.5;                   ///< m from the spot that a robot waits for
constexpr double kStands = 0.05;                        ///< m/s

sim::Vec2 velocity_of(const sim::RobotState& state) { return {state.vx, state.vy}; }
bool stands(const sim::RobotState& state) { return velocity_of(state).norm() < kStands; }

/// The distance from a point to the nearest spot of that team's machines.
double distance_to_spots(const sim::FloorPlan& plan, Team team, const sim::Vec2& p) {
  double nearest = 1e9;
  for (const sim::Spot& spot : plan.spots)
    if (team_of(plan.station(spot.station)) == team) nearest = std::min(nearest, sim::distance(p, spot.footprint()));
  return nearest;
}

}  // namespace

Maintenance::Maintenance(sim::World& world, GameReferee& referee, SimTime repair, EventLog& events, RecordSink& sink)
    : world_(world), referee_(referee), repair_(repair), events_(events), sink_(sink) {
  std::array<int, 2> numbers{};
  for (std::size_t i = 0; i < world.plan().robots.size(); ++i) {
    Robot& robot = robots_.emplace_back();
    robot.id = static_cast<sim::RobotId>(i);
    robot.team = team_of(world.plan().robots[i]);
    robot.number = ++numbers[static_cast<std::size_t>(robot.team)];
  }
}

void Maintenance::take(std::span<const sim::Fault> faults, std::uint64_t seed) {
  for (const sim::Fault& fault : faults) {
    if (fault.kind != sim::FaultKind::kRobotMaintenance) continue;
    for (std::size_t i = 0; i < robots_.size(); ++i)
      if (const std::string& name = world_.plan().robots[i].name; fault.robot.empty() || fault.robot == name)
        faults_.push_back({sim::FaultTimer(fault, seed, name), i});
  }
}

void Maintenance::request(Team team, const std::string& color, int number, bool maintenance, SimTime now) {
  requests_.push_back({team, color, number, maintenance, now});
}

SimTime Maintenance::remaining(const Robot& robot, SimTime now) const {
  if (robot.duty != RobotDuty::kMaintenance) return {};
  return std::max(SimTime{}, robot.since + kMaintenanceTime - now);
}

// --- Records

DutyChanged Maintenance::change_of(const Robot& robot, std::string_view state) const {
  DutyChanged change;
  change.state = state;
  change.team = robot.team;
  change.robot = world_.plan().robot(robot.id).name;
  return change;
}

// --- Deciding

void Maintenance::judge(SimTime now) {
  for (const Request& request : std::exchange(requests_, {})) grant(request, now);
  if (referee_.clock().phase(now) != Phase::kProduction) return;
  for (Fault& fault : faults_) {
    Robot& robot = robots_[fault.robot];
    if (robot.duty != RobotDuty::kActive || now < fault.timer.due()) continue;
    fault.timer.struck(now);
    const sim::Fault& what = fault.timer.fault();
    sim::begin_strike(data_, what).field("robot", world_.plan().robot(robot.id).name);
    sink_.write(sink_.open_stream("faults"), now, RecordKind::kControl, data_);
    begin(robot, MaintenanceCause::kFault, what.duration, now);
  }
  for (Robot& robot : robots_) watch(robot, now);
  for (Robot& robot : robots_) robot.velocity = velocity_of(world_.robot(robot.id));
}

void Maintenance::grant(const Request& request, SimTime now) {
  const auto refuse = [&](std::string_view reason) {
    DutyChanged refused;
    refused.state = "refused";
    refused.team = request.team;
    refused.number = request.number;
    refused.reason = reason;
    events_.write(now, std::move(refused));
  };
  const auto robot = std::ranges::find_if(
      robots_, [&](const Robot& r) { return r.team == request.team && r.number == request.number; });
  if (request.color != to_string(request.team)) return refuse("not the team's own robot");
  if (robot == robots_.end()) return refuse("no such robot");
  if (referee_.clock().phase(now) != Phase::kProduction) return refuse("not in production");
  if (robot->duty == RobotDuty::kDisqualified) return refuse("disqualified");
  const bool active = robot->duty == RobotDuty::kActive;
  if (request.maintenance != active) return refuse(active ? "not in maintenance" : "in maintenance");
  if (active) return begin(*robot, MaintenanceCause::kRequest, repair_, now);
  robot->asked_back = true;
}

void Maintenance::begin(Robot& robot, MaintenanceCause cause, SimTime needs, SimTime now) {
  robot.blocking_since = kNever;
  if (robot.cycles == kMaintenances) return disqualify(robot, to_string(cause), now);
  ++robot.cycles;
  ++changes_;
  robot.duty = RobotDuty::kMaintenance;
  robot.since = now;
  robot.needs = std::max(needs, kShortestMaintenance);
  robot.asked_for = cause == MaintenanceCause::kRequest;
  robot.asked_back = robot.warned = false;
  DutyChanged change = change_of(robot, "begin");
  change.cause = to_string(cause);
  change.cycle = robot.cycles;
  events_.write(now, std::move(change));
  if (robot.cycles == kMaintenances) referee_.fine(robot.team, kSecondMaintenancePoints, now);
}

void Maintenance::disqualify(Robot& robot, std::string_view reason, SimTime now) {
  ++changes_;
  robot.duty = RobotDuty::kDisqualified;
  DutyChanged change = change_of(robot, "disqualified");
  change.cause = reason;
  events_.write(now, std::move(change));
}

void Maintenance::watch(Robot& robot, SimTime now) {
  if (robot.duty == RobotDuty::kActive) {
    if (outside(robot)) return begin(robot, MaintenanceCause::kOutside, repair_, now);
    if (pushes(robot)) return begin(robot, MaintenanceCause::kPushing, repair_, now);
    robot.blocking_since = blocks(robot) ? std::min(robot.blocking_since, now) : kNever;
    if (robot.blocking_since != kNever && now - robot.blocking_since > kBlockingTime)
      begin(robot, MaintenanceCause::kBlocking, repair_, now);
  } else if (robot.duty == RobotDuty::kMaintenance && !wants_back(robot, now)) {
    if (now - robot.since >= kMaintenanceTime + kMaintenanceGrace) return disqualify(robot, "time", now);
    if (robot.warned || now - robot.since < kMaintenanceWarning) return;
    robot.warned = true;
    DutyChanged change = change_of(robot, "warning");
    change.remaining_s = to_seconds(remaining(robot, now));
    events_.write(now, std::move(change));
  }
}

SimTime Maintenance::back_at(const Robot& robot) const {
  return robot.asked_for && !robot.asked_back ? kNever : robot.since + robot.needs;
}

bool Maintenance::wants_back(const Robot& robot, SimTime now) const { return now >= back_at(robot); }

/// The base is fully outside of the field, whose corners are ends of walls.
bool Maintenance::outside(const Robot& robot) const {
  const sim::FloorPlan& plan = world_.plan();
  const sim::Pose2 at = world_.robot(robot.id).pose_in_world;
  constexpr double kRadius = sim::kRobot.hull_radius;
  return at.x < plan.min_x - kRadius || at.x > plan.max_x + kRadius || at.y < plan.min_y - kRadius ||
         at.y > plan.max_y + kRadius;
}

/// It stands where an opponent would work at its own machine, at none of its own team, and an opponent stands nearby
/// that is at no machine of its own.
bool Maintenance::blocks(const Robot& robot) const {
  const sim::FloorPlan& plan = world_.plan();
  for (const Robot& rival : robots_) {
    if (rival.team == robot.team || world_.is_off_field(rival.id)) continue;
    const sim::RobotState mine = world_.robot(robot.id), waiting = world_.robot(rival.id);
    const sim::Vec2 here = mine.pose_in_world.position(), there = waiting.pose_in_world.position();
    if (!stands(mine) || !stands(waiting) || sim::distance(here, there) > kWaitingRange + kTouch) continue;
    if (distance_to_spots(plan, rival.team, there) < kAtSpot) continue;
    const double to_own = distance_to_spots(plan, robot.team, here);
    for (const sim::Spot& spot : plan.spots)
      if (const sim::Segment place = spot.footprint(); team_of(plan.station(spot.station)) == rival.team &&
                                                       sim::distance(here, place) < std::min(kTouch, to_own) &&
                                                       sim::distance(there, place) < kWaitingRange)
        return true;
  }
  return false;
}

/// It touches another robot and drives towards it, or did so until the impact.
bool Maintenance::pushes(const Robot& robot) const {
  const sim::RobotState mine = world_.robot(robot.id);
  if (mine.touching == 0) return false;
  for (const Robot& other : robots_) {
    if ((mine.touching >> index_of(other.id) & 1) == 0) continue;
    const sim::Vec2 way = world_.robot(other.id).pose_in_world.position() - mine.pose_in_world.position();
    if (std::max(robot.velocity.dot(way), velocity_of(mine).dot(way)) >= kStands * way.norm()) return true;
  }
  return false;
}

// --- Carrying

void Maintenance::act(SimTime now) {
  retry_at_ = kNever;
  for (Robot& robot : robots_) {
    if (robot.duty == RobotDuty::kActive) continue;
    if (!world_.is_off_field(robot.id)) {
      const sim::Pose2& start = world_.plan().robot(robot.id).pose_in_world;
      world_.take_off_field(robot.id, {start.x, kOutsideY, start.yaw});
    }
    if (robot.duty != RobotDuty::kMaintenance || !wants_back(robot, now)) continue;
    if (const auto place = free_place(robot)) {
      world_.bring_back(robot.id, *place);
      for (Fault& fault : faults_)
        if (robots_[fault.robot].id == robot.id) fault.timer.skip_until(now);
      robot.duty = RobotDuty::kActive;
      ++changes_;
      DutyChanged change = change_of(robot, "end");
      change.duration_s = to_seconds(now - robot.since);
      events_.write(now, std::move(change));
    } else {
      retry_at_ = now + kRetry;
    }
  }
}

/// In the insertion area: where it started, else where another robot of its team did.
std::optional<sim::Pose2> Maintenance::free_place(const Robot& robot) const {
  const auto free = [&](const sim::Pose2& place) {
    return std::ranges::all_of(robots_, [&](const Robot& other) {
      return other.id == robot.id || world_.is_off_field(other.id) ||
             sim::distance(world_.robot(other.id).pose_in_world.position(), place.position()) >= kEntryGap;
    });
  };
  const sim::Pose2& own = world_.plan().robot(robot.id).pose_in_world;
  if (free(own)) return own;
  for (const Robot& other : robots_)
    if (const sim::Pose2& place = world_.plan().robot(other.id).pose_in_world; other.team == robot.team && free(place))
      return place;
  return std::nullopt;
}

SimTime Maintenance::next_due() const {
  if (!requests_.empty()) return requests_.front().at;
  if (referee_.phase() != Phase::kProduction) return kNever;
  SimTime due = retry_at_;
  for (const Fault& fault : faults_)
    if (robots_[fault.robot].duty == RobotDuty::kActive) due = std::min(due, fault.timer.due());
  for (const Robot& robot : robots_) {
    if (robot.duty == RobotDuty::kActive && robot.blocking_since != kNever)
      due = std::min(due, robot.blocking_since + kBlockingTime + SimTime{1});
    if (robot.duty != RobotDuty::kMaintenance) continue;
    const SimTime limit = robot.warned ? kMaintenanceTime + kMaintenanceGrace : kMaintenanceWarning;
    if (robot.since + limit < back_at(robot)) due = std::min(due, robot.since + limit);
    if (retry_at_ == kNever) due = std::min(due, back_at(robot));
  }
  return due;
}

}  // namespace cxlab::rcll
