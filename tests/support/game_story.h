#pragma once
// A game on the ledger world: a test gives instructions on the bus and moves pieces as a robot would, and looks at what
// machines and referee make of it. One tick is 20 ms, if the test wants no other.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "cx/run/loop.h"
#include "scenarios/rcll/game/factory.h"
#include "scenarios/rcll/game/floor_plan.h"
#include "sim/ledger/ledger_world.h"
#include "tests/support/test_bus.h"

namespace cxlab::rcll {

/// How a goal ended; `code` is the server's word for it.
struct Outcome {
  bool ended = false;
  bus::GoalStatus status{};
  std::int64_t code = -1;
  std::string error;
  double at = 0;
};

class GameStory : private bus::TestBus {
 public:
  explicit GameStory(WorldConfig config = quiet_game(), std::uint64_t seed = 1,
                     SimTime tick = std::chrono::milliseconds(20), std::span<const sim::Fault> faults = {})
      : tick_(tick), world_(floor_plan_of(config, game_of(config, seed)->layout)) {
    factory_ = std::move(*Factory::make(config, *game_of(config, seed), seed, world_, bus_, sink_, faults));
    agent_ = join(bus::ParticipantKind::kEnvironment, "env/agent", {"agent", "/", {}});
    action_ = *registry_.action("rcll_interfaces/action/InstructMachine");
    client_ = *bus_.create_action_client(
        agent_, "/factory/instruct_machine", *action_,
        {nullptr, [this](const bus::Delivery& d) { feedback_.push_back(d.message->view().text("state")); },
         [this](const bus::Delivery& d) { note_result(d); }, nullptr});
    loop_.emplace(bus_, tick_, Parts{{&world_}, {factory_.get()}, factory_.get(), {&client_of_factory_}});
    run_for(0);
  }

  /// No down periods; one C0 order for BASE_RED, CAP_GREY with window 0..1200, and whatever the test adds.
  static WorldConfig quiet_game() {
    WorldConfig config;
    config.down = false;
    OrderConfig order;
    order.base_color = "BASE_RED";
    order.cap_color = "CAP_GREY";
    config.orders = {order};
    return config;
  }

  /// Ticks until `seconds` later; 0 = one tick.
  void run_for(double seconds) {
    const SimTime end = world_.now() + from_seconds(seconds);
    loop_->set_end(end);
    do {
      const SimTime following = loop_->ticks() == 0 ? SimTime::zero() : loop_->now() + tick_;
      EXPECT_TRUE(loop_->tick_at(jumping_ ? loop_->next_tick() : following));
    } while (world_.now() < end);
  }
  void run_until(double seconds) {
    if (now() < seconds) run_for(seconds - now());
  }
  double now() const { return to_seconds(world_.now()); }
  /// From now on only the ticks at which something is due.
  void set_jumping(bool on) { jumping_ = on; }
  std::int64_t ticks() const { return loop_->ticks(); }

  /// Index of the new goal.
  std::size_t instruct(const std::string& yaml) {
    goals_.push_back(
        bus_.send_goal(client_, std::make_shared<bus::Message>(*bus::Message::from_yaml(*action_->goal, yaml))));
    outcomes_.emplace_back();
    return goals_.size() - 1;
  }
  void cancel(std::size_t goal) { bus_.cancel_goal(client_, goals_[goal]); }
  const Outcome& outcome(std::size_t goal) const { return outcomes_[goal]; }
  const std::vector<std::string>& feedback() const { return feedback_; }
  /// Instructs and waits until the goal ends, 60 s at most.
  Outcome carry_out(const std::string& yaml) {
    const std::size_t goal = instruct(yaml);
    for (int i = 0; i < 3000 && !outcomes_[goal].ended; ++i) run_for(0);
    return outcomes_[goal];
  }

  sim::SpotId spot(const std::string& name) const { return *world_.plan().find_spot(name); }
  bool nothing_at(const std::string& name) const { return world_.at(spot(name)) == nullptr; }
  /// R1 takes what lies there, or puts what it holds.
  void take(const std::string& from) {
    go_to(from);
    const Status s = world_.grasp(sim::RobotId{0}, spot(from));
    EXPECT_TRUE(s) << (s ? "" : s.error().message);
  }
  void put(const std::string& to) {
    go_to(to);
    const Status s = world_.release(sim::RobotId{0}, spot(to));
    EXPECT_TRUE(s) << (s ? "" : s.error().message);
  }
  void move(const std::string& from, const std::string& to) { take(from), put(to); }
  /// The robot stands there from the next tick on.
  void set_robot(int robot, const sim::Pose2& at) {
    world_.move_along(static_cast<sim::RobotId>(robot), std::span(&at, 1), world_.now(), world_.now());
  }

  /// R1 holds a capped base, made by the machines; returns the second at which it does.
  void make_product(const std::string& base, const std::string& cs) {
    EXPECT_EQ(carry_out("{machine: C-BS, side: OUTPUT, base_color: " + base + "}").code, 0);
    move("C-" + cs + "-SHELF-LEFT", "C-" + cs + "-INPUT");
    EXPECT_EQ(carry_out("{machine: C-" + cs + ", operation: RETRIEVE_CAP}").code, 0);
    take("C-" + cs + "-OUTPUT");
    world_.drop(sim::RobotId{0});
    run_for(6);
    move("C-BS-OUTPUT", "C-" + cs + "-INPUT");
    EXPECT_EQ(carry_out("{machine: C-" + cs + ", operation: MOUNT_CAP}").code, 0);
    take("C-" + cs + "-OUTPUT");
  }

  /// A product of those colours lies at cyan's delivery input as if a robot had put it there.
  void lay_before_delivery(const std::string& base, std::optional<CapColor> cap) {
    sim::Stack stack;
    stack.base = static_cast<std::uint8_t>(*named<BaseColor>(base));
    if (cap) stack.cap = static_cast<std::uint8_t>(*cap);
    EXPECT_TRUE(world_.dispense(machine("C-DS").id(), sim::kMachine.belt_rest_x, stack));
  }

  const Machine& machine(const std::string& name) const {
    for (const auto& m : factory_->machines())
      if (m->name() == name) return *m;
    std::abort();
  }
  std::string state(const std::string& name) const { return std::string(to_string(machine(name).state())); }
  const Score& score(Team team = Team::kCyan) const { return factory_->referee().score(team); }
  const std::vector<Delivery>& deliveries() const { return factory_->referee().deliveries(); }
  Factory& factory() { return *factory_; }
  sim::LedgerWorld& world() { return world_; }
  bus::Bus& bus() { return bus_; }
  bus::Registry& registry() { return registry_; }
  bus::ParticipantId agent() const { return agent_; }
  const KeptRecords& records() const { return sink_; }

 private:
  /// The client of the factory: takes what waits for it, and never acts by itself.
  struct Client final : Agent {
    explicit Client(GameStory& story) : story_(story) {}
    Status perceive() override {
      story_.bus_.deliver(story_.agent_);
      return {};
    }
    Status decide(SimTime) override { return {}; }
    Status act() override { return {}; }
    SimTime next_due() const override { return kNever; }
    GameStory& story_;
  };
  void go_to(const std::string& name) {
    set_robot(0, world_.plan().spot(spot(name)).work_in_world);
    run_for(0.04);
  }
  void note_result(const bus::Delivery& delivery) {
    for (std::size_t i = 0; i < goals_.size(); ++i) {
      if (goals_[i] != delivery.goal) continue;
      const bus::MessageView result = delivery.message->view();
      outcomes_[i] = {true, delivery.status, result.integer("error_code"), result.text("error"), now()};
    }
  }

  SimTime tick_;
  sim::LedgerWorld world_;
  std::unique_ptr<Factory> factory_;
  bus::ParticipantId agent_{};
  const bus::ActionType* action_ = nullptr;
  bus::EndpointId client_{};
  std::vector<bus::GoalId> goals_;
  std::vector<Outcome> outcomes_;
  std::vector<std::string> feedback_;
  Client client_of_factory_{*this};
  std::optional<Loop> loop_;
  bool jumping_ = false;
};

}  // namespace cxlab::rcll
