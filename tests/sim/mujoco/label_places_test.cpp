#include "sim/mujoco/label_places.h"

#include <cstdlib>

#include <gtest/gtest.h>

#include "cx/base/random.h"

namespace cxlab::sim {
namespace {

constexpr Box kPicture{0, 0, 640, 400};

int overlaps(const std::vector<LabelWish>& wishes, const std::vector<Box>& taken, const std::vector<Box>& labels) {
  int count = 0;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    for (const LabelWish& wish : wishes) count += labels[i].overlaps(wish.body);
    for (const Box& box : taken) count += labels[i].overlaps(box);
    for (std::size_t k = 0; k < i; ++k) count += labels[i].overlaps(labels[k]);
    count += !labels[i].within(kPicture);
  }
  return count;
}

TEST(PlaceLabels, StandByTheirBodiesInFiftyCrowdedPictures) {
  RandomStream random(1, "label places");
  int far = 0, all = 0;
  for (int picture = 0; picture < 50; ++picture) {
    std::vector<LabelWish> wishes;
    std::vector<Box> taken;
    for (int i = 0; i < 17; ++i) {
      const int x = 20 + 40 * static_cast<int>(random.below(14)), y = 20 + 40 * static_cast<int>(random.below(8));
      wishes.push_back({{x, y, 34, 38}, 60, 19});
      if (i % 3 == 0) taken.push_back({x + 10, y + 30, 9, 20});
    }
    const std::vector<Box> labels = place_labels(wishes, taken, kPicture);
    EXPECT_EQ(overlaps(wishes, taken, labels), 0) << picture;
    for (std::size_t i = 0; i < labels.size(); ++i, ++all) {
      EXPECT_EQ(labels[i].width, 60);
      EXPECT_LE(gap_between(labels[i], wishes[i].body), 60) << picture << ' ' << i;
      far += gap_between(labels[i], wishes[i].body) > 10;
    }
    EXPECT_EQ(place_labels(wishes, taken, kPicture), labels);
  }
  EXPECT_LT(far, all / 10);
}

TEST(PlaceLabels, TakesTheNearestFreePlace) {
  const std::vector<LabelWish> wish{{{90, 90, 20, 20}, 40, 10}};
  const Box picture{0, 0, 200, 200};
  EXPECT_EQ(place_labels(wish, {}, picture).front(), (Box{80, 112, 40, 10}));                  // above
  EXPECT_EQ(place_labels(wish, {{0, 115, 200, 85}}, picture).front(), (Box{80, 78, 40, 10}));  // below
  EXPECT_EQ(place_labels(wish, {{0, 115, 200, 85}, {0, 0, 200, 85}}, picture).front(), (Box{112, 95, 40, 10}));
}

TEST(PlaceLabels, MakesRoomForOneThatHasNoOtherPlace) {
  // The first could be above its body or below; the second only where the first would go.
  const std::vector<LabelWish> wishes{{{60, 60, 20, 20}, 40, 10}, {{60, 96, 20, 20}, 40, 10}};
  const std::vector<Box> taken{{0, 116, 200, 84}, {0, 94, 56, 22}, {84, 94, 116, 22}};
  const std::vector<Box> labels = place_labels(wishes, taken, {0, 0, 200, 200});
  EXPECT_EQ(gap_between(labels[1], wishes[1].body), 2);
  EXPECT_EQ(gap_between(labels[0], wishes[0].body), 2);
  EXPECT_LT(labels[0].bottom, 60);
}

TEST(PlaceLabels, LabelWithoutAPlaceIsLeftOut) {
  EXPECT_EQ(place_labels(std::vector<LabelWish>{{{5, 5, 10, 10}, 40, 10}}, {}, {0, 0, 30, 30}).front().width, 0);
}

TEST(Leader, CrossesABoxOnlyWhereItRunsThroughIt) {
  const Leader leader{0, 0, 100, 50};
  EXPECT_TRUE(leader.crosses({40, 15, 20, 10}));
  EXPECT_FALSE(leader.crosses({40, 35, 20, 10}));
  EXPECT_FALSE(leader.crosses({110, 50, 20, 20}));
  EXPECT_TRUE((Leader{50, 0, 50, 100}).crosses({40, 40, 20, 10}));
  EXPECT_FALSE((Leader{30, 0, 30, 100}).crosses({40, 40, 20, 10}));
}

TEST(GapBetween, IsTheWiderOfTheTwoGaps) {
  const Box box{100, 100, 20, 10};
  EXPECT_EQ(gap_between(box, {130, 100, 5, 5}), 10);
  EXPECT_EQ(gap_between(box, {130, 140, 5, 5}), 30);
  EXPECT_EQ(gap_between({0, 0, 90, 90}, box), 10);
  EXPECT_EQ(gap_between(box, {110, 105, 50, 50}), 0);
}

}  // namespace
}  // namespace cxlab::sim
