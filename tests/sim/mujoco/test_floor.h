#pragma once
// A small factory for tests: a BS, a CS, an RS and a DS side by side, two robots before them.

#include <numbers>

#include "sim/mujoco/factory_model.h"
#include "sim/world.h"
#include "tests/support/files.h"

namespace cxlab::sim {

inline FloorPlan small_floor() {
  FloorPlan plan;
  plan.stations = {{"C-BS", "BS", {1.5, 5.5, 0}, true},
                   {"C-CS1", "CS", {4.5, 5.5, 0}, true},
                   {"C-RS1", "RS", {4.5, 2.5, 0}, true},
                   {"C-DS", "DS", {1.5, 2.5, std::numbers::pi}, true}};
  for (std::size_t i = 0; i < plan.stations.size(); ++i)
    for (Spot& spot : spots_of(plan.stations[i], static_cast<StationId>(i))) plan.spots.push_back(std::move(spot));
  plan.robots = {{"R1", {0.5, 4, 0}}, {"R2", {3, 1.2, 0}}};
  plan.walls = {{{4, 0}, {7, 0}}, {{7, 0}, {7, 2}}};
  return plan;
}

inline ModelOptions test_options() { return {models_dir(), 0.01, 20}; }

}  // namespace cxlab::sim
