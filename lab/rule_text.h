#pragma once
// The text of a rule file: which lines are spared, and how a part of it is shown.

#include <set>
#include <string>
#include <string_view>

namespace cxlab::lab {

/// `; mutate: skip` of a file: lines at which nothing is changed.
std::set<int> skipped_lines(const std::string& text);
/// In one line, without comments.
std::string squeezed(std::string_view text);

}  // namespace cxlab::lab
