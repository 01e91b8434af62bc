// Suites of cxlab bench and files of stories: the first byte chooses which of them the rest is.

#include <unistd.h>

#include <filesystem>

#include "cx/base/file.h"
#include "cx/base/scratch_folder.h"
#include "cx/testing/story.h"
#include "lab/sweep/suite.h"
#include "tests/fuzz/fuzz.h"

namespace fuzz_suite {

FUZZ_TARGET(suite) {
  using namespace cxlab;
  static const std::unique_ptr<ScratchFolder> folder = *ScratchFolder::create();
  static const bool scenario =
      write_file(folder->path() / "game.yaml", "schema: 1\nworld: {kind: none}\nduration_s: 1\n").ok();
  if (size == 0 || !scenario) return 0;
  const auto file = folder->path() / "file.yaml";
  fuzz::promise(write_file(file, fuzz::text_of(data + 1, size - 1)).ok(), "the file is written");
  if (data[0] % 2 == 1) {
    const auto stories = cxlab::testing::read_stories(file);
    fuzz::promise(stories.ok() || !stories.error().message.empty(), "an error says what it is");
    return 0;
  }
  const auto suite = lab::Suite::load(file);
  fuzz::promise(suite.ok() || !suite.error().message.empty(), "an error says what it is");
  if (!suite || suite->seeds.size() > 1000) return 0;
  const std::size_t cells = suite->scenarios.size() * suite->strategies.size() * suite->seeds.size();
  fuzz::promise(suite->cells().size() == cells, "each cell is there once");
  (void)suite->check();
  return 0;
}

}  // namespace fuzz_suite
