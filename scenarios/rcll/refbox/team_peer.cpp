#include "scenarios/rcll/refbox/team_peer.h"

#include <google/protobuf/message.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "cx/bus/needed.h"
#include "scenarios/rcll/topics/team_channel.h"
#include "scenarios/rcll/topics/topic.h"

namespace cxlab::rcll {

namespace {
constexpr int kMachineBurst = 30;   // MachineInfos at the beginning
constexpr std::int64_t kStale = 5;  // s
}  // namespace

TeamPeer::TeamPeer(RefboxContext& context, Controllers& controllers, Team team, Channel channel)
    : context_(context), controllers_(controllers), team_(team), channel_(std::move(channel)) {}

Status TeamPeer::open() {
  const std::string prefix = channel_prefix(team_, context_.teams.size());
  machine_rate_ = {kBurstPeriod, context_.now};
  ring_rate_ = {kInfoPeriod, context_.now};
  report_rate_ = {kReportPeriod, context_.now};
  if (Status s = context_.hear(prefix + "/machine_info", "MachineInfo", machines_); !s) return s;
  if (Status s = context_.hear(prefix + "/machine_report_info", "MachineReportInfo", reports_); !s) return s;
  auto action = bus::needed_action(context_.bus.registry(), std::string(kInterfaces) + "action/InstructMachine");
  if (!action) return action.error();
  action_ = *action;
  auto client = context_.bus.create_action_client(context_.node, prefix + "/factory/instruct_machine", *action_,
                                                  {.goal_response = [](const bus::Delivery&) {},
                                                   .feedback = [](const bus::Delivery&) {},
                                                   .result = [this](const bus::Delivery& d) { take_result(d); },
                                                   .cancel_response = [](const bus::Delivery&) {}});
  if (!client) return client.error();
  instruct_ = *client;
  const auto advertise = [&](const char* topic, const char* type, bus::EndpointId& endpoint) -> Status {
    auto known = context_.interface(type);
    if (!known) return known.error();
    auto made = context_.bus.advertise(context_.node, prefix + topic, **known);
    if (!made) return made.error();
    endpoint = *made;
    return {};
  };
  if (Status s = advertise("/machine_report", "MachineReport", report_); !s) return s;
  return advertise("/set_robot_maintenance", "SetRobotMaintenance",
                   context_.maintenance[static_cast<std::size_t>(team_)]);
}

// --- What it says

void TeamPeer::take(const Fields& message, const std::string& type, std::string_view host) {
  if (message.has("team_color") && message.text("team_color") != to_string(team_))
    return context_.complain(channel_.name() + ": found a " + type + " of " + message.text("team_color"));
  if (type == "llsf_msgs.BeaconSignal") return context_.meet(message, host);
  if (type == "llsf_msgs.PrepareMachine") return prepare(message);
  if (type == "llsf_msgs.ResetMachine") {
    bus::Message goal(*action_->goal);
    goal->set("machine", message.text("machine")).set("operation", "RESET");
    return instruct(std::move(goal));
  }
  if (type == "llsf_msgs.MachineReport") return context_.pass_on(message, "MachineReport", report_);
  if (type == "llsf_msgs.SetRobotMaintenance")
    return context_.pass_on(message, "SetRobotMaintenance", context_.maintenance[static_cast<std::size_t>(team_)]);
  context_.complain(
      channel_.name() + ": " +
      found_expected(
          "a " + type,
          "a PrepareMachine, ResetMachine, MachineReport, SetRobotMaintenance or BeaconSignal of llsf_msgs"));
}

void TeamPeer::prepare(const Fields& message) {
  if (is_stale(message))
    return context_.complain(channel_.name() + ": a PrepareMachine that was sent more than " + std::to_string(kStale) +
                             " s ago");
  bus::Message goal(*action_->goal);
  goal->set("machine", message.text("machine"));
  // If the instruction of a delivery station is missing, the goal names an order that does not exist. Goals for other
  // machines lack their fields.
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
  instruct(std::move(goal));
}

bool TeamPeer::is_stale(const Fields& message) {
  if (!message.has("sent_at")) return false;
  // Only differences count: the team's clock need not be ours.
  const std::int64_t ahead = message.integer("sent_at") - context_.moment().sec;
  clock_ahead_ = std::max(clock_ahead_.value_or(ahead), ahead);
  return *clock_ahead_ - ahead > kStale;
}

void TeamPeer::instruct(bus::Message goal) {
  Instructed instructed{goal->text("machine")};
  instructed.busy =
      std::ranges::any_of(instructed_, [&](const auto& other) { return other.second.machine == instructed.machine; });
  if (machines_.message) {
    const bus::MessageView known = machines_.message->view();
    for (std::size_t i = 0; i < known.size("machines"); ++i)
      if (const bus::MessageView machine = known.nested("machines", i); machine.text("name") == instructed.machine)
        instructed.busy |= machine.text("state") != "IDLE";
  }
  const bus::GoalId id = context_.bus.send_goal(instruct_, std::make_shared<const bus::Message>(std::move(goal)));
  instructed_.emplace(id, std::move(instructed));
}

void TeamPeer::take_result(const bus::Delivery& result) {
  const auto goal = instructed_.extract(result.goal);
  if (goal.empty()) return;
  context_.bus.forget_goal(instruct_, result.goal);
  if (goal.mapped().busy || !result.message || result.message->view().integer("error_code") == 0) return;
  const std::string text = goal.mapped().machine + ": " + result.message->view().text("error");
  context_.complain(text);
  controllers_.attention(text, team_);
}

// --- What it is told

void TeamPeer::speak(const bus::SharedMessage& rings) {
  const bool heard = channel_.is_heard();
  if (machines_.message) {
    const bool due = machine_rate_.due(context_.now), fresh = std::exchange(machines_.fresh, false);
    if (heard && (due || fresh)) {
      const auto message = machines();
      const std::string bytes = message->SerializeAsString();
      if (due || bytes != machines_sent_) {
        channel_.send(*message);
        machines_sent_ = bytes;
        if (++machine_count_ == kMachineBurst) machine_rate_ = {kInfoPeriod, context_.now + kInfoPeriod};
      }
    }
  } else {
    machine_rate_.due(context_.now);
  }
  if (ring_rate_.due(context_.now) && rings) {
    const auto message = context_.make("RingInfo", rings->view());
    if (heard) channel_.send(*message);
    if (team_ == context_.teams.front()) controllers_.send(*message);
  }
  if (report_rate_.due(context_.now) && std::exchange(reports_.fresh, false)) {
    const auto message = context_.make("MachineReportInfo", reports_.message->view());
    if (heard) channel_.send(*message);
    controllers_.send(*message);
  }
}

SimTime TeamPeer::next_due() const { return std::min({machine_rate_.next, ring_rate_.next, report_rate_.next}); }

/// The team's machines, as the league tells the team about them.
pb::MessagePtr TeamPeer::machines() const {
  auto message = context_.make("MachineInfo");
  Fields info(*message);
  info.set("team_color", to_string(team_));
  const bus::MessageView heard = machines_.message->view();
  for (std::size_t i = 0; i < heard.size("machines"); ++i) {
    const bus::MessageView machine = heard.nested("machines", i);
    if (machine.text("team_color") != to_string(team_)) continue;
    Fields entry = info.append("machines");
    fill(entry.message(), machine, context_.moment());
    entry.clear("lights").clear("pose").clear("loaded_with");
    if (!machine.integer("correctly_reported") || machine.text("zone").empty()) entry.clear("zone").clear("rotation");
  }
  return message;
}

}  // namespace cxlab::rcll
