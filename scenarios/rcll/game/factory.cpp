#include "scenarios/rcll/game/factory.h"

#include <algorithm>
#include <utility>

#include "cx/bus/needed.h"
#include "scenarios/rcll/rules/layout.h"

namespace cxlab::rcll {

namespace {

constexpr SimTime kGameStatePeriod = std::chrono::seconds(1);
constexpr SimTime kRobotInfoPeriod = std::chrono::milliseconds(2500);

/// All orders, including those of overtime if there is one.
Schedule all_orders(const Game& game) {
  Schedule schedule = game.schedule;
  if (game.overtime) schedule.orders.push_back(*game.overtime);
  return schedule;
}

/// Fills an Order.
void put_order(const bus::MessageView& entry, const OrderState& state) {
  const Order& order = state.order;
  entry.set("id", order.id).set("complexity", to_string(order.complexity));
  entry.set("base_color", to_string(order.product.base)).set("cap_color", to_string(order.product.cap));
  std::vector<std::string_view> rings;
  for (const RingColor ring : order.product.rings) rings.push_back(to_string(ring));
  put_texts(entry, "ring_colors", rings);
  entry.set("quantity_requested", order.quantity);
  entry.set("quantity_delivered_cyan", state.delivered[0]).set("quantity_delivered_magenta", state.delivered[1]);
  entry.set("delivery_period_begin", static_cast<std::int64_t>(order.delivery_begin));
  entry.set("delivery_period_end", static_cast<std::int64_t>(order.delivery_end));
  entry.set("delivery_gate", order.delivery_gate).set("competitive", order.competitive);
}

}  // namespace

Expected<std::unique_ptr<Factory>> Factory::make(const WorldConfig& config, const Game& game, std::uint64_t seed,
                                                 sim::World& world, bus::Bus& bus, RecordSink& sink,
                                                 std::span<const sim::Fault> faults) {
  std::unique_ptr<Factory> factory(new Factory(config, game, seed, world, bus, sink));
  if (Status s = factory->faults_.take(faults, seed, factory->machines_, factory->teams()); !s) return s.error();
  factory->maintenance_.take(faults, seed);
  if (Status s = factory->join(); !s) return s.error();
  if (config.transforms)
    if (Status s = factory->broadcast_transforms(); !s) return s.error();
  return factory;
}

Factory::Factory(const WorldConfig& config, const Game& game, std::uint64_t seed, sim::World& world, bus::Bus& bus,
                 RecordSink& sink)
    : information_(*named<Information>(config.information)),
      post_game_(from_seconds(config.post_game_s)),
      world_(world),
      bus_(bus),
      sink_(sink),
      records_(world, sink),
      events_(sink, &world),
      faults_(world, records_),
      referee_(GameClock::of(config.setup_s, config.production_s, config.overtime_s),
               choices_of(*named<Rules>(config.rules)), all_orders(game), world.plan(), events_, config.exploration),
      context_{.clock = referee_.clock(),
               .rules = choices_of(*named<Rules>(config.rules)),
               .shelf_refill = from_seconds(config.shelf_refill_s),
               .schedule = &referee_.schedule(),
               .exploration = &referee_.exploration(),
               .seed = seed,
               .events = {}},
      maintenance_(world, referee_, from_seconds(config.repair_s), events_, records_),
      pauses_(config.pauses, referee_, world, events_),
      machines_(make_machines(world.plan(), context_)),
      down_(game.down),
      foreseen_down_(game.down) {
  if (config.foresight) foresight_.emplace();
  if (config.refbox.confirm_deliveries) referee_.wait_for_confirmation();
  const GameParts parts{world, machines_, referee_, maintenance_, faults_};
  for (const Team team : teams_of(config))
    channels_.push_back(std::make_unique<TeamChannel>(team, information_, parts, bus));
}

Status Factory::join() {
  bus::NodeName name;
  name.name = "factory";
  node_ = bus_.join(bus::ParticipantKind::kNode, name, sink_.open_stream("node/factory"));
  for (auto& channel : channels_)
    if (Status s = channel->open(node_, channel_prefix(channel->team(), channels_.size())); !s) return s;
  if (Status s = game_state_.open(bus_, node_, "/game_state", "GameState", kGameStatePeriod); !s) return s;
  if (Status s = order_info_.open(bus_, node_, "/order_info", "OrderInfo", kInfoPeriod); !s) return s;
  if (Status s = ring_info_.open(bus_, node_, "/ring_info", "RingInfo", kInfoPeriod); !s) return s;
  if (Status s = robot_info_.open(bus_, node_, "/robot_info", "RobotInfo", kRobotInfoPeriod); !s) return s;
  if (foresight_)
    if (Status s = foresight_->open(bus_, node_, "/foresight", "Foresight", kInfoPeriod); !s) return s;
  return serve_state();
}

Status Factory::serve_state() {
  auto type = bus::needed_service(bus_.registry(), std::string(kInterfaces) + "srv/SetGameState");
  if (!type) return type.error();
  state_type_ = *type;
  bus::NodeName name;
  name.name = "referee";
  referee_node_ = bus_.join(bus::ParticipantKind::kNode, name, sink_.open_stream("node/referee"));
  auto service = bus_.serve(referee_node_, "/set_game_state", *state_type_, [this](const bus::Delivery& call) {
    const std::string error =
        request_state(call.message->view().text("state"), bus_.name_of(call.from).full_name(), {&call.cause, 1});
    bus::Message response(*state_type_->response);
    response->set("success", error.empty()).set("error", error);
    bus_.respond(state_service_, call, std::make_shared<const bus::Message>(std::move(response)));
  });
  if (!service) return service.error();
  state_service_ = *service;
  return {};
}

std::vector<Team> Factory::teams() const {
  std::vector<Team> teams;
  for (const auto& channel : channels_) teams.push_back(channel->team());
  return teams;
}

void Factory::on_warning(const std::function<void(const std::string&)>& warn) {
  for (auto& channel : channels_) channel->on_warning(warn);
}

Status Factory::broadcast_transforms() {
  auto made = bus::TransformBroadcaster::create(bus_, node_);
  if (!made) return made.error();
  transforms_ = *std::move(made);
  for (const sim::Station& station : world_.plan().stations) {
    const sim::Pose2& at = station.pose_in_world;
    transforms_->set_static("map", station.name, bus::planar(at.x, at.y, at.yaw));
  }
  return {};
}

// --- The tick

Status Factory::sense(SimTime now) {
  const bool explored = std::exchange(published_explored_, referee_.exploration().changes()) != published_explored_;
  for (auto& channel : channels_) channel->sense(now, explored || !context_.events.empty());
  if (ring_info_.due(now, false)) publish_rings();
  if (foresight_ && foresight_->due(now, false)) publish_foresight();
  if (transforms_) {
    for (std::size_t i = 0; i < world_.plan().robots.size(); ++i) {
      const sim::Pose2 at = world_.robot(static_cast<sim::RobotId>(i)).pose_in_world;
      transforms_->set("map", world_.plan().robots[i].name, bus::planar(at.x, at.y, at.yaw));
    }
    transforms_->post();
  }
  return {};
}

Status Factory::judge(SimTime now) {
  const SimTime floor = world_.floor_time();
  if (!world_.halted()) maintenance_.judge(floor);
  if (robot_info_.due(now, std::exchange(published_duties_, maintenance_.changes()) != published_duties_))
    publish_robots();
  referee_.judge(floor, world_.changes(), context_.events);
  context_.clock = referee_.clock();
  context_.events.clear();
  pauses_.judge(now);

  if (order_info_.due(now, referee_.order_changes() != published_order_changes_)) publish_orders();
  published_order_changes_ = referee_.order_changes();
  const std::array points{referee_.score(Team::kCyan).published(), referee_.score(Team::kMagenta).published()};
  const bool changed =
      points != published_points_ || referee_.phase() != published_phase_ || state() != published_state_;
  if (game_state_.due(now, changed)) publish_game_state();
  published_points_ = points;
  published_phase_ = referee_.phase();
  published_state_ = state();
  return {};
}

Status Factory::act(SimTime) {
  const SimTime now = world_.floor_time();
  for (const sim::PieceId piece : referee_.take_confiscated())
    if (world_.find(piece)) world_.retire(piece, sim::Holder::kFloor);
  if (context_.clock.phase(now) != Phase::kSetup)
    for (const DownPeriodConfig& period : std::exchange(down_, {}))
      for (auto& machine : machines_)
        if (machine->name().substr(2) == period.machine)
          machine->add_down({context_.clock.at(period.begin_s), context_.clock.at(period.end_s)});
  if (!world_.halted()) faults_.strike(now);
  bus_.deliver(referee_node_);
  bus_.deliver(node_);
  if (!world_.halted()) {
    for (auto& channel : channels_) channel->act(now);
    for (auto& machine : machines_) machine->step(now, world_);
  }
  maintenance_.act(now);
  return {};
}

SimTime Factory::next_due() const {
  if (!context_.events.empty() || maintenance_.changes() != published_duties_) return world_.now();
  SimTime due = pauses_.next_due();
  if (foresight_) due = std::min(due, foresight_->next());
  for (const PeriodicTopic* topic : {&game_state_, &order_info_, &ring_info_, &robot_info_})
    due = std::min(due, topic->next());
  for (const auto& channel : channels_) due = std::min(due, channel->next_due());
  if (world_.halted()) return due;
  SimTime on_floor = std::min({referee_.next_due(), faults_.next_due(), maintenance_.next_due()});
  for (const auto& machine : machines_) on_floor = std::min(on_floor, machine->next_due());
  return std::min(due, world_.clock().when(on_floor));
}

// --- Controllers

std::string Factory::reset_machine(const std::string& name) {
  const SimTime now = world_.floor_time();
  Machine* machine = find_machine(machines_, name);
  if (machine == nullptr) return unknown_machine(machines_, name);
  if (machine->fail(now, world_, "reset by a controller")) return {};
  return name + " is " + std::string(to_string(machine->state())) + " in " +
         std::string(to_string(context_.clock.phase(now)));
}

std::string Factory::repair_machine(const std::string& name) {
  Machine* machine = find_machine(machines_, name);
  if (machine == nullptr) return unknown_machine(machines_, name);
  if (machine->repair(world_.floor_time())) return {};
  return name + " is " + std::string(to_string(machine->state())) + ", not BROKEN";
}

// --- Topics

void Factory::publish_game_state() {
  const SimTime now = world_.floor_time();
  bus::Message message = game_state_.message();
  message->set("game_time", context_.clock.game_time(now)).set("state", to_string(state()));
  message->set("phase", to_string(context_.clock.phase(now)));
  message->set("production_s", to_seconds(context_.clock.production_end - context_.clock.production_begin));
  message->set("points_cyan", referee_.score(Team::kCyan).published());
  message->set("points_magenta", referee_.score(Team::kMagenta).published());
  for (const auto& channel : channels_)
    message->set(channel->team() == Team::kCyan ? "team_cyan" : "team_magenta", to_string(channel->team()));
  message->set("field_height", kRows).set("field_width", kColumns).set("field_mirrored", true);
  game_state_.publish(bus_, std::move(message));
}

void Factory::publish_orders() {
  bus::Message message = order_info_.message();
  for (const OrderState& state : referee_.orders())
    if (state.released) put_order(message->append("orders"), state);
  order_info_.publish(bus_, std::move(message));
}

void Factory::publish_foresight() {
  bus::Message message = foresight_->message();
  for (const OrderState& state : referee_.orders())
    if (!state.order.overtime) put_order(message->append("orders"), state);
  for (const DownPeriodConfig& period : foreseen_down_)
    message->append("down").set("machine", period.machine).set("begin_s", period.begin_s).set("end_s", period.end_s);
  foresight_->publish(bus_, std::move(message));
}

void Factory::publish_rings() {
  bus::Message message = ring_info_.message();
  for (const RingColor color : kRingColors)
    message->append("rings").set("ring_color", to_string(color)).set("raw_material", referee_.schedule().price(color));
  ring_info_.publish(bus_, std::move(message));
}

void Factory::publish_robots() {
  bus::Message message = robot_info_.message();
  put_robots(message.view(), information_ == Information::kAll);
  robot_info_.publish(bus_, std::move(message));
}

void Factory::put_robots(const bus::MessageView& info, bool poses) const {
  for (const Maintenance::Robot& robot : maintenance_.robots()) {
    const bus::MessageView entry = info.append("robots");
    entry.set("name", world_.plan().robot(robot.id).name).set("team_color", to_string(robot.team));
    entry.set("number", robot.number).set("state", to_string(robot.duty));
    entry.set("maintenance_time_remaining", to_seconds(maintenance_.remaining(robot, world_.floor_time())));
    entry.set("maintenance_cycles", robot.cycles);
    if (poses) put_pose(entry, world_.robot(robot.id).pose_in_world);
  }
}

void Factory::put_machines(const bus::MessageView& info) const {
  for (const auto& machine : machines_)
    put_machine(info.append("machines"), *machine, world_, referee_.exploration(), Information::kAll);
}

}  // namespace cxlab::rcll
