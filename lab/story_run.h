#pragma once
// A story as a run: it is played again into a folder that can be asked like that of any run
// (docs/reference/questions.md).

#include <filesystem>
#include <string>

#include "cx/base/expected.h"
#include "cx/testing/story.h"
#include "lab/host.h"
#include "scenarios/scenario.h"

namespace cxlab::lab {

/// "door-a-bell-opens" of "a bell opens" in door.story.yaml; several stories may have this name.
std::string run_name(const testing::StorySpec& story);

/// Makes the folder for the run of this story below `runs`, or finds that of an earlier test of it. Its name is the
/// `run_name`; it ends with a hash of file and story if the story is not `alone` with that name, or another run has it.
Expected<std::filesystem::path> folder_for(const testing::StorySpec& story, bool alone,
                                           const std::filesystem::path& runs);

/// Plays the story as `run_story` does, in a world of kind `story`, whose scenario is written to story/scenario.yaml in
/// the folder. Each tick writes its records to the folder, so this process may be killed at any time. If rules are not
/// trusted, the process gives up its rights before the first one runs (lab/confine.h).
Status keep_run(const testing::StorySpec& story, const testing::StorySetup& setup, const std::filesystem::path& folder);

}  // namespace cxlab::lab
