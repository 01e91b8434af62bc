#include "sim/traffic/traffic.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace cxlab::sim {
namespace {

constexpr double kGap = 0.51;        ///< m between centres: a way keeps it from robots that stand; hulls touch at 0.45
constexpr double kMovingGap = 0.50;  ///< between motions, also when one is up to kTimeMargin early or late
constexpr double kStopGap = 0.47;    ///< below this a motion is broken off
constexpr double kPlaceGap = 0.58;   ///< of a place to wait from ways and other robots
constexpr SimTime kTimeMargin{300'000'000};
constexpr SimTime kSample{100'000'000};
constexpr SimTime kDelayStep{200'000'000};
constexpr SimTime kWorthADetour{1'000'000'000};
constexpr SimTime kGrace{1'000'000'000};  ///< a robot that ended a skill is not sent away for so long
constexpr SimTime kRetry{2'000'000'000};
constexpr SimTime kYieldFor{20'000'000'000};
constexpr double kReachOfASample = 0.25;  ///< m: further than a robot drives within kTimeMargin
constexpr double kOffTrack = 0.15;        ///< m: the motion is given up
constexpr double kWorthQueueing = 1.0;    ///< m that driving nearer must save
constexpr double kQueueRange = 2.5;       ///< m around a goal for places to wait
constexpr double kGoalClearance = 0.23;   ///< m: a robot's radius; nobody is sent nearer to fixed things

/// Where a standing robot is.
Segment footprint_at(const Pose2& pose) { return {pose.position(), pose.position()}; }

double distance_to_way(const Vec2& p, std::span<const Vec2> way) {
  double nearest = distance(p, way.front());
  for (std::size_t i = 1; i < way.size(); ++i) nearest = std::min(nearest, distance(p, Segment{way[i - 1], way[i]}));
  return nearest;
}

}  // namespace

Traffic::Traffic(const FloorPlan& plan, const DriveLimits& limits)
    : map_(plan), limits_(limits), robots_(plan.robots.size()) {
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    robots_[i].pose = plan.robots[i].pose_in_world;
    robots_[i].rest = footprint_at(robots_[i].pose);
  }
  for (const Spot& spot : plan.spots) workplaces_.push_back(spot.footprint());
}

// --- Wishes

void Traffic::request(RobotId id, const Pose2& goal, std::optional<Segment> work, SimTime now) {
  Robot& robot = at(id);
  if (robot.moving && robot.purpose != Purpose::kYield) brake(index_of(id), now);
  if (robot.working) robot.rest = footprint_at(robot.pose);
  robot.wants = true;
  robot.working = robot.arrived = robot.unreachable = false;
  robot.goal = goal;
  robot.work = work;
  robot.order = ++last_order_;
  changed_ = true;
}

void Traffic::withdraw(RobotId id, SimTime now) {
  Robot& robot = at(id);
  if (robot.working) robot.rest = footprint_at(robot.pose);
  robot.wants = robot.working = robot.arrived = robot.unreachable = false;
  robot.idle_since = now;
  if (robot.moving && (robot.purpose == Purpose::kGoal || robot.purpose == Purpose::kQueue)) brake(index_of(id), now);
  changed_ = true;
}

void Traffic::observe(RobotId id, const Pose2& pose, SimTime now) {
  Robot& robot = at(id);
  robot.pose = pose;
  if (!robot.moving) {
    if (!robot.working) robot.rest = footprint_at(pose);
  } else if (robot.purpose != Purpose::kBrake && distance(pose.position(), robot.motion.point_at(now)) > kOffTrack) {
    brake(index_of(id), now);
  }
}

void Traffic::set_speed(RobotId id, double share, SimTime now) {
  Robot& robot = at(id);
  const bool other = share != robot.speed;
  robot.speed = share;
  if (other && robot.moving && robot.purpose != Purpose::kBrake) brake(index_of(id), now);
  changed_ = true;
}

void Traffic::halted(RobotId id, const Pose2& pose, SimTime now) {
  Robot& robot = at(id);
  if (!robot.moving) return;
  robot.moving = false;
  robot.pose = pose;
  robot.rest = footprint_at(pose);
  robot.idle_since = now;
  changed_ = true;
}

void Traffic::set_down(RobotId id, const Pose2& pose, SimTime now) {
  Robot& robot = at(id);
  robot.pose = pose;
  robot.rest = footprint_at(pose);
  robot.wants = robot.working = robot.moving = robot.arrived = robot.unreachable = false;
  robot.idle_since = now;
  robot.yields_to.reset();
  changed_ = true;
  brake_others(index_of(id), now);
}

double Traffic::remaining(RobotId id, SimTime now) const {
  const Robot& robot = at(id);
  if (!robot.wants) return 0;
  if (robot.moving && robot.purpose == Purpose::kGoal) {
    double length = 0;
    Vec2 last = robot.motion.point_at(now);
    for (SimTime t = now; t < robot.motion.end(); t += kSample) {
      const Vec2 next = robot.motion.point_at(t + kSample);
      length += distance(last, next);
      last = next;
    }
    return length;
  }
  return distance(robot.pose.position(), robot.goal.position());
}

std::optional<Vec2> Traffic::standing_place(const Vec2& centre, double radius) const {
  constexpr double kStep = 0.05;
  std::optional<Vec2> best;
  const int n = static_cast<int>(radius / kStep);
  for (int r = -n; r <= n; ++r)
    for (int c = -n; c <= n; ++c) {
      const Vec2 p = centre + kStep * Vec2(c, r);
      if (distance(p, centre) > radius || map_.clearance(p) < FloorMap::kClearance) continue;
      if (!best || distance(p, centre) < distance(*best, centre) - 1e-9) best = p;
    }
  return best;
}

// --- Planning

Segment Traffic::footprint_at_goal(const Robot& robot) const {
  return robot.work ? *robot.work : footprint_at(robot.goal);
}

DriveLimits Traffic::limits_of(const Robot& robot) const {
  DriveLimits limits = limits_;
  const double speed = robot.speed / robot.stretch, change = 1 / (robot.stretch * robot.stretch);
  limits.speed *= speed;
  limits.turn *= speed;
  limits.speed_up *= change;
  limits.slow_down *= change;
  limits.sideways *= change;
  limits.turn_up *= change;
  return limits;
}

bool Traffic::movable(const Robot& robot, SimTime now) const {
  return !robot.moving && !robot.working && robot.speed > 0 && (robot.wants || now - robot.idle_since >= kGrace);
}

template <class Only>
std::vector<Keepout> Traffic::rests(std::size_t except, Only only) const {
  std::vector<Keepout> keepouts;
  for (std::size_t i = 0; i < robots_.size(); ++i)
    if (i != except && only(i)) keepouts.push_back({robots_[i].rest, kGap});
  return keepouts;
}

template <class Only>
std::optional<RobotId> Traffic::first_on(std::span<const Vec2> way, std::size_t except, Only only) const {
  std::optional<RobotId> found;
  double nearest = std::numeric_limits<double>::infinity();
  for (const Vec2& p : way)
    for (std::size_t i = 0; i < robots_.size(); ++i) {
      if (i == except || !only(i)) continue;
      if (const double apart = distance(p, robots_[i].rest); apart < nearest) {
        nearest = apart;
        found = static_cast<RobotId>(i);
      }
      if (nearest < kGap) return found;
    }
  return found;
}

std::vector<Keepout> Traffic::rests(std::size_t except) const {
  return rests(except, [](std::size_t) { return true; });
}

void Traffic::stand(std::size_t index, SimTime now) {
  Robot& robot = robots_[index];
  robot.moving = false;
  changed_ = true;
  if (robot.purpose == Purpose::kGoal && robot.wants) {
    robot.wants = false;
    robot.arrived = true;
    robot.working = robot.work.has_value();
  }
  robot.pose = robot.motion.last();
  if (!robot.working) robot.rest = footprint_at(robot.pose);
  robot.idle_since = now;
}

SimTime Traffic::next_due() const {
  SimTime next = kNever;
  bool wanted = false;
  for (const Robot& robot : robots_) {
    if (robot.moving) next = std::min(next, robot.motion.end());
    wanted = wanted || robot.wants;
  }
  return wanted ? std::min(next, retry_at_) : next;
}

void Traffic::settle(SimTime now) {
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    const Robot& robot = robots_[i];
    if (robot.moving && robot.motion.end() <= now) stand(i, now);
  }
}

void Traffic::plan(SimTime now) {
  if (!changed_ && now < retry_at_) return;
  std::vector<std::size_t> wanting;
  for (std::size_t i = 0; i < robots_.size(); ++i)
    if (robots_[i].wants) wanting.push_back(i);
  std::ranges::sort(wanting, {}, [&](std::size_t i) { return robots_[i].order; });
  changed_ = false;
  retry_at_ = now + kRetry;
  for (const Robot& robot : robots_)
    if (!robot.moving && !robot.working && !robot.wants && robot.idle_since + kGrace > now)
      retry_at_ = std::min(retry_at_, robot.idle_since + kGrace);
  for (const std::size_t i : wanting) attempt(i, now);
}

void Traffic::attempt(std::size_t index, SimTime now) {
  Robot& robot = robots_[index];
  if (!robot.moving) robot.blocked_by.reset();
  if (!robot.wants || robot.unreachable || robot.speed == 0) return;
  const auto conflicts = [&](std::size_t other) {
    return other != index && distance(robots_[other].rest, footprint_at_goal(robot)) < kGap;
  };
  if (robot.moving) {
    if (robot.purpose != Purpose::kQueue || robot.motion.end() - now < SimTime{1'500'000'000}) return;
    for (std::size_t i = 0; i < robots_.size(); ++i)
      if (conflicts(i)) return;
    brake(index, now);  // the goal became free on the way to the place to wait
    return;
  }
  if (robot.yields_to) {
    const Robot& other = robots_[*robot.yields_to];
    const bool still_here = other.wants && !(other.moving && other.purpose == Purpose::kGoal);
    if (still_here && other.order < robot.order && now < robot.yields_until) {
      robot.blocked_by = static_cast<RobotId>(*robot.yields_to);
      return;
    }
    robot.yields_to.reset();
  }
  if (map_.clearance(robot.goal.position()) < kGoalClearance) {
    robot.unreachable = true;
    return;
  }
  bool occupied = false;
  std::optional<RobotId> waits_for;
  for (std::size_t i = 0; i < robots_.size(); ++i)
    if (conflicts(i)) {
      occupied = true;
      if (!waits_for && !movable(robots_[i], now)) waits_for = static_cast<RobotId>(i);
    }
  if (waits_for) {
    queue(index, now);
    robot.blocked_by = waits_for;
    return;
  }
  if (!occupied && drive_to_goal(index, now)) return;

  const auto stays = [&](std::size_t i) { return !movable(robots_[i], now); };
  const auto way = map_.route(robot.pose.position(), robot.goal.position(), rests(index, stays));
  if (!way) {
    const auto free = map_.route(robot.pose.position(), robot.goal.position(), {});
    const auto first = free ? first_on(*free, index, stays) : std::nullopt;
    robot.unreachable = !first;
    if (first) queue(index, now);
    robot.blocked_by = first;
    return;
  }
  const Segment end = footprint_at_goal(robot);
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    if (i == index) continue;
    const Robot& other = robots_[i];
    if (!movable(other, now)) continue;
    const double to_way = std::min(distance_to_way(other.rest.a, *way), distance(other.rest, end));
    if (to_way >= kGap) continue;
    robot.blocked_by = static_cast<RobotId>(i);
    if (!displace(i, *way, end, index, robots_.size(), now)) return;
  }
  if (!robot.moving) drive_to_goal(index, now);
}

bool Traffic::drive_to_goal(std::size_t index, SimTime now) {
  Robot& robot = robots_[index];
  std::vector<Keepout> keepouts = rests(index);
  const Segment end = footprint_at_goal(robot);
  const auto way = map_.route(robot.pose.position(), robot.goal.position(), keepouts);
  if (!way) return false;
  Trajectory motion(*way, robot.pose.yaw, robot.goal.yaw, limits_of(robot));
  const auto delay = delay_of(index, motion, end, now);
  if (!delay) return false;
  if (*delay > kWorthADetour) {
    // Others come across: perhaps there is a way around all of their ways.
    for (std::size_t i = 0; i < robots_.size(); ++i) {
      const Robot& other = robots_[i];
      if (i == index || !other.moving) continue;
      Vec2 last = other.motion.point_at(now);
      for (SimTime t = now; t < other.motion.end();) {
        t = std::min(other.motion.end(), t + 5 * kSample);
        const Vec2 next = other.motion.point_at(t);
        keepouts.push_back({{last, next}, kGap});
        last = next;
      }
    }
    if (const auto around = map_.route(robot.pose.position(), robot.goal.position(), keepouts)) {
      Trajectory detour(*around, robot.pose.yaw, robot.goal.yaw, limits_of(robot));
      const auto detour_delay = delay_of(index, detour, end, now);
      if (detour_delay && *detour_delay + detour.duration() < *delay + motion.duration())
        return commit(index, *around, robot.goal.yaw, end, Purpose::kGoal, now);
    }
  }
  return commit(index, *way, robot.goal.yaw, end, Purpose::kGoal, now);
}

bool Traffic::commit(std::size_t index, std::span<const Vec2> way, double yaw, const Segment& rest, Purpose purpose,
                     SimTime now) {
  Robot& robot = robots_[index];
  Trajectory motion(way, robot.pose.yaw, yaw, limits_of(robot));
  const auto delay = delay_of(index, motion, rest, now);
  if (!delay) return false;
  motion.begin_at(now + *delay);
  robot.motion = std::move(motion);
  ++robot.motions;
  robot.moving = true;
  robot.purpose = purpose;
  robot.rest = rest;
  return true;
}

std::optional<SimTime> Traffic::delay_of(std::size_t index, Trajectory& motion, const Segment& rest, SimTime now) {
  SimTime last = now;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    const Robot& other = robots_[i];
    if (i != index && other.moving) last = std::max(last, other.motion.end());
  }
  for (SimTime delay{};; delay += kDelayStep) {
    motion.begin_at(now + delay);
    const auto met = met_by(index, motion, rest, now);
    if (!met) return delay;
    robots_[index].blocked_by = met;
    if (now + delay > last + 2 * kTimeMargin) return std::nullopt;
  }
}

std::optional<RobotId> Traffic::met_by(std::size_t index, const Trajectory& motion, const Segment& rest,
                                       SimTime now) const {
  for (std::size_t i = 0; i < robots_.size(); ++i)
    if (i != index && robots_[i].moving && meets(motion, rest, robots_[i], now)) return static_cast<RobotId>(i);
  return std::nullopt;
}

bool Traffic::meets(const Trajectory& motion, const Segment& rest, const Robot& other, SimTime now) {
  const double gap = std::min(kMovingGap, distance(motion.point_at(now), other.rest) - 0.005);
  const SimTime end = std::max(motion.end(), other.motion.end()) + kTimeMargin;
  for (SimTime t = now; t <= end; t += kSample) {
    const Vec2 mine = motion.point_at(t);
    const double apart = distance(mine, other.motion.point_at(t));
    if (apart < gap) return true;
    if (apart < kMovingGap + kReachOfASample)
      for (const SimTime early : {-kTimeMargin, -kTimeMargin / 2, kTimeMargin / 2, kTimeMargin})
        if (distance(mine, other.motion.point_at(std::max(now, t + early))) < gap) return true;
    if (t >= motion.end() - kTimeMargin && distance(other.motion.point_at(t), rest) < gap) return true;
  }
  return false;
}

// --- Making room

void Traffic::queue(std::size_t index, SimTime now) {
  Robot& robot = robots_[index];
  const Vec2 goal = robot.goal.position(), here = robot.pose.position();
  const Segment end = footprint_at_goal(robot);
  if (distance(here, goal) < kWorthQueueing) return;
  std::vector<Keepout> keepouts = rests(index);
  const auto place = map_.nearest(goal, {}, kQueueRange, [&](const Vec2& p) {
    if (distance(p, goal) > distance(here, goal) - kWorthQueueing || distance(p, end) < kPlaceGap + 0.1) return false;
    for (const Keepout& k : keepouts)
      if (distance(p, k.around) < kPlaceGap) return false;
    for (std::size_t i = 0; i < robots_.size(); ++i) {
      const Robot& other = robots_[i];
      if (i != index && other.wants && distance(p, footprint_at_goal(other)) < kPlaceGap) return false;
    }
    for (const Segment& workplace : workplaces_)
      if (distance(p, workplace) < kPlaceGap) return false;
    return map_.passable_around(p);
  });
  if (!place) return;
  if (const auto way = map_.route(here, *place, keepouts)) {
    commit(index, *way, robot.goal.yaw, {*place, *place}, Purpose::kQueue, now);
  }
}

std::optional<std::vector<Vec2>> Traffic::way_aside(std::size_t index, std::span<const Keepout> keepouts,
                                                    std::span<const Vec2> way, const Segment& end) {
  const Robot& robot = robots_[index];
  for (const bool well_chosen : {true, false}) {
    const auto place = map_.nearest(robot.pose.position(), keepouts, well_chosen ? 4.0 : 30.0, [&](const Vec2& p) {
      if (distance(p, end) < kPlaceGap || distance_to_way(p, way) < kPlaceGap) return false;
      for (std::size_t i = 0; i < robots_.size(); ++i) {
        const Robot& other = robots_[i];
        if (i == index) continue;
        if (distance(p, other.rest) < kPlaceGap) return false;
        if (well_chosen && other.wants && distance(p, footprint_at_goal(other)) < kPlaceGap) return false;
      }
      if (!well_chosen) return true;
      for (const Segment& workplace : workplaces_)
        if (distance(p, workplace) < kPlaceGap) return false;
      return map_.passable_around(p);
    });
    if (!place) continue;
    if (auto aside = map_.route(robot.pose.position(), *place, keepouts)) return aside;
  }
  return std::nullopt;
}

bool Traffic::displace(std::size_t index, std::span<const Vec2> way, const Segment& end, std::size_t for_robot,
                       std::size_t depth, SimTime now) {
  if (depth == 0) return false;
  Robot& robot = robots_[index];
  if (robot.moving || robot.working || robot.speed == 0) return false;
  const auto go = [&](std::span<const Vec2> aside) {
    if (!commit(index, aside, robot.pose.yaw, {aside.back(), aside.back()}, Purpose::kYield, now)) return false;
    robot.yields_to = for_robot;
    robot.blocked_by = static_cast<RobotId>(for_robot);
    robot.yields_until = now + kYieldFor;
    return true;
  };
  if (const auto aside = way_aside(index, rests(index), way, end)) return go(*aside);
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    if (i == index || !movable(robots_[i], now)) continue;
    const auto others = rests(index, [&](std::size_t k) { return k != i; });
    const auto aside = way_aside(index, others, way, end);
    if (!aside) continue;
    const Segment place{aside->back(), aside->back()};
    if (!displace(i, *aside, place, index, depth - 1, now)) continue;
    const auto free = map_.route(robot.pose.position(), aside->back(), rests(index));
    return free && go(*free);
  }
  return false;
}

void Traffic::brake(std::size_t index, SimTime now) {
  Robot& robot = robots_[index];
  robot.motion = robot.motion.braked(now, limits_);
  ++robot.motions;
  robot.purpose = Purpose::kBrake;
  robot.blocked_by.reset();
  robot.rest = footprint_at(robot.motion.last());
  changed_ = true;
  brake_others(index, now);
}

void Traffic::brake_others(std::size_t index, SimTime now) {
  const Robot& robot = robots_[index];
  const auto point_at = [&](SimTime t) -> Vec2 {
    return robot.moving ? robot.motion.point_at(t) : robot.pose.position();
  };
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    Robot& other = robots_[i];
    if (i == index || !other.moving || other.purpose == Purpose::kBrake) continue;
    for (SimTime t = now; t <= other.motion.end(); t += kSample)
      if (distance(other.motion.point_at(t), point_at(t)) < kStopGap || distance(other.rest, robot.rest) < kStopGap) {
        brake(i, now);
        break;
      }
  }
}

}  // namespace cxlab::sim
