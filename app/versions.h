#pragma once
// Versions of what is linked, as those libraries say themselves.

#include <string>

namespace cxlab::app {

std::string clips_version();
std::string mujoco_version();

}  // namespace cxlab::app
