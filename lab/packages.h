#pragma once
// The folders of a user's own packages.

#include <map>
#include <string>
#include <vector>

#include "cx/base/expected.h"

namespace cxlab::lab {

struct PackageOptions {
  std::vector<std::string> named;     ///< NAME=DIR
  std::vector<std::string> prefixes;  ///< packages below DIR/share
};

/// From NAME=DIR: name -> folder, absolute. kUsage for what is not NAME=DIR.
Expected<std::map<std::string, std::string>> named_packages(const std::vector<std::string>& named);
/// Those below these prefixes, then those below $CXLAB_PREFIX_PATH and below cxlab's own, then those that come with it.
/// The first of a name wins.
Expected<std::map<std::string, std::string>> installed_packages(const std::vector<std::string>& prefixes);
/// Both.
Expected<std::map<std::string, std::string>> find_packages(const PackageOptions& options);

}  // namespace cxlab::lab
