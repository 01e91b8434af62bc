#include <gtest/gtest.h>

#include <algorithm>

#include "scenarios/rcll/game/floor_plan.h"
#include "scenarios/rcll/game/game.h"
#include "scenarios/rcll/rules/machines.h"
#include "sim/mujoco/mujoco_world.h"
#include "tests/support/files.h"

namespace cxlab::rcll {
namespace {

/// Machines on simulated belts, without bus and robots' skills.
class BeltPhysics : public testing::Test {
 protected:
  void SetUp() override { make(60); }
  void make(int pieces) {
    sim::ModelOptions options;
    options.models = models_dir();
    options.pieces = pieces;
    machines_.clear();
    auto world = sim::MujocoWorld::create(floor_plan_of(WorldConfig{}, game_of(WorldConfig{}, 1)->layout), options);
    ASSERT_TRUE(world) << world.error().text();
    world_ = std::move(*world);
    schedule_.orders.resize(1);
    schedule_.orders[0].id = 1;
    schedule_.orders[0].delivery_end = 1200;
    context_.schedule = &schedule_;
    machines_ = make_machines(world_->plan(), context_);
    tick();
  }
  void tick() {
    ASSERT_TRUE(world_->advance(kTick));
    for (auto& machine : machines_) machine->step(world_->now(), *world_);
  }
  /// Seconds until the instruction ended, or 60.
  double carry_out(Machine& machine, const Instruction& instruction) {
    const SimTime begin = world_->now();
    EXPECT_EQ(machine.instruct(instruction, begin, *world_).error, InstructError::kNone);
    while (machine.job().open && world_->now() - begin < from_seconds(60)) tick();
    EXPECT_EQ(machine.job().error, InstructError::kNone) << machine.job().text;
    return to_seconds(world_->now() - begin);
  }
  Machine& machine(const std::string& name) {
    return *machines_[static_cast<std::size_t>(*world_->plan().find_station(name))];
  }
  const sim::Piece* at(const std::string& spot) { return world_->at(*world_->plan().find_spot(spot)); }

  static constexpr SimTime kTick = std::chrono::milliseconds(20);
  std::unique_ptr<sim::MujocoWorld> world_;
  Schedule schedule_;
  MachineContext context_;
  std::vector<std::unique_ptr<Machine>> machines_;
};

TEST_F(BeltPhysics, WhereAllPiecesAreInPlayAMachineSaysSoOnceAShortage) {
  make(13);  // twelve of them lie on shelves
  const auto shortages = [&] {
    return std::ranges::count(context_.events, MachineEvent::Kind::kNoSpare, &MachineEvent::kind);
  };
  carry_out(machine("C-BS"), {.side = "OUTPUT", .base_color = "BASE_RED"});
  EXPECT_EQ(shortages(), 0);
  machine("M-BS").instruct({.side = "OUTPUT", .base_color = "BASE_RED"}, world_->now(), *world_);
  for (int i = 0; i < 500; ++i) tick();
  EXPECT_EQ(shortages(), 1);
  world_->retire(at("C-BS-OUTPUT")->id, sim::Holder::kFloor);
  for (int i = 0; i < 300; ++i) tick();
  ASSERT_NE(at("M-BS-OUTPUT"), nullptr);
  EXPECT_EQ(shortages(), 1);
  world_->retire(at("M-BS-OUTPUT")->id, sim::Holder::kFloor);
  carry_out(machine("C-BS"), {.side = "OUTPUT", .base_color = "BASE_RED"});
  for (int i = 0; i < 300; ++i) tick();
  machine("M-BS").instruct({.side = "OUTPUT", .base_color = "BASE_RED"}, world_->now(), *world_);
  for (int i = 0; i < 200; ++i) tick();
  EXPECT_EQ(shortages(), 2) << "after M-BS had dispensed again";
}

TEST_F(BeltPhysics, ABaseRidesToTheSideThatWasAskedFor) {
  EXPECT_NEAR(carry_out(machine("C-BS"), {.side = "OUTPUT", .base_color = "BASE_RED"}), 1.1 + 2.656, 0.4);
  EXPECT_NE(at("C-BS-OUTPUT"), nullptr);
  EXPECT_NEAR(carry_out(machine("M-BS"), {.side = "INPUT", .base_color = "BASE_BLACK"}), 1.1 + 2.656, 0.4);
  EXPECT_NE(at("M-BS-INPUT"), nullptr);
}

TEST_F(BeltPhysics, ACapIsRetrievedAndMountedOnTheNextBase) {
  Machine& cap_station = machine("C-CS1");
  ASSERT_TRUE(world_->dispense(cap_station.id(), sim::kMachine.belt_rest_x, {4, {}, 2}));
  EXPECT_NEAR(carry_out(cap_station, {.operation = "RETRIEVE_CAP"}), 21.7, 0.6);
  ASSERT_NE(at("C-CS1-OUTPUT"), nullptr);
  EXPECT_EQ(at("C-CS1-OUTPUT")->stack, (sim::Stack{4, {}, 0}));
  world_->retire(at("C-CS1-OUTPUT")->id, sim::Holder::kFloor);
  for (int i = 0; i < 260; ++i) tick();

  ASSERT_TRUE(world_->dispense(cap_station.id(), sim::kMachine.belt_rest_x, {1, {}, 0}));
  EXPECT_NEAR(carry_out(cap_station, {.operation = "MOUNT_CAP"}), 21.7, 0.6);
  ASSERT_NE(at("C-CS1-OUTPUT"), nullptr);
  EXPECT_EQ(at("C-CS1-OUTPUT")->stack, (sim::Stack{1, {}, 2}));
}

TEST_F(BeltPhysics, RingsAreMountedOneOnTheOther) {
  Machine& ring_station = machine("C-RS1");
  sim::Stack wanted{1, {}, 0};
  for (const RingColor color : {RingColor::kOrange, RingColor::kGreen, RingColor::kOrange}) {  // all free here
    const auto piece = world_->dispense(ring_station.id(), sim::kMachine.belt_rest_x, wanted);
    ASSERT_TRUE(piece);
    EXPECT_NEAR(carry_out(ring_station, {.ring_color = std::string(to_string(color))}), 21.5, 0.6);
    wanted.mount(sim::Part::kRing, static_cast<std::uint8_t>(color));
    ASSERT_NE(at("C-RS1-OUTPUT"), nullptr);
    EXPECT_EQ(at("C-RS1-OUTPUT")->id, *piece);
    EXPECT_EQ(at("C-RS1-OUTPUT")->stack, wanted);
    world_->retire(*piece, sim::Holder::kFloor);
    for (int i = 0; i < 260; ++i) tick();
  }
}

TEST_F(BeltPhysics, AWorkpieceGoesIntoTheStorageAndComesOutAgain) {
  Machine& storage = machine("C-SS");
  ASSERT_TRUE(world_->dispense(storage.id(), sim::kMachine.belt_rest_x, {1, {2, 3, 0}, 0}));
  EXPECT_NEAR(carry_out(storage, {.operation = "STORE", .shelf = 4, .slot = 5}), 19.0, 0.6);
  for (int i = 0; i < 260; ++i) tick();
  EXPECT_NEAR(carry_out(storage, {.operation = "RETRIEVE", .shelf = 4, .slot = 5}), 20.2, 0.6);
  ASSERT_NE(at("C-SS-OUTPUT"), nullptr);
  EXPECT_EQ(at("C-SS-OUTPUT")->stack, (sim::Stack{1, {2, 3, 0}, 0}));
}

TEST_F(BeltPhysics, AProductGoesThroughTheGateAndLeavesPlay) {
  const auto product = world_->dispense(machine("C-DS").id(), sim::kMachine.belt_rest_x, {1, {}, 2});
  ASSERT_TRUE(product);
  EXPECT_NEAR(carry_out(machine("C-DS"), {.order_id = 1}), 3.746, 0.4);
  EXPECT_EQ(world_->find(*product), nullptr);
  bool delivered = false;
  for (const MachineEvent& event : context_.events)
    delivered |= event.kind == MachineEvent::Kind::kDelivery && event.stack == sim::Stack{1, {}, 2};
  EXPECT_TRUE(delivered);
}

TEST_F(BeltPhysics, EveryShelfIsFilledAndStaysFilled) {
  for (int i = 0; i < 100; ++i) tick();
  int carriers = 0;
  for (const sim::Spot& spot : world_->plan().spots)
    if (spot.kind == sim::SpotKind::kShelf && at(spot.name) != nullptr) ++carriers;
  EXPECT_EQ(carriers, 12);
}

}  // namespace
}  // namespace cxlab::rcll
