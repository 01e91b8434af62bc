#include "sim/mujoco/version.h"

#include <mujoco/mujoco.h>

namespace cxlab::sim {

std::string mujoco_version() { return mj_versionString(); }

}  // namespace cxlab::sim
