#pragma once
// The answer of a process that played a story, as a line, and the result of a process that gives no answer.

#include <cstdint>
#include <optional>
#include <string>

#include "cx/testing/story.h"
#include "lab/stories.h"

namespace cxlab::lab {

/// Without a line break.
std::string story_answer(const testing::StoryResult& result);
/// The result that the text is, if it is a whole one.
std::optional<testing::StoryResult> read_story_answer(const std::string& text);
/// The result for a process that ended without an answer: only its story fails. `late`: the process was ended because
/// it took too long.
testing::StoryResult answer_left_unsaid(const testing::StorySpec& spec, int code, bool late, double patience_s);

/// Adds how a story went with one more seed. What remains is the result of the smallest seed that failed, else of the
/// largest, with the rules and files of all.
void add_answer(PlayedStory& story, std::uint64_t seed, testing::StoryResult result);

}  // namespace cxlab::lab
