// A piece is taken, carried and put down by contact alone.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "test_floor.h"
#include "test_rig.h"

namespace cxlab::sim::grasp_test {
namespace {

constexpr Stack kBase{1, {}, 0};
constexpr Stack kC3{2, {1, 2, 3}, 2};
constexpr RobotId kR1{0};

class Grasp : public testing::TestWithParam<double> {
 protected:
  void SetUp() override {
    ModelOptions options = test_options();
    options.step = GetParam();
    auto made = MujocoWorld::create(small_floor(), options);
    ASSERT_TRUE(made.ok()) << made.error().text();
    world_ = std::move(*made);
    rig_.emplace(*world_);
  }
  SpotId spot(const char* name) { return *world_->plan().find_spot(name); }
  StationId station(const char* name) { return *world_->plan().find_station(name); }
  PieceId dispense(const char* name, double x, const Stack& stack) {
    auto piece = world_->dispense(station(name), x, stack);
    EXPECT_TRUE(piece.ok());
    return *piece;
  }
  std::optional<PieceId> id_at(const char* name) {
    const Piece* piece = world_->at(spot(name));
    return piece ? std::optional(piece->id) : std::nullopt;
  }
  /// Off the place where a piece should lie at that spot: along and across the belt.
  Vec3 offset_at(PieceId piece, const char* name) {
    const Spot& s = world_->plan().spot(spot(name));
    const Vec3 here =
        inverse_transform(world_->plan().station(s.station).pose_in_world, world_->find(piece)->position_in_world);
    return here - s.rest_in_station;
  }

  std::unique_ptr<MujocoWorld> world_;
  std::optional<Rig> rig_;
};

TEST_P(Grasp, ProductIsCarriedFromBeltToBelt) {
  for (const Stack& stack : {kBase, kC3}) {
    rig_->drive_to(kR1, {0.5, 4, 1.57});
    const PieceId piece = dispense("C-BS", 0, stack);
    world_->run_belt(station("C-BS"), -0.155 / 2.656, -0.155);
    rig_->wait(4);
    ASSERT_FALSE(world_->belt_running(station("C-BS")));
    ASSERT_TRUE(world_->at(spot("C-BS-OUTPUT"))) << world_->find(piece)->position_in_world.x();

    rig_->pick(kR1, spot("C-BS-OUTPUT"));
    ASSERT_EQ(world_->robot(kR1).held, piece);
    EXPECT_EQ(world_->find(piece)->holder, Holder::kGripper);
    EXPECT_EQ(world_->at(spot("C-BS-OUTPUT")), nullptr);

    // Around the machine, at full speed and with turns.
    for (const Pose2& via : {Pose2{0.5, 4, 1.57}, Pose2{3, 4, -1.57}, Pose2{6, 4, 0}}) rig_->drive_to(kR1, via);
    ASSERT_EQ(world_->robot(kR1).held, piece);

    rig_->put(kR1, spot("C-CS1-INPUT"));
    EXPECT_EQ(world_->robot(kR1).held, std::nullopt);
    ASSERT_EQ(id_at("C-CS1-INPUT"), piece);
    const Vec3 off = offset_at(piece, "C-CS1-INPUT");
    EXPECT_LT(std::abs(off.y()), 0.003);
    EXPECT_LT(std::abs(off.x()), 0.005);
    EXPECT_LT(std::abs(off.z()), 0.002);
    EXPECT_EQ(rig_->life(piece), "belt gripper belt");
    world_->retire(piece, Holder::kGate);
    rig_->drive_to(kR1, {6, 4, 0});
  }
  EXPECT_EQ(world_->robot(kR1).static_contacts, 0u);
}

TEST_P(Grasp, CarrierIsTakenOffTheShelfBesideItsNeighbours) {
  std::vector<PieceId> carriers;
  for (const char* name : {"C-CS1-SHELF-LEFT", "C-CS1-SHELF-MIDDLE", "C-CS1-SHELF-RIGHT"})
    carriers.push_back(*world_->dispense(spot(name), Stack{4, {}, 1}));
  rig_->drive_to(kR1, {6, 4, 0});
  rig_->pick(kR1, spot("C-CS1-SHELF-MIDDLE"));
  ASSERT_EQ(world_->robot(kR1).held, carriers[1]);
  EXPECT_EQ(world_->at(spot("C-CS1-SHELF-MIDDLE")), nullptr);
  EXPECT_EQ(id_at("C-CS1-SHELF-LEFT"), carriers[0]);
  EXPECT_EQ(id_at("C-CS1-SHELF-RIGHT"), carriers[2]);

  rig_->put(kR1, spot("C-CS1-INPUT"));
  EXPECT_LT(std::abs(offset_at(carriers[1], "C-CS1-INPUT").y()), 0.003);
  EXPECT_EQ(rig_->life(carriers[1]), "slot gripper belt");

  rig_->pick(kR1, spot("C-CS1-INPUT"));
  rig_->put(kR1, spot("C-CS1-SHELF-MIDDLE"));
  EXPECT_EQ(id_at("C-CS1-SHELF-MIDDLE"), carriers[1]);
  EXPECT_EQ(rig_->life(carriers[1]), "slot gripper belt gripper slot");
}

TEST_P(Grasp, PieceGoesDownTheSlideAndCounts) {
  const PieceId piece = dispense("C-RS1", 0.155, kBase);
  rig_->drive_to(kR1, {6, 4, 0});
  rig_->pick(kR1, spot("C-RS1-INPUT"));
  ASSERT_EQ(world_->robot(kR1).held, piece);
  EXPECT_TRUE(world_->slid(station("C-RS1")).empty());
  rig_->put(kR1, spot("C-RS1-SLIDE"));
  EXPECT_THAT(world_->slid(station("C-RS1")), testing::ElementsAre(kR1));
  EXPECT_EQ(world_->find(piece), nullptr);
  EXPECT_EQ(rig_->life(piece), "belt gripper slide");
}

TEST_P(Grasp, PieceIsHeldForAsLongAsItTakes) {
  const PieceId piece = dispense("C-RS1", 0.155, kBase);
  rig_->drive_to(kR1, {6, 4, 0});
  rig_->pick(kR1, spot("C-RS1-INPUT"));
  const double height = world_->find(piece)->position_in_world.z();
  rig_->wait(600);
  ASSERT_EQ(world_->robot(kR1).held, piece);
  EXPECT_NEAR(world_->find(piece)->position_in_world.z(), height, 0.0005);
  rig_->put(kR1, spot("C-CS1-INPUT"));
  EXPECT_EQ(id_at("C-CS1-INPUT"), piece);
  EXPECT_EQ(rig_->life(piece), "belt gripper belt");
}

TEST_P(Grasp, PieceFallsWhenTheFingersOpenHoweverLongItWasHeld) {
  for (const double seconds : {0.0, 1.3, 3.7, 7.0, 12.7, 20.0, 27.0, 33.0, 41.0, 55.0}) {
    const PieceId piece = dispense("C-RS1", 0.155, kBase);
    rig_->drive_to(kR1, {6, 4, 0});
    rig_->pick(kR1, spot("C-RS1-INPUT"));
    rig_->wait(seconds);
    world_->command_fingers(kR1, 0.035);
    rig_->wait(1.2);
    EXPECT_EQ(world_->robot(kR1).held, std::nullopt) << seconds;
    EXPECT_LT(world_->find(piece)->position_in_world.z(), 0.05) << seconds;
    world_->retire(piece, Holder::kFloor);
  }
}

TEST_P(Grasp, PieceThatFallsOnAnotherOneIsOnTheFloor) {
  for (int n = 0; n < 4; ++n) {
    const PieceId piece = dispense("C-RS1", 0.155, kBase);
    rig_->drive_to(kR1, {6, 4, 0});
    rig_->pick(kR1, spot("C-RS1-INPUT"));
    rig_->wait(10);
    world_->command_fingers(kR1, 0.035);
    rig_->wait(3);
    EXPECT_EQ(rig_->life(piece), "belt gripper floor") << n << ", z " << world_->find(piece)->position_in_world.z();
  }
}

INSTANTIATE_TEST_SUITE_P(Step, Grasp, testing::Values(0.005, 0.01),
                         [](const auto& test) { return std::to_string(static_cast<int>(test.param * 1000)) + "ms"; });

}  // namespace
}  // namespace cxlab::sim::grasp_test
