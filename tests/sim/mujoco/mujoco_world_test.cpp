#include "sim/mujoco/mujoco_world.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "test_floor.h"
#include "test_rig.h"

namespace cxlab::sim {
namespace {

using testing::HasSubstr;

constexpr SimTime kTick = std::chrono::milliseconds(20);
constexpr RobotId kR1{0}, kR2{1};
constexpr Stack kBase{1, {}, 0};

std::unique_ptr<MujocoWorld> make_world(PhysicsLog* tap = nullptr, FloorPlan plan = small_floor()) {
  auto made = MujocoWorld::create(std::move(plan), test_options(), tap);
  EXPECT_TRUE(made.ok()) << made.error().text();
  return std::move(*made);
}

StationId station(const MujocoWorld& world, const char* name) { return *world.plan().find_station(name); }
SpotId spot(const MujocoWorld& world, const char* name) { return *world.plan().find_spot(name); }

/// A while of everything at once: a belt runs, a piece grows, both robots move, one piece leaves.
void bustle(MujocoWorld& world, int from_tick, int to_tick) {
  for (int tick = from_tick; tick < to_tick; ++tick) {
    if (tick == 0) {
      ASSERT_TRUE(world.dispense(station(world, "C-BS"), 0, kBase).ok());
      ASSERT_TRUE(world.dispense(spot(world, "C-CS1-SHELF-LEFT"), Stack{4, {}, 2}).ok());
      world.run_belt(station(world, "C-BS"), 0.1, 0.155);
    }
    if (tick == 20) world.mount(PieceId{1}, Part::kRing, 2);
    if (tick == 60) world.retire(PieceId{2}, Holder::kGate);
    if (tick == 70) {
      ASSERT_TRUE(world.dispense(station(world, "C-DS"), 0.1, Stack{3, {1, 2, 3}, 1}).ok());
    }
    world.command_base(kR1, 0.3 * std::sin(0.1 * tick), 0.2, 0.5);
    world.command_base(kR2, -0.2, 0.01 * tick, -0.3);
    world.command_gripper(kR1, {0.002 * tick, 0, 0.05});
    ASSERT_TRUE(world.advance(kTick).ok());
  }
}

TEST(MujocoWorld, BeltCarriesAPieceToItsStop) {
  auto world = make_world();
  const StationId bs = station(*world, "C-BS");
  const PieceId piece = *world->dispense(bs, 0, kBase);
  ASSERT_TRUE(world->advance(kTick).ok());
  EXPECT_EQ(world->changes()[0].from, Holder::kDispenser);
  EXPECT_EQ(world->changes()[0].to, Holder::kBelt);
  Rig rig(*world);
  rig.wait(1);  // it is asleep by now and has to be woken
  world->run_belt(bs, -0.155 / 2.656, -0.155);
  EXPECT_TRUE(world->belt_running(bs));
  EXPECT_EQ(world->on_belt(bs, 0)->id, piece);
  rig.wait(2.0);
  EXPECT_TRUE(world->belt_running(bs));
  EXPECT_EQ(world->at(spot(*world, "C-BS-OUTPUT")), nullptr);
  rig.wait(0.8);
  EXPECT_FALSE(world->belt_running(bs));
  rig.wait(0.3);
  const Vec3 rest = inverse_transform(world->plan().station(bs).pose_in_world, world->find(piece)->position_in_world);
  EXPECT_NEAR(rest.x(), -0.155, 0.003);
  EXPECT_NEAR(rest.y(), -0.025, 0.001);
  EXPECT_EQ(world->at(spot(*world, "C-BS-OUTPUT"))->id, piece);
}

TEST(MujocoWorld, AHaltStopsBeltsUntilItIsOver) {
  auto world = make_world();
  const StationId bs = station(*world, "C-BS");
  const PieceId piece = *world->dispense(bs, 0, kBase);
  const auto x = [&] {
    return inverse_transform(world->plan().station(bs).pose_in_world, world->find(piece)->position_in_world).x();
  };
  Rig rig(*world);
  rig.wait(0.5);
  world->run_belt(bs, -0.155 / 2.656, -0.155);
  rig.wait(1.3);
  world->halt();
  rig.wait(0.2);
  const double there = x();
  EXPECT_NEAR(there, -0.155 / 2, 0.01);
  rig.wait(20);  // it falls asleep, and has to be woken
  EXPECT_NEAR(x(), there, 0.0005);
  EXPECT_TRUE(world->belt_running(bs));
  world->go_on();
  rig.wait(1.5);
  EXPECT_FALSE(world->belt_running(bs));
  EXPECT_EQ(world->at(spot(*world, "C-BS-OUTPUT"))->id, piece);
  EXPECT_NEAR(to_seconds(world->now() - world->floor_time()), 20.2, 1e-9);
}

TEST(MujocoWorld, AHaltBrakesRobotsAndFreezesTheirArms) {
  auto world = make_world();
  Rig rig(*world);
  world->command_base(kR1, 0, 0.7, 1);
  world->command_gripper(kR1, {0.2, 0, 0.05});
  rig.wait(1.9);
  EXPECT_GT(world->robot(kR1).vy, 0.65);
  world->halt();
  rig.wait(0.8);
  const RobotState standing = world->robot(kR1);
  EXPECT_LT(std::hypot(standing.vx, standing.vy), 0.03) << "it brakes with 1.5 m/s2";
  EXPECT_NEAR(standing.gripper.x(), 0.19, 0.005);
  world->command_base(kR1, 0.7, 0, 0);
  rig.wait(1);
  const RobotState held = world->robot(kR1);
  EXPECT_LT(distance(held.pose_in_world.position(), standing.pose_in_world.position()), 0.01);
  EXPECT_LT((held.gripper - standing.gripper).norm(), 0.002);
  world->go_on();
  rig.wait(1);
  EXPECT_GT(world->robot(kR1).vx, 0.3);
  EXPECT_NEAR(world->robot(kR1).gripper.x(), 0.2, 0.002);
}

TEST(MujocoWorld, PlaceOfANewPieceMustBeFree) {
  auto world = make_world();
  ASSERT_TRUE(world->dispense(spot(*world, "C-CS1-SHELF-LEFT"), kBase).ok());
  const auto second = world->dispense(spot(*world, "C-CS1-SHELF-LEFT"), kBase);
  ASSERT_FALSE(second.ok());
  EXPECT_THAT(second.error().message, HasSubstr("taken by piece 1"));
}

TEST(MujocoWorld, BodiesAreUsedAgainUnderNewNumbers) {
  auto world = make_world();
  const StationId bs = station(*world, "C-BS");
  for (int i = 1; i <= 30; ++i) {  // the pool has 20
    const auto piece = world->dispense(bs, 0, kBase);
    ASSERT_TRUE(piece.ok()) << piece.error().text();
    EXPECT_EQ(*piece, PieceId{i});
    ASSERT_TRUE(world->advance(kTick).ok());
    world->retire(*piece, Holder::kGate);
    EXPECT_EQ(world->find(*piece), nullptr);
    ASSERT_TRUE(world->advance(kTick).ok());
    EXPECT_EQ(world->changes().front().to, Holder::kGate);
  }
  EXPECT_TRUE(world->pieces().empty());
}

TEST(MujocoWorld, AStoredPieceComesBackWithItsNumber) {
  auto world = make_world();
  const StationId bs = station(*world, "C-BS");
  const PieceId stored = *world->dispense(bs, 0, kBase);
  world->retire(stored, Holder::kStorage);
  ASSERT_TRUE(world->advance(kTick).ok());
  ASSERT_TRUE(world->dispense(bs, 0.1, kBase).ok());  // has its body now
  EXPECT_EQ(*world->unstore(bs, 0, Stack{1, {3}, 0}, stored), stored);
  ASSERT_TRUE(world->advance(kTick).ok());
  EXPECT_EQ(world->find(stored)->stack, (Stack{1, {3}, 0}));
  EXPECT_EQ(world->on_belt(bs, 0), world->find(stored));
  EXPECT_EQ(world->on_belt(bs, 0.1), world->find(PieceId{2}));
  EXPECT_EQ(world->changes().back().from, Holder::kStorage);
  EXPECT_EQ(*world->dispense(bs, -0.1, kBase), PieceId{3});
}

TEST(MujocoWorld, PoolCanRunOut) {
  ModelOptions options = test_options();
  options.pieces = 1;
  auto world = std::move(*MujocoWorld::create(small_floor(), options));
  ASSERT_TRUE(world->dispense(station(*world, "C-BS"), 0, kBase).ok());
  const auto second = world->dispense(station(*world, "C-DS"), 0, kBase);
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, "no_spare_piece");
}

TEST(MujocoWorld, MountedPartsMakeAPieceHeavierAndHigher) {
  auto world = make_world();
  const PieceId piece = *world->dispense(station(*world, "C-RS1"), 0, kBase);
  world->mount(piece, Part::kRing, 3);
  world->mount(piece, Part::kRing, 1);
  world->mount(piece, Part::kCap, 2);
  EXPECT_EQ(world->find(piece)->stack, (Stack{1, {3, 1, 0}, 2}));
  const mjModel& m = world->gate().model();
  const PieceIds& ids = world->gate().factory().pieces[0];
  EXPECT_NEAR(m.body_mass[ids.body], 0.065, 1e-12);
  // Underside of the cap = top of the second ring.
  EXPECT_NEAR(m.geom_pos[3 * ids.geoms[kSlotCap] + 2] - m.geom_size[3 * ids.geoms[kSlotCap] + 1], 0.0125 + 0.016,
              1e-12);
  EXPECT_EQ(m.geom_contype[ids.geoms[kSlotRing3]], 0);
  world->unmount_cap(piece);
  EXPECT_EQ(world->find(piece)->stack.cap, 0);
}

TEST(MujocoWorld, RobotKeepsItsLimits) {
  auto world = make_world();
  world->command_base(kR1, 5, 0, 9);
  double fastest = 0, turn = 0, before = 0, most_acceleration = 0;
  for (int i = 0; i < 150; ++i) {
    ASSERT_TRUE(world->advance(kTick).ok());
    const RobotState state = world->robot(kR1);
    fastest = std::max(fastest, std::hypot(state.vx, state.vy));
    turn = std::max(turn, std::abs(state.omega));
    most_acceleration = std::max(most_acceleration, (state.vx - before) / 0.02);
    before = state.vx;
  }
  EXPECT_GT(fastest, 0.65);
  EXPECT_LE(fastest, 0.7);
  EXPECT_GT(turn, 1.25);
  EXPECT_LE(turn, 1.4);
  EXPECT_LE(most_acceleration, 0.41);
}

TEST(MujocoWorld, RobotsThatMeetAreCountedOnce) {
  FloorPlan plan = small_floor();
  plan.robots = {{"R1", {-3, 4, 0}}, {"R2", {-2.2, 4, 0}}};
  auto world = make_world(nullptr, std::move(plan));
  world->command_base(kR1, 0.5, 0, 0);
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(world->advance(kTick).ok());
  EXPECT_GE(world->robot(kR1).robot_contacts, 1u);
  EXPECT_EQ(world->robot(kR1).robot_contacts, world->robot(kR2).robot_contacts);
  EXPECT_EQ(world->robot(kR1).static_contacts, 0u);
  EXPECT_EQ(world->robot(kR1).touching, 2u);
  EXPECT_EQ(world->robot(kR2).touching, 1u);
  world->command_base(kR1, -0.5, 0, 0);
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(world->advance(kTick).ok());
  EXPECT_EQ(world->robot(kR1).touching, 0u);
  EXPECT_GE(world->robot(kR1).robot_contacts, 1u);
}

TEST(MujocoWorld, ARobotThatPeopleCarryStandsWhereTheySetItDown) {
  auto world = make_world();
  world->command_base(kR1, 0.5, 0.2, 1);
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(world->advance(kTick).ok());
  ASSERT_GT(world->robot(kR1).vx, 0.3);
  world->take_off_field(kR1, {-5, -0.6, 1});
  EXPECT_TRUE(world->is_off_field(kR1));
  EXPECT_FALSE(world->is_off_field(kR2));
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(world->advance(kTick).ok());
  EXPECT_NEAR(world->robot(kR1).pose_in_world.x, -5, 1e-4);
  EXPECT_NEAR(world->robot(kR1).pose_in_world.y, -0.6, 1e-4);
  EXPECT_NEAR(world->robot(kR1).pose_in_world.yaw, 1, 1e-4);
  world->bring_back(kR1, {-3, 4, -2});
  EXPECT_FALSE(world->is_off_field(kR1));
  EXPECT_NEAR(world->robot(kR1).pose_in_world.yaw, -2, 1e-9);
}

TEST(MujocoWorld, RobotThatDrivesIntoAMachineIsCounted) {
  FloorPlan plan = small_floor();
  plan.robots[0].pose_in_world = {1.5, 4.8, 0};
  auto world = make_world(nullptr, std::move(plan));
  world->command_base(kR1, 0, 0.3, 0);
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(world->advance(kTick).ok());
  EXPECT_EQ(world->robot(kR1).static_contacts, 1u);
  EXPECT_LT(world->robot(kR1).pose_in_world.y, 5.5 - 0.35 - 0.225 + 0.005);
}

TEST(MujocoWorld, DroppedPieceComesToTheFloor) {
  auto world = make_world();
  const PieceId piece = *world->dispense(station(*world, "C-BS"), 0.155, kBase);
  Rig rig(*world);
  rig.drive_to(kR1, {3, 4, 0});
  rig.pick(kR1, spot(*world, "C-BS-INPUT"));
  ASSERT_EQ(world->robot(kR1).held, piece);
  world->command_fingers(kR1, 0.035);
  rig.wait(3);
  EXPECT_EQ(world->robot(kR1).held, std::nullopt);
  EXPECT_EQ(rig.life(piece), "belt gripper floor");
  EXPECT_LT(world->find(piece)->position_in_world.z(), 0.05);
}

TEST(MujocoWorld, MotorsRampTheirSpeeds) {
  auto world = make_world();
  Rig rig(*world);
  world->command_base(kR1, 0.5, 0, 1.0);
  world->command_gripper(kR1, {0.24, 0.0375, 0.057});
  world->command_fingers(kR1, -0.010);
  rig.wait(0.3);
  EXPECT_NEAR(world->robot(kR1).finger_opening, 0.035 - 0.3 * 0.1, 0.004);
  rig.wait(0.7);
  EXPECT_NEAR(world->robot(kR1).gripper.x(), 0.1, 0.02);
  rig.wait(1);
  const RobotState fast = world->robot(kR1);
  EXPECT_NEAR(fast.vx, 0.5, 0.02);
  EXPECT_NEAR(fast.omega, 1.0, 0.05);
  world->command_base(kR1, 0, 0, 0);
  rig.wait(0.2);
  EXPECT_NEAR(world->robot(kR1).vx, 0.5 - 0.1 * 1.5, 0.05) << "the base follows 0.1 s later";
  EXPECT_NEAR(world->robot(kR1).omega, 1.0 - 0.2 * 3.2, 0.15);
}

TEST(MujocoWorld, CommandsAreClippedToTheStrokes) {
  auto world = make_world();
  Rig rig(*world);
  world->command_gripper(kR1, {1, -1, 1});
  world->command_fingers(kR1, 1);
  rig.wait(3.5);
  const RobotState state = world->robot(kR1);
  EXPECT_NEAR(state.gripper.x(), 0.24, 0.002);
  EXPECT_NEAR(state.gripper.y(), -0.0375, 0.002);
  EXPECT_NEAR(state.gripper.z(), 0.057, 0.002);
  EXPECT_NEAR(state.finger_opening, 0.045, 0.002);
}

TEST(MujocoWorld, APieceIsAtASpotWithinItsTolerance) {
  auto world = make_world();
  const StationId bs = station(*world, "C-BS");
  const auto found_at = [&](double x) {
    const auto piece = world->dispense(bs, x, kBase);
    EXPECT_TRUE(world->advance(kTick).ok());
    const bool at_spot = world->at(spot(*world, "C-BS-INPUT")) != nullptr;
    EXPECT_EQ(world->on_belt(bs, 0.155) != nullptr, at_spot);
    world->retire(*piece, Holder::kGate);
    return at_spot;
  };
  EXPECT_TRUE(found_at(0.155 - 0.0095));
  EXPECT_FALSE(found_at(0.155 - 0.0105));
}

TEST(MujocoWorld, NewPiecesNeedAPiecesWidth) {
  auto world = make_world();
  const StationId bs = station(*world, "C-BS");
  ASSERT_TRUE(world->dispense(bs, 0, kBase).ok());
  EXPECT_FALSE(world->dispense(bs, 0.039, kBase).ok());
  EXPECT_TRUE(world->dispense(bs, 0.041, kBase).ok());
}

TEST(MujocoWorld, ANewHolderCountsWhenItIsSeenForThreeTicks) {
  auto world = make_world();
  const PieceId piece = *world->dispense(station(*world, "C-BS"), 0.6, kBase);  // in the air before the machine
  int on_floor = 0;
  while (world->find(piece)->holder == Holder::kBelt) {
    ASSERT_TRUE(world->advance(kTick).ok());
    ASSERT_LT(world->now(), from_seconds(5));
    if (world->find(piece)->position_in_world.z() < 0.001) ++on_floor;
  }
  EXPECT_EQ(world->find(piece)->holder, Holder::kFloor);
  EXPECT_GE(on_floor, 3);
}

TEST(MujocoWorld, ChangesShowWhatVerbsDidBeforeTheTickOnce) {
  auto world = make_world();
  const PieceId piece = *world->dispense(station(*world, "C-BS"), 0, kBase);
  EXPECT_TRUE(world->changes().empty()) << "not before the next tick";
  ASSERT_TRUE(world->advance(kTick).ok());
  EXPECT_EQ(world->changes().size(), 1u);
  ASSERT_TRUE(world->advance(kTick).ok());
  EXPECT_TRUE(world->changes().empty());
  world->retire(piece, Holder::kGate);
  ASSERT_TRUE(world->advance(kTick).ok());
  ASSERT_EQ(world->changes().size(), 1u);
  EXPECT_EQ(world->changes()[0].from_index, static_cast<int>(station(*world, "C-BS")));
}

TEST(MujocoPhysics, SameCommandsGiveTheSameHashAloneOrBesideAnother) {
  auto alone = make_world();
  bustle(*alone, 0, 120);
  auto first = make_world(), second = make_world();
  for (int tick = 0; tick < 120; ++tick) {
    bustle(*first, tick, tick + 1);
    second->command_base(kR2, 0.4, 0, 0);
    ASSERT_TRUE(second->advance(kTick).ok());
  }
  EXPECT_EQ(first->physics_hash(), alone->physics_hash());
  EXPECT_NE(second->physics_hash(), alone->physics_hash());
}

TEST(MujocoPhysics, LogReplaysToTheSameHash) {
  PhysicsLog log;
  auto world = make_world(&log);
  bustle(*world, 0, 60);
  std::string bytes = log.take();  // written out on the way
  world->take_off_field(kR2, {3, -0.6, 1});
  bustle(*world, 60, 150);
  bytes += log.bytes();

  auto replay = PhysicsReplay::load(world->plan(), test_options(), bytes);
  ASSERT_TRUE(replay.ok()) << replay.error().text();
  ASSERT_TRUE(replay->advance_to(world->gate().steps()).ok());
  EXPECT_EQ(replay->hash(), world->physics_hash());

  // One write less, another world.
  auto shorter = PhysicsReplay::load(world->plan(), test_options(), std::string_view(bytes).substr(0, 0));
  ASSERT_TRUE(shorter->advance_to(world->gate().steps()).ok());
  EXPECT_NE(shorter->hash(), world->physics_hash());
}

TEST(MujocoPhysics, DamagedLogIsAnError) {
  PhysicsLog log;
  log.record({0, WriteKind::kPlace, 3, {1, 2, 3}});
  const auto cut = std::string(log.bytes().substr(0, log.bytes().size() - 2));
  auto replay = PhysicsReplay::load(small_floor(), test_options(), cut);
  ASSERT_FALSE(replay.ok());
  EXPECT_THAT(replay.error().message, HasSubstr("damaged at byte 0"));
}

TEST(MujocoPhysics, LogOfAnotherModelIsAnError) {
  PhysicsLog log;
  for (const PhysicsWrite& write : {PhysicsWrite{0, WriteKind::kPark, 999, {}}, {0, WriteKind::kSetDown, 2, {}}}) {
    log.take();
    log.record(write);
    auto replay = PhysicsReplay::load(small_floor(), test_options(), log.bytes());
    ASSERT_FALSE(replay.ok());
    EXPECT_THAT(replay.error().message, HasSubstr("does not belong to this model"));
  }
}

class BrokenModels : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) / "cxlab_broken_models";
    std::filesystem::remove_all(folder_);
    std::filesystem::copy(test_options().models, folder_, std::filesystem::copy_options::recursive);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  void replace(const char* part, const std::string& from, const std::string& to) {
    std::ifstream in(folder_ / part);
    std::string text(std::istreambuf_iterator<char>(in), {});
    in.close();
    ASSERT_NE(text.find(from), std::string::npos);
    text.replace(text.find(from), from.size(), to);
    std::ofstream(folder_ / part) << text;
  }
  Error error() {
    ModelOptions options = test_options();
    options.models = folder_;
    auto made = MujocoWorld::create(small_floor(), options);
    if (made) return {};
    return made.error();
  }
  std::filesystem::path folder_;
};

TEST_F(BrokenModels, WrongElementIsReportedWithFileAndLine) {
  replace("belt.xml", "<geom name=\"guide-left\"", "<goem name=\"guide-left\"");
  const Error e = error();
  EXPECT_EQ(std::filesystem::path(e.file).filename(), "belt.xml");
  EXPECT_EQ(e.line, 14) << e.text();
  EXPECT_THAT(e.message, HasSubstr("goem"));
}

TEST_F(BrokenModels, MissingNameIsReportedAtConstruction) {
  replace("robot.xml", "<geom name=\"pad-left-2\"", "<geom name=\"pad-left-two\"");
  const Error e = error();
  EXPECT_EQ(std::filesystem::path(e.file).filename(), "robot.xml");
  EXPECT_THAT(e.message, HasSubstr("'pad-left-2'"));
}

TEST_F(BrokenModels, MissingPartIsReported) {
  std::filesystem::remove(folder_ / "slide.xml");
  EXPECT_EQ(std::filesystem::path(error().file).filename(), "slide.xml");
}

TEST_F(BrokenModels, MeasuresThatTheCodeDoesNotHaveAreReported) {
  const struct {
    const char *file, *from, *to, *message;
  } kChanges[] = {
      {"machine.xml", "size=\"0.175 0.35 0.415\"", "size=\"0.18 0.35 0.415\"",
       "geom 'body': half size along x is 0.18, expected 0.175 as in sim/geometry.h"},
      {"machine.xml", "size=\"0.175 0.35 0.415\"", "size=\"0.175 0.3 0.415\"",
       "geom 'body': half size along y is 0.3, expected 0.35 as in sim/geometry.h"},
      {"machine.xml", "pos=\"0 0 0.445\"", "pos=\"0.01 0 0.445\"", "geom 'body': x is 0.01, expected 0 "},
      {"machine.xml", "pos=\"0 0 0.445\"", "pos=\"0 0.02 0.445\"", "geom 'body': y is 0.02, expected 0 "},
      {"belt.xml", "size=\"0.175 0.0225", "size=\"0.155 0.0225", "half size along x is 0.155, expected 0.175 "},
      {"belt.xml", "<frame name=\"belt\" pos=\"0 -0.025", "<frame name=\"belt\" pos=\"0 -0.02",
       "geom 'belt': y is -0.02, expected -0.025 "},
      {"belt.xml", "<frame name=\"belt\" pos=\"0 ", "<frame name=\"belt\" pos=\"0.1 ",
       "geom 'belt': x is 0.1, expected 0 "},
      {"belt.xml", "pos=\"0 0 -0.019\"", "pos=\"0 0 -0.018\"", "z of the top is 0.899, expected 0.898 "},
      {"shelf.xml", "pos=\"0 0 -0.005\"", "pos=\"0 0 -0.004\"", "geom 'shelf': z of the top is 0.899, expected 0.898 "},
      {"shelf.xml", "pos=\"0 -0.1 0\"", "pos=\"0 -0.11 0\"", "geom 'mark-left': y is 0.065, expected 0.075 "},
      {"shelf.xml", "pos=\"0 0.1 0\"", "pos=\"0.01 0.1 0\"", "geom 'mark-right': x is 0.115, expected 0.105 "},
      {"slide.xml", "pos=\"0.155 0.25 0.898\"", "pos=\"0.155 0.26 0.898\"", "geom 'slide': y is 0.26, expected 0.25 "},
      {"slide.xml", "pos=\"0.155 0.25 0.898\"", "pos=\"0.165 0.25 0.898\"",
       "geom 'slide': z of the floor at the mouth is "},
      {"robot.xml", "size=\"0.225 0.4\"", "size=\"0.2 0.4\"", "geom 'hull': radius is 0.2, expected 0.225 "},
      {"robot.xml", "pos=\"0.139 0 0.888\"", "pos=\"0.14 0 0.888\"", "body 'arm': x is 0.14, expected 0.139 "},
      {"robot.xml", "pos=\"0.139 0 0.888\"", "pos=\"0.139 0.1 0.888\"", "body 'arm': y is 0.1, expected 0 "},
      {"robot.xml", "pos=\"0.139 0 0.888\"", "pos=\"0.139 0 0.9\"", "body 'arm': z is 0.9, expected 0.888 "},
      {"robot.xml", "range=\"0 0.24\"", "range=\"0 0.25\"",
       "joint 'forward': upper end of the range is 0.25, expected 0.24 "},
      {"robot.xml", "range=\"-0.0375 0.0375\"", "range=\"-0.03 0.0375\"",
       "joint 'left': lower end of the range is -0.03, expected -0.0375 "},
      {"robot.xml", "range=\"0 0.057\"", "range=\"0 0.06\"",
       "joint 'up': upper end of the range is 0.06, expected 0.057 "},
      {"robot.xml", "range=\"-0.010 0.035\"", "range=\"-0.020 0.035\"",
       "joint 'finger-left': lower end of the range is -0.02, expected -0.01 "},
      {"robot.xml", "pos=\"0 -0.035 0.044\"", "pos=\"0 -0.036 0.044\"",
       "body 'finger-right': distance from the middle is 0.036, expected 0.035 "},
      {"piece.xml", "mass=\"0.05\"", "mass=\"0.06\"", "body 'piece': mass is 0.06, expected 0.05 "},
      {"piece.xml", "name=\"base\" size=\"0.020 0.0125\"", "name=\"base\" size=\"0.021 0.0125\"",
       "geom 'base': radius is 0.021, expected 0.02 "},
      {"piece.xml", "name=\"base\" size=\"0.020 0.0125\"", "name=\"base\" size=\"0.020 0.013\"",
       "geom 'base': half height is 0.013, expected 0.0125 "},
      {"piece.xml", "pos=\"0 0 0.0245\"", "pos=\"0 0 0.025\"", "geom 'ring-2': z is 0.025, expected 0.0245 "},
      {"piece.xml", "name=\"ring-3\" size=\"0.020 0.004\"", "name=\"ring-3\" size=\"0.020 0.005\"",
       "geom 'ring-3': half height is 0.005, expected 0.004 "},
      {"piece.xml", "name=\"ring-1\" size=\"0.020", "name=\"ring-1\" size=\"0.019", "geom 'ring-1': radius is 0.019, "},
      {"piece.xml", "name=\"cap\" size=\"0.020", "name=\"cap\" size=\"0.019",
       "geom 'cap': radius is 0.019, expected 0.02 "},
  };
  for (const auto& change : kChanges) {
    SetUp();
    replace(change.file, change.from, change.to);
    const Error e = error();
    EXPECT_EQ(e.kind, ErrorKind::kInput);
    EXPECT_EQ(e.file, (folder_ / change.file).string()) << change.to;
    EXPECT_THAT(e.message, HasSubstr(change.message));
  }
}

TEST_F(BrokenModels, AGeomThatIsOnlyCheckedMustBeThere) {
  replace("machine.xml", "geom name=\"body\"", "geom name=\"box\"");
  EXPECT_EQ(error().message, "geom 'body' is missing");
}

TEST_F(BrokenModels, WorldThatDivergesSaysWhen) {
  replace("factory.xml", "integrator=\"Euler\"", "integrator=\"Euler\" gravity=\"0 0 1e12\"");
  ModelOptions options = test_options();
  options.models = folder_;
  auto world = std::move(*MujocoWorld::create(small_floor(), options));
  ASSERT_TRUE(world->dispense(station(*world, "C-BS"), 0, kBase).ok());
  Status status;
  for (int i = 0; i < 10 && status.ok(); ++i) status = world->advance(kTick);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().kind, ErrorKind::kRun);
  EXPECT_THAT(status.error().message, HasSubstr("world diverged at 0.0"));
}

}  // namespace
}  // namespace cxlab::sim
