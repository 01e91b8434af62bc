#include "lab/versions.h"

#include "cx/engine/version.h"
#include "sim/box2d/library.h"
#include "sim/mujoco/library.h"

namespace cxlab::lab {

const char* cxlab_version() { return CXLAB_VERSION; }

std::vector<std::pair<std::string, std::string>> versions() {
  return {{"cxlab", CXLAB_VERSION},
          {"CLIPS", clips_version()},
          {"MuJoCo", sim::mujoco_version()},
          {"Box2D", sim::box2d_version()}};
}

}  // namespace cxlab::lab
