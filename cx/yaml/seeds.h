#pragma once
// Seeds, as suites and stories name them.

#include <cstdint>
#include <vector>

#include "cx/yaml/yaml.h"

namespace cxlab::yaml {

/// A list of seeds, each once, or a range of at most 100000: "0..29". An error is reported at the value.
std::vector<std::uint64_t> read_seeds(const Value& value);

}  // namespace cxlab::yaml
