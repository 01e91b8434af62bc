#pragma once
// Where a robot goes for a skill; the same in both tiers.

#include <optional>

#include "sim/skills/skill.h"
#include "sim/traffic/traffic.h"
#include "sim/world.h"

namespace cxlab::sim {

struct Destination {
  Pose2 pose;
  std::optional<Segment> ground;  ///< that the robot covers with its centre while it works there; none = it only drives
};

/// The destination of a skill that is not compound. A discard turns to the nearest direction with free floor where the
/// robot lets go; an explore goes to a lookout, or into the zone if there is none.
Destination destination_of(const SkillGoal& goal, const WorldView& world, Traffic& traffic, RobotId robot);

}  // namespace cxlab::sim
