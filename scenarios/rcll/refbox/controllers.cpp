#include "scenarios/rcll/refbox/controllers.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <algorithm>
#include <utility>

#include "scenarios/rcll/rules/layout.h"

namespace cxlab::rcll {

namespace {

constexpr SimTime kStreamPeriod = std::chrono::milliseconds(250);  // of machines and robots
constexpr SimTime kLost = std::chrono::seconds(5);                 // a robot without a beacon
constexpr std::size_t kMostStreams = 32;
constexpr std::string_view kPackage = "llsf_msgs.";

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

// --- What they say

void Controllers::take(const net::Event& event) {
  if (event.kind == net::EventKind::kAccepted) {
    if (streams_.size() >= kMostStreams) return host_.close(event.link);
    if (streams_.empty()) {
      rate_ = {kStreamPeriod, context_.now};
      workpiece_rate_ = {kInfoPeriod, context_.now};
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
      context_.complain("stream: " + frame.error().message);
      host_.close(event.link);
      streams_.erase(event.link);
      return;
    }
    if (!*frame) return;
    const auto message = context_.types->read(**frame);
    if (!message) {
      context_.complain("stream: " + message.error().message);
      continue;
    }
    const std::string& type = (*message)->GetDescriptor()->full_name();
    if (type == "llsf_msgs.BeaconSignal") continue;
    if (const std::string problem = control(Fields(**message), std::string_view(type).substr(kPackage.size()));
        !problem.empty())
      context_.complain("stream: a " + type + " is refused: " + problem);
  }
}

std::string Controllers::control(const Fields& message, std::string_view type) {
  if (type == "SetGameState") return context_.factory.request_state(message.text("state"), "a controller");
  if (type == "SetGamePhase") {
    const auto phase = named<Phase>(message.text("phase"));
    return phase ? context_.factory.set_phase(*phase)
                 : found_expected(message.text("phase"), "SETUP, PRODUCTION or POST_GAME");
  }
  if (type == "SetMachineState") return set_machine(message.text("machine_name"), message.text("state"));
  if (type == "ConfirmDelivery")
    return context_.factory.confirm_delivery(message.integer("delivery_id"), message.integer("correct") != 0);
  if (type == "SetTeamName" || type == "SetRobotMaintenance") {
    const std::string team = message.has("team_color") ? message.text("team_color") : "no team";
    const auto known = named<Team>(team);
    if (!known || !context_.plays(*known)) return team + " does not play";
    const auto i = static_cast<std::size_t>(*known);
    if (type == "SetTeamName")
      context_.team_names[i] = message.text("team_name");
    else
      context_.pass_on(message, "SetRobotMaintenance", context_.maintenance[i]);
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

/// The other states are those of stand-ins for machines.
std::string Controllers::set_machine(const std::string& machine, const std::string& state) {
  if (state == "RESET") return context_.factory.reset_machine(machine);
  if (state == "IDLE") return context_.factory.repair_machine(machine);
  return found_expected(state, "RESET or IDLE");
}

// --- What they are sent

void Controllers::speak() {
  if (streams_.empty()) return;
  if (rate_.due(context_.now)) {
    send(*machines());
    send(*context_.robots(true));
    look_after();
  }
  if (workpiece_rate_.due(context_.now)) send(*workpieces());
}

SimTime Controllers::next_due() const { return streams_.empty() ? kNever : std::min(rate_.next, workpiece_rate_.next); }

void Controllers::send(const google::protobuf::Message& message) {
  if (streams_.empty()) return;
  const auto bytes = pb::Types::write(message);
  for (const auto& [link, reader] : streams_)
    if (bytes) host_.send(link, *bytes);
}

void Controllers::attention(const std::string& text, Team team) {
  if (streams_.empty()) return;
  const auto message = context_.make("AttentionMessage");
  Fields(*message).set("message", text).set("team_color", to_string(team));
  send(*message);
}

void Controllers::look_after() {
  const auto look = [this](bool wanted, const std::string& text, Team team) {
    if (!wanted)
      attentions_.erase(text);
    else if (attentions_.insert(text).second)
      attention(text, team);
  };
  for (const auto& machine : context_.factory.machines())
    look(machine->may_be_stuck(context_.world.floor_time()),
         machine->name() + " is in the same state for 10 s, and breaks after 20 s", machine->team());
  for (const Maintenance::Robot& robot : context_.factory.maintenance().robots()) {
    const std::string name = "robot " + std::to_string(robot.number) + " of " + std::string(to_string(robot.team));
    const bool serviced = robot.duty == RobotDuty::kMaintenance;
    look(serviced && context_.world.floor_time() - robot.since >= kMaintenanceWarning,
         name + " has to be back from maintenance soon", robot.team);
    const auto met = context_.acquaintances.find({robot.team, robot.number});
    look(met != context_.acquaintances.end() && context_.now - met->second.heard > kLost &&
             robot.duty == RobotDuty::kActive,
         name + " is lost: no beacon for 5 s", robot.team);
  }
}

pb::MessagePtr Controllers::machines() const {
  bus::Message told(**context_.interface("MachineInfo"));
  context_.factory.put_machines(told.view());
  auto message = context_.make("MachineInfo", told.view());
  for (int i = 0; const auto& machine : context_.factory.machines())
    put_instruction(Fields(*message).item("machines", i++), *machine);
  return message;
}

/// The workpieces that lie on the belts of machines.
pb::MessagePtr Controllers::workpieces() const {
  auto message = context_.make("WorkpieceInfo");
  Fields info(*message);
  for (const sim::Piece& piece : context_.world.pieces()) {
    if (piece.holder != sim::Holder::kBelt) continue;
    const sim::Station& station = context_.world.plan().station(static_cast<sim::StationId>(piece.holder_index));
    Fields entry = info.append("workpieces");
    entry.set("id", static_cast<std::int64_t>(piece.id)).set("at_machine", station.name);
    entry.set("team_color", to_string(team_of(station)));
    entry.set("base_color", to_string(static_cast<BaseColor>(piece.stack.base)));
    for (const std::uint8_t ring : piece.stack.rings) entry.set("ring_colors", to_string(static_cast<RingColor>(ring)));
    entry.set("cap_color", to_string(static_cast<CapColor>(piece.stack.cap)));
  }
  return message;
}

}  // namespace cxlab::rcll
