#pragma once

#include <string>

namespace cxlab {

/// As CLIPS prints itself.
std::string clips_version();

}  // namespace cxlab
