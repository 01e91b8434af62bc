#pragma once
// A value of an enumeration together with the words for all of its values, as files and options name them.

#include <cstddef>
#include <string_view>

namespace cxlab {

template <class Enum>
struct NamedValue {
  Enum& value;
  const std::string_view *begin, *end;  ///< words, in the order of the enumeration

  std::string_view word() const { return begin[static_cast<std::size_t>(value)]; }
  /// False where there is no such word.
  bool set(std::string_view word) {
    for (const std::string_view* at = begin; at != end; ++at)
      if (*at == word) {
        value = static_cast<Enum>(at - begin);
        return true;
      }
    return false;
  }
};

template <class Enum, std::size_t N>
NamedValue<Enum> named(Enum& value, const std::string_view (&words)[N]) {
  return {value, words, words + N};
}

}  // namespace cxlab
