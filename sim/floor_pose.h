#pragma once
// A floor at an instant, as far as a picture of it shows.

#include <vector>

#include "sim/pose3.h"
#include "sim/world.h"

namespace cxlab::sim {

struct FloorPose {
  std::vector<RobotState> robots;  ///< by RobotId; pose, gripper and fingers count
  std::vector<Lights> lights;      ///< by StationId
  struct ShownPiece {
    Stack stack;
    Pose3 underside_in_world;
  };
  std::vector<ShownPiece> pieces;
};

}  // namespace cxlab::sim
