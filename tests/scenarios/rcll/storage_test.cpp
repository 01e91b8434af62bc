#include "scenarios/rcll/rules/storage.h"

#include <gmock/gmock.h>

namespace cxlab::rcll {
namespace {

using Slot = Storage::Slot;

TEST(Storage, HasOneC0BehindTheFirstSlotOfEachShelf) {
  const Storage storage = Storage::at_start();
  for (int shelf = 0; shelf < Storage::kShelves; ++shelf)
    for (int slot = 0; slot < Storage::kSlots; ++slot) EXPECT_EQ(storage.at({shelf, slot}).has_value(), slot == 1);
}

TEST(Storage, ASlotIsBlockedByWhatLiesBeforeIt) {
  Storage storage = Storage::at_start();
  EXPECT_FALSE(storage.blocker({2, 1})) << "nothing lies before it";
  EXPECT_FALSE(storage.blocker({2, 0})) << "what lies behind blocks nothing";
  storage.at({2, 0}) = Storage::Content{};
  EXPECT_EQ(storage.blocker({2, 1}), (Slot{2, 0}));
  EXPECT_FALSE(storage.blocker({2, 2})) << "another pair";
}

TEST(Storage, FreeSlotsAreEmptyReachableAndNotTheOneThatIsAskedFor) {
  Storage storage = Storage::at_start();
  EXPECT_EQ(storage.free_slots({0, 1}).size(), 42u) << "all but the six that are filled";
  EXPECT_EQ(storage.free_slots({0, 0}).size(), 41u);
  storage.at({3, 2}) = Storage::Content{};
  EXPECT_EQ(storage.free_slots({3, 2}).size(), 40u) << "nor the one behind it";
  EXPECT_THAT(storage.free_slots({3, 2}), testing::Not(testing::Contains(Slot{3, 3})));
}

}  // namespace
}  // namespace cxlab::rcll
