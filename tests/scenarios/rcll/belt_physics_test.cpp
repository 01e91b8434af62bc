#include <gtest/gtest.h>

#include "scenarios/rcll/floor_plan.h"
#include "scenarios/rcll/game.h"
#include "scenarios/rcll/machines.h"
#include "sim/mujoco/mujoco_world.h"
#include "tests/support/files.h"

namespace cxlab::rcll {
namespace {

/// Machines on simulated belts, without bus and robots' skills.
class BeltPhysics : public testing::Test {
 protected:
  void SetUp() override {
    sim::ModelOptions options;
    options.models = models_dir();
    auto world = sim::MujocoWorld::create(floor_plan_of(WorldConfig{}, game_of(WorldConfig{}, 1)->layout), options);
    ASSERT_TRUE(world) << world.error().text();
    world_ = std::move(*world);
    orders_.resize(1);
    orders_[0].id = 1;
    orders_[0].delivery_end = 1200;
    context_.orders = &orders_;
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
  std::vector<Order> orders_;
  MachineContext context_;
  std::vector<std::unique_ptr<Machine>> machines_;
};

TEST_F(BeltPhysics, ABaseRidesToTheSideThatWasAskedFor) {
  EXPECT_NEAR(carry_out(machine("C-BS"), {"", "OUTPUT", "BASE_RED", "", 0}), 1.1 + 2.656, 0.4);
  EXPECT_NE(at("C-BS-OUTPUT"), nullptr);
  EXPECT_NEAR(carry_out(machine("M-BS"), {"", "INPUT", "BASE_BLACK", "", 0}), 1.1 + 2.656, 0.4);
  EXPECT_NE(at("M-BS-INPUT"), nullptr);
}

TEST_F(BeltPhysics, ACapIsRetrievedAndMountedOnTheNextBase) {
  Machine& cap_station = machine("C-CS1");
  ASSERT_TRUE(world_->dispense(cap_station.id(), sim::kMachine.belt_rest_x, {4, {}, 2}));
  EXPECT_NEAR(carry_out(cap_station, {"RETRIEVE_CAP", "", "", "", 0}), 21.7, 0.6);
  ASSERT_NE(at("C-CS1-OUTPUT"), nullptr);
  EXPECT_EQ(at("C-CS1-OUTPUT")->stack, (sim::Stack{4, {}, 0}));
  world_->retire(at("C-CS1-OUTPUT")->id, sim::Holder::kFloor);
  for (int i = 0; i < 260; ++i) tick();

  ASSERT_TRUE(world_->dispense(cap_station.id(), sim::kMachine.belt_rest_x, {1, {}, 0}));
  EXPECT_NEAR(carry_out(cap_station, {"MOUNT_CAP", "", "", "", 0}), 21.7, 0.6);
  ASSERT_NE(at("C-CS1-OUTPUT"), nullptr);
  EXPECT_EQ(at("C-CS1-OUTPUT")->stack, (sim::Stack{1, {}, 2}));
}

TEST_F(BeltPhysics, AProductGoesThroughTheGateAndLeavesPlay) {
  const auto product = world_->dispense(machine("C-DS").id(), sim::kMachine.belt_rest_x, {1, {}, 2});
  ASSERT_TRUE(product);
  EXPECT_NEAR(carry_out(machine("C-DS"), {"", "", "", "", 1}), 3.746, 0.4);
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
