#include "cx/base/append_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/files.h"

namespace cxlab {
namespace {

using testing::HasSubstr;

class AppendFiles : public testing::Test {
 protected:
  AppendFile open() {
    auto file = AppendFile::create(path);
    EXPECT_TRUE(file) << file.error().text();
    return *std::move(file);
  }
  TempFolder folder;
  const std::filesystem::path path = folder / "log";
};

TEST_F(AppendFiles, PiecesWaitInTheBufferUntilAFlush) {
  AppendFile file = open();
  EXPECT_TRUE(file.is_open());
  EXPECT_TRUE(file.append("one\n"));
  EXPECT_TRUE(file.append("two\n"));
  EXPECT_EQ(file.size(), 8u);
  EXPECT_EQ(content_of(path), "");
  EXPECT_TRUE(file.flush());
  EXPECT_EQ(content_of(path), "one\ntwo\n");
  EXPECT_TRUE(file.append("three\n"));
  EXPECT_EQ(file.size(), 14u);
  EXPECT_TRUE(file.close());
  EXPECT_FALSE(file.is_open());
  EXPECT_EQ(content_of(path), "one\ntwo\nthree\n");
}

TEST_F(AppendFiles, ABufferOf64KiBIsWrittenByItself) {
  AppendFile file = open();
  const std::string piece(1024, 'x');
  for (int i = 0; i < 63; ++i) EXPECT_TRUE(file.append(piece));
  EXPECT_EQ(content_of(path).size(), 0u);
  EXPECT_TRUE(file.append(piece));
  EXPECT_EQ(content_of(path).size(), 64u * 1024);
  EXPECT_EQ(file.size(), 64u * 1024);
}

TEST_F(AppendFiles, AFileThatIsThereIsEmptied) {
  put_file(path, "old");
  EXPECT_TRUE(open().close());
  EXPECT_EQ(content_of(path), "");
}

TEST_F(AppendFiles, TheDestructorWritesWhatIsLeft) {
  {
    AppendFile file = open();
    EXPECT_TRUE(file.append("last\n"));
  }
  EXPECT_EQ(content_of(path), "last\n");
}

TEST_F(AppendFiles, AMovedFileGoesOnAtItsNewPlace) {
  AppendFile file = open();
  EXPECT_TRUE(file.append("one\n"));
  AppendFile second(std::move(file));
  EXPECT_TRUE(second.append("two\n"));
  auto other = AppendFile::create(folder / "other");
  ASSERT_TRUE(other);
  EXPECT_TRUE(other->append("other\n"));
  *other = std::move(second);
  EXPECT_EQ(content_of(folder / "other"), "other\n") << "closed by the assignment";
  EXPECT_EQ(other->size(), 8u);
  EXPECT_TRUE(other->append("three\n"));
  EXPECT_TRUE(other->close());
  EXPECT_EQ(content_of(path), "one\ntwo\nthree\n");
}

TEST_F(AppendFiles, AFolderThatIsMissingIsAnErrorWithTheName) {
  const auto file = AppendFile::create(folder / "missing" / "log");
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().kind, ErrorKind::kResource);
  EXPECT_EQ(file.error().file, (folder / "missing" / "log").string());
  EXPECT_THAT(file.error().message, HasSubstr("cannot be written: "));
}

TEST_F(AppendFiles, AFullDiskLeavesWholePiecesAndItsErrorStays) {
  AppendFile file = open();
  EXPECT_TRUE(file.append("first\n"));
  EXPECT_TRUE(file.flush());
  {
    const FileSizeLimit limit(6 + 7 + 3);
    EXPECT_TRUE(file.append("second\n"));
    EXPECT_TRUE(file.append("third\n"));
    EXPECT_TRUE(file.append("fourth\n"));
    const Status full = file.flush();
    ASSERT_FALSE(full);
    EXPECT_EQ(full.error().kind, ErrorKind::kResource);
    EXPECT_THAT(full.error().text(), HasSubstr(path.string() + ": writing stopped: "));
  }
  EXPECT_EQ(content_of(path), "first\nsecond\n") << "no half piece";
  EXPECT_EQ(file.size(), 13u);
  EXPECT_FALSE(file.append("fifth\n")) << "also when there is room again";
  EXPECT_FALSE(file.flush());
  EXPECT_FALSE(file.close());
  EXPECT_FALSE(file.status());
  EXPECT_EQ(content_of(path), "first\nsecond\n");
}

TEST_F(AppendFiles, AFullDiskAtTheFirstPieceLeavesNothingOfIt) {
  AppendFile file = open();
  {
    const FileSizeLimit limit(3);
    EXPECT_TRUE(file.append("first\n"));
    EXPECT_FALSE(file.close());
  }
  EXPECT_EQ(content_of(path), "");
  EXPECT_EQ(file.size(), 0u);
}

TEST_F(AppendFiles, AClosedFileTakesNothing) {
  AppendFile file = open();
  EXPECT_TRUE(file.close());
  EXPECT_TRUE(file.append("late\n")) << "no error, and no file";
  EXPECT_TRUE(file.close());
  EXPECT_EQ(content_of(path), "");
}

}  // namespace
}  // namespace cxlab
