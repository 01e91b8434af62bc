#include "scenarios/rcll/topics/team_channel.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "cx/bus/needed.h"
#include "scenarios/rcll/rules/layout.h"
#include "scenarios/rcll/rules/storage_station.h"

namespace cxlab::rcll {

template <>
inline constexpr std::array<std::string_view, 3> kNames<sim::Light>{"OFF", "ON", "BLINK"};
template <>
inline constexpr std::array<std::string_view, 3> kNames<Exploration::Guess>{"NO_REPORT", "CORRECT_REPORT",
                                                                            "WRONG_REPORT"};

namespace {

void put_light(const bus::MessageView& machine, std::string_view color, sim::Light light) {
  machine.append("lights").set("color", color).set("state", to_string(light));
}

/// Numbers of the markers at input and output, as in the rulebook.
struct Tags {
  int input = 0, output = 0;
};
Tags tags_of(const Machine& machine) {
  constexpr std::pair<std::string_view, int> kOutputs[]{{"CS1", 101}, {"CS2", 103}, {"RS1", 111}, {"RS2", 113},
                                                        {"BS", 121},  {"DS", 131},  {"SS", 141}};
  const auto at =
      std::ranges::find(kOutputs, std::string_view(machine.name()).substr(2), &std::pair<std::string_view, int>::first);
  const int output = at->second + (machine.team() == Team::kMagenta ? 100 : 0);
  return {output + 1, output};
}

}  // namespace

std::string channel_prefix(Team team, std::size_t teams) {
  return teams == 1 ? "" : team == Team::kCyan ? "/cyan" : "/magenta";
}

Status TeamChannel::open(bus::ParticipantId node, const std::string& prefix) {
  const std::string package(kInterfaces);
  auto action = bus::needed_action(bus_.registry(), package + "action/InstructMachine");
  if (!action) return action.error();
  action_ = *action;
  auto server =
      bus_.serve_action(node, prefix + "/factory/instruct_machine", *action_,
                        {[this](const bus::Delivery& d) { start(d); }, [this](const bus::Delivery& d) { cancel(d); }});
  if (!server) return server.error();
  server_ = *server;
  const auto hear = [&](const char* topic, const char* type, auto take) -> Status {
    auto known = bus::needed_message(bus_.registry(), package + "msg/" + type);
    if (!known) return known.error();
    auto heard =
        bus_.subscribe(node, prefix + topic, **known, [this, take](const bus::Delivery& d) { (this->*take)(d); });
    return heard ? Status() : Status(heard.error());
  };
  if (Status s = hear("/machine_report", "MachineReport", &TeamChannel::take_report); !s) return s;
  if (Status s = hear("/set_robot_maintenance", "SetRobotMaintenance", &TeamChannel::take_maintenance); !s) return s;
  if (Status s = machine_info_.open(bus_, node, prefix + "/machine_info", "MachineInfo", kInfoPeriod); !s) return s;
  return report_info_.open(bus_, node, prefix + "/machine_report_info", "MachineReportInfo", kReportPeriod);
}

void TeamChannel::sense(SimTime now, bool changed) {
  for (Goal& goal : goals_) report(goal);
  std::erase_if(goals_, [](const Goal& goal) { return goal.machine == nullptr; });
  if (machine_info_.due(now, changed)) publish_machines();
  if (report_info_.due(now, false) && !game_.referee.exploration().over(game_.world.floor_time())) publish_reports();
}

// --- Instructions

void TeamChannel::start(const bus::Delivery& delivery) {
  bus_.answer_goal(server_, delivery.goal, bus::GoalAnswer::kAccept);
  const bus::MessageView goal = delivery.message->view();
  const std::string& name = goal.text("machine");
  Machine* machine = find_machine(game_.machines, name);
  if (machine == nullptr)
    return finish(delivery.goal, InstructError::kNoMachine, unknown_machine(game_.machines, name), name);
  if (machine->team() != team_)
    return finish(delivery.goal, InstructError::kWrongTeam,
                  name + " belongs to " + std::string(to_string(machine->team())), name);

  const auto number = [&](std::string_view field) { return static_cast<int>(goal.integer(field)); };
  const Instruction instruction{goal.text("operation"),  goal.text("side"),       goal.text("base_color"),
                                goal.text("ring_color"), number("order_id"),      number("shelf"),
                                number("slot"),          goal.text("description")};
  const MachineFaults::Passage passage = game_.faults.instruct(*machine, game_.world.floor_time());
  if (passage.delay == SimTime::zero()) return instruct(delivery.goal, *machine, instruction);
  delayed_.push_back({delivery.goal, machine, instruction, game_.world.floor_time() + passage.delay, passage.lost});
}

void TeamChannel::instruct(const bus::GoalId& goal, Machine& machine, const Instruction& instruction) {
  const Machine::Answer answer = hear(machine, instruction);
  if (answer.error != InstructError::kNone || answer.done)
    return finish(goal, answer.error, answer.text, machine.name());
  goals_.push_back({goal, &machine, machine.job().number, MachineState::kIdle});
}

Machine::Answer TeamChannel::hear(Machine& machine, const Instruction& instruction) {
  const SimTime now = game_.world.floor_time();
  Machine::Answer answer = game_.world.halted() ? Machine::Answer{InstructError::kNotReady, "the game is paused"}
                                                : machine.instruct(instruction, now, game_.world);
  game_.referee.take_instruction(machine.id(), instruction, answer.error, now);
  return answer;
}

void TeamChannel::act(SimTime now) {
  for (const bus::SharedMessage& report : std::exchange(reports_, {})) judge_report(report->view());
  for (const Delayed& delayed : delayed_) {
    if (now < delayed.due) continue;
    if (delayed.canceled)
      (void)hear(*delayed.machine, delayed.instruction);
    else if (delayed.lost)
      finish(delayed.id, InstructError::kNoAnswer, "no answer: the instruction was lost", delayed.machine->name());
    else
      instruct(delayed.id, *delayed.machine, delayed.instruction);
  }
  std::erase_if(delayed_, [&](const Delayed& delayed) { return now >= delayed.due; });
}

SimTime TeamChannel::next_due() const {
  SimTime due = std::min(machine_info_.next(), report_info_.next());
  for (const Delayed& delayed : delayed_) due = std::min(due, game_.world.clock().when(delayed.due));
  return due;
}

void TeamChannel::cancel(const bus::Delivery& delivery) {
  // The machine works on; only the waiting ends.
  bus_.answer_cancel(server_, delivery, true);
  bus::Message result(*action_->result);
  result->set("error", "canceled");
  bus_.finish(server_, delivery.goal, bus::GoalStatus::kCanceled, std::make_shared<bus::Message>(std::move(result)));
  std::erase_if(goals_, [&](const Goal& goal) { return goal.id == delivery.goal; });
  std::erase_if(delayed_, [&](const Delayed& delayed) { return delayed.id == delivery.goal && delayed.lost; });
  for (Delayed& delayed : delayed_) delayed.canceled |= delayed.id == delivery.goal;
}

void TeamChannel::report(Goal& goal) {
  if (goal.machine->state() != goal.reported) {
    goal.reported = goal.machine->state();
    bus::Message feedback(*action_->feedback);
    feedback->set("state", to_string(goal.reported));
    bus_.publish_feedback(server_, goal.id, std::make_shared<bus::Message>(std::move(feedback)));
  }
  const Job& job = goal.machine->job();
  if (job.number == goal.job && job.open) return;
  finish(goal.id, job.error, job.text, goal.machine->name());
  goal.machine = nullptr;
}

void TeamChannel::finish(const bus::GoalId& goal, InstructError error, const std::string& text,
                         const std::string& machine) {
  bus::Message result(*action_->result);
  const bool success = error == InstructError::kNone;
  result->set("success", success).set("error_code", static_cast<int>(error)).set("error", text).set("target", machine);
  bus_.finish(server_, goal, success ? bus::GoalStatus::kSucceeded : bus::GoalStatus::kAborted,
              std::make_shared<bus::Message>(std::move(result)));
}

// --- Exploration

void TeamChannel::take_report(const bus::Delivery& delivery) {
  if (game_.world.halted())
    reports_.push_back(delivery.message);
  else
    judge_report(delivery.message->view());
}

void TeamChannel::judge_report(const bus::MessageView& report) {
  const auto warn = [&](const std::string& why) {
    if (warn_) warn_("a report of " + std::string(to_string(team_)) + " is ignored: " + why);
  };
  if (const std::string& color = report.text("team_color"); !color.empty() && color != to_string(team_))
    return warn(game_.referee.deny_report(team_, color, game_.world.floor_time()));
  for (std::size_t i = 0; i < report.size("machines"); ++i) {
    const bus::MessageView entry = report.nested("machines", i);
    const auto rotation = static_cast<int>(entry.integer("rotation"));
    const std::string nonsense = game_.referee.take_report(team_,
                                                           {entry.text("name"), entry.text("type"), entry.text("zone"),
                                                            rotation < 0 ? std::nullopt : std::optional(rotation)},
                                                           game_.world.floor_time());
    if (!nonsense.empty()) warn(nonsense);
  }
}

void TeamChannel::take_maintenance(const bus::Delivery& delivery) {
  const bus::MessageView message = delivery.message->view();
  game_.maintenance.request(team_, message.text("team_color"), static_cast<int>(message.integer("robot_number")),
                            message.integer("maintenance") != 0, game_.world.floor_time());
}

void TeamChannel::publish_reports() {
  bus::Message message = report_info_.message();
  message->set("team_color", to_string(team_));
  const std::vector<std::string> names = game_.referee.exploration().reported(team_);
  put_texts(message.view(), "reported_machines", {names.begin(), names.end()});
  for (const TypeFeedback& feedback : game_.referee.exploration().type_feedback()) {
    if (feedback.team != team_) continue;
    const bus::MessageView entry = message->append("reported_types");
    entry.set("type", feedback.type).set("zone", feedback.zone).set("name", feedback.name);
    if (!feedback.name.empty())
      entry.set("team_color", to_string(feedback.name.front() == letter(Team::kCyan) ? Team::kCyan : Team::kMagenta));
  }
  report_info_.publish(bus_, std::move(message));
}

// --- Machines

void TeamChannel::publish_machines() {
  bus::Message message = machine_info_.message();
  message->set("team_color", to_string(team_));
  for (const auto& machine : game_.machines)
    if (information_ == Information::kAll || machine->team() == team_)
      put_machine(message->append("machines"), *machine, game_.world, game_.referee.exploration(), information_);
  machine_info_.publish(bus_, std::move(message));
}

void put_machine(const bus::MessageView& entry, const Machine& machine, const sim::World& world,
                 const Exploration& exploration, Information information) {
  const sim::Station& station = world.plan().station(machine.id());
  const std::string_view type = std::string_view(station.name).substr(2);
  const bool all = information == Information::kAll;
  const bool known = exploration.knows(machine.id(), world.floor_time());
  entry.set("name", station.name).set("type", station.kind).set("state", to_string(machine.state()));
  entry.set("team_color", to_string(machine.team())).set("correctly_reported", known);
  const Exploration::Finding& finding = exploration.finding(machine.id());
  entry.set("exploration_zone_state", to_string(finding.zone));
  entry.set("exploration_rotation_state", to_string(finding.rotation));
  entry.set("input_tag", tags_of(machine).input).set("output_tag", tags_of(machine).output);
  if (known || all) entry.set("zone", to_string(zone_of(station))).set("rotation", rotation_of(station));
  if (station.kind == "RS")
    put_texts(entry, "ring_colors", {to_string(rings_of(type)[0]), to_string(rings_of(type)[1])});
  if (const auto* storage = dynamic_cast<const StorageStation*>(&machine)) {
    for (int shelf = 0; shelf < Storage::kShelves; ++shelf)
      for (int slot = 0; slot < Storage::kSlots; ++slot) {
        const auto& content = storage->storage().at({shelf, slot});
        if (!content) continue;
        const bus::MessageView status = entry.append("status_ss");
        status.set("shelf", shelf).set("slot", slot).set("is_filled", true).set("description", content->description);
      }
  }
  if (!all) return;
  const sim::Lights lights = world.lights(machine.id());
  put_light(entry, "RED", lights.red);
  put_light(entry, "YELLOW", lights.yellow);
  put_light(entry, "GREEN", lights.green);
  put_pose(entry, station.pose_in_world);
  entry.set("loaded_with", machine.loaded_with());
  if (station.kind == "CS") entry.set("cap_color", to_string(shelf_cap(type)));
}

}  // namespace cxlab::rcll
