#include "scenarios/rcll/refbox/refbox_context.h"

#include <google/protobuf/message.h>

#include <algorithm>

#include "cx/bus/needed.h"
#include "cx/network/host.h"
#include "scenarios/rcll/topics/topic.h"

namespace cxlab::rcll {

namespace {
constexpr std::size_t kMostComplaints = 100;
constexpr std::int64_t kMostRobots = 3;                     // of a team
constexpr SimTime kForgotten = std::chrono::seconds(1080);  // since its last beacon, a robot is not told of
}  // namespace

bool RefboxContext::plays(Team team) const { return std::ranges::find(teams, team) != teams.end(); }

std::string RefboxContext::team_name(Team team) const {
  return team_names[static_cast<std::size_t>(team)].value_or(std::string(to_string(team)));
}

void RefboxContext::meet(const Fields& beacon, std::string_view host) {
  const std::string name = beacon.text("team_name");
  std::optional<Team> team;
  if (beacon.has("team_color")) team = named<Team>(beacon.text("team_color"));
  for (const Team known : teams)
    if (!team && team_name(known) == name) team = known;
  for (const Team open : teams)
    if (!team && !team_names[static_cast<std::size_t>(open)]) team = open;
  if (!team || !plays(*team)) return;
  if (auto& told = team_names[static_cast<std::size_t>(*team)]; !name.empty() && !told) told = name;
  const std::int64_t number = beacon.integer("number");
  if (number >= 1 && number <= kMostRobots)
    acquaintances[{*team, number}] = {beacon.text("peer_name"), std::string(host), moment(), now};
}

pb::MessagePtr RefboxContext::make(std::string_view type) const {
  return types->make("llsf_msgs." + std::string(type));
}

pb::MessagePtr RefboxContext::make(std::string_view type, const bus::MessageView& from) const {
  auto message = make(type);
  fill(*message, from, moment());
  return message;
}

pb::MessagePtr RefboxContext::robots(bool poses) const {
  bus::Message told(**interface("RobotInfo"));
  factory.put_robots(told.view(), poses);
  auto message = make("RobotInfo", told.view());
  Fields info(*message);
  for (int i = info.size("robots") - 1; i >= 0; --i) {
    Fields robot = info.item("robots", i);
    const auto team = named<Team>(robot.text("team_color")).value_or(Team::kCyan);
    if (!poses) robot.clear("pose");
    robot.set("team", team_name(team));
    const auto known = acquaintances.find({team, robot.integer("number")});
    const bool met = known != acquaintances.end();
    if (met && now - known->second.heard > kForgotten) {
      info.erase("robots", i);
      continue;
    }
    if (met) robot.set("name", known->second.name);
    robot.set("host", met ? known->second.host : std::string(net::kLoopback));
    robot.set("last_seen", met ? known->second.seen : moment());
  }
  return message;
}

Expected<const bus::MessageType*> RefboxContext::interface(std::string_view type) const {
  return bus::needed_message(bus.registry(), std::string(kInterfaces) + "msg/" + std::string(type));
}

Status RefboxContext::hear(const std::string& topic, std::string_view type, Heard& heard) {
  auto known = interface(type);
  if (!known) return known.error();
  auto made = bus.subscribe(node, topic, **known, [&heard](const bus::Delivery& d) { heard = {d.message, true}; });
  return made ? Status() : Status(made.error());
}

void RefboxContext::pass_on(const Fields& message, std::string_view type, bus::EndpointId topic) {
  bus::Message out(**interface(type));
  fill(out.view(), message.message());
  bus.publish(topic, std::make_shared<const bus::Message>(std::move(out)));
}

void RefboxContext::complain(const std::string& text) {
  if (!log || complaints.size() >= kMostComplaints || !complaints.insert(text).second) return;
  log->line({bus.now(), cx::LogLevel::kWarn, "refbox", text, {}});
  if (complaints.size() == kMostComplaints)
    log->line({bus.now(), cx::LogLevel::kWarn, "refbox", "what else it cannot read is not reported", {}});
}

}  // namespace cxlab::rcll
