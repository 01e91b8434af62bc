// Action clients of the rules, with any type.

#include "cx/plugins/ros_msgs/ros_interface.h"

namespace cxlab::cx {

namespace {

constexpr const char* kCancelResponse = "action_msgs/srv/CancelGoal_Response";

}  // namespace

std::vector<RosInterface::Entry> RosInterface::action_functions(const std::string& owner) {
  using F = FunctionKind;
  using R = RosInterface;
  return {
      {{"ros-msgs-create-action-client", "v", 2, 2, ";sy;sy", F::kActing, owner, "Opens a client of an action server."},
       &R::create_action_client},
      {{"ros-msgs-destroy-action-client", "v", 1, 1, ";sy", F::kActing, owner, "Closes an action client."},
       &R::destroy_action_client},
      {{"ros-msgs-create-goal-request", "e", 1, 1, ";sy", F::kActing, owner, "A new goal of an action type."},
       &R::create_goal},
      {{"ros-msgs-async-send-goal", "v", 2, 2, ";e;sy", F::kActing, owner,
        "Sends a goal; it waits until the server is there."},
       &R::send_goal},
      {{"ros-msgs-async-cancel-goal", "v", 2, 2, ";sy;e", F::kActing, owner, "Asks the server to cancel a goal."},
       &R::cancel_goal},
      {{"ros-msgs-destroy-client-goal-handle", "v", 1, 1, ";e", F::kActing, owner, "Drops a goal handle."},
       &R::destroy_goal_handle},
      {{"ros-msgs-client-goal-handle-get-goal-id", "y", 1, 1, ";e", F::kPure, owner, "The goal's id, 32 hex digits."},
       &R::goal_id},
      {{"ros-msgs-client-goal-handle-get-goal-stamp", "d", 1, 1, ";e", F::kPure, owner,
        "When the goal was accepted, in seconds."},
       &R::goal_stamp},
      {{"ros-msgs-client-goal-handle-get-status", "y", 1, 1, ";e", F::kPure, owner,
        "UNKNOWN, ACCEPTED, EXECUTING, CANCELING, SUCCEEDED, CANCELED or ABORTED."},
       &R::goal_status},
      {{"ros-msgs-client-goal-handle-is-feedback-aware", "b", 1, 1, ";e", F::kPure, owner,
        "Whether feedback becomes facts."},
       &R::is_aware},
      {{"ros-msgs-client-goal-handle-is-result-aware", "b", 1, 1, ";e", F::kPure, owner,
        "Whether the result becomes a fact."},
       &R::is_aware},
      {{"ros-msgs-goal-uuid-to-string", "y", 1, 1, ";m", F::kPure, owner, "16 integers as 32 hex digits."},
       &R::uuid_to_string},
  };
}

void RosInterface::create_action_client(Call& call) {
  const std::string server(call.text(0)), name(call.text(1));
  auto type = bus_.registry().action(name);
  if (!type) return call.fail(type.error().text());
  // Answers to cancels are messages, too: their type must be there before the first one comes.
  if (auto cancel = bus_.registry().message(kCancelResponse); !cancel) return call.fail(cancel.error().text());
  if (open_action_client(call, server, **type))
    put("ros-msgs-action-client", {{"server", Value::string(server)}, {"type", Value::string(name)}});
}

void RosInterface::destroy_action_client(Call& call) {
  const std::string server(call.text(0));
  if (close_action_client(server)) take_back("ros-msgs-action-client", "server", server);
}

void RosInterface::create_goal(Call& call) {
  auto type = bus_.registry().action(std::string(call.text(0)));
  if (!type) return call.fail(type.error().text());
  call.give_handle(store_.create(*(*type)->goal, owner_));
}

void RosInterface::send_goal(Call& call) { BusConnection::send_goal(call, call.handle(0), std::string(call.text(1))); }
void RosInterface::cancel_goal(Call& call) { BusConnection::cancel_goal(call, call.text(0), call.handle(1)); }
void RosInterface::destroy_goal_handle(Call& call) { destroy_goal(call.handle(0)); }

const BusConnection::Goal* RosInterface::goal_of(Call& call) {
  const Goal* goal = find_goal(call.handle(0));
  if (!goal) call.fail(unknown_goal(call.handle(0)));
  return goal;
}

void RosInterface::goal_id(Call& call) {
  if (const Goal* goal = goal_of(call)) call.give_symbol(bus::to_string(goal->id));
}

void RosInterface::goal_stamp(Call& call) {
  if (const Goal* goal = goal_of(call)) call.give_number(to_seconds(goal->stamp));
}

void RosInterface::goal_status(Call& call) {
  if (const Goal* goal = goal_of(call)) call.give_symbol(status_word(bus_.goal_status(goal->client, goal->id)));
}

void RosInterface::is_aware(Call& call) {
  if (goal_of(call)) call.give_boolean(true);
}

void RosInterface::uuid_to_string(Call& call) {
  const ValueRef& bytes = call.arg(0);
  bus::GoalId id{};
  bool fits = bytes.size() == id.size();
  for (std::size_t i = 0; fits && i < id.size(); ++i) {
    fits = bytes[i].is(ValueType::kInteger) && bytes[i].as_integer() >= 0 && bytes[i].as_integer() <= 255;
    if (fits) id[i] = static_cast<std::uint8_t>(bytes[i].as_integer());
  }
  if (fits) return call.give_symbol(bus::to_string(id));
  call.complain("found " + bytes.copy().print() + ", expected 16 integers from 0 to 255");
  call.give_boolean(false);
}

void RosInterface::on_goal_response(const std::string& server, Handle goal) {
  put("ros-msgs-goal-response", {{"server", Value::string(server)}, {"client-goal-handle-ptr", Value::handle(goal)}});
}

void RosInterface::on_feedback(const std::string& server, Handle goal, Handle feedback) {
  put("ros-msgs-feedback", {{"server", Value::string(server)},
                            {"client-goal-handle-ptr", Value::handle(goal)},
                            {"feedback-ptr", Value::handle(feedback)}});
}

void RosInterface::on_result(const std::string& server, const bus::Delivery& end, Handle result) {
  put("ros-msgs-wrapped-result", {{"server", Value::string(server)},
                                  {"goal-id", Value::symbol(bus::to_string(end.goal))},
                                  {"code", Value::symbol(result_word(end.status))},
                                  {"result-ptr", Value::handle(result)}});
}

void RosInterface::on_cancel_response(const std::string& server, const bus::Delivery& delivery) {
  auto type = bus_.registry().message(kCancelResponse);
  const Handle response = store_.create(**type, owner_);
  const bus::MessageView view = store_.writable(response);
  view.set("return_code", static_cast<std::int64_t>(delivery.return_code));
  for (const auto& [id, stamp] : delivery.goals_canceling) {
    const bus::MessageView info = view.append("goals_canceling");
    const bus::MessageView uuid = info.nested("goal_id");
    const bus::Field& bytes = *uuid.type().find("uuid");
    for (std::size_t i = 0; i < id.size(); ++i) (void)uuid.set_integer(bytes, id[i], i);
    const std::int64_t ns = stamp.count();
    info.nested("stamp").set("sec", ns / 1'000'000'000).set("nanosec", ns % 1'000'000'000);
  }
  put("ros-msgs-cancel-response", {{"server", Value::string(server)},
                                   {"client-goal-handle-ptr", Value::handle(handle_of(server, delivery.goal))},
                                   {"cancel-response-ptr", Value::handle(response)}});
}

}  // namespace cxlab::cx
