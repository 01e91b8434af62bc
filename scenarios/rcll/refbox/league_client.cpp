#include "scenarios/rcll/refbox/league_client.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <algorithm>
#include <cmath>

#include "cx/bus/names.h"
#include "cx/bus/needed.h"
#include "scenarios/rcll/rules/layout.h"
#include "scenarios/rcll/topics/topic.h"
#include "scenarios/rcll/world.h"

namespace cxlab::rcll {

namespace {

constexpr SimTime kPeriod = std::chrono::seconds(1);               // messages without an answer are sent again
constexpr SimTime kNotTaken = std::chrono::seconds(10);            // of an instruction
constexpr int kBroken = 1, kNoMachineCode = 203, kNotReady = 209;  // errors of instructions
constexpr std::int64_t kNotSupportedCode = 104;

/// "C-CS1-SHELF-LEFT": machine and point.
std::pair<std::string, std::string> split_spot(const std::string& spot) {
  const std::size_t dash = spot.find('-', std::min(spot.find('-') + 1, spot.size()));
  if (dash == std::string::npos) return {spot, ""};
  return {spot.substr(0, dash), spot.substr(dash + 1)};
}

/// The zone of a place in the field.
std::string zone_at(double x, double y) {
  const auto within = [](double value, int most) { return std::clamp(static_cast<int>(value) + 1, 1, most); };
  return to_string(Zone{x < 0 ? Team::kMagenta : Team::kCyan, within(std::abs(x), kColumns), within(y, kRows)});
}

}  // namespace

LeagueClient::LeagueClient(LeagueClientConfig config, const StageSetup& setup)
    : config_(std::move(config)),
      bus_(setup.bus),
      network_(*setup.network),
      log_(setup.log),
      epoch_(setup.scenario.epoch) {
  node_ = bus_.join(bus::ParticipantKind::kNode, bus::NodeName{"league_client", config_.name_space, {}},
                    setup.sink.open_stream("node/league_client"));
}

LeagueClient::~LeagueClient() = default;

Expected<std::unique_ptr<LeagueClient>> LeagueClient::make(const LeagueClientConfig& config, const StageSetup& setup) {
  const auto check = [](const char* key, int found, int least, int most) {
    if (found >= least && found <= most) return Status();
    return Status(input_error(std::string(key) + ": found " + std::to_string(found) + ", expected " +
                              std::to_string(least) + " to " + std::to_string(most)));
  };
  if (Status s = check("robots", config.robots, 0, 3); !s) return s.error();
  if (Status s = check("first_robot", config.first_robot, 1, 4); !s) return s.error();
  if (Status s = check("port_shift", config.port_shift, -1000, 60000); !s) return s.error();
  if (Status s = bus::check_node(config.name_space, {}); !s) return s.error();
  std::unique_ptr<LeagueClient> client(new LeagueClient(config, setup));
  auto types = load_types(setup.keep);
  if (!types) return types.error();
  client->types_ = *std::move(types);
  if (Status s = client->open(); !s) return s.error();
  return client;
}

Status LeagueClient::advertise(const char* topic, const char* message) {
  auto type = bus::needed_message(bus_.registry(), std::string(kInterfaces) + "msg/" + message);
  if (!type) return type.error();
  auto made = bus_.advertise(node_, topic, **type);
  if (!made) return made.error();
  topics_[message] = {*type, *made};
  return {};
}

Status LeagueClient::open() {
  auto host = net::Host::create(network_, node_, [this](const net::Event& event) { take(event); });
  if (!host) return host.error();
  host_ = *std::move(host);
  const auto port = [this](int number) { return static_cast<std::uint16_t>(number + config_.port_shift); };
  std::unique_ptr<pb::Crypto> crypto;
  if (!config_.key.empty()) {
    const auto cipher = pb::cipher_of(config_.cipher);
    if (!cipher) return cipher.error();
    auto made = pb::Crypto::create(*cipher, config_.key);
    if (!made) return made.error();
    crypto = *std::move(made);
  }
  const int magenta = config_.team == "MAGENTA" ? 1 : 0;
  public_.emplace(*host_, "public channel", port(4445), port(4444));
  team_.emplace(*host_, "channel of the team", port(4446 + magenta), port(4441 + magenta), std::move(crypto));
  for (const auto& [topic, message] : {std::pair{"game_state", "GameState"},
                                       {"order_info", "OrderInfo"},
                                       {"ring_info", "RingInfo"},
                                       {"robot_info", "RobotInfo"},
                                       {"machine_info", "MachineInfo"},
                                       {"machine_report_info", "MachineReportInfo"}})
    if (Status s = advertise(topic, message); !s) return s;
  const auto hear = [this](const char* topic, const char* message, auto handler) -> Status {
    auto type = bus::needed_message(bus_.registry(), std::string(kInterfaces) + "msg/" + message);
    if (!type) return type.error();
    auto made = bus_.subscribe(node_, topic, **type, [this, handler](const bus::Delivery& d) { (this->*handler)(d); });
    return made ? Status() : Status(made.error());
  };
  if (Status s = hear("machine_report", "MachineReport", &LeagueClient::take_report); !s) return s;
  if (Status s = hear("set_robot_maintenance", "SetRobotMaintenance", &LeagueClient::take_maintenance); !s) return s;
  auto action = bus::needed_action(bus_.registry(), std::string(kInterfaces) + "action/InstructMachine");
  if (!action) return action.error();
  instruct_ = *action;
  auto server = bus_.serve_action(node_, "factory/instruct_machine", *instruct_,
                                  {[this](const bus::Delivery& d) { take_instruction(d); },
                                   [this](const bus::Delivery& d) {
                                     bus_.answer_cancel(instruct_server_, d, true);
                                     bus_.finish(instruct_server_, d.goal, bus::GoalStatus::kCanceled,
                                                 std::make_shared<const bus::Message>(*instruct_->result));
                                     std::erase_if(instructions_, [&](const auto& i) { return i.goal == d.goal; });
                                   }});
  if (!server) return server.error();
  instruct_server_ = *server;
  for (int i = 0; i < config_.robots; ++i) {
    const int of_game = config_.first_robot - 1 + i;
    robots_.push_back(std::make_unique<Robot>(i + 1, Channel(*host_, "channel of robot " + std::to_string(i + 1),
                                                             port(2126 + of_game), port(2116 + of_game))));
    if (Status s = open(*robots_.back()); !s) return s;
  }
  return {};
}

Status LeagueClient::open(Robot& robot) {
  const std::string name = "robot" + std::to_string(robot.number) + '/';
  for (const auto& [skill, type] : {std::pair{"drive_to", "DriveTo"},
                                    {"pick", "Pick"},
                                    {"place", "Place"},
                                    {"transport", "Transport"},
                                    {"explore", "Explore"},
                                    {"discard", "Discard"}}) {
    auto known = bus::needed_action(bus_.registry(), std::string("cxlab_skills/action/") + type);
    if (!known) return known.error();
    Skill& made = robot.skills[skill];
    made = {skill, *known, {}};
    auto server = bus_.serve_action(node_, name + skill, **known,
                                    {[this, &robot, &made](const bus::Delivery& d) { take_goal(robot, made, d); },
                                     [this, &robot, &made](const bus::Delivery& d) { take_cancel(robot, made, d); }});
    if (!server) return server.error();
    made.server = *server;
  }
  auto type = bus::needed_message(bus_.registry(), "cxlab_skills/msg/Sightings");
  if (!type) return type.error();
  auto sightings = bus_.advertise(node_, name + "sightings", **type);
  if (!sightings) return sightings.error();
  robot.sightings = *sightings;
  return {};
}

// --- The tick

Status LeagueClient::act(SimTime now) {
  now_ = now;
  bus_.deliver(node_);
  if (now < next_) return {};
  while (next_ <= now) next_ += kPeriod;
  say_where_robots_are();
  for (const Instruction& instruction : instructions_)
    if (!instruction.at_work) team_->send(*instruction.message);
  for (const auto& robot : robots_)
    if (robot->active && robot->task) robot->channel.send(*robot->task);
  follow_machines();
  return {};
}

SimTime LeagueClient::next_due() const { return next_; }

void LeagueClient::say_where_robots_are() {
  for (const auto& robot : robots_) {
    const auto message = types_->make("llsf_msgs.BeaconSignal");
    Fields beacon(*message);
    beacon.set("time", moment()).set("seq", static_cast<std::int64_t>(++beacons_)).set("number", robot->number);
    beacon.set("team_name", config_.team_name).set("peer_name", "robot" + std::to_string(robot->number));
    beacon.set("team_color", config_.team);
    if (robot->beacon && Fields(*robot->beacon).has("pose"))
      beacon.part("pose").message().CopyFrom(Fields(*robot->beacon).part("pose").message());
    public_->send(*message);
  }
}

// --- From the network

void LeagueClient::take(const net::Event& event) {
  if (event.kind != net::EventKind::kDatagram) return;
  const auto read = [&](const Channel& channel) -> pb::MessagePtr {
    auto message = channel.read(*types_, event);
    if (message) return *std::move(message);
    complain(channel.name() + ": " + message.error().message);
    return nullptr;
  };
  for (const Channel* channel : {&*public_, &*team_})
    if (channel->owns(event.link)) {
      if (const auto message = read(*channel)) take_refbox(*message);
      return;
    }
  for (auto& robot : robots_)
    if (robot->channel.owns(event.link)) {
      if (auto message = read(robot->channel)) take_robot(*robot, *message);
      return;
    }
}

void LeagueClient::publish(const std::string& topic, google::protobuf::Message& message) {
  const Topic& to = topics_.find(topic)->second;
  bus::Message out(*to.type);
  fill(out.view(), message);
  bus_.publish(to.endpoint, std::make_shared<const bus::Message>(std::move(out)));
}

void LeagueClient::take_refbox(google::protobuf::Message& message) {
  const std::string& type = message.GetDescriptor()->name();
  if (!topics_.contains(type)) return;
  Fields fields(message);
  if (type == "RobotInfo")
    for (int i = 0; i < fields.size("robots"); ++i) {
      Fields robot = fields.item("robots", i);  // its actions have this name here, whatever it says of itself
      if (robot.text("team_color") == config_.team)
        robot.set("name", "robot" + std::to_string(robot.integer("number")));
    }
  publish(type, message);
  if (type != "MachineInfo") return;
  machines_.clear();
  for (int i = 0; i < fields.size("machines"); ++i)
    machines_[fields.item("machines", i).text("name")] = fields.item("machines", i).text("state");
  follow_machines();
}

void LeagueClient::complain(const std::string& text) {
  if (log_ && text != complaint_) log_->line({bus_.now(), cx::LogLevel::kWarn, "league_client", text, {}});
  complaint_ = text;
}

// --- Machines

pb::MessagePtr LeagueClient::prepare_message(const bus::MessageView& goal) const {
  const std::string &machine = goal.text("machine"), &operation = goal.text("operation");
  const bool reset = operation == "RESET";
  auto message = types_->make(reset ? "llsf_msgs.ResetMachine" : "llsf_msgs.PrepareMachine");
  Fields prepare(*message);
  prepare.set("team_color", config_.team).set("machine", machine);
  if (reset) return message;
  prepare.set("sent_at", moment().sec);
  const std::string kind(kind_of(std::string_view(machine).substr(std::min<std::size_t>(2, machine.size()))));
  if (kind == "BS")
    prepare.part("instruction_bs").set("side", goal.text("side")).set("color", goal.text("base_color"));
  else if (kind == "CS")
    prepare.part("instruction_cs").set("operation", operation);
  else if (kind == "RS")
    prepare.part("instruction_rs").set("ring_color", goal.text("ring_color"));
  else if (kind == "DS")
    prepare.part("instruction_ds").set("order_id", goal.integer("order_id"));
  else
    prepare.part("instruction_ss")
        .set("operation", operation)
        .set("shelf", goal.integer("shelf"))
        .set("slot", goal.integer("slot"))
        .set("wp_description", goal.text("description"));
  return message;
}

void LeagueClient::take_instruction(const bus::Delivery& delivery) {
  bus_.answer_goal(instruct_server_, delivery.goal, bus::GoalAnswer::kAccept);
  const bus::MessageView goal = delivery.message->view();
  Instruction instruction;
  instruction.goal = delivery.goal;
  instruction.machine = goal.text("machine");
  instruction.since = now_;
  instruction.reset = goal.text("operation") == "RESET";
  const auto machine = machines_.find(instruction.machine);
  if (machine == machines_.end())
    return finish(instruction, kNoMachineCode, "no machine '" + instruction.machine + "'");
  if (!instruction.reset && machine->second != "IDLE")
    return finish(instruction, kNotReady, instruction.machine + " is " + machine->second);
  const bool delivers = instruction.machine.ends_with("DS") || goal.text("operation") == "STORE";
  instruction.waits_for_piece = !delivers;
  instruction.message = prepare_message(goal);
  if (!instruction.message->IsInitialized())
    return finish(instruction, 103, "a field of the instruction is missing or wrong");
  team_->send(*instruction.message);
  if (goal.text("operation") == "CHANGE_INFO") return finish(instruction, 0, "");
  instructions_.push_back(std::move(instruction));
}

void LeagueClient::follow_machines() {
  for (Instruction& instruction : instructions_) {
    const auto known = machines_.find(instruction.machine);
    if (known == machines_.end()) continue;
    const std::string& state = known->second;
    if (state != instruction.reported) {
      instruction.reported = state;
      bus::Message feedback(*instruct_->feedback);
      feedback->set("state", state);
      bus_.publish_feedback(instruct_server_, instruction.goal,
                            std::make_shared<const bus::Message>(std::move(feedback)));
    }
    const bool idle = state == "IDLE" || state == "WAIT-IDLE";
    instruction.at_work |= !idle && state != "DOWN";
    const bool ready = instruction.waits_for_piece && state == "READY-AT-OUTPUT";
    if (state == "BROKEN")
      finish(instruction, instruction.reset ? 0 : kBroken, instruction.reset ? "" : instruction.machine + " broke");
    else if (!instruction.reset && (ready || (instruction.at_work && idle)))
      finish(instruction, 0, "");
    else if (!instruction.at_work && now_ - instruction.since > kNotTaken && state != "DOWN")
      finish(instruction, kNotReady, instruction.machine + " takes no instruction");
    else
      continue;
    instruction.message.reset();
  }
  std::erase_if(instructions_, [](const Instruction& instruction) { return !instruction.message; });
}

void LeagueClient::finish(const Instruction& instruction, int code, const std::string& error) {
  bus::Message result(*instruct_->result);
  result->set("success", code == 0).set("error_code", code).set("error", error).set("target", instruction.machine);
  bus_.finish(instruct_server_, instruction.goal, code == 0 ? bus::GoalStatus::kSucceeded : bus::GoalStatus::kAborted,
              std::make_shared<const bus::Message>(std::move(result)));
}

void LeagueClient::take_report(const bus::Delivery& delivery) {
  const auto message = types_->make("llsf_msgs.MachineReport");
  fill(*message, delivery.message->view(), moment());
  Fields(*message).set("team_color", config_.team);
  team_->send(*message);
}

void LeagueClient::take_maintenance(const bus::Delivery& delivery) {
  const auto message = types_->make("llsf_msgs.SetRobotMaintenance");
  fill(*message, delivery.message->view(), moment());
  if (message->IsInitialized()) team_->send(*message);
}

// --- Robots

void LeagueClient::take_goal(Robot& robot, const Skill& skill, const bus::Delivery& delivery) {
  if (robot.active) {
    bus_.answer_goal(skill.server, delivery.goal, bus::GoalAnswer::kReject);
    return;
  }
  bus_.answer_goal(skill.server, delivery.goal, bus::GoalAnswer::kAccept);
  const bus::MessageView goal = delivery.message->view();
  const bool transport = skill.name == "transport";
  robot.active = &skill;
  robot.goal = delivery.goal;
  robot.canceled = false;
  robot.target = transport ? goal.text("from") + " to " + goal.text("to") : goal.text("target");
  robot.parts.clear();
  const auto move = [&](std::string_view sub_action, const std::string& to) {
    const auto [machine, point] = split_spot(to);
    Part part{sub_action, "move", {{"waypoint", machine}}};
    if (!point.empty()) part.values.emplace_back("machine_point", point);
    robot.parts.push_back(std::move(part));
  };
  const auto handle = [&](std::string_view sub_action, const char* field, const std::string& spot) {
    const auto [machine, point] = split_spot(spot);
    robot.parts.push_back({sub_action, field, {{"machine_id", machine}, {"machine_point", point}}});
  };
  if (transport) {
    move("drive_from", goal.text("from"));
    handle("pick", "retrieve", goal.text("from"));
    move("drive_to", goal.text("to"));
    handle("place", "deliver", goal.text("to"));
  } else if (skill.name == "pick" || skill.name == "place") {
    move("", robot.target);
    handle("", skill.name == "pick" ? "retrieve" : "deliver", robot.target);
  } else if (skill.name == "explore") {
    robot.parts.push_back(
        {"", "explore_machine", {{"machine_id", ""}, {"machine_point", ""}, {"waypoint", robot.target}}});
  } else if (skill.name == "drive_to") {
    const bus::MessageView pose = goal.nested("pose");
    move("", robot.target.empty() ? zone_at(pose.real("x"), pose.real("y")) : robot.target);
  } else {
    return finish(robot, kNotSupportedCode);
  }
  send_part(robot);
}

void LeagueClient::take_cancel(Robot& robot, const Skill& skill, const bus::Delivery& delivery) {
  bus_.answer_cancel(skill.server, delivery, true);
  if (!robot.active || robot.goal != delivery.goal || !robot.task) return;
  robot.canceled = true;
  Fields(*robot.task).set("cancel_task", true);
  robot.channel.send(*robot.task);
}

void LeagueClient::send_part(Robot& robot) {
  const Part& part = robot.parts.front();
  robot.task = types_->make("llsf_msgs.AgentTask");
  Fields task(*robot.task);
  task.set("team_color", config_.team).set("task_id", ++robot.task_id).set("robot_id", robot.number);
  for (const auto& [field, value] : part.values) task.part(part.field).set(field, value);
  robot.channel.send(*robot.task);
  bus::Message feedback(*robot.active->type->feedback);
  if (!part.sub_action.empty()) feedback->set("sub_action", part.sub_action);
  bus_.publish_feedback(robot.active->server, robot.goal, std::make_shared<const bus::Message>(std::move(feedback)));
}

void LeagueClient::take_robot(Robot& robot, google::protobuf::Message& message) {
  const std::string& type = message.GetDescriptor()->name();
  const auto copy = [&] {
    pb::MessagePtr out(message.New());
    out->CopyFrom(message);
    return out;
  };
  if (type == "BeaconSignal") {
    robot.beacon = copy();
  } else if (type == "MachineReport") {
    robot.seen = copy();
    auto known = bus::needed_message(bus_.registry(), "cxlab_skills/msg/Sightings");
    bus::Message sightings(**known);
    Fields report(message);
    for (int i = 0; i < report.size("machines"); ++i) {
      Fields entry = report.item("machines", i);
      const bus::MessageView seen = sightings->append("machines");
      seen.set("zone", entry.text("zone")).set("machine", entry.text("name"));
      if (entry.has("rotation")) seen.set("rotation", entry.integer("rotation"));
    }
    bus_.publish(robot.sightings, std::make_shared<const bus::Message>(std::move(sightings)));
  } else if (type == "AgentTask") {
    Fields answer(message);
    const bool ended = answer.has("successful") || answer.has("canceled");
    if (!robot.active || !ended || answer.integer("task_id") != robot.task_id) return;
    const bool canceled = answer.has("canceled") && answer.integer("canceled") != 0;
    if (canceled || !answer.integer("successful"))
      return finish(robot, std::max<std::int64_t>(1, answer.integer("error_code")), canceled && robot.canceled);
    if (robot.parts.size() == 1) return finish(robot, 0);
    robot.parts.pop_front();
    if (robot.canceled) return finish(robot, 1, true);
    send_part(robot);
  }
}

void LeagueClient::finish(Robot& robot, std::int64_t code, bool canceled) {
  bus::Message result(*robot.active->type->result);
  result->set("success", code == 0).set("error_code", canceled ? 0 : code).set("target", robot.target);
  if (code != 0) result->set("error", canceled ? "canceled" : "error " + std::to_string(code) + " of the robot");
  if (robot.active->name == "transport" && code != 0) result->set("sub_action", robot.parts.front().sub_action);
  if (robot.active->name == "explore") {
    result->set("zone", robot.target).set("rotation", -1);
    for (int i = 0; robot.seen && i < Fields(*robot.seen).size("machines"); ++i) {
      const Fields entry = Fields(*robot.seen).item("machines", i);
      if (entry.text("zone") != robot.target || !entry.has("name")) continue;
      result->set("machine", entry.text("name")).set("rotation", entry.integer("rotation"));
    }
  }
  const bus::GoalStatus status = canceled    ? bus::GoalStatus::kCanceled
                                 : code == 0 ? bus::GoalStatus::kSucceeded
                                             : bus::GoalStatus::kAborted;
  bus_.finish(robot.active->server, robot.goal, status, std::make_shared<const bus::Message>(std::move(result)));
  robot.active = nullptr;
  robot.task.reset();
  robot.parts.clear();
}

namespace {

Status add_client(const ServerSpec& spec, const StageSetup& setup, Stage& stage) {
  auto client = LeagueClient::make(spec.get<LeagueClientConfig>(), setup);
  if (!client) return client.error();
  stage.servers.push_back(*std::move(client));
  return {};
}

}  // namespace

constinit const NodeKind kLeagueClient{
    .name = "league_client",
    .what = "an outside referee box and its robots, for agents that know topics and actions (docs/rcll-protocol.md)",
    .settings = settings_of<LeagueClientConfig>(),
    .add = add_client,
};

}  // namespace cxlab::rcll
