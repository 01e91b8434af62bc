#pragma once

#include <cstdint>
#include <string>

namespace cxlab {

/// A hash of 128 bits as 32 lower-case hex digits, most significant first.
std::string hash_text(std::uint64_t high, std::uint64_t low);
/// One of 64 bits as 16 digits.
std::string hash_text(std::uint64_t hash);

}  // namespace cxlab
