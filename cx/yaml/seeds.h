#pragma once
// Seeds, as suites and stories name them.

#include <cstdint>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/yaml/yaml.h"

namespace cxlab::yaml {

inline constexpr std::uint64_t kMostSeeds = 1'000'000;
/// A list of seeds, each once, or a range of at most `kMostSeeds`: "0..29". An error is reported at the value.
std::vector<std::uint64_t> read_seeds(const Value& value);
/// The seeds of such a range.
Expected<std::vector<std::uint64_t>> seeds_of_range(const std::string& text);

}  // namespace cxlab::yaml
