// One robot builds and delivers a C3 with two paid rings in MuJoCo, told step by step by a script. Short: one field.
// With CXLAB_SWEEP=FIRST:COUNT (the long test sets it): that many fields.

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>

#include "cx/run/loop.h"
#include "scenarios/rcll/game/factory.h"
#include "scenarios/rcll/game/floor_plan.h"
#include "sim/mujoco/mujoco_world.h"
#include "sim/skills/fleet.h"
#include "tests/support/test_bus.h"

namespace cxlab::rcll {
namespace {

/// Rings with the prices 1, 0 and 2 in the game of that seed.
std::vector<std::string> two_paid_rings(std::uint64_t seed) {
  const Schedule drawn = game_of(WorldConfig{}, seed)->schedule;
  std::vector<std::string> rings;
  for (const int price : {1, 0, 2})
    for (const RingColor color : kRingColors)
      if (drawn.price(color) == price && rings.size() == static_cast<std::size_t>(price == 2 ? 2 : price == 0 ? 1 : 0))
        rings.emplace_back(to_string(color));
  return rings;
}

class Builder final : public Agent, private bus::TestBus {
 public:
  Builder(const WorldConfig& config, std::uint64_t seed) : game_(*game_of(config, seed)) {
    world_ = *sim::MujocoWorld::create(floor_plan_of(config, game_.layout), {models_dir(), 0.01, 60});
    fleet_ = *sim::Fleet::create(*world_, *world_, {}, bus_, sink_);
    factory_ = *Factory::make(config, game_, seed, *world_, bus_, sink_);
    node_ = join(bus::ParticipantKind::kEnvironment, "env/builder", {"builder", "/", {}});
    loop_.emplace(bus_, kTick, Parts{{world_.get()}, {fleet_.get(), factory_.get()}, factory_.get(), {this}});
    tick();
  }

  Status perceive() override {
    bus_.deliver(node_);
    return {};
  }
  Status decide(SimTime) override { return {}; }
  Status act() override { return {}; }
  SimTime next_due() const override { return kNever; }

  void pick(const std::string& spot) {
    carry_out("/robot1/pick", "cxlab_skills/action/Pick", "{target: " + spot + "}");
  }
  void place(const std::string& spot) {
    carry_out("/robot1/place", "cxlab_skills/action/Place", "{target: " + spot + "}");
  }
  void move(const std::string& from, const std::string& to) { pick(from), place(to); }
  /// Waits until the machine is idle, instructs it, and waits for the end.
  void instruct(const std::string& machine, const std::string& fields) {
    for (int i = 0; i < 3000 && state(machine) != MachineState::kIdle; ++i) tick();
    carry_out("/factory/instruct_machine", "rcll_interfaces/action/InstructMachine",
              "{machine: " + machine + ", " + fields + "}");
  }
  MachineState state(const std::string& name) const { return find_machine(factory_->machines(), name)->state(); }
  const GameReferee& referee() const { return factory_->referee(); }
  const Schedule& schedule() const { return game_.schedule; }
  const KeptRecords& records() const { return sink_; }
  double now() const { return to_seconds(world_->now()); }

 private:
  static constexpr SimTime kTick = std::chrono::milliseconds(20);
  void tick() { ASSERT_TRUE(loop_->tick_at(loop_->ticks() == 0 ? SimTime::zero() : loop_->now() + kTick)); }
  void carry_out(const std::string& action, const std::string& type_name, const std::string& goal) {
    const bus::ActionType& type = **registry_.action(type_name);
    if (!clients_.contains(action))
      clients_[action] = *bus_.create_action_client(node_, action, type,
                                                    {nullptr, nullptr,
                                                     [this](const bus::Delivery& d) {
                                                       ended_ = true;
                                                       code_ = d.message->view().integer("error_code");
                                                       error_ = d.message->view().text("error");
                                                     },
                                                     nullptr});
    ended_ = false;
    bus_.send_goal(clients_[action], std::make_shared<bus::Message>(*bus::Message::from_yaml(*type.goal, goal)));
    for (int i = 0; i < 7000 && !ended_; ++i) tick();
    ASSERT_TRUE(ended_) << action << ' ' << goal;
    ASSERT_EQ(code_, 0) << action << ' ' << goal << ": " << error_ << " at " << now() << " s";
  }

  Game game_;
  std::unique_ptr<sim::MujocoWorld> world_;
  std::unique_ptr<sim::Fleet> fleet_;
  std::unique_ptr<Factory> factory_;
  bus::ParticipantId node_{};
  std::map<std::string, bus::EndpointId> clients_;
  bool ended_ = false;
  std::int64_t code_ = 0;
  std::string error_;
  std::optional<Loop> loop_;
};

/// The records "piece" of one piece hang together, from the dispenser on.
void expect_unbroken_track(const std::vector<nlohmann::json>& events, std::int64_t piece, const std::string& end) {
  std::string holder = "dispenser";
  for (const auto& event : events) {
    if (event.at("event") != "piece" || event.at("piece") != piece) continue;
    EXPECT_EQ(event.at("from"), holder) << "piece " << piece;
    holder = event.at("to");
  }
  EXPECT_EQ(holder, end) << "piece " << piece;
}

void build(std::uint64_t seed) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  WorldConfig config;
  config.robots = 1;
  config.down = false;
  OrderConfig order;
  order.complexity = "C3";
  order.ring_colors = two_paid_rings(seed);
  order.cap_color = "CAP_BLACK";
  config.orders = {order};
  Builder builder(config, seed);
  const auto station_of = [](const std::string& ring) {
    return ring == "RING_ORANGE" || ring == "RING_GREEN" ? std::string("C-RS1") : std::string("C-RS2");
  };
  const auto base = [&] { builder.instruct("C-BS", "side: OUTPUT, base_color: BASE_RED"); };

  for (const std::string& ring : order.ring_colors)
    for (int i = 0; i < builder.schedule().price(*named<RingColor>(ring)); ++i) {
      base();
      builder.move("C-BS-OUTPUT", station_of(ring) + "-SLIDE");
    }
  builder.move("C-CS2-SHELF-LEFT", "C-CS2-INPUT");
  builder.instruct("C-CS2", "operation: RETRIEVE_CAP");
  builder.move("C-CS2-OUTPUT", "C-DS-INPUT");
  builder.instruct("C-DS", "order_id: 0");
  base();
  std::string at = "C-BS";
  for (const std::string& ring : order.ring_colors) {
    builder.move(at + "-OUTPUT", station_of(ring) + "-INPUT");
    builder.instruct(station_of(ring), "ring_color: " + ring);
    at = station_of(ring);
  }
  builder.move(at + "-OUTPUT", "C-CS2-INPUT");
  builder.instruct("C-CS2", "operation: MOUNT_CAP");
  builder.move("C-CS2-OUTPUT", "C-DS-INPUT");
  builder.instruct("C-DS", "order_id: 1");
  if (testing::Test::HasFatalFailure()) return;

  std::printf("seed %d: a C3 with two paid rings after %.0f s\n", static_cast<int>(seed), builder.now());
  std::fflush(stdout);
  EXPECT_EQ(builder.referee().score(Team::kCyan).by_kind,
            (std::array<std::int64_t, kPointKinds>{100, 35, 10, 2, 6, 0, 0, 0, 0}));
  std::vector<nlohmann::json> events;
  for (const auto& record : builder.records().of(RecordKind::kReferee))
    events.push_back(nlohmann::json::from_msgpack(record.data));
  std::string mounted;
  std::int64_t product = 0;
  int payments = 0;
  for (const auto& event : events) {
    if (event.at("event") == "mounted") {
      EXPECT_TRUE(product == 0 || product == event.at("piece")) << "one piece from the first ring to the cap";
      product = event.at("piece");
      mounted = event.at("product");
    }
    if (event.at("event") == "piece" && event.at("to") == "slide") {
      ++payments;
      expect_unbroken_track(events, event.at("piece"), "slide");
    }
  }
  EXPECT_EQ(payments, 3);
  EXPECT_EQ(mounted, "BASE_RED " + order.ring_colors[0] + ' ' + order.ring_colors[1] + ' ' + order.ring_colors[2] +
                         " CAP_BLACK");
  ASSERT_EQ(builder.referee().deliveries().size(), 1u);
  EXPECT_EQ(static_cast<std::int64_t>(builder.referee().deliveries()[0].piece), product);
  expect_unbroken_track(events, product, "gate");
}

TEST(C3InPhysics, IsBuiltPaidForAndDelivered) {
  unsigned first = 1, count = 1;
  if (const char* sweep = std::getenv("CXLAB_SWEEP")) {
    ASSERT_EQ(std::sscanf(sweep, "%u:%u", &first, &count), 2) << "CXLAB_SWEEP=FIRST:COUNT";
  }
  for (unsigned seed = first; seed < first + count; ++seed) build(seed);
}

}  // namespace
}  // namespace cxlab::rcll
