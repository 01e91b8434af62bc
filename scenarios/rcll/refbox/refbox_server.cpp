#include "scenarios/rcll/refbox/refbox_server.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <algorithm>
#include <array>
#include <utility>

#include "cx/base/number_text.h"
#include "scenarios/rcll/rules/layout.h"

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

constexpr SimTime kBeaconPeriod = std::chrono::seconds(1), kGamePeriod = std::chrono::seconds(1);
constexpr SimTime kRobotPeriod = std::chrono::milliseconds(2500);
constexpr SimTime kVersionPeriod = std::chrono::seconds(5);
constexpr SimTime kNobodyComes = std::chrono::seconds(60);
constexpr int kOrderBurst = 10;  // OrderInfos after a new order
constexpr const char* kVersion = CXLAB_VERSION;

}  // namespace

// --- Making

RefboxServer::RefboxServer(const WorldConfig& config, const sim::World& world, Factory& factory,
                           const StageSetup& setup)
    : config_(config.refbox),
      network_(*setup.network),
      keep_(setup.keep),
      context_{.world = world,
               .factory = factory,
               .bus = setup.bus,
               .log = setup.log,
               .epoch = setup.scenario.epoch,
               .teams = teams_of(config)} {
  bus::NodeName name;
  name.name = "refbox";
  context_.node = context_.bus.join(bus::ParticipantKind::kNode, name, setup.sink.open_stream("node/refbox"));
  if (!config_.team_cyan.empty()) context_.team_names[0] = config_.team_cyan;
  if (!config_.team_magenta.empty()) context_.team_names[1] = config_.team_magenta;
}

Expected<std::unique_ptr<RefboxServer>> RefboxServer::make(const WorldConfig& config, const sim::World& world,
                                                           Factory& factory, const StageSetup& setup) {
  std::unique_ptr<RefboxServer> refbox(new RefboxServer(config, world, factory, setup));
  if (Status s = refbox->open_ports(); !s) return s.error();
  return refbox;
}

Status RefboxServer::open_ports() {
  auto host = net::Host::create(network_, context_.node, [this](const net::Event& event) { take(event); });
  if (!host) return host.error();
  host_ = *std::move(host);
  controllers_.emplace(context_, *host_);
  const auto port = [this](int number) { return static_cast<std::uint16_t>(number + config_.port_shift); };
  const auto channel = [&](std::string name, Ports ports, std::unique_ptr<pb::Crypto> crypto = nullptr) {
    return Channel(*host_, std::move(name), port(ports.send), port(ports.receive), std::move(crypto));
  };
  public_.emplace(channel("public channel", kPublic));
  for (const Team team : context_.teams) {
    const bool cyan = team == Team::kCyan;
    std::unique_ptr<pb::Crypto> crypto;
    if (const std::string& key = cyan ? config_.key_cyan : config_.key_magenta; !key.empty()) {
      const auto cipher = pb::cipher_of(config_.cipher);
      if (!cipher) return cipher.error();
      auto made = pb::Crypto::create(*cipher, key);
      if (!made) return made.error();
      crypto = *std::move(made);
    }
    teams_.push_back(
        std::make_unique<TeamPeer>(context_, *controllers_, team,
                                   channel("channel of " + std::string(to_string(team)),
                                           kTeamPorts[static_cast<std::size_t>(team)], std::move(crypto))));
  }
  if (config_.controllers) host_->listen(port(kStreams));
  std::array<int, 2> numbers{};
  for (int shift = 0; const sim::RobotStart& robot : context_.world.plan().robots) {
    const Team team = team_of(robot);
    robots_.push_back(std::make_unique<RobotPeer>(
        context_,
        RobotPeer::Identity{static_cast<sim::RobotId>(shift), robot.name, team,
                            ++numbers[static_cast<std::size_t>(team)]},
        channel("channel of " + robot.name, {kRobots.send + shift, kRobots.receive + shift})));
    ++shift;
  }
  return {};
}

bool RefboxServer::is_heard() const {
  const auto heard = [](const auto& peer) { return peer->channel().is_heard(); };
  return public_->is_heard() || std::ranges::any_of(teams_, heard) || std::ranges::any_of(robots_, heard);
}

Status RefboxServer::begin() {
  auto types = load_types(keep_);
  if (!types) return types.error();
  context_.types = *std::move(types);
  if (Status s = context_.hear("/game_state", "GameState", game_state_); !s) return s;
  if (Status s = context_.hear("/order_info", "OrderInfo", order_info_); !s) return s;
  if (Status s = context_.hear("/ring_info", "RingInfo", ring_info_); !s) return s;
  begun_ = context_.now;
  beacon_rate_ = {kBeaconPeriod, context_.now};
  game_rate_ = {kGamePeriod, context_.now};
  order_rate_ = {kInfoPeriod, context_.now};
  robot_rate_ = {kRobotPeriod, context_.now};
  version_rate_ = {kVersionPeriod, context_.now};
  for (auto& team : teams_)
    if (Status s = team->open(); !s) return s;
  for (auto& robot : robots_)
    if (Status s = robot->open(); !s) return s;
  return {};
}

// --- The tick

Status RefboxServer::sense(SimTime now) {
  context_.now = now;
  if (!std::exchange(ports_shared_, true) && !network_.is_open()) {
    public_->share_port();
    for (auto& team : teams_) team->channel().share_port();
  }
  if (!context_.types && status_ && is_heard()) status_ = begin();
  return status_;
}

Status RefboxServer::act(SimTime now) {
  context_.now = now;
  context_.bus.deliver(context_.node);
  if (context_.types && status_) speak();
  return status_;
}

SimTime RefboxServer::next_due() const {
  if (!context_.types) return is_heard() ? context_.now : kNever;
  SimTime due = std::min({beacon_rate_.next, game_rate_.next, order_rate_.next, robot_rate_.next, version_rate_.next,
                          controllers_->next_due()});
  for (const auto& team : teams_) due = std::min(due, team->next_due());
  for (const auto& robot : robots_) due = std::min(due, robot->next_due());
  return due;
}

void RefboxServer::take(const net::Event& event) {
  if (!context_.types && status_) status_ = begin();
  if (!status_) return;
  if (event.kind != net::EventKind::kDatagram) return controllers_->take(event);
  const std::string from = " (from " + std::string(event.host) + ':' + std::to_string(event.port) + ')';
  const auto read = [&](const Channel& channel) -> pb::MessagePtr {
    auto message = channel.read(*context_.types, event);
    if (message) return *std::move(message);
    context_.complain(channel.name() + ": " + message.error().message + from);
    return nullptr;
  };
  if (public_->owns(event.link)) {
    const auto message = read(*public_);
    if (!message) return;
    const std::string& type = message->GetDescriptor()->full_name();
    if (type == "llsf_msgs.BeaconSignal") return context_.meet(Fields(*message), event.host);
    return context_.complain("public channel: " + found_expected("a " + type, "a llsf_msgs.BeaconSignal"));
  }
  for (auto& team : teams_)
    if (team->channel().owns(event.link)) {
      if (const auto message = read(team->channel()); message && (somebody_came_ = true))
        team->take(Fields(*message), message->GetDescriptor()->full_name(), event.host);
      return;
    }
  for (auto& robot : robots_) {
    if (!robot->channel().owns(event.link)) continue;
    const auto message = read(robot->channel());
    if (!message) return;
    somebody_came_ = true;
    const std::string& type = message->GetDescriptor()->full_name();
    if (type != "llsf_msgs.AgentTask")
      return context_.complain(robot->channel().name() + ": " +
                               found_expected("a " + type, "a llsf_msgs.AgentTask" + from));
    if (const std::string problem = robot->take(Fields(*message)); !problem.empty())
      context_.complain(robot->channel().name() + ": " + problem + from);
    return;
  }
}

// --- What all hear

/// An agent that sends no beacon looks for its team's name in GameState, and waits for it.
void RefboxServer::tell_that_nobody_came() {
  if (somebody_came_ || context_.now < begun_ + kNobodyComes) return;
  somebody_came_ = true;  // said once
  const auto told = [](const auto& name) { return name.has_value(); };
  if (std::ranges::any_of(context_.team_names, told)) return;
  std::string names, settings;
  for (const Team team : context_.teams) {
    const bool cyan = team == Team::kCyan;
    names += (names.empty() ? "" : " and ") + context_.team_name(team);
    settings += std::string(settings.empty() ? "" : ", ") + (cyan ? "refbox.team_cyan" : "refbox.team_magenta");
  }
  context_.complain(
      "nobody has taken the field for 60 s: no beacon, task or instruction of a team has come, and GameState "
      "calls the teams " +
      names + ". An agent without beacons waits for its own name there: set " + settings +
      " (--param rcll.refbox.team_cyan=NAME of cxlab env)");
}

void RefboxServer::speak() {
  tell_that_nobody_came();
  speak_public();
  for (auto& team : teams_) team->speak(ring_info_.message);
  controllers_->speak();
  for (auto& robot : robots_) robot->speak();
}

void RefboxServer::send_public(const google::protobuf::Message& message) {
  if (public_->is_heard()) public_->send(message);
  controllers_->send(message);
}

void RefboxServer::speak_public() {
  const SimTime now = context_.now;
  if (beacon_rate_.due(now)) {
    const auto message = context_.make("BeaconSignal");
    Fields beacon(*message);
    beacon.set("time", context_.moment()).set("seq", static_cast<std::int64_t>(++beacons_)).set("number", 0);
    beacon.set("team_name", "LLSF").set("peer_name", "RefBox");
    send_public(*message);
  }
  if (game_rate_.due(now) && game_state_.message) send_public(*game_state());
  if (order_info_.fresh) {
    order_info_.fresh = false;
    const std::size_t count = order_info_.message->view().size("orders");
    if (count > order_count_) {
      order_burst_ = kOrderBurst;
      order_rate_ = {kBurstPeriod, now};
    }
    order_count_ = count;
  }
  if (order_rate_.due(now) && order_info_.message) {
    send_public(*orders());
    if (order_burst_ > 0 && --order_burst_ == 0) order_rate_ = {kInfoPeriod, now + kInfoPeriod};
  }
  if (robot_rate_.due(now) && public_->is_heard()) public_->send(*context_.robots(false));
  if (version_rate_.due(now)) send_public(*version());
}

pb::MessagePtr RefboxServer::game_state() const {
  auto message = context_.make("GameState", game_state_.message->view());
  for (const Team team : context_.teams)
    Fields(*message).set(team == Team::kCyan ? "team_cyan" : "team_magenta", context_.team_name(team));
  return message;
}

pb::MessagePtr RefboxServer::orders() const {
  auto message = context_.make("OrderInfo", order_info_.message->view());
  const Fields info(*message);
  const Factory& factory = context_.factory;
  for (const GameReferee::Unconfirmed& delivery : factory.referee().unconfirmed())
    for (int i = 0; i < info.size("orders"); ++i)
      if (Fields order = info.item("orders", i); order.integer("id") == delivery.event.order_id)
        order.append("unconfirmed_deliveries")
            .set("id", delivery.id)
            .set("team", to_string(delivery.team))
            .set("delivery_time", Moment::of(0, from_seconds(factory.clock().game_time(delivery.event.at))));
  return message;
}

pb::MessagePtr RefboxServer::version() const {
  auto message = context_.make("VersionInfo");
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

}  // namespace cxlab::rcll
