// Clients of actions.

#include <array>

#include "cx/plugins/ros_msgs/ros_interface.h"

namespace cxlab::cx {

namespace {

constexpr const char* kCancelResponse = "action_msgs/srv/CancelGoal_Response";

const char* status_word(bus::GoalStatus status) {
  switch (status) {
    case bus::GoalStatus::kUnknown: break;
    case bus::GoalStatus::kAccepted: return "ACCEPTED";
    case bus::GoalStatus::kExecuting: return "EXECUTING";
    case bus::GoalStatus::kCanceling: return "CANCELING";
    case bus::GoalStatus::kSucceeded: return "SUCCEEDED";
    case bus::GoalStatus::kCanceled: return "CANCELED";
    case bus::GoalStatus::kAborted: return "ABORTED";
  }
  return "UNKNOWN";
}

}  // namespace

std::vector<RosInterface::Entry> RosInterface::action_functions(const std::string& owner) {
  using F = FunctionKind;
  return {
      {{"ros-msgs-create-action-client", "v", 2, 2, ";sy;sy", F::kActing, owner, "Opens a client of an action server."}, &RosInterface::create_action_client},
      {{"ros-msgs-destroy-action-client", "v", 1, 1, ";sy", F::kActing, owner, "Closes an action client."}, &RosInterface::destroy_action_client},
      {{"ros-msgs-create-goal-request", "e", 1, 1, ";sy", F::kActing, owner, "A new goal of an action type."}, &RosInterface::create_goal},
      {{"ros-msgs-async-send-goal", "v", 2, 2, ";e;sy", F::kActing, owner, "Sends a goal; it waits until the server is there."}, &RosInterface::send_goal},
      {{"ros-msgs-async-cancel-goal", "v", 2, 2, ";sy;e", F::kActing, owner, "Asks the server to cancel a goal."}, &RosInterface::cancel_goal},
      {{"ros-msgs-destroy-client-goal-handle", "v", 1, 1, ";e", F::kActing, owner, "Drops a goal handle."}, &RosInterface::destroy_goal_handle},
      {{"ros-msgs-client-goal-handle-get-goal-id", "y", 1, 1, ";e", F::kPure, owner, "The goal's id, 32 hex digits."}, &RosInterface::goal_id},
      {{"ros-msgs-client-goal-handle-get-goal-stamp", "d", 1, 1, ";e", F::kPure, owner, "When the goal was accepted, in seconds."}, &RosInterface::goal_stamp},
      {{"ros-msgs-client-goal-handle-get-status", "y", 1, 1, ";e", F::kPure, owner, "UNKNOWN, ACCEPTED, EXECUTING, CANCELING, SUCCEEDED, CANCELED or ABORTED."}, &RosInterface::goal_status},
      {{"ros-msgs-client-goal-handle-is-feedback-aware", "b", 1, 1, ";e", F::kPure, owner, "Whether feedback becomes facts."}, &RosInterface::is_aware},
      {{"ros-msgs-client-goal-handle-is-result-aware", "b", 1, 1, ";e", F::kPure, owner, "Whether the result becomes a fact."}, &RosInterface::is_aware},
      {{"ros-msgs-goal-uuid-to-string", "y", 1, 1, ";m", F::kPure, owner, "16 integers as 32 hex digits."}, &RosInterface::uuid_to_string},
  };
}

void RosInterface::create_action_client(Call& call) {
  const std::string server(call.text(0)), type_name(call.text(1));
  if (action_clients_.contains(server)) return log(LogLevel::kWarn, "Already have an action client for server " + server);
  auto type = bus_.registry().action(type_name);
  if (!type) return call.fail(type.error().text());
  // Answers to cancels are messages, too: their type must be there before the first one comes.
  if (auto cancel = bus_.registry().message(kCancelResponse); !cancel) return call.fail(cancel.error().text());
  auto endpoint = bus_.create_action_client(
      environment_.participant(), server, **type,
      {[this, server](const bus::Delivery& d) { take_goal_response(server, d); },
       [this, server](const bus::Delivery& d) { take_feedback(server, d); },
       [this, server](const bus::Delivery& d) { take_result(server, d); },
       [this, server](const bus::Delivery& d) { take_cancel_response(server, d); }});
  if (!endpoint) return call.fail(endpoint.error().text());
  action_clients_[server] = {*endpoint, *type, false, {}};
  put("ros-msgs-action-client", {{"server", Value::string(server)}, {"type", Value::string(type_name)}});
}

void RosInterface::destroy_action_client(Call& call) {
  const std::string server(call.text(0));
  const auto found = action_clients_.find(server);
  if (found == action_clients_.end()) return log(LogLevel::kWarn, "No action client for server " + server);
  bus_.remove(found->second.endpoint);
  action_clients_.erase(found);
  take_back("ros-msgs-action-client", "server", server);
}

void RosInterface::create_goal(Call& call) {
  auto type = bus_.registry().action(std::string(call.text(0)));
  if (!type) return call.fail(type.error().text());
  call.give_handle(store_.create(*(*type)->goal));
}

void RosInterface::send_goal(Call& call) {
  const std::string server(call.text(1));
  const bus::MessageView view = store_.view(call.handle(0));
  if (!view) return call.fail("Failed to send goal: invalid message pointer");
  const auto found = action_clients_.find(server);
  if (found == action_clients_.end()) return call.fail("no action client for server " + server + ": call ros-msgs-create-action-client before");
  ActionClient& client = found->second;
  if (&view.type() != client.type->goal)
    return call.fail("found a message of type " + view.type().name() + ", server " + server + " takes " + client.type->goal->name());
  const Value ready = environment_.look("action-ready " + server, [&] { return Value::boolean(bus_.action_ready(client.endpoint)); });
  if (!ready.is_true() && !client.waited) {
    log(LogLevel::kWarn, "server " + server + " not available, the goal waits for it");
    client.waited = true;
  }
  bus_.send_goal(client.endpoint, store_.share(call.handle(0)), engine_.cause());
}

const RosInterface::Goal* RosInterface::find_goal(Call& call, std::size_t arg) {
  const auto found = goals_.find(call.handle(arg));
  if (found != goals_.end()) return &found->second;
  call.fail("unknown client goal handle");
  return nullptr;
}

void RosInterface::cancel_goal(Call& call) {
  const Goal* goal = find_goal(call, 1);
  if (!goal) return;
  const auto client = action_clients_.find(call.text(0));
  if (client == action_clients_.end()) return call.fail("no action client for server " + std::string(call.text(0)));
  bus_.cancel_goal(client->second.endpoint, goal->id, engine_.cause());
}

void RosInterface::destroy_goal_handle(Call& call) { goals_.erase(call.handle(0)); }

void RosInterface::goal_id(Call& call) {
  if (const Goal* goal = find_goal(call, 0)) call.give_symbol(bus::to_string(goal->id));
}

void RosInterface::goal_stamp(Call& call) {
  if (const Goal* goal = find_goal(call, 0)) call.give_number(to_seconds(goal->stamp));
}

void RosInterface::goal_status(Call& call) {
  if (const Goal* goal = find_goal(call, 0)) call.give_symbol(status_word(bus_.goal_status(goal->client, goal->id)));
}

void RosInterface::is_aware(Call& call) {
  if (find_goal(call, 0)) call.give_boolean(true);
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
  log(LogLevel::kError, "ros-msgs-goal-uuid-to-string: found " + bytes.copy().print() + ", expected 16 integers from 0 to 255");
  call.give_boolean(false);
}

Handle RosInterface::handle_of(const std::string& server, const bus::GoalId& id) const {
  const auto& goals = action_clients_.at(server).goals;
  const auto found = goals.find(id);
  return found == goals.end() ? Handle::kNone : found->second;
}

void RosInterface::take_goal_response(const std::string& server, const bus::Delivery& delivery) {
  environment_.note_input("goal-response", server, delivery);
  ActionClient& client = action_clients_.at(server);
  if (client.waited) log(LogLevel::kInfo, "server " + server + " is finally reachable");
  client.waited = false;
  Handle handle = Handle::kNone;  // of a rejected goal, as in CX
  if (delivery.accepted) {
    handle = engine_.new_handle();
    client.goals[delivery.goal] = handle;
    goals_[handle] = {client.endpoint, server, delivery.goal, delivery.stamp};
  }
  put("ros-msgs-goal-response", {{"server", Value::string(server)}, {"client-goal-handle-ptr", Value::handle(handle)}});
}

void RosInterface::take_feedback(const std::string& server, const bus::Delivery& delivery) {
  environment_.note_input("feedback", server, delivery);
  put("ros-msgs-feedback", {{"server", Value::string(server)},
                            {"client-goal-handle-ptr", Value::handle(handle_of(server, delivery.goal))},
                            {"feedback-ptr", Value::handle(store_.receive(delivery.message))}});
}

void RosInterface::take_result(const std::string& server, const bus::Delivery& delivery) {
  environment_.note_input("result", server, delivery);
  const bool ended = delivery.status == bus::GoalStatus::kSucceeded || delivery.status == bus::GoalStatus::kCanceled ||
                     delivery.status == bus::GoalStatus::kAborted;
  const Handle result = delivery.message ? store_.receive(delivery.message) : store_.create(*action_clients_.at(server).type->result);
  put("ros-msgs-wrapped-result", {{"server", Value::string(server)},
                                  {"goal-id", Value::symbol(bus::to_string(delivery.goal))},
                                  {"code", Value::symbol(ended ? status_word(delivery.status) : "UNKNOWN")},
                                  {"result-ptr", Value::handle(result)}});
  action_clients_.at(server).goals.erase(delivery.goal);
}

void RosInterface::take_cancel_response(const std::string& server, const bus::Delivery& delivery) {
  environment_.note_input("cancel-response", server, delivery);
  auto type = bus_.registry().message(kCancelResponse);
  const Handle response = store_.create(**type);
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
