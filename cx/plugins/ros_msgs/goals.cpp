// Action clients of a connection.

#include "cx/plugins/ros_msgs/connection.h"

#include "cx/bus/needed.h"

namespace cxlab::cx {

const char* status_word(bus::GoalStatus status) {
  static constexpr const char* kWords[] = {"UNKNOWN",   "ACCEPTED", "EXECUTING", "CANCELING",
                                           "SUCCEEDED", "CANCELED", "ABORTED"};
  return kWords[static_cast<std::size_t>(status)];
}

void BusConnection::add_action_clients(const bus::ActionType* bound) {
  using F = FunctionKind;
  const char* client = bound ? "client" : "action-client";
  const char* id_type = bound ? "STRING" : "SYMBOL";
  const std::string server = "(slot server (type STRING)) ",
                    handle = server + "(slot client-goal-handle-ptr (type EXTERNAL-ADDRESS))";
  define(client, opened_slots("server"));
  define("goal-response", handle);
  define("wrapped-result", server + "(slot goal-id (type " + id_type +
                               ")) (slot code (type SYMBOL) (allowed-values UNKNOWN SUCCEEDED CANCELED ABORTED)) "
                               "(slot result-ptr (type EXTERNAL-ADDRESS))");
  define(bound ? "goal-feedback" : "feedback", handle + " (slot feedback-ptr (type EXTERNAL-ADDRESS))");

  add(std::string("create-") + client, "v", bound ? ";s" : ";sy;sy", F::kActing, "Opens a client of an action server.",
      [this, bound, client](Call& call) {
        const auto* type = bound ? bound : known(call, bus_.registry().action(std::string(call.text(1))));
        if (!type) return;
        // Answers to cancels are messages, too: their type must be there before the first one comes.
        if (!bound && !known(call, bus::needed_message(bus_.registry(), "action_msgs/srv/CancelGoal_Response"))) return;
        const auto make = [&](const std::string& name) {
          return bus_.create_action_client(environment_.participant(), name, *type,
                                           {[this, name](const bus::Delivery& d) { take_goal_response(name, d); },
                                            [this, name](const bus::Delivery& d) { take_feedback(name, d); },
                                            [this, name](const bus::Delivery& d) { take_result(name, d); },
                                            [this, name](const bus::Delivery& d) {
                                              environment_.note_input("cancel-response", name, d);
                                              on_cancel_response(name, d);
                                            }});
        };
        if (auto* made =
                open(call, action_clients_, client, "server", "Already registered to action client for ", make))
          made->type = type;
      });
  add(std::string("destroy-") + client, "v", bound ? ";s" : ";sy", F::kActing, "Closes an action client.",
      [this, client](Call& call) {
        const std::string name(call.text(0));
        if (close_one(action_clients_, name, "Action client")) take_back(client, "server", name);
      });
  add(bound ? "send-goal" : "async-send-goal", "v", ";e;sy", F::kActing,
      "Sends a goal; it waits until the server is there.", [this](Call& call) { send_goal(call); });
  add(bound ? "client-cancel-goal" : "async-cancel-goal", "v", ";sy;e", F::kActing, "Asks the server to cancel a goal.",
      [this](Call& call) { cancel_goal(call); });
  add("client-goal-handle-get-goal-id", bound ? "s" : "y", ";e", F::kPure, "The goal's id, 32 hex digits.",
      [this](Call& call) {
        const Goal* goal = goal_of(call);
        if (bound_)
          call.give_string(goal ? bus::to_string(goal->id) : std::string());
        else if (goal)
          call.give_symbol(bus::to_string(goal->id));
      });
  add("client-goal-handle-get-goal-stamp", "d", ";e", F::kPure, "When the goal was accepted, in seconds.",
      [this](Call& call) {
        const Goal* goal = goal_of(call);
        if (goal || bound_) call.give_number(goal ? to_seconds(goal->stamp) : 0.0);
      });
  add("client-goal-handle-get-status", bound ? "l" : "y", ";e", F::kPure,
      bound ? "0 unknown, 1 accepted, 2 executing, 3 canceling, 4 succeeded, 5 canceled, 6 aborted."
            : "UNKNOWN, ACCEPTED, EXECUTING, CANCELING, SUCCEEDED, CANCELED or ABORTED.",
      [this](Call& call) {
        const Goal* goal = goal_of(call);
        const auto status = goal ? bus_.goal_status(goal->client, goal->id) : bus::GoalStatus::kUnknown;
        if (bound_)
          call.give_integer(static_cast<std::int64_t>(status));
        else if (goal)
          call.give_symbol(status_word(status));
      });
  const auto aware = [this](Call& call) {
    const Goal* goal = goal_of(call);
    if (goal || bound_) call.give_boolean(goal != nullptr);
  };
  add("client-goal-handle-is-feedback-aware", "b", ";e", F::kPure, "Whether feedback becomes facts.", aware);
  add("client-goal-handle-is-result-aware", "b", ";e", F::kPure, "Whether the result becomes a fact.", aware);
  add(bound ? "client-goal-handle-destroy" : "destroy-client-goal-handle", bound ? "d" : "v", ";e", F::kActing,
      "Drops a goal handle.", [this](Call& call) {
        const auto found = goals_.find(call.handle(0));
        if (found == goals_.end()) return;
        bus_.forget_goal(found->second.client, found->second.id);
        goals_.erase(found);
      });
}

BusConnection::ActionClient* BusConnection::action_client(Call& call, std::string_view server) {
  const auto found = action_clients_.find(server);
  if (found != action_clients_.end()) return &found->second;
  call.fail("no action client for server " + std::string(server) + ", it has to be created before");
  return nullptr;
}

void BusConnection::send_goal(Call& call) {
  const std::string server(call.text(1));
  const bus::MessageView view = store_.view(call.handle(0));
  if (!view) return call.fail("Failed to send goal: invalid message pointer");
  ActionClient* client = action_client(call, server);
  if (!client) return;
  if (&view.type() != client->type->goal)
    return call.fail(wrong_type(view, "server " + server + " takes", *client->type->goal));
  const Value ready =
      environment_.look("action-ready " + server, [&] { return Value::boolean(bus_.action_ready(client->endpoint)); });
  if (!ready.is_true()) wait(client->waiting);
  bus_.send_goal(client->endpoint, store_.share(call.handle(0)), engine_.cause());
}

namespace {

std::string unknown_goal(Handle goal) {
  return std::string("unknown client goal handle") +
         (goal == Handle::kNone ? ": a null pointer, as of a goal that was rejected" : "");
}

}  // namespace

void BusConnection::cancel_goal(Call& call) {
  const auto goal = goals_.find(call.handle(1));
  if (goal == goals_.end()) return call.fail(unknown_goal(call.handle(1)));
  if (const ActionClient* client = action_client(call, call.text(0)))
    bus_.cancel_goal(client->endpoint, goal->second.id, engine_.cause());
}

const BusConnection::Goal* BusConnection::goal_of(Call& call) {
  const auto found = goals_.find(call.handle(0));
  if (found != goals_.end()) return &found->second;
  if (bound_)
    unknown_handle(call, "client goal handle");
  else
    call.fail(unknown_goal(call.handle(0)));
  return nullptr;
}

Handle BusConnection::handle_of(const std::string& server, const bus::GoalId& id) const {
  const auto& goals = action_clients_.at(server).goals;
  const auto found = goals.find(id);
  return found == goals.end() ? Handle::kNone : found->second;
}

void BusConnection::take_goal_response(const std::string& server, const bus::Delivery& delivery) {
  environment_.note_input("goal-response", server, delivery);
  ActionClient& client = action_clients_.at(server);
  reached(client.waiting, "server " + server);
  Handle handle = Handle::kNone;  // of a rejected goal, as in CX
  if (delivery.accepted) {
    handle = engine_.new_handle();
    client.goals[delivery.goal] = handle;
    goals_[handle] = {client.endpoint, delivery.goal, delivery.stamp};
  }
  put(named("goal-response"), {{"server", Value::string(server)}, {"client-goal-handle-ptr", Value::handle(handle)}});
}

void BusConnection::take_feedback(const std::string& server, const bus::Delivery& delivery) {
  environment_.note_input("feedback", server, delivery);
  put(named(bound_ ? "goal-feedback" : "feedback"),
      {{"server", Value::string(server)},
       {"client-goal-handle-ptr", Value::handle(handle_of(server, delivery.goal))},
       {"feedback-ptr", Value::handle(store_.receive(delivery.message, owner_))}});
}

void BusConnection::take_result(const std::string& server, const bus::Delivery& delivery) {
  environment_.note_input("result", server, delivery);
  ActionClient& client = action_clients_.at(server);
  const std::string id = bus::to_string(delivery.goal);
  const Handle result =
      delivery.message ? store_.receive(delivery.message, owner_) : store_.create(*client.type->result, owner_);
  const bool ended = delivery.status > bus::GoalStatus::kCanceling;
  put(named("wrapped-result"), {{"server", Value::string(server)},
                                {"goal-id", bound_ ? Value::string(id) : Value::symbol(id)},
                                {"code", Value::symbol(ended ? status_word(delivery.status) : "UNKNOWN")},
                                {"result-ptr", Value::handle(result)}});
  client.goals.erase(delivery.goal);
}

}  // namespace cxlab::cx
