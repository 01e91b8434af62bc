#pragma once
// A story as a run: it is played again into a folder that can be asked like that of any run
// (docs/reference/questions.md).

#include <filesystem>

#include "cx/base/expected.h"
#include "cx/testing/story.h"
#include "lab/host.h"
#include "scenarios/scenario.h"

namespace cxlab::lab {

/// A folder for the run of this story below `runs`: that of the same story before, or a new one.
Expected<std::filesystem::path> folder_for(const testing::StorySpec& story, const std::filesystem::path& runs);

/// Plays the story as `run_story` does, in a world of kind `story`, whose scenario is written to story/scenario.yaml in
/// the folder. Each tick writes its records to the folder, so this process may be killed at any time. If rules are not
/// trusted, the process gives up its rights before the first one runs (lab/confine.h).
Status keep_run(const testing::StorySpec& story, const testing::StorySetup& setup, const std::filesystem::path& folder);

}  // namespace cxlab::lab
