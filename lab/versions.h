#pragma once
// The versions of cxlab and of what it is built on, and the machine.

#include <string>
#include <utility>
#include <vector>

namespace cxlab::lab {

/// "0.1.0".
const char* cxlab_version();
/// Name and version: cxlab first, then the libraries that results depend on.
std::vector<std::pair<std::string, std::string>> versions();
/// The properties of this machine on which the bytes of a run depend: architecture, C library, and a digest of
/// mathematical results. The last bits that sin, cos, tan, atan2, exp, log and pow of the C library return differ
/// between kinds of processors.
std::vector<std::pair<std::string, std::string>> machine();

}  // namespace cxlab::lab
