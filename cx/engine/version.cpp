#include "cx/engine/version.h"

#include <clips_ns/clips.h>

namespace cxlab {

std::string clips_version() {
  const std::string banner = BANNER_STRING;
  const auto begin = banner.find_first_not_of(" \n"), end = banner.find_last_not_of(" \n");
  return banner.substr(begin, end + 1 - begin) + ", version " + VERSION_STRING;
}

}  // namespace cxlab
