#include <gmock/gmock.h>

#include <map>

#include "scenarios/rcll/game/game.h"

namespace cxlab::rcll {
namespace {

TEST(DrawnGame, HasACompetitiveC0ForOvertime) {
  WorldConfig config;
  config.robots = 0;  // any layout will do
  std::map<int, int> gates;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const Order order = *game_of(config, seed)->overtime;
    EXPECT_EQ(order.id, 11);
    EXPECT_EQ(order.complexity, Complexity::kC0);
    EXPECT_TRUE(order.product.rings.empty());
    EXPECT_NE(order.product.base, BaseColor::kClear);
    EXPECT_TRUE(order.competitive);
    EXPECT_EQ(order.activate_at, 1200);
    EXPECT_EQ(order.delivery_begin, 1200);
    EXPECT_EQ(order.delivery_end, 1500);
    EXPECT_EQ(order.quantity, 1);
    ++gates[order.delivery_gate];
  }
  EXPECT_EQ(gates.size(), 3u);
}

TEST(DrawnGame, HasOneRingAndOneCapStationDownOnce) {
  const Game game = *game_of({}, 1);
  ASSERT_EQ(game.down.size(), 2u);
  EXPECT_THAT(game.down[0].machine, testing::MatchesRegex("RS[12]"));
  EXPECT_THAT(game.down[1].machine, testing::MatchesRegex("CS[12]"));
  WorldConfig never;
  never.down = false;
  EXPECT_THAT(game_of(never, 1)->down, testing::IsEmpty());
}

TEST(DrawnGame, KeepsTheIdOfOvertimeBehindListedOrders) {
  WorldConfig config;
  config.orders.resize(2);
  EXPECT_EQ(game_of(config, 1)->overtime->id, 3);
  config.overtime_s = 0;
  EXPECT_FALSE(game_of(config, 1)->overtime);
}

}  // namespace
}  // namespace cxlab::rcll
