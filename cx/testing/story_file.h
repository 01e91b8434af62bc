#pragma once

#include "cx/testing/story.h"

namespace cxlab::testing {

/// Reads the stories of a file (docs/testing.md); paths in it are relative to it.
Expected<std::vector<StorySpec>> read_stories(const std::filesystem::path& file);

}  // namespace cxlab::testing
