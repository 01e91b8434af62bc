#pragma once
// Golden runs: a recorded run is played again with the files of now, and must go as it went then.

#include <filesystem>

#include "cx/testing/story.h"
#include "lab/host.h"

namespace cxlab::lab {

/// Plays the run that the story names again (lab/rerun.h) in a process of its own. Where rules do something else than
/// then, or the result is another, the failures say where first and what led to it, as `cxlab diff` does. This process
/// plays the rules of both again, and gives up its rights before that. With `coverage`, the result has the coverage of
/// the new run.
testing::StoryResult play_golden(const testing::StorySpec& story, bool coverage, const Host& host);

/// Plays it again into a folder that stays.
Status keep_golden(const testing::StorySpec& story, const std::filesystem::path& folder, const Host& host);

/// Plays it again to the end of the recorded run, in a process of its own, and puts the new run in its place.
Status accept_golden(const testing::StorySpec& story, const Host& host);

}  // namespace cxlab::lab
