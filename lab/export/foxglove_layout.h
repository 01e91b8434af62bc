#pragma once
// A layout of Foxglove for an exported run: the world in 3D, what each robot does, points, log, and all events.

#include <string>
#include <vector>

namespace cxlab::lab {

/// The layout file, for a bag that has these topics (sorted).
std::string foxglove_layout(const std::vector<std::string>& topics);

}  // namespace cxlab::lab
