#pragma once
// Which stories a person means by words: `-k EXPR`, in the language of pytest.

#include <functional>
#include <string>

#include "cx/base/expected.h"

namespace cxlab::lab {

/// A word holds for a text that contains it, in capitals or not; `and`, `or`, `not` and parentheses combine words. A
/// word with blanks, parentheses or one of these three in it stands in quotes, single or double.
///
///   auto filter = StoryFilter::parse("door and not (slow or 'two robots')");
///   if (filter->takes("door.story.yaml::a bell opens the door")) ...
class StoryFilter {
 public:
  /// Takes all.
  StoryFilter() = default;
  /// A usage error names the column where something else was expected.
  static Expected<StoryFilter> parse(const std::string& expression);
  bool takes(const std::string& text) const;

 private:
  std::function<bool(const std::string& lower)> holds_;
};

}  // namespace cxlab::lab
