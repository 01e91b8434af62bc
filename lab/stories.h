#pragma once
// Stories of a user's files, played in processes, and reports about them.
//
//   auto stories = read_stories({"my_agent", "doors.story.yaml::a bell opens the door"});
//   play_stories(*stories, {.setup = {find_share().interfaces}, .jobs = 2});
//   for (const PlayedStory& story : *stories) if (!story.passed()) ...

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/testing/story.h"
#include "lab/host.h"

namespace cxlab::lab {

/// Names of files with stories end so: those of folders are found by it.
inline constexpr std::string_view kStoryEnding = ".story.yaml";

/// One story and how it went.
struct PlayedStory {
  testing::StorySpec spec;
  bool played = false;               ///< with all its seeds; else it has not been its turn
  testing::StoryResult result = {};  ///< with several seeds that of the smallest one that failed, and rules of all
  std::uint64_t seed = 1;            ///< that the result is of
  std::size_t seeds_played = 0;
  std::set<std::uint64_t> failed_seeds = {};
  double wall_s = 0;               ///< of all its processes
  bool late = false;               ///< a process took longer than `StoryPlan::patience_s`
  std::size_t untold = 0;          ///< processes that ended before they said what its rules did
  std::filesystem::path run = {};  ///< a folder that can be asked why it failed; empty: none was kept
  bool unreadable = false;         ///< it stands for a whole file, whose error is in `result`: there is nothing to play
  bool accepted = false;           ///< what goes otherwise than its golden run is the golden run from now on

  bool passed() const { return accepted || result.passed(); }
  /// The faults: those of the story itself, then those of the rules.
  std::vector<std::string> complaints() const;
};

/// These files, and all *.story.yaml below these folders; the file of FILE::NAME.
Expected<std::vector<std::filesystem::path>> story_files(const std::vector<std::string>& paths);
/// The stories of these files and of all *.story.yaml below these folders; of FILE::NAME those of that name. A file
/// that cannot be read is one story that is `unreadable`.
Expected<std::vector<PlayedStory>> read_stories(const std::vector<std::string>& paths);

struct StoryPlan {
  testing::StorySetup setup;
  int jobs = 1;                  ///< processes at a time
  bool stop_at_failure = false;  ///< stories after the first one that fails are not played, or not to their end
  bool load_once = false;        ///< each agent, for all its stories; `jobs` is 1, and no runs are kept
  double patience_s = 60;        ///< s that a process may take; one that takes longer is ended
  /// Where each story that fails leaves a run (lab/story_run.h); empty: none does.
  std::filesystem::path runs = {};
  std::function<void(const PlayedStory&)> begins = {};  ///< called when a story's turn comes
  /// Called with each story that was played, in the order of the stories.
  std::function<void(const PlayedStory&)> ended = {};
};

/// Plays each in a copy of this process, which must have one thread only. The copy reaches nothing but what its story
/// names (cx/wall/wall.h); a story whose copy ends early or takes too long has failed, and the others are played.
Status play_stories(std::vector<PlayedStory>& stories, const StoryPlan& plan, const Host& host = {});

/// The stories whose golden runs go otherwise have passed, once the runs of now are in the place of these. One that
/// failed before it could be compared, as at a limit or after its patience, keeps its golden run. So does one whose run
/// of now fails or cannot be put there; its last failure says why.
void accept_golden_runs(std::vector<PlayedStory>& stories, const Host& host = {});

/// The coverage of all stories together.
explain::Coverage coverage_of(const std::vector<PlayedStory>& stories);
/// What that lacks: the rules of stories whose process has not told what they did.
std::vector<std::string> notes_on_coverage(const std::vector<PlayedStory>& stories);

/// A JUnit report of the played stories; with `printed`, it includes what their agents printed.
Expected<std::string> to_junit(const std::vector<PlayedStory>& stories, bool printed = false);

}  // namespace cxlab::lab
