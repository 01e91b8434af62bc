#pragma once

#include <cstdint>
#include <string>

namespace cxlab {

/// A hash as 16 lower-case hex digits, most significant first.
inline std::string hash_text(std::uint64_t hash) {
  std::string text;
  for (int shift = 60; shift >= 0; shift -= 4) text += "0123456789abcdef"[hash >> shift & 15];
  return text;
}

}  // namespace cxlab
