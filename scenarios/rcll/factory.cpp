#include "scenarios/rcll/factory.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "scenarios/rcll/layout.h"

namespace cxlab::rcll {

template <>
inline constexpr std::array<std::string_view, 3> kNames<sim::Light>{"OFF", "ON", "BLINK"};

namespace {

constexpr std::string_view kPackage = "rcll_interfaces/";
constexpr SimTime kGameStatePeriod = std::chrono::seconds(1);
constexpr SimTime kInfoPeriod = std::chrono::seconds(2);
constexpr SimTime kRobotInfoPeriod = std::chrono::milliseconds(2500);

Zone zone_at(const sim::Pose2& pose) {
  return {pose.x > 0 ? Team::kCyan : Team::kMagenta, static_cast<int>(std::abs(pose.x)) + 1,
          static_cast<int>(pose.y) + 1};
}

int degrees_of(double yaw) { return static_cast<int>(std::lround(yaw * 180 / std::numbers::pi) + 360) % 360; }

void put_pose(const bus::MessageView& message, const sim::Pose2& pose) {
  message.nested("pose").set("x", pose.x).set("y", pose.y).set("theta", pose.yaw);
}

void put_texts(const bus::MessageView& message, std::string_view field, const std::vector<std::string_view>& texts) {
  const bus::Field& list = *message.type().find(field);
  Status done = message.resize(list, texts.size());
  for (std::size_t i = 0; i < texts.size() && done; ++i) done = message.set_text(list, texts[i], i);
}

void put_light(const bus::MessageView& machine, std::string_view color, sim::Light light) {
  machine.append("lights").set("color", color).set("state", to_string(light));
}

bus::SharedMessage shared(bus::Message message) { return std::make_shared<const bus::Message>(std::move(message)); }

/// Those of overtime too, where there is one.
Schedule all_orders(const Game& game) {
  Schedule schedule = game.schedule;
  if (game.overtime) schedule.orders.push_back(*game.overtime);
  return schedule;
}

}  // namespace

Expected<std::unique_ptr<Factory>> Factory::make(const WorldConfig& config, const Game& game, std::uint64_t seed,
                                                 sim::World& world, bus::Bus& bus, RecordSink& sink,
                                                 std::span<const sim::Fault> faults) {
  std::unique_ptr<Factory> factory(new Factory(config, game, seed, world, bus, sink));
  if (Status s = factory->take_faults(faults, seed); !s) return s.error();
  if (Status s = factory->join(); !s) return s.error();
  if (config.transforms)
    if (Status s = factory->broadcast_transforms(); !s) return s.error();
  return factory;
}

Factory::Factory(const WorldConfig& config, const Game& game, std::uint64_t seed, sim::World& world, bus::Bus& bus,
                 RecordSink& sink)
    : team_(*named<Team>(config.team)),
      world_(world),
      bus_(bus),
      sink_(sink),
      context_{GameClock::of(config.setup_s, config.production_s, config.overtime_s),
               choices_of(*named<Rules>(config.rules)),
               from_seconds(config.shelf_refill_s),
               nullptr,
               seed,
               {}},
      referee_(context_.clock, context_.rules, all_orders(game), world.plan(), sink) {
  context_.schedule = &referee_.schedule();
  machines_ = make_machines(world.plan(), context_);
  for (const DownPeriodConfig& period : game.down)
    for (auto& machine : machines_)
      if (machine->name().substr(2) == period.machine)
        machine->add_down({context_.clock.at(period.begin_s), context_.clock.at(period.end_s)});
}

Status Factory::join() {
  const std::string package(kPackage);
  auto action = bus_.registry().action(package + "action/InstructMachine");
  if (!action) return action.error();
  action_ = *action;
  bus::NodeName name;
  name.name = "factory";
  node_ = bus_.join(bus::ParticipantKind::kNode, name, sink_.open_stream("node/factory"));
  auto server =
      bus_.serve_action(node_, "/factory/instruct_machine", *action_,
                        {[this](const bus::Delivery& d) { start(d); }, [this](const bus::Delivery& d) { cancel(d); }});
  if (!server) return server.error();
  server_ = *server;
  if (Status s = advertise(game_state_, "/game_state", package + "msg/GameState", kGameStatePeriod); !s) return s;
  if (Status s = advertise(order_info_, "/order_info", package + "msg/OrderInfo", kInfoPeriod); !s) return s;
  if (Status s = advertise(machine_info_, "/machine_info", package + "msg/MachineInfo", kInfoPeriod); !s) return s;
  if (Status s = advertise(ring_info_, "/ring_info", package + "msg/RingInfo", kInfoPeriod); !s) return s;
  return advertise(robot_info_, "/robot_info", package + "msg/RobotInfo", kRobotInfoPeriod);
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

Status Factory::advertise(Topic& topic, std::string_view name, const std::string& type, SimTime period) {
  auto message = bus_.registry().message(type);
  if (!message) return message.error();
  topic.type = *message;
  topic.period = period;
  auto endpoint = bus_.advertise(node_, name, *topic.type);
  if (!endpoint) return endpoint.error();
  topic.endpoint = *endpoint;
  return {};
}

bool Factory::due(Topic& topic, SimTime now, bool changed) {
  const bool periodic = now >= topic.next;
  while (topic.next <= now) topic.next += topic.period;
  return periodic || changed;
}

// --- The tick

Status Factory::sense(SimTime now) {
  for (Goal& goal : goals_) report(goal);
  std::erase_if(goals_, [](const Goal& goal) { return goal.machine == nullptr; });
  if (due(machine_info_, now, !context_.events.empty())) publish_machines();
  if (due(ring_info_, now, false)) publish_rings();
  if (due(robot_info_, now, false)) publish_robots();
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
  referee_.judge(now, world_.changes(), context_.events);
  context_.clock = referee_.clock();
  context_.events.clear();

  if (due(order_info_, now, referee_.order_changes() != published_order_changes_)) publish_orders();
  published_order_changes_ = referee_.order_changes();
  const std::array points{referee_.score(Team::kCyan).total(), referee_.score(Team::kMagenta).total()};
  if (due(game_state_, now, points != published_points_ || referee_.phase() != published_phase_))
    publish_game_state(now);
  published_points_ = points;
  published_phase_ = referee_.phase();
  return {};
}

Status Factory::act(SimTime now) {
  for (const sim::PieceId piece : referee_.take_confiscated())
    if (world_.find(piece)) world_.retire(piece, sim::Holder::kFloor);
  strike_faults(now);
  bus_.deliver(node_);
  for (auto& machine : machines_) machine->step(now, world_);
  return {};
}

SimTime Factory::next_due() const {
  if (!context_.events.empty()) return context_.events.back().at;
  SimTime due = referee_.next_due();
  for (const Topic* topic : {&game_state_, &order_info_, &machine_info_, &ring_info_, &robot_info_})
    due = std::min(due, topic->next);
  for (const auto& machine : machines_) due = std::min(due, machine->next_due());
  for (const auto& [timer, machine] : faults_) due = std::min(due, timer.due());
  return due;
}

// --- Faults

Status Factory::take_faults(std::span<const sim::Fault> faults, std::uint64_t seed) {
  for (const sim::Fault& fault : faults) {
    if (fault.machine.empty()) continue;
    Machine* machine = find(fault.machine);
    if (machine == nullptr) return input_error("machine: " + unknown(fault.machine), fault.origin);
    faults_.emplace_back(sim::FaultTimer(fault, seed, fault.machine), machine);
  }
  return {};
}

void Factory::strike_faults(SimTime now) {
  for (auto& [timer, machine] : faults_) {
    if (now < timer.due()) continue;
    const sim::Fault& fault = timer.fault();
    timer.struck(now);
    const bool down = fault.kind == sim::FaultKind::kMachineDown;
    if (down) machine->add_down({now, now + fault.duration});
    const bool acted = down || machine->fail(now, world_, "a fault of the scenario");
    RecordData data;
    data.begin()
        .field("fault", sim::to_string(fault.kind))
        .field("number", static_cast<std::int64_t>(fault.number))
        .field("machine", fault.machine)
        .field("acted", acted);
    sink_.write(sink_.open_stream("faults"), now, RecordKind::kControl, data);
  }
}

// --- Goals

Machine* Factory::find(std::string_view name) const {
  const auto at = std::ranges::find_if(machines_, [&](const auto& machine) { return machine->name() == name; });
  return at == machines_.end() ? nullptr : at->get();
}

std::string Factory::unknown(const std::string& name) const {
  std::vector<std::string> names;
  for (const auto& machine : machines_) names.push_back(machine->name());
  return "no machine '" + name + "'" + did_you_mean(name, names);
}

void Factory::start(const bus::Delivery& delivery) {
  bus_.answer_goal(server_, delivery.goal, bus::GoalAnswer::kAccept);
  const bus::MessageView goal = delivery.message->view();
  const std::string& name = goal.text("machine");
  Machine* machine = find(name);
  if (machine == nullptr) return finish(delivery.goal, InstructError::kNoMachine, unknown(name), name);
  if (machine->team() != team_)
    return finish(delivery.goal, InstructError::kWrongTeam,
                  name + " belongs to " + std::string(to_string(machine->team())), name);

  const Instruction instruction{goal.text("operation"),
                                goal.text("side"),
                                goal.text("base_color"),
                                goal.text("ring_color"),
                                static_cast<int>(goal.integer("order_id")),
                                static_cast<int>(goal.integer("shelf")),
                                static_cast<int>(goal.integer("slot")),
                                std::string(goal.text("description"))};
  const Machine::Answer answer = machine->instruct(instruction, bus_.now(), world_);
  if (answer.error != InstructError::kNone || answer.done)
    return finish(delivery.goal, answer.error, answer.text, name);
  goals_.push_back({delivery.goal, machine, machine->job().number, MachineState::kIdle});
}

void Factory::cancel(const bus::Delivery& delivery) {
  // The machine works on; only the waiting ends.
  bus_.answer_cancel(server_, delivery, true);
  bus::Message result(*action_->result);
  result->set("error", "canceled");
  bus_.finish(server_, delivery.goal, bus::GoalStatus::kCanceled, shared(std::move(result)));
  std::erase_if(goals_, [&](const Goal& goal) { return goal.id == delivery.goal; });
}

void Factory::report(Goal& goal) {
  if (goal.machine->state() != goal.reported) {
    goal.reported = goal.machine->state();
    bus::Message feedback(*action_->feedback);
    feedback->set("state", to_string(goal.reported));
    bus_.publish_feedback(server_, goal.id, shared(std::move(feedback)));
  }
  const Job& job = goal.machine->job();
  if (job.number == goal.job && job.open) return;
  finish(goal.id, job.error, job.text, goal.machine->name());
  goal.machine = nullptr;
}

void Factory::finish(const bus::GoalId& goal, InstructError error, const std::string& text,
                     const std::string& machine) {
  bus::Message result(*action_->result);
  const bool success = error == InstructError::kNone;
  result->set("success", success).set("error_code", static_cast<int>(error)).set("error", text).set("target", machine);
  bus_.finish(server_, goal, success ? bus::GoalStatus::kSucceeded : bus::GoalStatus::kAborted,
              shared(std::move(result)));
}

// --- Topics

void Factory::publish_game_state(SimTime now) {
  bus::Message message(*game_state_.type);
  message->set("game_time", context_.clock.game_time(now)).set("state", "RUNNING");
  message->set("phase", to_string(context_.clock.phase(now)));
  message->set("points_cyan", referee_.score(Team::kCyan).total());
  message->set("points_magenta", referee_.score(Team::kMagenta).total());
  message->set(team_ == Team::kCyan ? "team_cyan" : "team_magenta", to_string(team_));
  message->set("field_height", kRows).set("field_width", kColumns).set("field_mirrored", true);
  bus_.publish(game_state_.endpoint, shared(std::move(message)));
}

void Factory::publish_orders() {
  bus::Message message(*order_info_.type);
  for (const OrderState& state : referee_.orders()) {
    if (!state.released) continue;
    const Order& order = state.order;
    const bus::MessageView entry = message->append("orders");
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
  bus_.publish(order_info_.endpoint, shared(std::move(message)));
}

void Factory::publish_machines() {
  bus::Message message(*machine_info_.type);
  message->set("team_color", to_string(team_));
  for (const auto& machine : machines_) {
    const sim::Station& station = world_.plan().station(machine->id());
    const bus::MessageView entry = message->append("machines");
    entry.set("name", station.name).set("type", station.kind).set("state", to_string(machine->state()));
    entry.set("team_color", to_string(machine->team()));
    const sim::Lights lights = world_.lights(machine->id());
    put_light(entry, "RED", lights.red);
    put_light(entry, "YELLOW", lights.yellow);
    put_light(entry, "GREEN", lights.green);
    put_pose(entry, station.pose_in_world);
    entry.set("zone", to_string(zone_at(station.pose_in_world))).set("rotation", degrees_of(station.pose_in_world.yaw));
    entry.set("correctly_reported", true).set("loaded_with", machine->loaded_with());
    const std::string_view type = std::string_view(station.name).substr(2);
    if (station.kind == "CS") entry.set("cap_color", to_string(shelf_cap(type)));
    if (station.kind == "RS")
      put_texts(entry, "ring_colors", {to_string(rings_of(type)[0]), to_string(rings_of(type)[1])});
  }
  bus_.publish(machine_info_.endpoint, shared(std::move(message)));
}

void Factory::publish_rings() {
  bus::Message message(*ring_info_.type);
  for (const RingColor color : kRingColors)
    message->append("rings").set("ring_color", to_string(color)).set("raw_material", referee_.schedule().price(color));
  bus_.publish(ring_info_.endpoint, shared(std::move(message)));
}

void Factory::publish_robots() {
  bus::Message message(*robot_info_.type);
  for (std::size_t i = 0; i < world_.plan().robots.size(); ++i) {
    const bus::MessageView entry = message->append("robots");
    entry.set("name", world_.plan().robots[i].name).set("team_color", to_string(team_));
    entry.set("number", static_cast<std::int64_t>(i) + 1).set("state", "ACTIVE");
    put_pose(entry, world_.robot(static_cast<sim::RobotId>(i)).pose_in_world);
  }
  bus_.publish(robot_info_.endpoint, shared(std::move(message)));
}

}  // namespace cxlab::rcll
