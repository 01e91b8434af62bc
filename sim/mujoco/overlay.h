#pragma once
// What is written over a picture from above: a tag with name and signal lights for each machine and robot, and each
// piece as a column of its colours. Tags never overlap.

#include <array>
#include <span>
#include <string>
#include <vector>

#include <mujoco/mujoco.h>

#include "sim/mujoco/physics_gate.h"

namespace cxlab::sim {

/// In pixels, from the lower left corner of the picture.
struct Box {
  int left = 0, bottom = 0, width = 0, height = 0;
  bool overlaps(const Box& other) const {
    return left < other.left + other.width && other.left < left + width && bottom < other.bottom + other.height &&
           other.bottom < bottom + height;
  }
};

/// A box that wants to be near a point.
struct BoxWish {
  int x = 0, y = 0, width = 0, height = 0;
};

/// Gives each box the free place nearest to its point: within `picture`, clear of `taken` and of the other boxes. A box
/// that finds no free place is left out (width 0).
std::vector<Box> place_boxes(std::span<const BoxWish> wishes, std::vector<Box> taken, const Box& picture);

/// What an overlay is drawn with. `scene` holds the camera of the picture, `data` the world at that time.
struct OverlayInput {
  const PhysicsGate& world;
  const mjData& data;
  const mjvScene& scene;
  const mjrContext& gl;
  std::span<const int> robot_geoms;    ///< by robot: where its tag points to
  std::span<const int> station_geoms;  ///< by station
  std::span<const std::string> robots, stations;
  double time = 0;  ///< s, for lights that blink
};

void draw_overlay(const OverlayInput& input, const Box& picture);

/// Which of red, yellow and green shine at that time.
std::array<bool, 3> shining(const Lights& lights, double time);

}  // namespace cxlab::sim
