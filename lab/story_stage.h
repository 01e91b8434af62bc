#pragma once
// Stories whose agents are loaded once: a process loads an agent behind the wall, and copies of it play the stories.

#include <vector>

#include "cx/base/expected.h"
#include "lab/host.h"
#include "lab/stories.h"

namespace cxlab::lab {

/// Plays them as `play_stories` does with one job, several times as fast where they have an agent in common. While an
/// agent is loaded its process may copy itself; a copy may not, and has the same wall as in `play_stories` otherwise.
/// No runs are kept, and none of the stories is a golden run.
Status play_on_stages(std::vector<PlayedStory>& stories, const StoryPlan& plan, const Host& host);

}  // namespace cxlab::lab
