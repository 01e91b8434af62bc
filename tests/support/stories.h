#pragma once
// Stories of a bell and a door.

#include <gtest/gtest.h>

#include <fstream>

#include "cx/testing/story.h"
#include "tests/support/files.h"

namespace cxlab::testing {

class Stories : public ::testing::Test {
 protected:
  Stories() {
    write("door.clp",
          "(deftemplate door (slot state) (slot by (default NOBODY)))\n"
          "(defrule open \"A bell.\" (bell) ?d <- (door (state CLOSED)) => (modify ?d (state OPEN) (by BELL)))\n"
          "(defrule slam (wind) ?d <- (door (state OPEN)) => (modify ?d (state CLOSED)))\n");
  }

  void write(const std::string& name, const std::string& text) { std::ofstream(folder_ / name) << text; }
  Expected<std::vector<StorySpec>> read(const std::string& text) {
    write("t.story.yaml", text);
    return read_stories(folder_ / "t.story.yaml");
  }
  /// The one story of a bell and a door, with these expectations.
  StoryResult play(const std::string& expectation, const std::string& more = {}) {
    auto stories = read("- story: s\n  rules: door.clp\n  given: [(door (state CLOSED))]\n" + more +
                        "  expect:\n    - {" + expectation + "}\n");
    if (!stories) {
      StoryResult bad;
      bad.bad = stories.error();
      return bad;
    }
    return run_story(stories->front(), {interfaces_dir()});
  }
  TempFolder temp_;
  const std::filesystem::path folder_ = temp_.path();
};

inline const char* const kBell = "  steps: [{at: 1, assert: (bell)}]\n";

}  // namespace cxlab::testing
