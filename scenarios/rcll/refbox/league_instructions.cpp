#include "scenarios/rcll/refbox/league_instructions.h"

#include <google/protobuf/message.h>

#include <algorithm>

#include "cx/bus/needed.h"
#include "scenarios/rcll/refbox/codes.h"
#include "scenarios/rcll/rules/layout.h"
#include "scenarios/rcll/topics/topic.h"

namespace cxlab::rcll {

namespace {

constexpr SimTime kNotTaken = std::chrono::seconds(10);  // after which no machine takes it any more

}  // namespace

Expected<std::unique_ptr<LeagueInstructions>> LeagueInstructions::open(LeagueLink& link) {
  std::unique_ptr<LeagueInstructions> made(new LeagueInstructions(link));
  if (Status s = made->serve(); !s) return s.error();
  return made;
}

Status LeagueInstructions::serve() {
  auto type = bus::needed_action(link_.bus.registry(), std::string(kInterfaces) + "action/InstructMachine");
  if (!type) return type.error();
  type_ = *type;
  auto server =
      link_.bus.serve_action(link_.node, "factory/instruct_machine", *type_,
                             {[this](const bus::Delivery& d) { take(d); },
                              [this](const bus::Delivery& d) {
                                link_.bus.answer_cancel(server_, d, true);
                                link_.bus.finish(server_, d.goal, bus::GoalStatus::kCanceled,
                                                 std::make_shared<const bus::Message>(*type_->result));
                                std::erase_if(pending_, [&](const Pending& one) { return one.goal == d.goal; });
                              }});
  if (!server) return server.error();
  server_ = *server;
  return {};
}

pb::MessagePtr LeagueInstructions::message_for(const bus::MessageView& goal) const {
  const std::string &machine = goal.text("machine"), &operation = goal.text("operation");
  const bool reset = operation == "RESET";
  auto message = link_.make(reset ? "llsf_msgs.ResetMachine" : "llsf_msgs.PrepareMachine");
  Fields prepare(*message);
  prepare.set("team_color", link_.config.team).set("machine", machine);
  if (reset) return message;
  prepare.set("sent_at", link_.moment().sec);
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

void LeagueInstructions::take(const bus::Delivery& delivery) {
  link_.bus.answer_goal(server_, delivery.goal, bus::GoalAnswer::kAccept);
  const bus::MessageView goal = delivery.message->view();
  Pending instruction;
  instruction.goal = delivery.goal;
  instruction.machine = goal.text("machine");
  instruction.since = link_.now;
  instruction.reset = goal.text("operation") == "RESET";
  const auto machine = machines_.find(instruction.machine);
  if (machine == machines_.end())
    return finish(instruction, InstructError::kNoMachine, "no machine '" + instruction.machine + "'");
  if (!instruction.reset && machine->second != "IDLE")
    return finish(instruction, InstructError::kNotReady, instruction.machine + " is " + machine->second);
  const bool delivers = instruction.machine.ends_with("DS") || goal.text("operation") == "STORE";
  instruction.waits_for_piece = !delivers;
  instruction.message = message_for(goal);
  if (!instruction.message->IsInitialized())
    return finish(instruction, InstructError::kInvalid, "a field of the instruction is missing or wrong");
  link_.team().send(*instruction.message);
  if (goal.text("operation") == "CHANGE_INFO") return finish(instruction, InstructError::kNone, "");
  pending_.push_back(std::move(instruction));
}

void LeagueInstructions::take_machines(google::protobuf::Message& machine_info) {
  const Fields info(machine_info);
  machines_.clear();
  for (int i = 0; i < info.size("machines"); ++i)
    machines_[info.item("machines", i).text("name")] = info.item("machines", i).text("state");
  follow();
}

void LeagueInstructions::repeat() {
  for (const Pending& instruction : pending_)
    if (!instruction.at_work) link_.team().send(*instruction.message);
}

void LeagueInstructions::follow() {
  for (Pending& instruction : pending_) {
    const auto known = machines_.find(instruction.machine);
    if (known == machines_.end()) continue;
    const std::string& state = known->second;
    if (state != instruction.reported) {
      instruction.reported = state;
      bus::Message feedback(*type_->feedback);
      feedback->set("state", state);
      link_.bus.publish_feedback(server_, instruction.goal, std::make_shared<const bus::Message>(std::move(feedback)));
    }
    const bool idle = state == "IDLE" || state == "WAIT-IDLE";
    instruction.at_work |= !idle && state != "DOWN";
    const bool ready = instruction.waits_for_piece && state == "READY-AT-OUTPUT";
    if (state == "BROKEN" && instruction.reset)
      finish(instruction, InstructError::kNone, "");
    else if (state == "BROKEN")
      finish(instruction, InstructError::kBroken, instruction.machine + " broke");
    else if (!instruction.reset && (ready || (instruction.at_work && idle)))
      finish(instruction, InstructError::kNone, "");
    else if (!instruction.at_work && link_.now - instruction.since >= kNotTaken && state != "DOWN")
      finish(instruction, InstructError::kNotReady, instruction.machine + " takes no instruction");
    else
      continue;
    instruction.message.reset();
  }
  std::erase_if(pending_, [](const Pending& instruction) { return !instruction.message; });
}

void LeagueInstructions::finish(const Pending& instruction, InstructError code, const std::string& error) {
  const bool done = code == InstructError::kNone;
  bus::Message result(*type_->result);
  result->set("success", done).set("error_code", number_of(code)).set("error", error);
  result->set("target", instruction.machine);
  link_.bus.finish(server_, instruction.goal, done ? bus::GoalStatus::kSucceeded : bus::GoalStatus::kAborted,
                   std::make_shared<const bus::Message>(std::move(result)));
}

}  // namespace cxlab::rcll
