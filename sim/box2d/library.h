#pragma once
// The Box2D that is linked.

#include <string>

namespace cxlab::sim {

std::string box2d_version();  ///< "2.4.1"

}  // namespace cxlab::sim
