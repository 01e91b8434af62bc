#pragma once

#include <algorithm>
#include <cstddef>
#include <string_view>

namespace cxlab {

/// One word is the other one with a slip of the finger: a letter too many, too few or changed, or two that changed
/// places.
inline bool is_slip(std::string_view word, std::string_view other) {
  const std::size_t longer = std::max(word.size(), other.size()), shorter = std::min(word.size(), other.size());
  std::size_t same = 0, end = 0;
  while (same < shorter && word[same] == other[same]) ++same;
  while (end < shorter - same && word[word.size() - 1 - end] == other[other.size() - 1 - end]) ++end;
  return longer - shorter <= 1 && same + end + 2 >= longer;
}

}  // namespace cxlab
