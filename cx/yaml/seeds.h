#pragma once
// Seeds, as suites and stories name them.

#include <cstdint>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/yaml/yaml.h"

namespace cxlab::yaml {

inline constexpr std::uint64_t kMostSeeds = 1'000'000;
/// The seeds of a text, in its order: numbers and ranges with commas between them, as "0..29" or "1..5,9". Each seed is
/// there once, and at most `kMostSeeds` are there.
Expected<std::vector<std::uint64_t>> seeds_of(const std::string& text);
/// The seeds of such a text, or of a list of seeds. An error is reported at the value.
std::vector<std::uint64_t> read_seeds(const Value& value);

}  // namespace cxlab::yaml
