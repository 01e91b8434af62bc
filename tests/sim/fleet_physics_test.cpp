// Three robots on drawn fields in MuJoCo: nobody touches anybody or anything, no drive is given up, nothing is dropped.
// Short: one field, 200 s. With CXLAB_SWEEP=FIRST:COUNT:SECONDS (the long test sets it): that many fields.

#include <cstdio>
#include <cstdlib>

#include "tests/support/busy_floor.h"

namespace cxlab::sim::fleet_physics_test {
namespace {

constexpr SimTime kTick{20'000'000};

struct Hashes {
  std::uint64_t records = 0, physics = 0;
};

/// How often the floor is halted, and for how long.
struct Halts {
  SimTime every = kNever, length{};
};

/// Halts the floor and lets it go on; robots stand soon, and do not move until it goes on.
class Halting {
 public:
  Halting(MujocoWorld& world, Halts halts) : world_(world), halts_(halts), next_(halts.every) {}

  void tick() {
    if (!world_.halted() && world_.now() >= next_) {
      world_.halt();
      ++count_;
      for (std::size_t i = 0; i < world_.plan().robots.size(); ++i) moving_ += speed(i) > 0.3;
      next_ += halts_.length;
    } else if (world_.halted() && world_.now() >= next_) {
      world_.go_on();
      next_ += halts_.every;
    }
    if (!world_.halted()) return;
    const SimTime since = world_.now() - (next_ - halts_.length);
    stood_.resize(world_.plan().robots.size());
    for (std::size_t i = 0; i < stood_.size(); ++i) {
      const RobotState state = world_.robot(static_cast<RobotId>(i));
      if (since == kStandAfter) stood_[i] = state;
      if (since < kStandAfter) continue;
      EXPECT_LT(speed(i), 0.005) << to_seconds(world_.now());
      EXPECT_LT(std::abs(state.omega), 0.005);
      EXPECT_LT(distance(state.pose_in_world.position(), stood_[i].pose_in_world.position()), 0.001);
      EXPECT_LT((state.gripper - stood_[i].gripper).norm(), 0.0005);
      EXPECT_EQ(state.held, stood_[i].held);
    }
  }
  int count() const { return count_; }
  int moving() const { return moving_; }  ///< robots that drove fast at a halt

 private:
  static constexpr SimTime kStandAfter = std::chrono::seconds(1);
  double speed(std::size_t robot) const {
    const RobotState state = world_.robot(static_cast<RobotId>(robot));
    return std::hypot(state.vx, state.vy);
  }

  MujocoWorld& world_;
  Halts halts_;
  SimTime next_;
  std::vector<RobotState> stood_;
  int count_ = 0, moving_ = 0;
};

void play(std::uint64_t seed, double seconds, Hashes* hashes = nullptr, Halts halts = {}) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  auto world = MujocoWorld::create(drawn_floor(seed), {source_dir() / "models", 0.01, 60});
  ASSERT_TRUE(world) << world.error().text();
  MujocoWorld& w = **world;
  BusyFloor floor(w, seed, 0.05);
  auto fleet = Fleet::create(w, w, {}, floor.bus, floor.sink);
  ASSERT_TRUE(fleet) << fleet.error().text();
  floor.connect();
  Halting halting(w, halts);
  while (w.floor_time() < from_seconds(seconds)) {
    floor.bus.begin_tick(w.now());
    ASSERT_TRUE((*fleet)->sense(w.now()));
    floor.stock();
    floor.act();
    halting.tick();
    ASSERT_TRUE((*fleet)->act(w.now()));
    const Status moved = w.advance(kTick);
    ASSERT_TRUE(moved) << moved.error().text();
  }
  const auto& report = floor.report;
  int robot_contacts = 0, static_contacts = 0;
  double busy = 0, drive = 0, wait = 0;
  for (std::size_t i = 0; i < w.plan().robots.size(); ++i) {
    const RobotState state = w.robot(static_cast<RobotId>(i));
    robot_contacts += static_cast<int>(state.robot_contacts);
    static_contacts += static_cast<int>(state.static_contacts);
  }
  for (const RobotStats& stats : (*fleet)->stats()) {
    busy += stats.busy_s;
    drive += stats.drive_s;
    wait += stats.wait_s;
  }
  std::printf(
      "seed %d: %d drives, %d picks, %d places, %d cancels; longest %.1f s, handling %.1f s; busy %.0f %%, drive %.0f "
      "%%, "
      "wait %.0f %%, two drive %.0f %%; contacts %d, %d; trouble %zu\n",
      static_cast<int>(seed), report.drives, report.picks, report.places, report.cancels, report.longest_s,
      report.handling_s / std::max(1, report.handled), busy / seconds / 3 * 100, drive / seconds / 3 * 100,
      wait / seconds / 3 * 100, report.two_drive_s / seconds * 100, robot_contacts, static_contacts,
      report.trouble.size());
  std::fflush(stdout);
  EXPECT_EQ(robot_contacts, 0);
  EXPECT_EQ(static_contacts, 0);
  for (const std::string& trouble : report.trouble) ADD_FAILURE() << trouble;
  EXPECT_GT(report.picks + report.places, seconds / 30);
  if (halts.every != kNever) {
    EXPECT_GT(halting.count(), 5);
    EXPECT_GT(halting.moving(), 3);
  }
  if (hashes) *hashes = {floor.sink.hash, w.physics_hash()};
}

TEST(FleetInPhysics, WorksWithoutTouchingBlockingOrDropping) {
  unsigned first = 1, count = 1, seconds = 150;
  if (const char* sweep = std::getenv("CXLAB_SWEEP")) {
    ASSERT_EQ(std::sscanf(sweep, "%u:%u:%u", &first, &count, &seconds), 3) << "CXLAB_SWEEP=FIRST:COUNT:SECONDS";
  }
  for (unsigned seed = first; seed < first + count; ++seed) play(seed, seconds);
}

/// The league gives robots 3 s to stop.
TEST(FleetInPhysics, RobotsStandWhileTheFloorIsHaltedAndGoOn) {
  Hashes first, second;
  const Halts halts{std::chrono::seconds(9), std::chrono::seconds(4)};
  play(3, 120, &first, halts);
  play(3, 120, &second, halts);
  EXPECT_EQ(first.records, second.records);
  EXPECT_EQ(first.physics, second.physics);
}

TEST(FleetInPhysics, TheSameSeedGivesTheSameRecordsAndTheSamePhysics) {
  Hashes first, second;
  play(2, 40, &first);
  play(2, 40, &second);
  EXPECT_EQ(first.records, second.records);
  EXPECT_EQ(first.physics, second.physics);
}

}  // namespace
}  // namespace cxlab::sim::fleet_physics_test
