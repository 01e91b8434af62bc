#include "sim/box2d/library.h"

#include <box2d/b2_common.h>

namespace cxlab::sim {

std::string box2d_version() {
  return std::to_string(b2_version.major) + '.' + std::to_string(b2_version.minor) + '.' +
         std::to_string(b2_version.revision);
}

}  // namespace cxlab::sim
