#pragma once

#include <string>

namespace cxlab::sim {

std::string mujoco_version();

}  // namespace cxlab::sim
