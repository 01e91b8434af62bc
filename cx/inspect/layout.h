#pragma once
// Long texts in lines that people can read.

#include <cstddef>
#include <string>
#include <string_view>

namespace cxlab::inspect {

/// Columns of a line.
inline constexpr std::size_t kLineWidth = 100;

/// Whether a line has room for the text behind that beginning.
bool fits(std::string_view text, std::string_view before);

/// The text in lines of at most `kLineWidth` columns, the first of which begins with `first`, the others with `rest`.
/// A line breaks at blanks: a fact between its slots, `?x = 3` and strings not at all. What cannot be broken, or has
/// fewer than 40 columns because the lines begin far to the right, makes a longer line.
std::string laid_out(std::string_view text, const std::string& first, const std::string& rest);

}  // namespace cxlab::inspect
