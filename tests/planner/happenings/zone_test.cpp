// Distances of points in time.

#include "planner/happenings/zone.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

namespace cxlab::planner {
namespace {

constexpr Micros kAny = Zone::kAny;

Zone with_points(int count) {
  Zone zone;
  for (int i = 0; i < count; ++i) EXPECT_EQ(zone.add_point(), i);
  return zone;
}

TEST(Zone, PointsAreAnyDistanceApartUntilSomethingIsRequired) {
  const Zone zone = with_points(2);
  EXPECT_EQ(zone.most(0, 1), kAny);
  EXPECT_EQ(zone.least(0, 1), -kAny);
  EXPECT_EQ(zone.most(1, 1), 0);
  EXPECT_FALSE(zone.is_fixed(0, 1));
}

TEST(Zone, WhatIsRequiredLeadsOverOtherPoints) {
  Zone zone = with_points(4);
  ASSERT_TRUE(zone.require(0, 1, 5));
  ASSERT_TRUE(zone.require(1, 2, 3));
  EXPECT_EQ(zone.least(0, 2), 8);
  EXPECT_EQ(zone.most(0, 2), kAny) << "nothing bounds it from above";
  EXPECT_EQ(zone.most(0, 1), kAny);
  for (int other = 0; other < 3; ++other) {
    EXPECT_EQ(zone.most(3, other), kAny) << "of a point of which nothing is known";
    EXPECT_EQ(zone.most(other, 3), kAny);
  }
  ASSERT_TRUE(zone.require(2, 0, -10)) << "2 is at most 10 after 0";
  EXPECT_EQ(zone.most(0, 2), 10);
  EXPECT_EQ(zone.most(0, 1), 7);
  EXPECT_EQ(zone.most(1, 2), 5);
}

TEST(Zone, HasNothingLeftWhereRequirementsContradictEachOther) {
  Zone zone = with_points(3);
  ASSERT_TRUE(zone.require(0, 1, 5));
  ASSERT_TRUE(zone.require(1, 2, 3));
  Zone exact = zone;
  EXPECT_TRUE(exact.require(2, 0, -8));
  EXPECT_TRUE(exact.is_fixed(0, 2));
  EXPECT_TRUE(exact.is_fixed(0, 1));
  EXPECT_FALSE(zone.require(2, 0, -7));
}

TEST(Zone, ANewPointLeavesTheOthersAsTheyAre) {
  Zone zone = with_points(2);
  ASSERT_TRUE(zone.require(0, 1, 5));
  ASSERT_TRUE(zone.require(1, 0, -6));
  EXPECT_EQ(zone.add_point(), 2);
  EXPECT_EQ(zone.least(0, 1), 5);
  EXPECT_EQ(zone.most(0, 1), 6);
  EXPECT_EQ(zone.most(1, 2), kAny);
  EXPECT_EQ(zone.most(2, 2), 0);
}

TEST(Zone, KeepsSomePointsInANewOrder) {
  Zone zone = with_points(3);
  ASSERT_TRUE(zone.require(0, 1, 5));
  ASSERT_TRUE(zone.require(1, 2, 3));
  zone.keep(std::array{2, 0});
  EXPECT_EQ(zone.points(), 2);
  EXPECT_EQ(zone.least(1, 0), 8) << "what was known over the forgotten point stays";
}

TEST(Zone, ContainsWhatIsAsNarrowOrNarrower) {
  Zone wide = with_points(2);
  ASSERT_TRUE(wide.require(0, 1, 5));
  Zone narrow = wide;
  EXPECT_TRUE(wide.contains(narrow));
  ASSERT_TRUE(narrow.require(1, 0, -9));
  EXPECT_TRUE(wide.contains(narrow));
  EXPECT_FALSE(narrow.contains(wide));
}

}  // namespace
}  // namespace cxlab::planner
