#include "cx/base/scratch_folder.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
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

TEST(ScratchFolder, WhatAKilledProcessLeftIsRemovedAndNothingElse) {
  const TempFolder temporary;
  const std::filesystem::path& here = temporary.path();
  const char* before = std::getenv("TMPDIR");
  const std::string old = before ? before : "/tmp";
  setenv("TMPDIR", here.c_str(), 1);
  put_file(here / "cxlab-other" / "file", "x");
  const auto alive = ScratchFolder::create();
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t child = fork();
  if (child == 0) {
    const auto dead = ScratchFolder::create();
    const std::string path = (*dead)->path();
    put_file((*dead)->path() / "file", "x");
    const bool written = write(ready[1], path.c_str(), path.size()) > 0;
    for (;;) pause();
    _exit(written);
  }
  char path[4096] = {};
  ASSERT_GT(read(ready[0], path, sizeof path - 1), 0);
  const auto meanwhile = ScratchFolder::create();
  EXPECT_TRUE(std::filesystem::exists(path)) << "of a process that lives";
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  const auto next = ScratchFolder::create();
  setenv("TMPDIR", old.c_str(), 1);
  ASSERT_TRUE(alive && meanwhile && next);
  EXPECT_FALSE(std::filesystem::exists(path));
  for (const auto& folder : {&alive, &meanwhile, &next}) EXPECT_TRUE(std::filesystem::exists((**folder)->path()));
  EXPECT_TRUE(std::filesystem::exists(here / "cxlab-other" / "file"));
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
