#include "cx/engine/version.h"

#include <clips_ns/clips.h>

namespace cxlab {

std::string clips_version() { return std::string("CLIPS ") + VERSION_STRING + " (" + CREATION_DATE_STRING + ")"; }

}  // namespace cxlab
