#include "cx/base/file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "cx/base/scratch_folder.h"

namespace cxlab {
namespace {

TEST(File, WhatWasWrittenIsRead) {
  const auto folder = *ScratchFolder::create();
  const std::string text = std::string("a\0b\n", 4) + std::string(200'000, 'x');
  ASSERT_TRUE(write_file(folder->path() / "f", text));
  EXPECT_EQ(*read_file(folder->path() / "f"), text);
  ASSERT_TRUE(write_file(folder->path() / "f", ""));
  EXPECT_EQ(*read_file(folder->path() / "f"), "");
}

TEST(File, AnErrorNamesWhatIsThereInstead) {
  EXPECT_EQ(read_file("/no/such/file").error().text(), "/no/such/file: there is no such file");
  EXPECT_EQ(read_file("/proc/self/mem").error().text(), "/proc/self/mem: cannot be read: Input/output error");
  EXPECT_EQ(read_file("/dev/null/x").error().text(), "/dev/null/x: cannot be read: Not a directory");
  EXPECT_EQ(read_file("/tmp").error().text(), "/tmp: is a folder, expected a file");
  EXPECT_EQ(read_file("/dev/zero").error().text(), "/dev/zero: found more than 16 MB, expected a file");
  EXPECT_EQ(*read_file("/dev/null"), "");
  EXPECT_EQ(write_file("/dev/full", "x").error().kind, ErrorKind::kResource);
}

TEST(File, OfAnOutputGetsTheFolderThatItIsWrittenTo) {
  const auto folder = *ScratchFolder::create();
  const std::filesystem::path file = folder->path() / "new" / "deep" / "f";
  EXPECT_TRUE(write_output(file, "1"));
  EXPECT_TRUE(write_output(file, "2"));
  EXPECT_EQ(*read_file(file), "2");
  EXPECT_EQ(write_output("/dev/null/none/f", "x").error().text(),
            "/dev/null/none: the folder cannot be made: Not a directory");
}

TEST(File, OfAPipeIsReadAsFarAsSomebodyWritesIntoIt) {
  const auto folder = *ScratchFolder::create();
  const std::string pipe = folder->path() / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(read_file(pipe).error().text(), pipe + ": is a pipe into which nobody writes, expected a file");
  const int both = open(pipe.c_str(), O_RDWR);  // a writer, but nothing in the pipe yet
  std::thread writer([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    EXPECT_EQ(write(both, "late", 4), 4);
    close(both);
  });
  EXPECT_EQ(*read_file(pipe), "late");
  writer.join();
}

}  // namespace
}  // namespace cxlab
