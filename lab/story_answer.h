#pragma once
// The answer of a process that played a story, as a line, and the result of a process that gives no answer.

#include <cstdint>
#include <string>

#include "cx/testing/story.h"
#include "lab/stories.h"

namespace cxlab::lab {

/// Without a line break.
std::string story_answer(const testing::StoryResult& result);

/// How a process that played a story ended.
struct StoryEnd {
  std::string said;
  int code = 0;
  bool late = false;  ///< it took longer than this, so that its answer does not count:
  double patience_s = 0;
};
/// Adds how a story went with one more seed: a process that has not said so failed. What remains is the result of the
/// smallest seed that failed, else of the largest, with the rules and files of all.
void add_answer(PlayedStory& story, std::uint64_t seed, const StoryEnd& end);

}  // namespace cxlab::lab
