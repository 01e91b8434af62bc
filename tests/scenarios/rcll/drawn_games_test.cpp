// Drawn games compared with schedules of the referee box. Each comparison has a level of 0.1 %: some fifty of them
// together would refuse a right generator once in twenty seeds.

#include <gtest/gtest.h>

#include <algorithm>

#include "scenarios/rcll/game/game.h"
#include "tests/support/statistics.h"

namespace cxlab::rcll {
namespace {

constexpr std::uint64_t kGames = 1000;
/// How often each value, or each stretch of values, came.
using Histogram = std::vector<int>;

// Counted in 200 schedules that the referee box's own rules drew.

// orders 1 to 10: C0, C1, C2, C3
const std::vector<Histogram> kComplexity{
    {101, 99, 0, 0},  {0, 0, 100, 100}, {52, 51, 45, 52}, {64, 50, 50, 36}, {52, 50, 47, 51},
    {55, 58, 47, 40}, {45, 47, 50, 58}, {48, 55, 55, 42}, {37, 46, 61, 56}, {37, 53, 59, 51},
};
// colour that costs 2 (blue, green, orange, yellow), for each: colour that costs 1
const Histogram kPrices{0, 14, 12, 19, 17, 0, 15, 12, 13, 22, 0, 12, 17, 24, 23, 0};
// orders 1 to 11: gates 1, 2, 3
const std::vector<Histogram> kGate{
    {67, 65, 68}, {53, 67, 80}, {80, 63, 57}, {67, 64, 69}, {70, 66, 64}, {71, 64, 65},
    {69, 66, 65}, {64, 73, 63}, {65, 74, 61}, {69, 67, 64}, {75, 69, 56},
};
// orders 3 to 10
const Histogram kCompetitive{20, 25, 28, 27, 24, 21, 25, 30};
// first, second, third ring: blue, green, orange, yellow
const std::vector<Histogram> kRing{
    {402, 371, 387, 349},
    {231, 256, 255, 258},
    {122, 111, 141, 112},
};
// red, black, silver bases, each with a black and a grey cap; orders 1 to 11
const Histogram kProduct{374, 370, 366, 382, 337, 371};
// payments of a game: 0 to 30
const Histogram kPayments{0, 0, 0, 0, 2, 6, 4, 10, 23, 22, 24, 34, 25, 26, 8, 5,
                          8, 2, 1, 0, 0, 0, 0, 0,  0,  0,  0,  0,  0,  0,  0};
// orders 3 to 10: activation in steps of 30 s from 180 s
const std::vector<Histogram> kActivation{
    {200, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
    {162, 17, 10, 9, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
    {127, 7, 21, 12, 9, 9, 10, 3, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
    {69, 19, 9, 10, 9, 13, 15, 16, 11, 11, 9, 5, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
    {31, 11, 10, 20, 13, 12, 11, 18, 7, 6, 10, 15, 13, 4, 13, 5, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
    {0, 2, 6, 6, 14, 9, 11, 15, 21, 14, 11, 11, 11, 9, 11, 9, 14, 9, 11, 6, 0, 0, 0, 0, 0, 0, 0},
    {0, 0, 0, 0, 1, 5, 6, 7, 7, 16, 19, 15, 14, 10, 12, 13, 11, 9, 14, 7, 12, 9, 9, 3, 1, 0, 0},
    {0, 0, 0, 0, 0, 0, 0, 0, 1, 4, 5, 7, 14, 13, 15, 16, 13, 14, 12, 8, 9, 10, 12, 15, 10, 9, 13},
};
// orders 3 to 10: begin of the window in steps of 30 s from 240 s
const std::vector<Histogram> kBegin{
    {22, 59, 31, 27, 27, 20, 13, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
    {11, 17, 21, 17, 27, 23, 21, 16, 22, 16, 9, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
    {0, 0, 0, 18, 12, 15, 23, 21, 33, 32, 13, 15, 8, 7, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
    {0, 0, 0, 0, 0, 0, 0, 24, 22, 27, 29, 34, 48, 12, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
    {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 20, 22, 46, 35, 35, 41, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
    {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 41, 34, 34, 37, 27, 25, 2, 0, 0, 0, 0, 0, 0, 0},
    {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 28, 31, 31, 32, 43, 35, 0, 0, 0, 0},
    {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 30, 35, 60, 56, 15, 4},
};
// C0 and C1 of orders 3 to 10: begin of the window after its mean, in steps of 10 s from -240 s. The mean is 180 s, and
// 120 s more for each order.
const Histogram kOffset{0,  0,  0,  0,  0,  0,  0,  0,  0,  0,  0,  0,  0,  0,  0,  37, 28, 29, 34, 41,
                        26, 36, 44, 38, 47, 45, 45, 44, 46, 38, 35, 40, 41, 21, 14, 15, 6,  11, 7,  5,
                        8,  3,  4,  4,  4,  0,  1,  1,  0,  0,  2,  0,  0,  0,  0,  0,  0,  0,  0,  0};
// C0 to C3: from activation to the begin of the window, in steps of 10 s from 60 s
const std::vector<Histogram> kLead{
    {70, 65, 65, 63, 64, 56, 7, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
     0,  0,  0,  0,  0,  0,  0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
    {0,  0, 0, 1, 4, 5, 19, 27, 29, 24, 25, 28, 19, 30, 14, 27, 17, 22, 28, 16, 24, 16, 25,
     10, 0, 0, 0, 0, 0, 0,  0,  0,  0,  0,  0,  0,  0,  0,  0,  0,  0,  0,  0,  0,  0},
    {0, 0,  0,  5,  2,  4,  3,  4,  1,  1,  3,  3, 2, 1, 3, 4, 4, 6, 8, 3, 5, 3, 7,
     2, 41, 42, 36, 42, 31, 33, 26, 26, 35, 26, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
    {0, 0, 0, 5, 2, 3,  1, 2, 4, 4, 4, 1,  2,  4,  3,  4,  8,  8,  3,  3,  5,  2, 1,
     3, 0, 4, 2, 4, 10, 7, 7, 3, 5, 2, 37, 26, 36, 23, 20, 36, 23, 25, 23, 19, 2},
};
// C0 to C3: length of the window in steps of 5 s from 90 s
const std::vector<Histogram> kLength{
    {19, 27, 19, 22, 20, 22, 18, 20, 16, 25, 29, 30, 20, 18, 21, 14, 17, 28, 5, 0, 0, 0, 0, 0, 0},
    {15, 21, 29, 26, 26, 25, 7, 16, 26, 14, 24, 28, 27, 18, 28, 24, 24, 26, 6, 0, 0, 0, 0, 0, 0},
    {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 39, 30, 29, 44, 39, 33, 33, 29, 31, 33, 31, 33, 10},
    {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 30, 29, 39, 37, 33, 32, 34, 31, 33, 31, 21, 32, 4},
};

const std::vector<Game>& drawn_games() {
  static const std::vector<Game> games = [] {
    WorldConfig config;
    config.robots = 0;  // layouts are not looked at: the first draw will do
    std::vector<Game> drawn;
    for (std::uint64_t seed = 0; seed < kGames; ++seed) drawn.push_back(*game_of(config, seed));
    return drawn;
  }();
  return games;
}

/// Counts in steps of `step` from `low`; what lies outside is a failure.
class Counter {
 public:
  Counter(std::size_t size, int low = 0, int step = 1) : counts_(size), low_(low), step_(step) {}
  void add(double value) {
    const auto at = static_cast<std::size_t>((static_cast<int>(value) - low_) / step_);
    if (value < low_ || at >= counts_.size())
      ADD_FAILURE() << value << " is out of range";
    else
      ++counts_[at];
  }
  const Histogram& counts() const { return counts_; }

 private:
  Histogram counts_;
  int low_, step_;
};

/// Chi-square.
void expect_alike(const Histogram& recorded, const Histogram& drawn, const std::string& what) {
  ASSERT_EQ(recorded.size(), drawn.size()) << what;
  EXPECT_LT(difference(recorded, drawn), kNormalLimit) << what;
}

/// Kolmogorov and Smirnov.
void expect_same_course(const Histogram& recorded, const Histogram& drawn, const std::string& what) {
  ASSERT_EQ(recorded.size(), drawn.size()) << what;
  EXPECT_LT(course_difference(recorded, drawn), kCourseLimit) << what;
}

void expect_uniform(const Histogram& drawn, const std::string& what) {
  EXPECT_LT(unevenness(drawn), kNormalLimit) << what;
}

/// Counts `value_of` of the order of each place from `first`.
template <class Value>
std::vector<Histogram> by_place(int first, std::size_t places, const Counter& empty, Value value_of) {
  std::vector<Histogram> out;
  for (std::size_t place = 0; place < places; ++place) {
    Counter counter = empty;
    for (const Game& game : drawn_games()) {
      const std::size_t at = static_cast<std::size_t>(first - 1) + place;
      counter.add(value_of(at < 10 ? game.schedule.orders[at] : *game.overtime));
    }
    out.push_back(counter.counts());
  }
  return out;
}

/// Counts `value_of` of orders 3 to 10 of each complexity.
template <class Value>
std::vector<Histogram> by_complexity(const Counter& empty, Value value_of) {
  std::vector<Counter> counters(4, empty);
  for (const Game& game : drawn_games())
    for (const Order& order : game.schedule.orders)
      if (order.id > 2) counters[static_cast<std::size_t>(order.complexity)].add(value_of(order));
  std::vector<Histogram> out;
  for (const Counter& counter : counters) out.push_back(counter.counts());
  return out;
}

std::string order_text(std::size_t id) { return "order " + std::to_string(id); }
std::string complexity_text(std::size_t c) { return "C" + std::to_string(c); }

TEST(DrawnGames, HaveTheComplexitiesOfTheRefereeBoxAtEachPlace) {
  const auto drawn = by_place(1, 10, Counter(4), [](const Order& o) { return static_cast<int>(o.complexity); });
  for (std::size_t i = 0; i < drawn.size(); ++i) expect_alike(kComplexity[i], drawn[i], order_text(i + 1));
}

TEST(DrawnGames, HaveItsRingPrices) {
  Counter counter(16);
  for (const Game& game : drawn_games()) {
    const auto at = [&](int price) {
      return static_cast<int>(std::ranges::find(game.schedule.ring_prices, price) - game.schedule.ring_prices.begin());
    };
    counter.add(4 * at(2) + at(1));
  }
  expect_alike(kPrices, counter.counts(), "prices");
}

TEST(DrawnGames, HaveItsGatesAlsoInOvertime) {
  const auto drawn = by_place(1, 11, Counter(3, 1), [](const Order& o) { return o.delivery_gate; });
  for (std::size_t i = 0; i < drawn.size(); ++i) expect_alike(kGate[i], drawn[i], order_text(i + 1));
}

TEST(DrawnGames, HaveItsCompetitiveOrder) {
  Counter counter(8, 3);
  for (const Game& game : drawn_games())
    for (const Order& order : game.schedule.orders)
      if (order.competitive) counter.add(order.id);
  expect_alike(kCompetitive, counter.counts(), "competitive order");
}

TEST(DrawnGames, HaveItsProducts) {
  Counter bases_and_caps(6), payments(kPayments.size());
  std::vector<Counter> rings(3, Counter(4, 1));
  for (const Game& game : drawn_games()) {
    int price = 0;
    std::vector<Order> orders = game.schedule.orders;
    orders.push_back(*game.overtime);
    for (const Order& order : orders) {
      const Product& product = order.product;
      bases_and_caps.add(2 * static_cast<int>(product.base) + static_cast<int>(product.cap) - 3);
      for (std::size_t i = 0; i < product.rings.size(); ++i) {
        rings[i].add(static_cast<int>(product.rings[i]));
        price += game.schedule.price(product.rings[i]);
      }
    }
    payments.add(price);
  }
  expect_alike(kProduct, bases_and_caps.counts(), "bases and caps");
  for (std::size_t i = 0; i < rings.size(); ++i)
    expect_alike(kRing[i], rings[i].counts(), "ring " + std::to_string(i + 1));
  expect_same_course(kPayments, payments.counts(), "payments");
}

TEST(DrawnGames, HaveItsTimes) {
  const auto activation = by_place(3, 8, Counter(27, 180, 30), [](const Order& o) { return o.activate_at; });
  const auto begin = by_place(3, 8, Counter(29, 240, 30), [](const Order& o) { return o.delivery_begin; });
  for (std::size_t i = 0; i < 8; ++i) {
    expect_same_course(kActivation[i], activation[i], order_text(i + 3) + ", activation");
    expect_same_course(kBegin[i], begin[i], order_text(i + 3) + ", begin of the window");
  }
  Counter offset(kOffset.size(), -240, 10);
  for (const Game& game : drawn_games())
    for (const Order& order : game.schedule.orders)
      if (order.id > 2 && order.complexity < Complexity::kC2)
        offset.add(order.delivery_begin - (180 + 120 * (order.id - 3)));
  expect_same_course(kOffset, offset.counts(), "begin of the window after its mean");
  const auto lead = by_complexity(Counter(45, 60, 10), [](const Order& o) { return o.delivery_begin - o.activate_at; });
  const auto length =
      by_complexity(Counter(25, 90, 5), [](const Order& o) { return o.delivery_end - o.delivery_begin; });
  for (std::size_t c = 0; c < 4; ++c) {
    expect_same_course(kLead[c], lead[c], complexity_text(c) + ", from activation to window");
    expect_same_course(kLength[c], length[c], complexity_text(c) + ", length of the window");
  }
}

// The referee box's law: one of two stations each, 30 to 60 s, within 180 s and the end of production; all equally
// likely.
TEST(DrawnGames, HaveDownPeriodsOfEqualChance) {
  for (const std::size_t kind : {0u, 1u}) {
    Counter machine(2), duration(31, 30), begin(10);
    for (const Game& game : drawn_games()) {
      const DownPeriodConfig& period = game.down[kind];
      machine.add(period.machine.back() - '1');
      const double seconds = period.end_s - period.begin_s;
      duration.add(seconds);
      begin.add(10 * (period.begin_s - 180) / (1200 - 180 - seconds + 1));
    }
    expect_uniform(machine.counts(), "machine");
    expect_uniform(duration.counts(), "duration");
    expect_uniform(begin.counts(), "begin");
  }
}

}  // namespace
}  // namespace cxlab::rcll
