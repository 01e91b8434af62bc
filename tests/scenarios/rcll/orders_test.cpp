#include "scenarios/rcll/rules/orders.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "scenarios/rcll/game/game.h"

namespace cxlab::rcll::orders_test {
namespace {

constexpr int kGames = 1000;

std::vector<Schedule> many_schedules(const std::vector<Complexity>& allowed = {}) {
  std::vector<Schedule> schedules;
  for (std::uint64_t seed = 0; seed < kGames; ++seed) {
    RandomStream random(seed, "orders");
    schedules.push_back(draw_schedule(random, allowed));
  }
  return schedules;
}

/// Sum over the orders of all games, a game.
template <class Value>
double per_game(const std::vector<Schedule>& schedules, Value value) {
  double sum = 0;
  for (const Schedule& schedule : schedules)
    for (const Order& order : schedule.orders) sum += static_cast<double>(value(schedule, order));
  return sum / static_cast<double>(schedules.size());
}

TEST(DrawnOrders, TenWithIdsFromOneAndTwoStandingFromTheStart) {
  for (const Schedule& schedule : many_schedules()) {
    ASSERT_EQ(schedule.orders.size(), 10u);
    for (int i = 0; i < 10; ++i) EXPECT_EQ(schedule.orders[static_cast<std::size_t>(i)].id, i + 1);
    for (int i = 0; i < 2; ++i) {
      const Order& standing = schedule.orders[static_cast<std::size_t>(i)];
      EXPECT_EQ(standing.activate_at, 0);
      EXPECT_EQ(standing.delivery_begin, 0);
      EXPECT_EQ(standing.delivery_end, 1200);
      EXPECT_FALSE(standing.competitive);
      if (!standing.product.rings.empty()) {
        EXPECT_EQ(schedule.price(standing.product.rings[0]), 0);
      }
    }
    EXPECT_LT(schedule.orders[0].complexity, Complexity::kC2);
    EXPECT_GE(schedule.orders[1].complexity, Complexity::kC2);
  }
}

TEST(DrawnOrders, TimesKeepToTheLimitsOfTheirComplexity) {
  constexpr int kMinWindow[]{90, 90, 150, 150}, kMaxWindow[]{180, 180, 210, 210};
  for (const Schedule& schedule : many_schedules())
    for (const Order& order : schedule.orders) {
      if (order.id < 3) continue;
      const auto kind = static_cast<std::size_t>(order.complexity);
      const double window = order.delivery_end - order.delivery_begin;
      EXPECT_GE(window, kMinWindow[kind]);
      EXPECT_LE(window, kMaxWindow[kind]);
      EXPECT_GE(order.activate_at, 180);
      EXPECT_LE(order.activate_at, 960);
      EXPECT_LE(order.delivery_end, 1200);
      EXPECT_GT(order.delivery_begin, order.activate_at);
      EXPECT_LE(order.delivery_begin - order.activate_at, kind == 0 ? 120 : 500);
    }
}

TEST(DrawnOrders, ExactlyOneIsCompetitiveAndAnyOfTheLaterOnesMayBe) {
  std::map<int, int> competitive;
  for (const Schedule& schedule : many_schedules()) {
    int count = 0;
    for (const Order& order : schedule.orders)
      if (order.competitive) ++count, ++competitive[order.id];
    EXPECT_EQ(count, 1);
  }
  for (int id = 3; id <= 10; ++id) EXPECT_NEAR(competitive[id], kGames / 8, 45) << id;
}

TEST(DrawnOrders, NoRingLiesOnItsOwnColourAndNoTwoProductsBeginAlike) {
  for (const Schedule& schedule : many_schedules())
    for (const Order& order : schedule.orders) {
      const auto& rings = order.product.rings;
      EXPECT_EQ(rings.size(), static_cast<std::size_t>(order.complexity));
      EXPECT_EQ(std::ranges::adjacent_find(rings), rings.end());
      EXPECT_NE(order.product.base, BaseColor::kClear);
      for (const Order& earlier : schedule.orders)
        if (earlier.id < order.id && !rings.empty() && !earlier.product.rings.empty()) {
          EXPECT_FALSE(earlier.product.base == order.product.base && earlier.product.rings[0] == rings[0]);
        }
    }
}

TEST(DrawnOrders, TwoColoursAreFreeOneCostsOneAndOneTwo) {
  std::map<int, std::array<int, 4>> prices;
  for (const Schedule& schedule : many_schedules()) {
    auto sorted = schedule.ring_prices;
    std::ranges::sort(sorted);
    EXPECT_EQ(sorted, (RingPrices{0, 0, 1, 2}));
    for (std::size_t c = 0; c < 4; ++c) ++prices[schedule.ring_prices[c]][c];
  }
  for (std::size_t c = 0; c < 4; ++c) {
    EXPECT_NEAR(prices[0][c], kGames / 2, 65);
    EXPECT_NEAR(prices[1][c], kGames / 4, 55);
    EXPECT_NEAR(prices[2][c], kGames / 4, 55);
  }
}

// Means of recorded schedules of the referee box (200 to 300 games). The bounds are three standard errors of the
// difference, rounded up.
TEST(DrawnOrders, HaveTheMeansOfRecordedSchedulesOfTheRefereeBox) {
  const std::vector<Schedule> games = many_schedules();
  const auto count = [&](auto predicate) {
    return per_game(games, [&](const Schedule&, const Order& order) { return predicate(order) ? 1 : 0; });
  };
  EXPECT_NEAR(count([](const Order& o) { return o.complexity == Complexity::kC0; }), 2.46, 0.25);
  EXPECT_NEAR(count([](const Order& o) { return o.complexity == Complexity::kC1; }), 2.54, 0.25);
  EXPECT_NEAR(count([](const Order& o) { return o.complexity == Complexity::kC2; }), 2.60, 0.25);
  EXPECT_NEAR(count([](const Order& o) { return o.complexity == Complexity::kC3; }), 2.40, 0.25);
  EXPECT_NEAR(per_game(games, [](const Schedule&, const Order& o) { return o.product.rings.size(); }), 14.9, 0.35);
  EXPECT_NEAR(per_game(games,
                       [](const Schedule& s, const Order& o) {
                         int payments = 0;
                         for (const RingColor ring : o.product.rings) payments += s.price(ring);
                         return payments;
                       }),
              10.7, 0.7);
  EXPECT_NEAR(count([](const Order& o) { return o.id > 2 && o.activate_at == 180; }), 2.7, 0.25);
  EXPECT_NEAR(count([](const Order& o) { return o.activate_at == 960; }), 0.08, 0.06);

  std::vector<double> activations;
  double window = 0, begin = 0, lead = 0;
  for (const Schedule& game : games)
    for (const Order& o : game.orders) {
      if (o.id < 3) continue;
      activations.push_back(o.activate_at);
      window += o.delivery_end - o.delivery_begin;
      begin += o.delivery_begin;
      lead += o.delivery_begin - o.activate_at;
    }
  const auto n = static_cast<double>(activations.size());
  std::ranges::nth_element(activations, activations.begin() + static_cast<std::ptrdiff_t>(activations.size() / 2));
  EXPECT_NEAR(activations[activations.size() / 2], 325, 25);
  EXPECT_NEAR(window / n, 157.6, 3);
  EXPECT_NEAR(begin / n, 640.9, 10);
  EXPECT_NEAR(lead / n, 250.0, 12);
}

/// FNV-1a, 64 bits, of all that orders and prices say.
std::uint64_t fingerprint(const std::vector<Schedule>& schedules) {
  std::uint64_t hash = 0xcbf29ce484222325;
  const auto add = [&hash](std::int64_t value) {
    for (int byte = 0; byte < 8; ++byte)
      hash = (hash ^ (static_cast<std::uint64_t>(value) >> 8 * byte & 0xff)) * 0x100000001b3;
  };
  for (const Schedule& schedule : schedules) {
    for (const int price : schedule.ring_prices) add(price);
    for (const Order& order : schedule.orders) {
      add(order.id), add(static_cast<int>(order.complexity)), add(static_cast<int>(order.product.base));
      for (const RingColor ring : order.product.rings) add(static_cast<int>(ring));
      add(static_cast<int>(order.product.cap)), add(order.delivery_gate), add(order.quantity), add(order.competitive);
      for (const double time : {order.activate_at, order.delivery_begin, order.delivery_end}) add(std::llround(time));
    }
  }
  return hash;
}

TEST(DrawnOrders, OfASeedStayTheSame) {
  using enum Complexity;
  EXPECT_EQ(fingerprint(many_schedules()), 11413375325294933174U);
  EXPECT_EQ(fingerprint(many_schedules({kC0})), 16927381528882455230U);
  EXPECT_EQ(fingerprint(many_schedules({kC2, kC3})), 2457102585041913408U);
}

TEST(DrawnOrders, CanBeLimitedToC0AndKeepTheTimesOfC0) {
  std::map<BaseColor, int> bases;
  for (const Schedule& schedule : many_schedules({Complexity::kC0}))
    for (const Order& order : schedule.orders) {
      EXPECT_EQ(order.complexity, Complexity::kC0);
      EXPECT_TRUE(order.product.rings.empty());
      ++bases[order.product.base];
      if (order.id < 3) continue;
      EXPECT_GE(order.delivery_begin, 180);
      EXPECT_LE(order.delivery_begin - order.activate_at, 120);
    }
  EXPECT_EQ(bases.size(), 3u);
}

TEST(DrawnOrders, OneClassOfComplexitiesServesForBoth) {
  for (const Schedule& schedule : many_schedules({Complexity::kC3}))
    for (const Order& order : schedule.orders) EXPECT_EQ(order.complexity, Complexity::kC3);
  bool seen_c2 = false;
  for (const Schedule& schedule : many_schedules({Complexity::kC0, Complexity::kC2}))
    for (const Order& order : schedule.orders) {
      EXPECT_TRUE(order.complexity == Complexity::kC0 || order.complexity == Complexity::kC2);
      seen_c2 |= order.complexity == Complexity::kC2;
    }
  EXPECT_TRUE(seen_c2);
}

TEST(ListedOrders, AreTakenAsTheyStandAndPricesStayThoseOfTheSeed) {
  WorldConfig config;
  OrderConfig order;
  order.complexity = "C1";
  order.base_color = "BASE_SILVER";
  order.ring_colors = {"RING_GREEN"};
  order.cap_color = "CAP_GREY";
  order.activate_at = 10;
  order.delivery_begin = 100;
  order.delivery_end = 250;
  order.quantity = 2;
  config.orders = {order, {}};
  const Game game = *game_of(config, 4);
  ASSERT_EQ(game.schedule.orders.size(), 2u);
  EXPECT_EQ(game.schedule.orders[1].id, 2);
  EXPECT_EQ(describe(stack_of(game.schedule.orders[0].product)), "BASE_SILVER RING_GREEN CAP_GREY");
  EXPECT_EQ(game.schedule.orders[0].quantity, 2);
  EXPECT_EQ(game.schedule.ring_prices, game_of(WorldConfig{}, 4)->schedule.ring_prices);
}

}  // namespace
}  // namespace cxlab::rcll::orders_test
