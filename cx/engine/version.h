#pragma once

#include <string>

#include "cx/base/expected.h"

namespace cxlab {

/// As CLIPS prints itself.
std::string clips_version();

/// Fails (kResource) if the CLIPS library of this process is another one than cxlab was built with. The engine uses
/// internals of CLIPS, so it must not run then.
Status check_clips_library();

}  // namespace cxlab
