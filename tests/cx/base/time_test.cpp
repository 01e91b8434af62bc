#include "cx/base/time.h"

#include <gtest/gtest.h>

namespace cxlab {
namespace {

TEST(Time, SecondsAreRoundedToTheNearestNanosecond) {
  EXPECT_EQ(from_seconds(1.5), SimTime{1'500'000'000});
  EXPECT_EQ(from_seconds(0.02), SimTime{20'000'000});
  EXPECT_EQ(from_seconds(1.4e-9), SimTime{1});
  EXPECT_EQ(from_seconds(1.6e-9), SimTime{2});
  EXPECT_EQ(from_seconds(-1.6e-9), SimTime{-2});
}

TEST(Time, SecondsComeBackAsTheyWere) {
  for (const double s : {0.0, 0.02, 0.1, 1.3, 1199.98, 1e6 + 0.5}) EXPECT_EQ(to_seconds(from_seconds(s)), s);
  EXPECT_EQ(to_seconds(SimTime{1}), 1e-9);
}

TEST(Time, DueTimesOfARateAreRoundedOneByOneAndDoNotDrift) {
  const SimTime start{5};
  EXPECT_EQ(due_time(start, 0, 3), SimTime{5});
  EXPECT_EQ(due_time(start, 1, 3), SimTime{333'333'338});
  EXPECT_EQ(due_time(start, 2, 3), SimTime{666'666'672}) << "rounded up";
  EXPECT_EQ(due_time(start, 3, 3), SimTime{1'000'000'005});
  EXPECT_EQ(due_time(start, 3'000'000, 3), SimTime{1'000'000'000'000'005});
}

TEST(DueTimes, TheNextIsFoundWithoutLookingAtAllBefore) {
  using std::chrono::seconds;
  EXPECT_EQ(due_after(SimTime{0}, SimTime{0}, 0, 3), 1);
  EXPECT_EQ(due_after(SimTime{0}, SimTime{5}, 0, 3), 0) << "before the first";
  EXPECT_EQ(due_after(SimTime{0}, SimTime{0}, 7, 3), 7) << "those before the seventh have had their turn";
  for (const double rate : {0.001, 3.0, 10.0, 1e9}) {
    for (const SimTime now :
         {SimTime{1}, SimTime{333'333'333}, SimTime{seconds{1'000'000}}, SimTime{seconds{1'000'000'000}}}) {
      const std::int64_t k = due_after(now, SimTime{0}, 0, rate);
      EXPECT_GT(due_time(SimTime{0}, k, rate), now) << rate;
      EXPECT_LE(due_time(SimTime{0}, k - 1, rate), now) << rate;
    }
  }
}

TEST(Time, ATickIsNeverBeforeWhatIsDue) {
  const SimTime tick{20};
  EXPECT_EQ(tick_not_before(SimTime{0}, tick), SimTime{0});
  EXPECT_EQ(tick_not_before(SimTime{1}, tick), SimTime{20});
  EXPECT_EQ(tick_not_before(SimTime{19}, tick), SimTime{20});
  EXPECT_EQ(tick_not_before(SimTime{20}, tick), SimTime{20});
  EXPECT_EQ(tick_not_before(SimTime{21}, tick), SimTime{40});
}

TEST(Time, NeverIsLaterThanEveryDueTime) { EXPECT_GT(kNever, from_seconds(9e9)); }

}  // namespace
}  // namespace cxlab
