#pragma once
// Stories played one after the other or in several processes, and reports about them.

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/testing/story.h"
#include "lab/host.h"

namespace cxlab::lab {

/// One story and how it went.
struct PlayedStory {
  testing::StorySpec spec;
  testing::StoryResult result;
  double wall_s = 0;
  /// What is wrong: with the story itself, then with the rules.
  std::vector<std::string> complaints() const;
};

/// The stories of these files and of all *.story.yaml below these folders.
Expected<std::vector<PlayedStory>> read_stories(const std::vector<std::string>& paths);

/// Plays each in a copy of this process, which must have one thread only, `jobs` at a time. The copy reaches nothing
/// but what its story names (cx/wall/wall.h); a story whose copy ends early has failed.
Status play_stories(std::vector<PlayedStory>& stories, const testing::StorySetup& setup, int jobs,
                    const Host& host = {});

/// What became of a rule in all stories.
struct CoveredRule {
  long fired = 0, activated = 0;
  /// "fired", "activated but never fired" or "never matched".
  const char* state() const;
};
/// By file, then by line and name.
using Coverage = std::map<std::string, std::map<std::pair<int, std::string>, CoveredRule>>;
Coverage coverage_of(const std::vector<PlayedStory>& stories);

/// A JSON array of rules: file, line, rule, state, fired, activated.
std::string to_json(const Coverage& coverage);

Expected<std::string> to_junit(const std::vector<PlayedStory>& stories);
/// Rules as functions of lcov; its branches say whether each was activated and whether it fired.
Expected<std::string> to_lcov(const Coverage& coverage);

}  // namespace cxlab::lab
