#include "cx/journal/hash_text.h"

namespace cxlab {

std::string hash_text(std::uint64_t high, std::uint64_t low) { return hash_text(high) + hash_text(low); }

std::string hash_text(std::uint64_t hash) {
  std::string text;
  for (int shift = 60; shift >= 0; shift -= 4) text += "0123456789abcdef"[hash >> shift & 15];
  return text;
}

}  // namespace cxlab
