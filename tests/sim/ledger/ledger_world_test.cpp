#include "sim/ledger/ledger_world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cxlab::sim::ledger_world_test {
namespace {

constexpr StationId kBase{0}, kCap{1}, kRing{2};
constexpr RobotId kRobot1{0}, kRobot2{1};
constexpr Stack kRed{1, {}, 0};

FloorPlan three_stations() {
  FloorPlan plan;
  plan.stations = {{"C-BS", "BS", {1.5, 2.5, 0}, true},
                   {"C-CS1", "CS", {3.5, 4.5, 1.5707963267948966}, true},
                   {"C-RS1", "RS", {5.5, 6.5, 0}, true}};
  for (std::size_t i = 0; i < plan.stations.size(); ++i)
    for (const Spot& spot : spots_of(plan.stations[i], static_cast<StationId>(i))) plan.spots.push_back(spot);
  plan.robots = {{"robot1", {4.5, 0.5, 0}}, {"robot2", {5.5, 0.5, 0}}};
  return plan;
}

class Ledger : public ::testing::Test {
 protected:
  SpotId spot(std::string_view name) const { return *world.plan().find_spot(name); }
  void pass(double seconds) { ASSERT_TRUE(world.advance(from_seconds(seconds))); }
  double belt_x(PieceId id, StationId station) const {
    return inverse_transform(world.plan().station(station).pose_in_world, world.find(id)->position_in_world).x();
  }
  LedgerWorld world{three_stations()};
};

TEST_F(Ledger, ABeltCarriesAPieceToItsStopAndSaysWhen) {
  const auto piece = world.dispense(kBase, 0, kRed);
  ASSERT_TRUE(piece);
  world.run_belt(kBase, -0.05, -0.155);
  EXPECT_EQ(world.next_event(), from_seconds(3.1));
  pass(1.0);
  EXPECT_NEAR(belt_x(*piece, kBase), -0.05, 1e-9);
  EXPECT_EQ(world.at(spot("C-BS-OUTPUT")), nullptr);
  pass(60.0);
  EXPECT_NEAR(belt_x(*piece, kBase), -0.155, 1e-9);
  EXPECT_FALSE(world.belt_running(kBase));
  ASSERT_NE(world.at(spot("C-BS-OUTPUT")), nullptr);
  EXPECT_EQ(world.at(spot("C-BS-OUTPUT"))->id, *piece);
  EXPECT_EQ(world.next_event(), kNever);
}

TEST_F(Ledger, APieceFallsOverTheEndOfABeltThatDoesNotStop) {
  const auto piece = world.dispense(kBase, 0, kRed);
  world.run_belt(kBase, 0.1, 1.0);
  pass(1.0);
  EXPECT_EQ(world.find(*piece)->holder, Holder::kBelt);
  pass(1.0);
  EXPECT_EQ(world.find(*piece)->holder, Holder::kFloor);
  EXPECT_EQ(world.find(*piece)->position_in_world.z(), 0);
}

TEST_F(Ledger, ABeltThatRunsStopsForWhatIsPutOnItAndNotForWhatIsTakenAway) {
  const auto first = world.dispense(kBase, 0.155, kRed);
  ASSERT_TRUE(world.grasp(kRobot1, spot("C-BS-INPUT")));
  world.run_belt(kBase, -0.05, 0);
  EXPECT_EQ(world.next_event(), kNever) << "nothing lies on it";
  ASSERT_TRUE(world.release(kRobot1, spot("C-BS-INPUT")));
  EXPECT_EQ(world.next_event(), from_seconds(3.1));
  ASSERT_TRUE(world.grasp(kRobot1, spot("C-BS-INPUT")));
  EXPECT_EQ(world.next_event(), kNever) << "it was taken away";
  pass(5);
  EXPECT_TRUE(world.belt_running(kBase));
  ASSERT_TRUE(world.release(kRobot1, spot("C-BS-INPUT")));
  EXPECT_EQ(world.next_event(), from_seconds(5 + 3.1));
  world.retire(*first, Holder::kGate);
  EXPECT_EQ(world.next_event(), kNever) << "it has left play";
}

TEST_F(Ledger, AStoppedBeltKeepsThePieceWhereItIs) {
  const auto piece = world.dispense(kBase, 0, kRed);
  world.run_belt(kBase, 0.1, 0.155);
  pass(0.5);
  world.stop_belt(kBase);
  pass(5);
  EXPECT_NEAR(belt_x(*piece, kBase), 0.05, 1e-9);
}

TEST_F(Ledger, NothingIsDispensedOntoAPiece) {
  ASSERT_TRUE(world.dispense(kBase, 0, kRed));
  EXPECT_FALSE(world.dispense(kBase, 0.03, kRed));
  EXPECT_TRUE(world.dispense(kBase, 0.05, kRed));
  ASSERT_TRUE(world.dispense(spot("C-CS1-SHELF-LEFT"), kRed));
  EXPECT_FALSE(world.dispense(spot("C-CS1-SHELF-LEFT"), kRed));
}

TEST_F(Ledger, AStoredPieceComesBackWithItsNumber) {
  const PieceId stored = *world.dispense(kBase, 0, kRed);
  world.retire(stored, Holder::kStorage);
  ASSERT_TRUE(world.dispense(kBase, 0.1, kRed));
  EXPECT_EQ(*world.unstore(kBase, 0, kRed, stored), stored);
  EXPECT_EQ(world.on_belt(kBase, 0), world.find(stored));
  EXPECT_EQ(*world.dispense(kBase, -0.1, kRed), PieceId{3});
}

TEST_F(Ledger, AGraspedPieceGoesWithTheRobotAndLiesWhereItIsReleased) {
  const auto piece = world.dispense(spot("C-CS1-SHELF-LEFT"), kRed);
  ASSERT_TRUE(world.grasp(kRobot1, spot("C-CS1-SHELF-LEFT")));
  EXPECT_EQ(world.robot(kRobot1).held, *piece);
  EXPECT_EQ(world.at(spot("C-CS1-SHELF-LEFT")), nullptr);
  const std::vector<Pose2> path{{4.5, 0.5, 0}, {4.5, 3.5, 0}};
  world.move_along(kRobot1, path, from_seconds(0), from_seconds(6));
  pass(3);
  EXPECT_NEAR(world.robot(kRobot1).pose_in_world.y, 2.0, 1e-9);
  EXPECT_NEAR(world.robot(kRobot1).vy, 0.5, 1e-6);
  EXPECT_NEAR(world.find(*piece)->position_in_world.y(), 2.0, 0.2);
  pass(3);
  EXPECT_EQ(world.robot(kRobot1).vy, 0);
  ASSERT_TRUE(world.release(kRobot1, spot("C-CS1-INPUT")));
  EXPECT_FALSE(world.robot(kRobot1).held);
  EXPECT_EQ(world.at(spot("C-CS1-INPUT"))->id, *piece);
}

TEST_F(Ledger, GraspAndReleaseRefuseWhatCannotBe) {
  EXPECT_EQ(world.grasp(kRobot1, spot("C-BS-OUTPUT")).error().code, "no_piece");
  EXPECT_EQ(world.release(kRobot1, spot("C-BS-INPUT")).error().code, "gripper_empty");
  ASSERT_TRUE(world.dispense(kBase, -0.155, kRed));
  ASSERT_TRUE(world.dispense(kBase, 0.155, kRed));
  ASSERT_TRUE(world.grasp(kRobot1, spot("C-BS-OUTPUT")));
  EXPECT_EQ(world.grasp(kRobot1, spot("C-BS-INPUT")).error().code, "gripper_full");
  EXPECT_EQ(world.release(kRobot1, spot("C-BS-INPUT")).error().code, "place_taken");
}

TEST_F(Ledger, APaymentIsCountedAndLeavesPlay) {
  const auto piece = world.dispense(kBase, -0.155, kRed);
  ASSERT_TRUE(world.grasp(kRobot2, spot("C-BS-OUTPUT")));
  ASSERT_TRUE(world.release(kRobot2, spot("C-RS1-SLIDE")));
  EXPECT_THAT(world.slid(kRing), testing::ElementsAre(kRobot2));
  EXPECT_EQ(world.find(*piece), nullptr);
}

TEST_F(Ledger, ChangesOfHolderAreSeenOnceInOrderOfTime) {
  const auto piece = world.dispense(kBase, -0.155, kRed);
  EXPECT_TRUE(world.changes().empty());
  pass(0.02);
  ASSERT_EQ(world.changes().size(), 1u);
  EXPECT_EQ(world.changes()[0].from, Holder::kDispenser);
  EXPECT_EQ(world.changes()[0].to, Holder::kBelt);
  ASSERT_TRUE(world.grasp(kRobot1, spot("C-BS-OUTPUT")));
  world.drop(kRobot1);
  pass(0.02);
  ASSERT_EQ(world.changes().size(), 2u);
  EXPECT_EQ(world.changes()[0].to, Holder::kGripper);
  EXPECT_EQ(world.changes()[0].to_index, static_cast<int>(kRobot1));
  EXPECT_EQ(world.changes()[1].to, Holder::kFloor);
  EXPECT_EQ(world.changes()[1].at, from_seconds(0.02));
  world.retire(*piece, Holder::kGate);
  pass(0.02);
  ASSERT_EQ(world.changes().size(), 1u);
  EXPECT_EQ(world.changes()[0].to, Holder::kGate);
  EXPECT_TRUE(world.pieces().empty());
}

TEST_F(Ledger, AMachineMountsRingsAndCap) {
  const auto piece = world.dispense(kCap, 0, Stack{2, {}, 0});
  world.mount(*piece, Part::kRing, 3);
  world.mount(*piece, Part::kRing, 4);
  world.mount(*piece, Part::kCap, 1);
  EXPECT_EQ(world.find(*piece)->stack, (Stack{2, {3, 4, 0}, 1}));
  world.unmount_cap(*piece);
  EXPECT_EQ(world.find(*piece)->stack.cap, 0);
}

TEST_F(Ledger, ARobotTurnsAllAlongItsWayAndStandsBeforeItDeparts) {
  const std::vector<Pose2> path{{4.5, 0.5, 1}, {4.5, 2.5, 0}, {4.5, 4.5, 2}};
  world.move_along(kRobot1, path, from_seconds(2), from_seconds(6));
  pass(1);
  EXPECT_NEAR(world.robot(kRobot1).pose_in_world.y, 0.5, 1e-9);
  EXPECT_EQ(world.robot(kRobot1).vy, 0);
  pass(2);
  EXPECT_NEAR(world.robot(kRobot1).pose_in_world.y, 1.5, 1e-9);
  EXPECT_NEAR(world.robot(kRobot1).pose_in_world.yaw, 1.25, 1e-9);
  EXPECT_NEAR(world.robot(kRobot1).omega, 0.25, 1e-6);
  pass(4);
  EXPECT_NEAR(world.robot(kRobot1).pose_in_world.yaw, 2, 1e-9);
}

TEST_F(Ledger, ARobotDrivesAllLegsOfItsWayAtOneSpeed) {
  const std::vector<Pose2> way{{1, 1, 0}, {4, 1, 0}, {4, 2, 0.8}};
  world.move_along(kRobot1, way, from_seconds(2), from_seconds(10));
  struct Row {
    double at;
    Pose2 pose;
    double vx, vy, omega;
  };
  for (const Row& row : {Row{1, {1, 1, 0}, 0, 0, 0}, Row{2, {1, 1, 0}, 0.5, 0, 0.1}, Row{5, {2.5, 1, 0.3}, 0.5, 0, 0.1},
                         Row{9, {4, 1.5, 0.7}, 0, 0.5, 0.1}, Row{10, {4, 2, 0.8}, 0, 0, 0}}) {
    pass(row.at - to_seconds(world.now()));
    const RobotState state = world.robot(kRobot1);
    EXPECT_NEAR(state.pose_in_world.x, row.pose.x, 1e-9) << row.at;
    EXPECT_NEAR(state.pose_in_world.y, row.pose.y, 1e-9) << row.at;
    EXPECT_NEAR(state.pose_in_world.yaw, row.pose.yaw, 1e-9) << row.at;
    EXPECT_NEAR(state.vx, row.vx, 1e-6) << row.at;
    EXPECT_NEAR(state.vy, row.vy, 1e-6) << row.at;
    EXPECT_NEAR(state.omega, row.omega, 1e-6) << row.at;
  }
}

TEST_F(Ledger, ARobotThatStopsStaysWhereItIs) {
  const std::vector<Pose2> path{{4.5, 0.5, 0}, {4.5, 4.5, 0}};
  world.move_along(kRobot1, path, from_seconds(0), from_seconds(4));
  pass(1);
  world.stop(kRobot1);
  pass(10);
  EXPECT_NEAR(world.robot(kRobot1).pose_in_world.y, 1.5, 1e-9);
}

TEST_F(Ledger, APaymentIsNotedWithTheSlideAsItsPlace) {
  ASSERT_TRUE(world.dispense(kBase, -0.155, kRed));
  ASSERT_TRUE(world.grasp(kRobot2, spot("C-BS-OUTPUT")));
  ASSERT_TRUE(world.release(kRobot2, spot("C-RS1-SLIDE")));
  pass(0.02);
  EXPECT_EQ(world.changes().back().to, Holder::kSlide);
  EXPECT_EQ(world.changes().back().to_index, static_cast<int>(spot("C-RS1-SLIDE")));
}

TEST_F(Ledger, ABeltStopsForTheFirstPieceThatArrivesAndIsStillThere) {
  ASSERT_TRUE(world.dispense(kBase, 0, kRed));
  const auto second = world.dispense(kBase, 0.155, kRed);
  ASSERT_TRUE(second);
  world.run_belt(kBase, -0.1, -0.155);
  EXPECT_EQ(world.next_event(), from_seconds(1.55));
  ASSERT_TRUE(world.grasp(kRobot1, spot("C-BS-INPUT")));
  world.stop_belt(kBase);
  EXPECT_EQ(world.next_event(), kNever);
  world.run_belt(kBase, -0.1, -0.155);
  pass(1.55);
  ASSERT_TRUE(world.grasp(kRobot2, spot("C-BS-OUTPUT")));
  EXPECT_FALSE(world.belt_running(kBase));
}

TEST_F(Ledger, APieceThatIsTakenOffARunningBeltDoesNotStopIt) {
  ASSERT_TRUE(world.dispense(kBase, 0.155, kRed));
  world.run_belt(kBase, -0.05, -0.155);
  ASSERT_TRUE(world.grasp(kRobot1, spot("C-BS-INPUT")));
  EXPECT_EQ(world.next_event(), kNever);
  pass(10);
  EXPECT_TRUE(world.belt_running(kBase));
}

TEST_F(Ledger, APieceIsAtASpotWithinTenMillimetres) {
  const auto near = world.dispense(kBase, -0.155 + 0.0095, kRed);
  ASSERT_TRUE(near);
  EXPECT_NE(world.at(spot("C-BS-OUTPUT")), nullptr);
  world.retire(*near, Holder::kGate);
  ASSERT_TRUE(world.dispense(kBase, -0.155 + 0.0105, kRed));
  EXPECT_EQ(world.at(spot("C-BS-OUTPUT")), nullptr);
}

TEST_F(Ledger, ARobotTurnsByTheShorterSideAsItDrives) {
  const std::vector<Pose2> path{{4.5, 0.5, 3}, {4.5, 4.5, -3}};
  world.move_along(kRobot1, path, from_seconds(1), from_seconds(5));
  pass(0.5);
  EXPECT_NEAR(world.robot(kRobot1).pose_in_world.y, 0.5, 1e-9) << "not yet";
  pass(2.5);
  EXPECT_NEAR(std::abs(world.robot(kRobot1).pose_in_world.yaw), 3.14159, 1e-4);
  EXPECT_NEAR(world.robot(kRobot1).omega, (2 * 3.14159265 - 6) / 4, 1e-4);
  EXPECT_EQ(world.robot(kRobot1).finger_opening, 0.035);
}

TEST_F(Ledger, AHeldPieceIsCarriedBeforeTheRobotAndDroppedBelow) {
  const auto piece = world.dispense(kBase, -0.155, kRed);
  ASSERT_TRUE(world.grasp(kRobot1, spot("C-BS-OUTPUT")));
  pass(0.02);
  EXPECT_NEAR(world.find(*piece)->position_in_world.x(), 4.5 + 0.139, 1e-9);
  EXPECT_NEAR(world.find(*piece)->position_in_world.z(), 0.945, 1e-9);
  world.drop(kRobot1);
  EXPECT_EQ(world.find(*piece)->position_in_world.z(), 0);
  EXPECT_EQ(world.find(*piece)->holder, Holder::kFloor);
  EXPECT_FALSE(world.robot(kRobot1).held);
}

TEST_F(Ledger, ARobotMovesBetweenDepartureAndArrivalOnly) {
  const std::vector<Pose2> path{{4.5, 0.5, 0}, {4.5, 4.5, 1}};
  world.move_along(kRobot1, path, from_seconds(2), from_seconds(6));
  struct Row {
    SimTime until;
    double y, vy, omega;
  };
  for (const Row& row : {Row{from_seconds(1.9995), 0.5, 0, 0}, Row{from_seconds(2), 0.5, 1, 0.25},
                         Row{from_seconds(5.9995), 4.4995, 1, 0.25}, Row{from_seconds(6), 4.5, 0, 0}}) {
    ASSERT_TRUE(world.advance(row.until - world.now()));
    const RobotState robot = world.robot(kRobot1);
    EXPECT_NEAR(robot.pose_in_world.y, row.y, 1e-9) << to_seconds(row.until);
    EXPECT_NEAR(robot.vy, row.vy, 1e-6) << to_seconds(row.until);
    EXPECT_NEAR(robot.omega, row.omega, 1e-6) << to_seconds(row.until);
  }
}

TEST_F(Ledger, APieceAlreadyAtTheStopStopsTheBeltAtOnceAndOneBeyondDoesNot) {
  struct Row {
    double x;
    bool stops;
    double ends_at;
  };
  for (const Row& row :
       {Row{-0.155, true, -0.155}, Row{-0.164, true, -0.164}, Row{-0.166, false, 0}, Row{-0.146, true, -0.155}}) {
    LedgerWorld fresh(three_stations());
    const auto piece = fresh.dispense(kBase, row.x, kRed);
    ASSERT_TRUE(piece);
    fresh.run_belt(kBase, -0.05, -0.155);
    ASSERT_TRUE(fresh.advance(from_seconds(0.5)));
    EXPECT_EQ(fresh.belt_running(kBase), !row.stops) << row.x;
    if (!row.stops) continue;
    EXPECT_NEAR(inverse_transform(fresh.plan().station(kBase).pose_in_world, fresh.find(*piece)->position_in_world).x(),
                row.ends_at, 1e-6)
        << row.x;
  }
}

TEST(LedgerWorld, RobotsStandInAHaltAndGoOnAfterIt) {
  LedgerWorld world(three_stations());
  const Pose2 path[]{{0, 0, 0}, {4, 0, 0}};
  world.move_along(kRobot1, path, from_seconds(0), from_seconds(4));
  EXPECT_TRUE(world.advance(from_seconds(1)));
  EXPECT_NEAR(world.robot(kRobot1).vx, 1, 1e-6);
  world.halt();
  EXPECT_TRUE(world.advance(from_seconds(10)));
  EXPECT_NEAR(world.robot(kRobot1).pose_in_world.x, 1, 1e-9);
  EXPECT_EQ(world.robot(kRobot1).vx, 0);
  world.go_on();
  EXPECT_NEAR(world.robot(kRobot1).vx, 1, 1e-6);
  EXPECT_TRUE(world.advance(from_seconds(2)));
  EXPECT_NEAR(world.robot(kRobot1).pose_in_world.x, 3, 1e-9);
}

}  // namespace
}  // namespace cxlab::sim::ledger_world_test
