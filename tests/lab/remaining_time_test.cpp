#include "lab/sweep/remaining_time.h"

#include <gtest/gtest.h>

namespace cxlab::lab {
namespace {

TEST(RemainingTime, IsUnknownBeforeTheFirstGameHasEnded) {
  RemainingTime time;
  time.add("a", 3);
  time.begun("a");
  EXPECT_FALSE(time.estimate(1, 5));
}

TEST(RemainingTime, CountsEachKindByItsOwnGames) {
  RemainingTime time;
  time.add("short", 3);
  time.add("long", 2);
  time.begun("short");
  time.ended("short", 1);
  time.begun("long");
  EXPECT_DOUBLE_EQ(*time.estimate(1, 0), 4) << "two short ones, and two of which nothing better is known";
  time.ended("long", 10);
  EXPECT_DOUBLE_EQ(*time.estimate(1, 0), 12) << "two short ones and a long one";
  EXPECT_DOUBLE_EQ(*time.estimate(2, 0), 6) << "on two processors";
}

TEST(RemainingTime, CountsWhatIsLeftOfGamesThatArePlayed) {
  RemainingTime time;
  time.add("a", 2);
  time.begun("a");
  time.ended("a", 10);
  time.begun("a");
  EXPECT_DOUBLE_EQ(*time.estimate(1, 4), 6);
  EXPECT_DOUBLE_EQ(*time.estimate(1, 15), 0) << "it takes longer than the others; it is never less than nothing";
}

}  // namespace
}  // namespace cxlab::lab
