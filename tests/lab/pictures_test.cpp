#include "lab/pictures.h"

#include <gmock/gmock.h>

#include "cx/base/process.h"
#include "folder.h"

namespace cxlab::lab {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(SnapshotTimes, ReadsAListInOrder) {
  EXPECT_THAT(*snapshot_times("3,1,2.5", 10), ElementsAre(1, 2.5, 3));
  EXPECT_THAT(*snapshot_times("", 10), IsEmpty());
}

TEST(SnapshotTimes, ReadsAStep) { EXPECT_THAT(*snapshot_times("every:4", 10), ElementsAre(0, 4, 8)); }

TEST(SnapshotTimes, RejectsWhatCannotBe) {
  for (const char* text : {"x", "1,,2", ",", "-1", "every:", "every:0", "every:-1", "every:1e-9", "11", "nan", "inf"}) {
    const auto times = snapshot_times(text, 10);
    ASSERT_FALSE(times) << text;
    EXPECT_EQ(times.error().kind, ErrorKind::kUsage) << text;
  }
}

using PicturesTest = FolderTest;

TEST_F(PicturesTest, ThatCannotBeMadeAreAnErrorBeforeTheRun) {
  scenario("game", kQuietRules);  // in an empty world
  const Played played = play("game", {.snapshot = "1"});
  ASSERT_TRUE(played.failure);
  EXPECT_EQ(played.failure->kind, ErrorKind::kResource);
  EXPECT_THAT(played.failure->message, HasSubstr("no pictures: the world is empty"));
  EXPECT_EQ(played.result.ticks, 0);
}

}  // namespace
}  // namespace cxlab::lab
