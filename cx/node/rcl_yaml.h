#pragma once
// The differences between ROS 2 and cxlab in reading a file of parameters.

#include <filesystem>
#include <vector>

#include "cx/base/expected.h"

namespace cxlab::cx {

/// What the parser of rcl refuses in the file, which then is not read at all: aliases, lists of mixed values, maps and
/// lists in lists, values outside of `ros__parameters`.
std::vector<Error> refused_by_rcl(const std::filesystem::path& file);

}  // namespace cxlab::cx
