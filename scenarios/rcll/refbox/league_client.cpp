#include "scenarios/rcll/refbox/league_client.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include "scenarios/rcll/refbox/node.h"

namespace cxlab::rcll {

namespace {

constexpr SimTime kPeriod = std::chrono::seconds(1);  // messages without an answer are sent again

Status add_client(const ServerSpec& spec, const StageSetup& setup, Stage& stage) {
  auto client = LeagueClient::make(spec.get<LeagueClientConfig>(), setup);
  if (!client) return client.error();
  stage.servers.push_back(*std::move(client));
  return {};
}

}  // namespace

constinit const NodeKind kLeagueClient{
    .name = "league_client",
    .what =
        "an outside referee box and its robots, for agents that know topics and actions "
        "(docs/reference/rcll-protocol.md)",
    .settings = settings_of<LeagueClientConfig>(),
    .add = add_client,
};

Expected<std::unique_ptr<LeagueClient>> LeagueClient::make(const LeagueClientConfig& config, const StageSetup& setup) {
  if (Status s = check(config); !s) return s.error();
  std::unique_ptr<LeagueClient> client(new LeagueClient(setup.log));
  if (Status s = client->open(config, setup); !s) return s.error();
  return client;
}

Status LeagueClient::open(const LeagueClientConfig& config, const StageSetup& setup) {
  auto link = LeagueLink::open(config, setup, [this](const net::Event& event) { take(event); });
  if (!link) return link.error();
  link_ = *std::move(link);
  auto topics = LeagueTopics::open(*link_);
  if (!topics) return topics.error();
  topics_ = *std::move(topics);
  auto instructions = LeagueInstructions::open(*link_);
  if (!instructions) return instructions.error();
  instructions_ = *std::move(instructions);
  for (int number = 1; number <= config.robots; ++number) {
    auto robot = LeagueRobot::open(*link_, number);
    if (!robot) return robot.error();
    robots_.push_back(*std::move(robot));
  }
  return {};
}

Status LeagueClient::act(SimTime now) {
  link_->now = now;
  link_->bus.deliver(link_->node);
  if (now < next_) return {};
  while (next_ <= now) next_ += kPeriod;
  say_where_robots_are();
  instructions_->repeat();
  for (const auto& robot : robots_) robot->repeat();
  instructions_->follow();
  return {};
}

void LeagueClient::say_where_robots_are() {
  for (const auto& robot : robots_) {
    const auto message = link_->make("llsf_msgs.BeaconSignal");
    Fields beacon(*message);
    beacon.set("time", link_->moment()).set("seq", static_cast<std::int64_t>(++beacons_));
    beacon.set("number", robot->number()).set("team_name", link_->config.team_name);
    beacon.set("peer_name", "robot" + std::to_string(robot->number())).set("team_color", link_->config.team);
    if (robot->beacon() && Fields(*robot->beacon()).has("pose"))
      beacon.part("pose").message().CopyFrom(Fields(*robot->beacon()).part("pose").message());
    link_->everybody().send(*message);
  }
}

void LeagueClient::take(const net::Event& event) {
  if (event.kind != net::EventKind::kDatagram) return;
  const auto read = [&](const Channel& channel) -> pb::MessagePtr {
    auto message = channel.read(link_->types(), event);
    if (message) return *std::move(message);
    complain(channel.name() + ": " + message.error().message);
    return nullptr;
  };
  for (const Channel* channel : {&link_->everybody(), &link_->team()})
    if (channel->owns(event.link)) {
      if (const auto message = read(*channel)) take_refbox(*message);
      return;
    }
  for (auto& robot : robots_)
    if (robot->channel().owns(event.link)) {
      if (auto message = read(robot->channel())) robot->take(*message);
      return;
    }
}

void LeagueClient::take_refbox(google::protobuf::Message& message) {
  topics_->take(message);
  if (message.GetDescriptor()->name() == "MachineInfo") instructions_->take_machines(message);
}

void LeagueClient::complain(const std::string& text) {
  if (log_ && text != complaint_) log_->line({link_->bus.now(), cx::LogLevel::kWarn, "league_client", text, {}});
  complaint_ = text;
}

}  // namespace cxlab::rcll
