#pragma once
// A story from a recorded moment: what an environment knew then, what came to it afterwards, and what it did.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "lab/host.h"
#include "lab/run.h"
#include "lab/stories.h"

namespace cxlab::lab {

struct MomentStory {
  SimTime at{};                  ///< the moment: the last tick in which rules ran up to then
  double seconds = 10;           ///< how long it goes on after the moment
  std::string environment = {};  ///< empty: the only one
  std::string name = {};         ///< of the story; empty: "at T of RUN"
  /// Where packages of the run are now, and further ones for the story.
  std::map<std::string, std::string> packages = {};
};

struct WrittenStory {
  std::string text;                ///< of the file
  std::vector<std::string> notes;  ///< what of the moment is not in it, and why
  int expectations = 0;
};

/// The story for `file`, from whose folder it names the files of the agent. The rules are played again in a process of
/// their own. The expectations are all that the environment did: which of them hold in a story is for `keep_what_holds`
/// to find out.
Expected<WrittenStory> story_of(const Run& run, const MomentStory& moment, const std::filesystem::path& file,
                                const Host& host);

/// Plays the story of this file, and takes away the expectations that do not hold: what other nodes did in the run a
/// story cannot always repeat. An error if the story cannot be played, or if nothing is left of it.
Status keep_what_holds(WrittenStory& story, const std::filesystem::path& file, const StoryPlan& plan, const Host& host);

}  // namespace cxlab::lab
