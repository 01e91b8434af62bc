// Action clients of a connection.

#include "cx/plugins/ros_msgs/connection.h"

namespace cxlab::cx {

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

const char* result_word(bus::GoalStatus status) {
  return status > bus::GoalStatus::kCanceling ? status_word(status) : "UNKNOWN";
}

bool BusConnection::open_action_client(Call& call, const std::string& server, const bus::ActionType& type) {
  if (action_clients_.contains(server)) {
    log(LogLevel::kWarn, "Already have an action client for server " + server);
    return false;
  }
  auto endpoint = bus_.create_action_client(
      environment_.participant(), server, type,
      {[this, server](const bus::Delivery& d) { take_goal_response(server, d); },
       [this, server](const bus::Delivery& d) {
         environment_.note_input("feedback", server, d);
         on_feedback(server, handle_of(server, d.goal), store_.receive(d.message, owner_));
       },
       [this, server](const bus::Delivery& d) {
         environment_.note_input("result", server, d);
         on_result(server, d,
                   d.message ? store_.receive(d.message, owner_)
                             : store_.create(*action_clients_.at(server).type->result, owner_));
         action_clients_.at(server).goals.erase(d.goal);
       },
       [this, server](const bus::Delivery& d) {
         environment_.note_input("cancel-response", server, d);
         on_cancel_response(server, d);
       }});
  if (!endpoint) {
    call.fail(endpoint.error().text());
    return false;
  }
  action_clients_[server] = {*endpoint, &type, false, {}};
  return true;
}

bool BusConnection::close_action_client(const std::string& server) {
  return close_one(action_clients_, server, "No action client for server ");
}

BusConnection::ActionClient* BusConnection::action_client(Call& call, std::string_view server) {
  const auto found = action_clients_.find(server);
  if (found != action_clients_.end()) return &found->second;
  call.fail("no action client for server " + std::string(server) + ", it has to be created before");
  return nullptr;
}

void BusConnection::send_goal(Call& call, Handle goal, const std::string& server) {
  const bus::MessageView view = store_.view(goal);
  if (!view) return call.fail("Failed to send goal: invalid message pointer");
  ActionClient* client = action_client(call, server);
  if (!client) return;
  if (&view.type() != client->type->goal)
    return call.fail("found a message of type " + view.type().name() + ", server " + server + " takes " +
                     client->type->goal->name());
  const Value ready =
      environment_.look("action-ready " + server, [&] { return Value::boolean(bus_.action_ready(client->endpoint)); });
  if (!ready.is_true() && !client->waited) {
    log(LogLevel::kWarn, "server " + server + " not available, the goal waits for it");
    client->waited = true;
  }
  bus_.send_goal(client->endpoint, store_.share(goal), engine_.cause());
}

const BusConnection::Goal* BusConnection::find_goal(Handle goal) const {
  const auto found = goals_.find(goal);
  return found == goals_.end() ? nullptr : &found->second;
}

std::string BusConnection::unknown_goal(Handle goal) {
  return std::string("unknown client goal handle") +
         (goal == Handle::kNone ? ": a null pointer, as of a goal that was rejected" : "");
}

void BusConnection::destroy_goal(Handle goal) {
  const auto found = goals_.find(goal);
  if (found == goals_.end()) return;
  bus_.forget_goal(found->second.client, found->second.id);
  goals_.erase(found);
}

void BusConnection::cancel_goal(Call& call, std::string_view server, Handle handle) {
  const Goal* goal = find_goal(handle);
  if (!goal) return call.fail(unknown_goal(handle));
  if (const ActionClient* client = action_client(call, server))
    bus_.cancel_goal(client->endpoint, goal->id, engine_.cause());
}

Handle BusConnection::handle_of(const std::string& server, const bus::GoalId& id) const {
  const auto& goals = action_clients_.at(server).goals;
  const auto found = goals.find(id);
  return found == goals.end() ? Handle::kNone : found->second;
}

void BusConnection::take_goal_response(const std::string& server, const bus::Delivery& delivery) {
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
  on_goal_response(server, handle);
}

}  // namespace cxlab::cx
