// The same three robots on the same fields in the timed tier, where time jumps to what is due.

#include <cstdio>

#include "tests/support/busy_floor.h"

namespace cxlab::sim::fleet_timed_test {
namespace {

constexpr SimTime kTick{20'000'000};

struct Outcome {
  BusyFloor::Report report;
  std::vector<RobotStats> stats;
  std::uint64_t hash = 0;
  int ticks = 0;
};

/// Times of the floor's clock at which it is halted, and how long.
struct Halts {
  std::vector<double> at;
  double seconds = 0;
};

Outcome play(std::uint64_t seed, double seconds, const TimedSkillsConfig& config = {}, double cancel_chance = 0.05,
             Halts halts = {}) {
  LedgerWorld world(drawn_floor(seed));
  BusyFloor floor(world, seed, cancel_chance);
  auto fleet = Fleet::create(world, world, config, seed, {}, floor.bus, floor.sink);
  EXPECT_TRUE(fleet) << fleet.error().text();
  floor.connect();
  Outcome outcome;
  SimTime now{}, goes_on = kNever;
  while (world.floor_time() < from_seconds(seconds)) {
    floor.bus.begin_tick(now);
    EXPECT_TRUE((*fleet)->sense(now));
    if (!world.halted()) {
      floor.stock();
      floor.act();
    }
    if (world.halted() && now >= goes_on) {
      world.go_on();
      goes_on = kNever;
    } else if (!halts.at.empty() && world.floor_time() >= from_seconds(halts.at.front())) {
      halts.at.erase(halts.at.begin());
      if (halts.seconds > 0) {
        world.halt();
        goes_on = now + from_seconds(halts.seconds);
      }
    }
    EXPECT_TRUE((*fleet)->act(now));
    ++outcome.ticks;
    SimTime next = std::min({(*fleet)->next_due(), world.next_event(), floor.next_due(), goes_on});
    if (floor.bus.any_waiting()) next = now;
    if (!world.halted())
      next = std::min(next, world.clock().when(from_seconds(halts.at.empty() ? seconds : halts.at.front())));
    next = std::max(now + kTick, tick_not_before(next, kTick));
    EXPECT_TRUE(world.advance(next - now));
    now = next;
  }
  outcome.report = floor.report;
  outcome.stats = (*fleet)->stats();
  outcome.hash = floor.sink.hash;
  return outcome;
}

TEST(FleetInTime, WorksWithoutGivingUp) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Outcome outcome = play(seed, 1200);
    const auto& report = outcome.report;
    std::printf(
        "seed %d: %d drives, %d picks, %d places, %d cancels; longest %.1f s, handling %.1f s, two drive %.0f %%, %d "
        "ticks\n",
        static_cast<int>(seed), report.drives, report.picks, report.places, report.cancels, report.longest_s,
        report.handling_s / std::max(1, report.handled), report.two_drive_s / 12, outcome.ticks);
    for (const std::string& trouble : report.trouble) ADD_FAILURE() << trouble;
    EXPECT_GT(report.picks + report.places, 100);
    EXPECT_GT(report.handling_s / report.handled, 4);
    EXPECT_LT(outcome.ticks, 1200 * 50 / 8) << "time does not jump";
    for (const RobotStats& stats : outcome.stats) {
      EXPECT_GT(stats.busy_s, 0.6 * 1200);
      EXPECT_LE(stats.drive_s + stats.wait_s, stats.busy_s);
    }
  }
}

TEST(FleetInTime, TheSameSeedGivesTheSameRecords) {
  EXPECT_EQ(play(4, 300).hash, play(4, 300).hash);
  EXPECT_NE(play(4, 300).hash, play(5, 300).hash);
}

TEST(FleetInTime, DrivesOfDrawnTimesMeetNobodyAndAreTheSameForASeed) {
  TimedSkillsConfig config;
  config.drive_sigma = 0.5;
  const Outcome outcome = play(4, 1200, config);
  EXPECT_EQ(play(4, 1200, config).hash, outcome.hash);
  EXPECT_NE(play(4, 1200).hash, outcome.hash);
  EXPECT_TRUE(outcome.report.trouble.empty()) << outcome.report.trouble.front();
  EXPECT_GT(outcome.report.picks + outcome.report.places, 100);
}

TEST(FleetInTime, AHaltMovesAllThatRobotsDoAndChangesNothing) {
  const std::vector<double> at{20, 61.3, 61.3, 150, 222.2};
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Outcome plain = play(seed, 300, {}, 0.05, {at, 0}), halted = play(seed, 300, {}, 0.05, {at, 33.3});
    ASSERT_EQ(plain.stats.size(), halted.stats.size());
    for (std::size_t i = 0; i < plain.stats.size(); ++i) {
      EXPECT_EQ(plain.stats[i].skills, halted.stats[i].skills);
      EXPECT_EQ(plain.stats[i].busy_s, halted.stats[i].busy_s);
      EXPECT_EQ(plain.stats[i].drive_s, halted.stats[i].drive_s);
      EXPECT_EQ(plain.stats[i].wait_s, halted.stats[i].wait_s);
    }
    EXPECT_EQ(plain.report.handling_s, halted.report.handling_s);
    EXPECT_GT(plain.report.picks, 5);
    EXPECT_TRUE(halted.report.trouble.empty());
    EXPECT_EQ(plain.hash, halted.hash) << "records differ in their times alone";
  }
}

TEST(FleetInTime, FailuresComeAsOftenAsTheyAreAskedFor) {
  TimedSkillsConfig config;
  config.pick_failure = 0.25;
  const Outcome outcome = play(6, 1200, config, 0);
  int failed = 0;
  for (const RobotStats& stats : outcome.stats) failed += stats.failures;
  EXPECT_NEAR(static_cast<double>(outcome.report.failures) / outcome.report.picks, 0.25, 0.12);
  EXPECT_GE(failed, outcome.report.failures);
  ASSERT_FALSE(outcome.report.trouble.empty());
  EXPECT_NE(outcome.report.trouble.front().find("206 grasping failed"), std::string::npos);
}

TEST(FleetInTime, DurationsAreDrawnAndNeverZero) {
  TimedSkillsConfig config;
  config.pick_mean_s = 0.001;
  config.pick_sigma_s = 0;
  config.place_mean_s = 0.001;
  config.place_sigma_s = 0;
  config.shortest_s = 3;
  const Outcome outcome = play(7, 300, config, 0);
  EXPECT_NEAR(outcome.report.handling_s / outcome.report.handled, 3, 0.1);
}

std::string means(const TimedSkillsConfig& config) {
  const HandlingMeans m = means_of(config);
  char text[80];
  std::snprintf(text, sizeof text, "%g %g %g %g %g", m.pick, m.pick_shelf, m.place, m.place_slide, m.discard);
  return text;
}

TEST(TimedSkillsConfig, MeansAreThoseOfPhysicsOrMeasuredAndKeysOverride) {
  TimedSkillsConfig config;
  EXPECT_EQ(means(config), "15.5 15.5 15.3 15.3 6.5");
  config.durations = "measured";
  EXPECT_EQ(means(config), "20.9 24.2 19.2 23.5 8.25");
  config.pick_mean_s = 3;
  config.place_mean_s = 4;
  EXPECT_EQ(means(config), "3 3 4 4 8.25");
  config.pick_shelf_mean_s = 5;
  config.place_slide_mean_s = 6;
  config.discard_mean_s = 7;
  EXPECT_EQ(means(config), "3 5 4 6 7");
}

TEST(TimedSkillsConfig, WrongNumbersAreRefusedByName) {
  TimedSkillsConfig config;
  config.place_failure = 1.5;
  ASSERT_FALSE(validate(config));
  EXPECT_NE(validate(config).error().message.find("place_failure"), std::string::npos);
  config = {};
  config.shortest_s = 0;
  ASSERT_FALSE(validate(config));
  EXPECT_NE(validate(config).error().message.find("shortest_s"), std::string::npos);
  for (const double sigma : {-0.1, 1.1}) {
    config = {};
    config.drive_sigma = sigma;
    ASSERT_FALSE(validate(config));
    EXPECT_NE(validate(config).error().message.find("drive_sigma"), std::string::npos);
  }
}

}  // namespace
}  // namespace cxlab::sim::fleet_timed_test
