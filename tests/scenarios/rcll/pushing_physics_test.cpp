// Robots that drive into others in the physics tier, and what the referee makes of it.

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "scenarios/rcll/game/floor_plan.h"
#include "scenarios/rcll/game/game.h"
#include "scenarios/rcll/rules/maintenance.h"
#include "sim/mujoco/mujoco_world.h"
#include "tests/support/files.h"
#include "tests/support/records.h"

namespace cxlab::rcll {
namespace {

constexpr SimTime kTick = std::chrono::milliseconds(20);
constexpr sim::RobotId kFirst{0}, kMate{1}, kRival{3};

struct Motion {
  sim::RobotId robot;
  sim::Vec2 from, velocity;
  double until = 5;  ///< s, when it brakes
};

class Pushing : public testing::Test {
 protected:
  /// Cycles of maintenance of the robots after that time.
  std::vector<int> play(std::vector<Motion> motions, double seconds = 5, double production_s = 1200,
                        double setup_s = 0) {
    WorldConfig config;
    config.team = "BOTH";
    sim::ModelOptions options;
    options.models = models_dir();
    sim::FloorPlan plan = floor_plan_of(config, game_of(config, 1)->layout);
    plan.stations.clear();
    plan.spots.clear();
    auto world = sim::MujocoWorld::create(std::move(plan), options);
    EXPECT_TRUE(world) << world.error().text();
    world_ = std::move(*world);
    EventLog events(records_);
    GameReferee referee(GameClock::of(setup_s, production_s), choices_of(Rules::kRefbox), {}, world_->plan(), events);
    Maintenance maintenance(*world_, referee, from_seconds(30), events, records_);
    for (const Motion& motion : motions) world_->set_down(motion.robot, {motion.from.x(), motion.from.y(), 0});
    while (world_->now() < from_seconds(seconds)) {
      EXPECT_TRUE(world_->advance(kTick));
      for (const Motion& m : motions) {
        const bool drives = !world_->is_off_field(m.robot) && world_->now() < from_seconds(m.until);
        world_->command_base(m.robot, drives ? m.velocity.x() : 0, drives ? m.velocity.y() : 0, 0);
      }
      maintenance.judge(world_->now());
      maintenance.act(world_->now());
    }
    std::vector<int> cycles;
    for (const Maintenance::Robot& robot : maintenance.robots()) cycles.push_back(robot.cycles);
    return cycles;
  }
  bool met(sim::RobotId robot) const { return world_->robot(robot).robot_contacts > 0; }

  KeptRecords records_;
  std::unique_ptr<sim::MujocoWorld> world_;
};

using Cycles = std::vector<int>;

TEST_F(Pushing, WhoDrivesIntoARobotThatStandsMustLeave) {
  EXPECT_EQ(play({{kFirst, {-0.6, 4.5}, {0.5, 0}}, {kRival, {0.4, 4.5}, {0, 0}}}), (Cycles{1, 0, 0, 0, 0, 0}));
  EXPECT_TRUE(met(kFirst));
  EXPECT_TRUE(world_->is_off_field(kFirst));
  EXPECT_FALSE(world_->is_off_field(kRival));
  const std::string told = records_.text();
  EXPECT_NE(told.find("pushing"), std::string::npos) << told;
}

TEST_F(Pushing, AlsoWhenItIsOneOfItsOwnTeam) {
  EXPECT_EQ(play({{kFirst, {-0.6, 4.5}, {0.5, 0}}, {kMate, {0.4, 4.5}, {0, 0}}}), (Cycles{1, 0, 0, 0, 0, 0}));
}

TEST_F(Pushing, WhoIsHitFromBehindOnItsWayMayStay) {
  EXPECT_EQ(play({{kFirst, {-0.6, 4.5}, {0.6, 0}}, {kRival, {0.2, 4.5}, {0.2, 0}}}, 4), (Cycles{1, 0, 0, 0, 0, 0}));
  EXPECT_TRUE(met(kRival));
}

TEST_F(Pushing, TwoThatDriveIntoEachOtherMustBothLeave) {
  EXPECT_EQ(play({{kFirst, {-0.6, 4.5}, {0.4, 0}}, {kRival, {0.6, 4.5}, {-0.4, 0}}}), (Cycles{1, 0, 0, 1, 0, 0}));
}

TEST_F(Pushing, WhoPassesOrBrakesInTimeMayStay) {
  const Cycles none(6, 0);
  EXPECT_EQ(play({{kFirst, {-0.6, 4.5}, {0.5, 0}}, {kRival, {0.2, 5.0}, {0, 0}}}, 3), none) << "0.5 m aside";
  EXPECT_FALSE(met(kFirst));
  EXPECT_EQ(play({{kFirst, {-0.6, 4.5}, {0.5, 0}, 1.0}, {kRival, {0.4, 4.5}, {0, 0}}}), none);
  EXPECT_FALSE(met(kFirst));
}

TEST_F(Pushing, WhoLeansAgainstAnotherAtLessThanFiveCentimetresASecondMayStay) {
  EXPECT_EQ(play({{kFirst, {0, 4.5}, {0.04, 0}}, {kRival, {0.5, 4.5}, {0, 0}}}), Cycles(6, 0));
  EXPECT_TRUE(met(kFirst));
}

TEST_F(Pushing, IsJudgedInProductionOnly) {
  EXPECT_EQ(play({{kFirst, {-0.6, 4.5}, {0.5, 0}}, {kRival, {0.4, 4.5}, {0, 0}}}, 5, 1200, 100), Cycles(6, 0));
  EXPECT_TRUE(met(kFirst));
}

}  // namespace
}  // namespace cxlab::rcll
