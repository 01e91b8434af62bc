#include "scenarios/rcll/refbox/refbox_server.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <algorithm>
#include <limits>

#include "cx/base/number_text.h"
#include "scenarios/rcll/layout.h"
#include "scenarios/rcll/topic.h"

namespace cxlab::rcll {

namespace {

/// Ports of the referee box when all programs are on one machine.
struct Ports {
  int send = 0, receive = 0;
};
constexpr Ports kPublic{4444, 4445};
constexpr std::array<Ports, 2> kTeamPorts{{{4441, 4446}, {4442, 4447}}};
constexpr int kStreams = 4444;
constexpr Ports kRobots{2116, 2126};  // of the first robot; the next ones follow

constexpr SimTime kSecond = std::chrono::seconds(1);
constexpr SimTime kBeaconPeriod = kSecond, kGamePeriod = kSecond, kReportPeriod = kSecond;
constexpr SimTime kInfoPeriod = std::chrono::seconds(2);  // of orders, machines, rings
constexpr SimTime kRobotPeriod = std::chrono::milliseconds(2500);
constexpr SimTime kVersionPeriod = std::chrono::seconds(5);
constexpr SimTime kStreamPeriod = std::chrono::milliseconds(250);  // of machines and robots
constexpr SimTime kLost = std::chrono::seconds(5);                 // a robot without a beacon
constexpr SimTime kBurstPeriod = std::chrono::milliseconds(500);
constexpr int kOrderBurst = 10;     // OrderInfos after a new order
constexpr int kMachineBurst = 30;   // MachineInfos at the beginning
constexpr std::int64_t kStale = 5;  // s
constexpr std::size_t kMostComplaints = 100;
constexpr std::size_t kMostStreams = 32;
constexpr std::int64_t kMostRobots = 3;  // of a team

constexpr std::string_view kPackage = "llsf_msgs.";
constexpr const char* kVersion = CXLAB_VERSION;

std::string prefix_of(Team team, std::size_t teams) {
  return teams == 1 ? "" : team == Team::kCyan ? "/cyan" : "/magenta";
}

/// What the machine was told to do, while it does it.
void put_instruction(const Fields& entry, const Machine& machine) {
  if (!machine.job().open) return;
  const Instruction& told = machine.instruction();
  const std::string kind = entry.text("type");
  if (kind == "BS") entry.part("instruction_bs").set("side", told.side).set("color", told.base_color);
  if (kind == "CS") entry.part("instruction_cs").set("operation", told.operation);
  if (kind == "RS") entry.part("instruction_rs").set("ring_color", told.ring_color);
  if (kind == "DS") entry.part("instruction_ds").set("order_id", told.order_id);
  if (kind == "SS")
    entry.part("instruction_ss").set("operation", told.operation).set("shelf", told.shelf).set("slot", told.slot);
}

}  // namespace

bool RefboxServer::Rate::due(SimTime now) {
  if (now < next) return false;
  while (next <= now) next += period;
  return true;
}

// --- Making

RefboxServer::RefboxServer(const WorldConfig& config, const sim::World& world, Factory& factory,
                           const StageSetup& setup)
    : config_(config.refbox),
      world_(world),
      factory_(factory),
      bus_(setup.bus),
      network_(*setup.network),
      log_(setup.log),
      epoch_(setup.scenario.epoch),
      teams_(teams_of(config)),
      keep_(setup.keep),
      team_names_{std::string(to_string(Team::kCyan)), std::string(to_string(Team::kMagenta))} {
  bus::NodeName name;
  name.name = "refbox";
  node_ = bus_.join(bus::ParticipantKind::kNode, name, setup.sink.open_stream("node/refbox"));
  const std::array names{&config_.team_cyan, &config_.team_magenta};
  for (const Team team : kTeams)
    if (const auto i = static_cast<std::size_t>(team); !names[i]->empty()) {
      team_names_[i] = *names[i];
      named_[i] = true;
    }
}

Expected<std::unique_ptr<RefboxServer>> RefboxServer::make(const WorldConfig& config, const sim::World& world,
                                                           Factory& factory, const StageSetup& setup) {
  std::unique_ptr<RefboxServer> refbox(new RefboxServer(config, world, factory, setup));
  if (Status s = refbox->open_ports(); !s) return s.error();
  return refbox;
}

Status RefboxServer::open_ports() {
  auto host = net::Host::create(network_, node_, [this](const net::Event& event) { take(event); });
  if (!host) return host.error();
  host_ = *std::move(host);
  const auto port = [this](int number) { return static_cast<std::uint16_t>(number + config_.port_shift); };
  const auto channel = [&](std::string name, Ports ports, std::unique_ptr<pb::Crypto> crypto = nullptr) {
    return Channel(*host_, std::move(name), port(ports.send), port(ports.receive), std::move(crypto));
  };
  public_.emplace(channel("public channel", kPublic));
  for (const Team team : teams_) {
    const bool cyan = team == Team::kCyan;
    std::unique_ptr<pb::Crypto> crypto;
    if (const std::string& key = cyan ? config_.key_cyan : config_.key_magenta; !key.empty()) {
      const auto cipher = pb::cipher_of(config_.cipher);
      if (!cipher) return cipher.error();
      auto made = pb::Crypto::create(*cipher, key);
      if (!made) return made.error();
      crypto = *std::move(made);
    }
    sides_.push_back(
        std::make_unique<TeamSide>(team, channel("channel of " + std::string(to_string(team)),
                                                 kTeamPorts[static_cast<std::size_t>(team)], std::move(crypto))));
  }
  if (config_.controllers) server_ = host_->listen(port(kStreams));
  for (std::size_t i = 0; i < world_.plan().robots.size(); ++i) {
    const int shift = static_cast<int>(i);
    robot_channels_.emplace_back(
        i, channel("channel of " + world_.plan().robots[i].name, {kRobots.send + shift, kRobots.receive + shift}));
  }
  return {};
}

bool RefboxServer::is_heard() const {
  return public_->is_heard() || std::ranges::any_of(sides_, [](const auto& s) { return s->channel.is_heard(); }) ||
         std::ranges::any_of(robot_channels_, [](const auto& robot) { return robot.second.is_heard(); });
}

Status RefboxServer::begin() {
  auto types = load_types(keep_);
  if (!types) return types.error();
  types_ = *std::move(types);
  const auto hear = [this](const std::string& topic, const char* type, Heard& heard) -> Status {
    auto known = bus_.registry().message(std::string(kInterfaces) + "msg/" + type);
    if (!known) return known.error();
    auto made = bus_.subscribe(node_, topic, **known, [&heard](const bus::Delivery& d) { heard = {d.message, true}; });
    return made ? Status() : Status(made.error());
  };
  if (Status s = hear("/game_state", "GameState", game_state_); !s) return s;
  if (Status s = hear("/order_info", "OrderInfo", order_info_); !s) return s;
  if (Status s = hear("/ring_info", "RingInfo", ring_info_); !s) return s;
  for (const auto& [name, type] : {std::pair{"MachineInfo", &machine_type_}, {"RobotInfo", &robot_type_}}) {
    auto known = bus_.registry().message(std::string(kInterfaces) + "msg/" + name);
    if (!known) return known.error();
    *type = *known;
  }
  beacon_rate_ = {kBeaconPeriod, now_};
  game_rate_ = {kGamePeriod, now_};
  order_rate_ = {kInfoPeriod, now_};
  robot_rate_ = {kRobotPeriod, now_};
  version_rate_ = {kVersionPeriod, now_};
  for (auto& side : sides_) {
    const std::string prefix = prefix_of(side->team, sides_.size());
    if (Status s = hear(prefix + "/machine_info", "MachineInfo", side->machines); !s) return s;
    if (Status s = hear(prefix + "/machine_report_info", "MachineReportInfo", side->reports); !s) return s;
    if (Status s = begin(*side); !s) return s;
  }
  std::array<int, 2> numbers{};
  for (auto& [i, channel] : robot_channels_) {
    const sim::RobotStart& robot = world_.plan().robots[i];
    const Team team = team_of(robot);
    const auto of_team = static_cast<std::size_t>(team);
    robots_.push_back(std::make_unique<RobotPeer>(
        RobotPeer::Identity{robot.name, team, ++numbers[of_team], team_names_[of_team]}, std::move(channel), *types_,
        bus_, node_, [this, id = static_cast<sim::RobotId>(i)] { return world_.robot(id).pose_in_world; }));
    if (Status s = robots_.back()->open(); !s) return s;
  }
  robot_channels_.clear();
  return {};
}

Status RefboxServer::begin(TeamSide& side) {
  const std::string prefix = prefix_of(side.team, sides_.size());
  side.machine_rate = {kBurstPeriod, now_};
  side.ring_rate = {kInfoPeriod, now_};
  side.report_rate = {kReportPeriod, now_};
  auto action = bus_.registry().action(std::string(kInterfaces) + "action/InstructMachine");
  if (!action) return action.error();
  side.action = *action;
  auto client = bus_.create_action_client(node_, prefix + "/factory/instruct_machine", *side.action,
                                          {.goal_response = [](const bus::Delivery&) {},
                                           .feedback = [](const bus::Delivery&) {},
                                           .result = [this, &side](const bus::Delivery& d) { take_result(side, d); },
                                           .cancel_response = [](const bus::Delivery&) {}});
  if (!client) return client.error();
  side.instruct = *client;
  const auto advertise = [&](const char* topic, const char* type, bus::EndpointId& endpoint) -> Status {
    auto known = bus_.registry().message(std::string(kInterfaces) + "msg/" + type);
    if (!known) return known.error();
    auto made = bus_.advertise(node_, prefix + topic, **known);
    if (!made) return made.error();
    endpoint = *made;
    return {};
  };
  if (Status s = advertise("/machine_report", "MachineReport", side.report); !s) return s;
  return advertise("/set_robot_maintenance", "SetRobotMaintenance", side.maintenance);
}

// --- The tick

Status RefboxServer::sense(SimTime now) {
  now_ = now;
  if (!std::exchange(ports_shared_, true) && !network_.is_open()) {
    public_->share_port();
    for (auto& side : sides_) side->channel.share_port();
  }
  if (!types_ && status_ && is_heard()) status_ = begin();
  return status_;
}

Status RefboxServer::act(SimTime now) {
  now_ = now;
  bus_.deliver(node_);
  if (types_ && status_) speak();
  return status_;
}

SimTime RefboxServer::next_due() const {
  if (!types_) return is_heard() ? now_ : kNever;
  SimTime due = std::min({beacon_rate_.next, game_rate_.next, order_rate_.next, robot_rate_.next, version_rate_.next});
  for (const auto& side : sides_)
    due = std::min({due, side->machine_rate.next, side->ring_rate.next, side->report_rate.next});
  for (const auto& robot : robots_) due = std::min(due, robot->next_due());
  if (!streams_.empty()) due = std::min({due, stream_rate_.next, workpiece_rate_.next});
  return due;
}

// --- Taking

void RefboxServer::take(const net::Event& event) {
  if (!types_ && status_) status_ = begin();
  if (!status_) return;
  if (event.kind != net::EventKind::kDatagram) return take_stream(event);
  const std::string from = " (from " + std::string(event.host) + ':' + std::to_string(event.port) + ')';
  const auto read = [&](const Channel& channel) -> pb::MessagePtr {
    auto message = channel.read(*types_, event);
    if (!message) {
      complain(channel.name() + ": " + message.error().message + from);
      return nullptr;
    }
    return *std::move(message);
  };
  if (public_->owns(event.link)) {
    if (const auto message = read(*public_))
      take_public(Fields(*message), message->GetDescriptor()->full_name(), event);
    return;
  }
  for (auto& side : sides_)
    if (side->channel.owns(event.link)) {
      if (const auto message = read(side->channel))
        take_team(*side, Fields(*message), message->GetDescriptor()->full_name(), event);
      return;
    }
  for (auto& robot : robots_) {
    if (!robot->channel().owns(event.link)) continue;
    const auto message = read(robot->channel());
    if (!message) return;
    const std::string& type = message->GetDescriptor()->full_name();
    if (type != "llsf_msgs.AgentTask")
      return complain(robot->channel().name() + ": found a " + type + ", expected a llsf_msgs.AgentTask" + from);
    if (const std::string problem = robot->take(Fields(*message)); !problem.empty())
      complain(robot->channel().name() + ": " + problem + from);
    return;
  }
}

void RefboxServer::take_stream(const net::Event& event) {
  if (event.kind == net::EventKind::kAccepted) {
    if (streams_.size() >= kMostStreams) return host_->close(event.link);
    if (streams_.empty()) {
      stream_rate_ = {kStreamPeriod, now_};
      workpiece_rate_ = {kInfoPeriod, now_};
    }
    streams_[event.link];
    return;
  }
  const auto stream = streams_.find(event.link);
  if (stream == streams_.end()) return;
  if (event.kind == net::EventKind::kClosed) {
    streams_.erase(stream);
    return;
  }
  stream->second.add(event.bytes);
  while (true) {
    auto frame = stream->second.next();
    if (!frame) {
      complain("stream: " + frame.error().message);
      host_->close(event.link);
      streams_.erase(event.link);
      return;
    }
    if (!*frame) return;
    const auto message = types_->read(**frame);
    if (!message)
      complain("stream: " + message.error().message);
    else
      take_controller(Fields(**message), (*message)->GetDescriptor()->full_name());
  }
}

void RefboxServer::take_public(const Fields& message, const std::string& type, const net::Event& event) {
  if (type == "llsf_msgs.BeaconSignal") return take_beacon(message, event);
  complain("public channel: found a " + type + ", expected a llsf_msgs.BeaconSignal");
}

void RefboxServer::take_team(TeamSide& side, const Fields& message, const std::string& type, const net::Event& event) {
  const auto foreign = [&] {
    if (!message.has("team_color") || message.text("team_color") == to_string(side.team)) return false;
    complain(side.channel.name() + ": found a " + type + " of " + message.text("team_color"));
    return true;
  };
  if (foreign()) return;
  if (type == "llsf_msgs.BeaconSignal") return take_beacon(message, event);
  if (type == "llsf_msgs.PrepareMachine") return prepare(side, message);
  if (type == "llsf_msgs.ResetMachine") {
    bus::Message goal(*side.action->goal);
    goal->set("machine", message.text("machine")).set("operation", "RESET");
    return instruct(side, std::move(goal));
  }
  if (type == "llsf_msgs.MachineReport") return pass_on(message, "MachineReport", side.report);
  if (type == "llsf_msgs.SetRobotMaintenance") return pass_on(message, "SetRobotMaintenance", side.maintenance);
  complain(
      side.channel.name() + ": found a " + type +
      ", expected a PrepareMachine, ResetMachine, MachineReport, SetRobotMaintenance or BeaconSignal of llsf_msgs");
}

/// The name that a team says is its name, where the scenario gives it none.
void RefboxServer::take_beacon(const Fields& beacon, const net::Event& event) {
  const std::string name = beacon.text("team_name");
  std::optional<Team> team;
  if (beacon.has("team_color")) team = named<Team>(beacon.text("team_color"));
  for (const Team known : teams_)
    if (!team && team_names_[static_cast<std::size_t>(known)] == name) team = known;
  for (const Team open : teams_)
    if (!team && !named_[static_cast<std::size_t>(open)]) team = open;
  if (!team || !side_of(*team)) return;
  if (!name.empty() && !named_[static_cast<std::size_t>(*team)]) name_team(*team, name);
  const std::int64_t number = beacon.integer("number");
  if (number >= 1 && number <= kMostRobots)
    acquaintances_[{*team, number}] = {beacon.text("peer_name"), std::string(event.host), moment(), now_};
}

void RefboxServer::name_team(Team team, const std::string& name) {
  const auto i = static_cast<std::size_t>(team);
  team_names_[i] = name;
  named_[i] = true;
  for (std::size_t robot = 0; robot < robots_.size(); ++robot)
    if (team_of(world_.plan().robots[robot]) == team) robots_[robot]->rename_team(name);
}

void RefboxServer::take_controller(const Fields& message, const std::string& type) {
  if (type == "llsf_msgs.BeaconSignal") return;
  const std::string problem = control(message, std::string_view(type).substr(kPackage.size()));
  if (!problem.empty()) complain("stream: a " + type + " is refused: " + problem);
}

std::string RefboxServer::control(const Fields& message, std::string_view type) {
  if (type == "SetGameState") return factory_.request_state(message.text("state"), "a controller");
  if (type == "SetGamePhase") return set_phase(message.text("phase"));
  if (type == "SetMachineState") return set_machine(message.text("machine_name"), message.text("state"));
  if (type == "ConfirmDelivery")
    return factory_.confirm_delivery(message.integer("delivery_id"), message.integer("correct") != 0);
  if (type == "SetTeamName" || type == "SetRobotMaintenance") {
    const std::string team = message.has("team_color") ? message.text("team_color") : "no team";
    TeamSide* side = named<Team>(team) ? side_of(*named<Team>(team)) : nullptr;
    if (!side) return team + " does not play";
    if (type == "SetTeamName")
      name_team(side->team, message.text("team_name"));
    else
      pass_on(message, "SetRobotMaintenance", side->maintenance);
    return {};
  }
  constexpr std::pair<std::string_view, const char*> kMeaningless[]{
      {"RandomizeField", "the field is laid before the game, by seed and scenario"},
      {"MachineAddBase", "a payment is a base on the slide of the machine"},
      {"SetMachineLights", "the lights show what the machine does"},
      {"SetOrderDelivered", "a product counts that has come through a gate"},
      {"WorkpieceAddRing", "rings are mounted by machines"},
      {"SimTimeSync", "the game goes by the time of the run"}};
  for (const auto& [name, why] : kMeaningless)
    if (type == name) return why;
  return "expected a SetGameState, SetGamePhase, SetTeamName, SetRobotMaintenance, SetMachineState or ConfirmDelivery";
}

std::string RefboxServer::set_phase(const std::string& phase) {
  const auto known = named<Phase>(phase);
  return known ? factory_.set_phase(*known) : "found " + phase + ", expected SETUP, PRODUCTION or POST_GAME";
}

/// The other states are those of stand-ins for machines.
std::string RefboxServer::set_machine(const std::string& machine, const std::string& state) {
  if (state == "RESET") return factory_.reset_machine(machine);
  if (state == "IDLE") return factory_.repair_machine(machine);
  return "found " + state + ", expected RESET or IDLE";
}

void RefboxServer::take_result(TeamSide& side, const bus::Delivery& result) {
  const auto goal = side.instructed.extract(result.goal);
  if (goal.empty()) return;
  bus_.forget_goal(side.instruct, result.goal);
  if (goal.mapped().busy || !result.message || result.message->view().integer("error_code") == 0) return;
  const std::string text = goal.mapped().machine + ": " + result.message->view().text("error");
  complain(text);
  attention(text, side.team);
}

void RefboxServer::pass_on(const Fields& message, const char* type, bus::EndpointId topic) {
  auto known = bus_.registry().message(std::string(kInterfaces) + "msg/" + type);
  bus::Message out(**known);
  fill(out.view(), message.message());
  bus_.publish(topic, std::make_shared<const bus::Message>(std::move(out)));
}

bool RefboxServer::is_stale(TeamSide& side, const Fields& message) {
  if (!message.has("sent_at")) return false;
  // Only differences count: the team's clock need not be ours.
  const std::int64_t ahead = message.integer("sent_at") - moment().sec;
  side.clock_ahead = std::max(side.clock_ahead.value_or(ahead), ahead);
  return *side.clock_ahead - ahead > kStale;
}

void RefboxServer::prepare(TeamSide& side, const Fields& message) {
  if (is_stale(side, message))
    return complain(side.channel.name() + ": a PrepareMachine that was sent more than " + std::to_string(kStale) +
                    " s ago");
  bus::Message goal(*side.action->goal);
  goal->set("machine", message.text("machine"));
  // A delivery station without its instruction is asked for an order that there is not; others lack their fields.
  goal->set("order_id", std::int64_t{std::numeric_limits<std::uint32_t>::max()});
  const auto part = [&](const char* name) -> std::optional<Fields> {
    if (!message.has(name)) return std::nullopt;
    return message.part(name);
  };
  if (const auto bs = part("instruction_bs")) goal->set("side", bs->text("side")).set("base_color", bs->text("color"));
  if (const auto ds = part("instruction_ds")) goal->set("order_id", ds->integer("order_id"));
  if (const auto cs = part("instruction_cs")) goal->set("operation", cs->text("operation"));
  if (const auto rs = part("instruction_rs")) goal->set("ring_color", rs->text("ring_color"));
  if (const auto ss = part("instruction_ss")) {
    goal->set("operation", ss->text("operation")).set("shelf", ss->integer("shelf")).set("slot", ss->integer("slot"));
    goal->set("description", ss->text("wp_description"));
  }
  instruct(side, std::move(goal));
}

void RefboxServer::instruct(TeamSide& side, bus::Message goal) {
  Instructed instructed{goal->text("machine")};
  instructed.busy = std::ranges::any_of(side.instructed,
                                        [&](const auto& other) { return other.second.machine == instructed.machine; });
  if (side.machines.message) {
    const bus::MessageView known = side.machines.message->view();
    for (std::size_t i = 0; i < known.size("machines"); ++i)
      if (const bus::MessageView machine = known.nested("machines", i); machine.text("name") == instructed.machine)
        instructed.busy |= machine.text("state") != "IDLE";
  }
  const bus::GoalId id = bus_.send_goal(side.instruct, std::make_shared<const bus::Message>(std::move(goal)));
  side.instructed.emplace(id, std::move(instructed));
}

// --- Speaking

pb::MessagePtr RefboxServer::make(std::string_view type) const {
  return types_->make(std::string(kPackage) + std::string(type));
}

Moment RefboxServer::moment() const { return Moment::of(epoch_, now_); }

void RefboxServer::send_public(const google::protobuf::Message& message) {
  if (public_->is_heard()) public_->send(message);
  send_streams(message);
}

void RefboxServer::send_streams(const google::protobuf::Message& message) {
  if (streams_.empty()) return;
  const auto bytes = pb::Types::write(message);
  for (const auto& [link, reader] : streams_)
    if (bytes) host_->send(link, *bytes);
}

void RefboxServer::speak() {
  speak_public();
  for (auto& side : sides_) speak_team(*side);
  speak_streams();
  for (auto& robot : robots_) robot->speak(now_, moment());
}

void RefboxServer::speak_public() {
  if (beacon_rate_.due(now_)) {
    const auto message = make("BeaconSignal");
    Fields beacon(*message);
    beacon.set("time", moment()).set("seq", static_cast<std::int64_t>(++beacons_)).set("number", 0);
    beacon.set("team_name", "LLSF").set("peer_name", "RefBox");
    send_public(*message);
  }
  if (game_rate_.due(now_) && game_state_.message) send_public(*game_state());
  if (order_info_.fresh) {
    order_info_.fresh = false;
    const std::size_t count = order_info_.message->view().size("orders");
    if (count > order_count_) {
      order_burst_ = kOrderBurst;
      order_rate_ = {kBurstPeriod, now_};
    }
    order_count_ = count;
  }
  if (order_rate_.due(now_) && order_info_.message) {
    send_public(*orders());
    if (order_burst_ > 0 && --order_burst_ == 0) order_rate_ = {kInfoPeriod, now_ + kInfoPeriod};
  }
  if (robot_rate_.due(now_) && public_->is_heard()) public_->send(*robots(false));
  if (version_rate_.due(now_)) send_public(*version());
}

void RefboxServer::speak_team(TeamSide& side) {
  const bool heard = side.channel.is_heard();
  if (side.machines.message) {
    const bool due = side.machine_rate.due(now_), fresh = std::exchange(side.machines.fresh, false);
    if (heard && (due || fresh)) {
      const auto message = machines(side);
      const std::string bytes = message->SerializeAsString();
      if (due || bytes != side.machines_sent) {
        side.channel.send(*message);
        side.machines_sent = bytes;
        if (++side.machine_count == kMachineBurst) side.machine_rate = {kInfoPeriod, now_ + kInfoPeriod};
      }
    }
  } else {
    side.machine_rate.due(now_);
  }
  if (side.ring_rate.due(now_) && ring_info_.message) {
    const auto message = make("RingInfo");
    fill(*message, ring_info_.message->view(), moment());
    if (heard) side.channel.send(*message);
    if (&side == sides_.front().get()) send_streams(*message);
  }
  if (side.report_rate.due(now_) && std::exchange(side.reports.fresh, false)) {
    const auto message = make("MachineReportInfo");
    fill(*message, side.reports.message->view(), moment());
    if (heard) side.channel.send(*message);
    send_streams(*message);
  }
}

void RefboxServer::speak_streams() {
  if (streams_.empty()) return;
  if (stream_rate_.due(now_)) {
    send_streams(*all_machines());
    send_streams(*robots(true));
    look_after();
  }
  if (workpiece_rate_.due(now_)) send_streams(*workpieces());
}

void RefboxServer::attention(const std::string& text, Team team) {
  if (streams_.empty()) return;
  const auto message = make("AttentionMessage");
  Fields(*message).set("message", text).set("team_color", to_string(team));
  send_streams(*message);
}

void RefboxServer::look_after() {
  const auto look = [this](bool wanted, const std::string& text, Team team) {
    if (!wanted)
      attentions_.erase(text);
    else if (attentions_.insert(text).second)
      attention(text, team);
  };
  for (const auto& machine : factory_.machines())
    look(machine->may_be_stuck(world_.floor_time()),
         machine->name() + " is in the same state for 10 s, and breaks after 20 s", machine->team());
  for (const Maintenance::Robot& robot : factory_.maintenance().robots()) {
    const std::string name = "robot " + std::to_string(robot.number) + " of " + std::string(to_string(robot.team));
    const bool serviced = robot.duty == RobotDuty::kMaintenance;
    look(serviced && world_.floor_time() - robot.since >= kMaintenanceWarning,
         name + " has to be back from maintenance soon", robot.team);
    const auto met = acquaintances_.find({robot.team, robot.number});
    look(met != acquaintances_.end() && now_ - met->second.heard > kLost && robot.duty == RobotDuty::kActive,
         name + " is lost: no beacon for 5 s", robot.team);
  }
}

pb::MessagePtr RefboxServer::game_state() const {
  auto message = make("GameState");
  fill(*message, game_state_.message->view(), moment());
  Fields state(*message);
  for (const Team team : teams_)
    state.set(team == Team::kCyan ? "team_cyan" : "team_magenta", team_names_[static_cast<std::size_t>(team)]);
  return message;
}

pb::MessagePtr RefboxServer::orders() const {
  auto message = make("OrderInfo");
  fill(*message, order_info_.message->view(), moment());
  Fields info(*message);
  for (const GameReferee::Unconfirmed& delivery : factory_.referee().unconfirmed())
    for (int i = 0; i < info.size("orders"); ++i)
      if (Fields order = info.item("orders", i); order.integer("id") == delivery.event.order_id)
        order.append("unconfirmed_deliveries")
            .set("id", delivery.id)
            .set("team", to_string(delivery.team))
            .set("delivery_time", Moment::of(0, from_seconds(factory_.clock().game_time(delivery.event.at))));
  return message;
}

pb::MessagePtr RefboxServer::robots(bool poses) const {
  bus::Message told(*robot_type_);
  factory_.put_robots(told.view(), poses);
  auto message = make("RobotInfo");
  fill(*message, told.view(), moment());
  Fields info(*message);
  for (int i = 0; i < info.size("robots"); ++i) {
    Fields robot = info.item("robots", i);
    const auto team = named<Team>(robot.text("team_color")).value_or(Team::kCyan);
    if (!poses) robot.clear("pose");
    robot.set("team", team_names_[static_cast<std::size_t>(team)]);
    const auto known = acquaintances_.find({team, robot.integer("number")});
    const bool met = known != acquaintances_.end();
    if (met) robot.set("name", known->second.name);
    robot.set("host", met ? known->second.host : std::string(net::kLoopback));
    robot.set("last_seen", met ? known->second.seen : moment());
  }
  return message;
}

/// Those of the team, as the league tells it of them.
pb::MessagePtr RefboxServer::machines(const TeamSide& side) const {
  auto message = make("MachineInfo");
  Fields info(*message);
  info.set("team_color", to_string(side.team));
  const bus::MessageView heard = side.machines.message->view();
  for (std::size_t i = 0; i < heard.size("machines"); ++i) {
    const bus::MessageView machine = heard.nested("machines", i);
    if (machine.text("team_color") != to_string(side.team)) continue;
    Fields entry = info.append("machines");
    fill(entry.message(), machine, moment());
    entry.clear("lights").clear("pose").clear("loaded_with");
    if (!machine.integer("correctly_reported") || machine.text("zone").empty()) entry.clear("zone").clear("rotation");
  }
  return message;
}

pb::MessagePtr RefboxServer::all_machines() const {
  bus::Message told(*machine_type_);
  factory_.put_machines(told.view());
  auto message = make("MachineInfo");
  fill(*message, told.view(), moment());
  for (int i = 0; const auto& machine : factory_.machines())
    put_instruction(Fields(*message).item("machines", i++), *machine);
  return message;
}

/// Those that lie on the belts of machines.
pb::MessagePtr RefboxServer::workpieces() const {
  auto message = make("WorkpieceInfo");
  Fields info(*message);
  for (const sim::Piece& piece : world_.pieces()) {
    if (piece.holder != sim::Holder::kBelt) continue;
    const sim::Station& station = world_.plan().station(static_cast<sim::StationId>(piece.holder_index));
    Fields entry = info.append("workpieces");
    entry.set("id", static_cast<std::int64_t>(piece.id)).set("at_machine", station.name);
    entry.set("team_color", to_string(team_of(station)));
    entry.set("base_color", to_string(static_cast<BaseColor>(piece.stack.base)));
    for (const std::uint8_t ring : piece.stack.rings) entry.set("ring_colors", to_string(static_cast<RingColor>(ring)));
    entry.set("cap_color", to_string(static_cast<CapColor>(piece.stack.cap)));
  }
  return message;
}

pb::MessagePtr RefboxServer::version() const {
  auto message = make("VersionInfo");
  Fields info(*message);
  std::array<std::int64_t, 3> numbers{};
  std::string_view rest = kVersion;
  for (std::int64_t& number : numbers) {
    const std::size_t dot = std::min(rest.find('.'), rest.size());
    number = read_number<std::int64_t>(rest.substr(0, dot)).value_or(0);
    rest = rest.substr(std::min(dot + 1, rest.size()));
  }
  info.set("version_major", numbers[0]).set("version_minor", numbers[1]).set("version_micro", numbers[2]);
  info.set("version_string", "cxlab " + std::string(kVersion));
  const auto value = [&](const char* name, const char* type) {
    Fields entry = info.append("configuration");
    return entry.set("name", name).set("type", type);
  };
  value("field_width", "INTEGER").set("integer_value", kColumns);
  value("field_height", "INTEGER").set("integer_value", kRows);
  value("field_mirrored", "BOOLEAN").set("boolean_value", true);
  return message;
}

void RefboxServer::complain(const std::string& text) {
  if (!log_ || complaints_.size() >= kMostComplaints || !complaints_.insert(text).second) return;
  log_->line({bus_.now(), cx::LogLevel::kWarn, "refbox", text, {}});
  if (complaints_.size() == kMostComplaints)
    log_->line({bus_.now(), cx::LogLevel::kWarn, "refbox", "what else it cannot read is not reported", {}});
}

RefboxServer::TeamSide* RefboxServer::side_of(Team team) {
  const auto found = std::ranges::find(sides_, team, [](const auto& side) { return side->team; });
  return found == sides_.end() ? nullptr : found->get();
}

}  // namespace cxlab::rcll
