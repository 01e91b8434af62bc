#include "cx/base/scratch_folder.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "tests/support/files.h"

namespace cxlab {
namespace {

TEST(ScratchFolder, IsEmptyAtFirstAndGoneWithItsContentAtTheEnd) {
  std::filesystem::path path;
  {
    auto folder = ScratchFolder::create();
    ASSERT_TRUE(folder) << folder.error().text();
    path = (*folder)->path();
    EXPECT_TRUE(std::filesystem::is_directory(path));
    EXPECT_TRUE(std::filesystem::is_empty(path));
    put_file(path / "below" / "file", "x");
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(ScratchFolder, EachOneIsAnother) {
  const auto first = ScratchFolder::create(), second = ScratchFolder::create();
  ASSERT_TRUE(first && second);
  EXPECT_NE((*first)->path(), (*second)->path());
}

TEST(ScratchFolder, WithoutATemporaryFolderThereIsAnError) {
  const char* before = std::getenv("TMPDIR");
  const std::string old = before ? before : "";
  const TempFolder folder;
  setenv("TMPDIR", (folder / "missing").c_str(), 1);
  const auto made = ScratchFolder::create();
  if (before)
    setenv("TMPDIR", old.c_str(), 1);
  else
    unsetenv("TMPDIR");
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().kind, ErrorKind::kResource);
}

}  // namespace
}  // namespace cxlab
