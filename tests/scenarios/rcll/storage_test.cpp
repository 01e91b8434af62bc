#include "scenarios/rcll/rules/storage.h"

#include <gmock/gmock.h>

#include "tests/support/game_story.h"

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

/// Only what is blocked needs another slot.
TEST(Storage, AStationThatIsFullServesSlotsThatNothingBlocks) {
  WorldConfig config = GameStory::quiet_game();
  config.production_s = 3000;
  GameStory story(config);
  story.set_jumping(true);
  const auto storage = [&](const char* operation, int shelf, int slot) {
    const Outcome outcome =
        story.carry_out("{machine: C-SS, operation: " + std::string(operation) + ", shelf: " + std::to_string(shelf) +
                        ", slot: " + std::to_string(slot) + "}");
    story.run_for(6);
    return outcome;
  };
  const sim::Spot& input = story.world().plan().spot(story.spot("C-SS-INPUT"));
  for (const int slot : {3, 5, 7, 0, 2, 4, 6})
    for (int shelf = 0; shelf < Storage::kShelves; ++shelf) {
      ASSERT_TRUE(story.world().dispense(input.station, input.rest_in_station.x(), sim::Stack{1, {}, 0}));
      ASSERT_EQ(storage("STORE", shelf, slot).code, 0) << "shelf " << shelf << ", slot " << slot;
    }
  const Outcome behind = storage("RETRIEVE", 0, 1);
  EXPECT_EQ(behind.code, 103);
  EXPECT_THAT(behind.error, testing::HasSubstr("a workpiece lies before shelf 0, slot 1, and no other slot is free"));
  story.run_for(31);
  EXPECT_EQ(storage("RETRIEVE", 0, 0).code, 0);
  EXPECT_FALSE(story.nothing_at("C-SS-OUTPUT"));
}

}  // namespace
}  // namespace cxlab::rcll
