#pragma once
// The versions of cxlab and of what it is built on.

#include <string>
#include <utility>
#include <vector>

namespace cxlab::lab {

/// "0.1.0".
const char* cxlab_version();
/// Name and version: cxlab first, then the libraries that results depend on.
std::vector<std::pair<std::string, std::string>> versions();

}  // namespace cxlab::lab
