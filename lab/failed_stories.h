#pragma once
// The stories that failed when they were played the last time, for `cxlab test --last-failed`.

#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cx/base/expected.h"

namespace cxlab::lab {

struct PlayedStory;

class FailedStories {
 public:
  /// The failed stories of all folders in which this user has played stories, from failed_stories.json
  /// (lab/state_folder.h). None if this file cannot be read.
  static FailedStories remembered();

  bool has(const PlayedStory& story) const;
  /// The results of the played stories replace the older ones. The other stories stay, without those whose file was
  /// removed.
  void note(const std::vector<PlayedStory>& played);
  /// Writes the file if it would be another one. Nothing happens where there is no state folder.
  Status save() const;

 private:
  std::set<std::pair<std::string, std::string>> failed_;  // absolute file, name
  std::string text_;                                      // of the file
};

}  // namespace cxlab::lab
