#pragma once
// Compares a compiled model with the measures that the code uses.

#include <filesystem>

#include <mujoco/mujoco.h>

#include "cx/base/expected.h"
#include "sim/world.h"

namespace cxlab::sim {

/// Fails at the first measure of a part that differs from sim/geometry.h; the error names the element, both numbers and
/// the part's file in `models`. Parts that the plan does not use are not compared.
Status check_geometry(const mjModel& model, const FloorPlan& plan, const std::filesystem::path& models);

}  // namespace cxlab::sim
