// Bindings of actions. Their clients are those of the generic plugin, their servers are here.

#include <vector>

#include "cx/plugins/bindings/binding.h"

namespace cxlab::cx {

namespace {

constexpr std::int64_t kReject = 1, kAccept = 2;  // of both callbacks; a goal may also be deferred, 3

const char* cancel_word(std::int8_t code) {
  switch (code) {
    case 0: return "ERROR_NONE";
    case 1: return "ERROR_REJECTED";
    case 2: return "ERROR_UNKNOWN_GOAL_ID";
    case 3: return "ERROR_GOAL_TERMINATED";
    default: return "ERROR_UNKNOWN";
  }
}

}  // namespace

void ActionBinding::add_all() {
  using F = FunctionKind;
  add_fields("goal", "goal-create", "goal-destroy", "goal-", *type_.goal);
  add_fields("result", "result-create", "result-destroy", "result-", *type_.result);
  add_fields("feedback", "feedback-create", "feedback-destroy", "feedback-", *type_.feedback);
  add_action_clients(&type_);
  define("cancel-goal-response",
         "(slot server (type STRING)) (slot return-code (type SYMBOL) (allowed-values ERROR_NONE ERROR_REJECTED "
         "ERROR_UNKNOWN_GOAL_ID ERROR_GOAL_TERMINATED ERROR_UNKNOWN)) (slot num-goals (type INTEGER))");
  define("cancel-goal-entry", "(slot server (type STRING)) (slot goal-id (type STRING)) (slot stamp (type FLOAT))");
  add("client-cancel-all-goals", "v", ";sy", F::kActing, "Asks the server to cancel all its goals.",
      [this](Call& call) {
        if (const ActionClient* client = action_client(call, call.text(0)))
          bus_.cancel_all_goals(client->endpoint, engine_.cause());
      });
  add("client-cancel-goals-before", "v", ";sy;ld", F::kActing,
      "Asks the server to cancel the goals accepted until then (s).", [this](Call& call) {
        if (const ActionClient* client = action_client(call, call.text(0)))
          bus_.cancel_goals_before(client->endpoint, from_seconds(call.number(1)), engine_.cause());
      });
  add_server();
}

void ActionBinding::close(Leftovers& left) {
  close_all(servers_, "server", left);
  const std::size_t served = served_.size();
  for (const auto& [handle, goal] : served_) store_.destroy(goal.goal);
  served_.clear();
  Binding::close(left);
  left.add("server_goal_handle(s)", served);
}

void ActionBinding::on_cancel_response(const std::string& server, const bus::Delivery& response) {
  put(named("cancel-goal-response"),
      {{"server", Value::string(server)},
       {"return-code", Value::symbol(cancel_word(response.return_code))},
       {"num-goals", Value::integer(static_cast<std::int64_t>(response.goals_canceling.size()))}});
  for (const auto& [id, stamp] : response.goals_canceling)
    put(named("cancel-goal-entry"), {{"server", Value::string(server)},
                                     {"goal-id", Value::string(bus::to_string(id))},
                                     {"stamp", Value::number(to_seconds(stamp))}});
}

// --- The server

void ActionBinding::add_server() {
  using F = FunctionKind;
  using S = bus::GoalStatus;
  define("server", "(slot name (type STRING))");
  define("accepted-goal", "(slot server (type STRING)) (slot server-goal-handle-ptr (type EXTERNAL-ADDRESS))");
  add("create-server", "v", ";sy", F::kActing, "Serves the action.", [this](Call& call) { create_server(call); });
  add("destroy-server", "v", ";sy", F::kActing, "Ends the server.", [this](Call& call) { destroy_server(call); });
  add("server-goal-handle-succeed", "v", ";e;e", F::kActing, "Ends a goal with a result.",
      [this](Call& call) { end_goal(call, S::kSucceeded); });
  add("server-goal-handle-abort", "v", ";e;e", F::kActing, "Ends a goal that has failed.",
      [this](Call& call) { end_goal(call, S::kAborted); });
  add("server-goal-handle-canceled", "v", ";e;e", F::kActing, "Ends a goal that was to be cancelled.",
      [this](Call& call) { end_goal(call, S::kCanceled); });
  add("server-goal-handle-get-goal", "e", ";e", F::kActing, "The goal's message.", [this](Call& call) {
    ServedGoal* goal = served(call);
    call.give_handle(goal ? goal_message(*goal) : Handle::kNone);
  });
  add("server-goal-handle-get-goal-id", "s", ";e", F::kPure, "The goal's id, 32 hex digits.", [this](Call& call) {
    const ServedGoal* goal = served(call);
    call.give_string(goal ? bus::to_string(goal->id) : std::string());
  });
  const auto asks = [&](const char* suffix, const char* doc, bool (*holds)(S)) {
    add(suffix, "b", ";e", F::kPure, doc, [this, holds](Call& call) {
      const ServedGoal* goal = served(call);
      call.give_boolean(goal && holds(bus_.server_goal_status(goal->endpoint, goal->id)));
    });
  };
  asks("server-goal-handle-is-canceling", "Whether the client wants the goal cancelled.",
       [](S s) { return s == S::kCanceling; });
  asks("server-goal-handle-is-executing", "Whether the goal is executing.", [](S s) { return s == S::kExecuting; });
  asks("server-goal-handle-is-active", "Whether the goal has not ended.",
       [](S s) { return s == S::kAccepted || s == S::kExecuting || s == S::kCanceling; });
  add("server-goal-handle-execute", "v", ";e", F::kActing, "Begins a deferred goal.", [this](Call& call) {
    const ServedGoal* goal = served(call);
    if (goal && !bus_.execute(goal->endpoint, goal->id)) fail_state(call, *goal, "ACCEPTED");
  });
  add("server-goal-handle-publish-feedback", "v", ";e;e", F::kActing, "Tells the client how far the goal is.",
      [this](Call& call) {
        const ServedGoal* goal = served(call);
        if (!goal || !has_message(call, *type_.feedback)) return;
        if (!bus_.publish_feedback(goal->endpoint, goal->id, store_.share(call.handle(1))))
          fail_state(call, *goal, "one that has not ended");
      });
  add("server-goal-handle-destroy", "d", ";e", F::kActing, "Drops a goal handle.",
      [this](Call& call) { destroy_served(call); });
}

void ActionBinding::fail_state(Call& call, const ServedGoal& goal, const char* expected) {
  call.fail(std::string("the goal is ") + status_word(bus_.server_goal_status(goal.endpoint, goal.id)) + ", expected " +
            expected);
}

bool ActionBinding::has_message(Call& call, const bus::MessageType& type) {
  const bus::MessageView view = store_.view(call.handle(1));
  if (view && &view.type() == &type) return true;
  call.fail(view ? found_expected("a message of type " + view.type().name(), type.name()) : "invalid message pointer");
  return false;
}

void ActionBinding::create_server(Call& call) {
  const std::string server(call.text(0));
  if (servers_.contains(server)) return log(LogLevel::kWarn, "Already providing action server " + server);
  auto endpoint = bus_.serve_action(environment_.participant(), server, type_,
                                    {[this, server](const bus::Delivery& d) { take_goal(server, d); },
                                     [this, server](const bus::Delivery& d) { take_cancel(server, d); }});
  if (!endpoint) return call.fail(endpoint.error().text());
  servers_[server].endpoint = *endpoint;
  put(named("server"), {{"name", Value::string(server)}});
}

void ActionBinding::destroy_server(Call& call) {
  const std::string server(call.text(0));
  const auto found = servers_.find(server);
  if (found == servers_.end())
    return log(LogLevel::kWarn, "Action server " + server + " not found in environment " + environment_.name());
  const bus::EndpointId endpoint = found->second.endpoint;
  servers_.erase(found);
  take_back("server", "name", server);
  for (const auto& [handle, goal] : served_)
    if (goal.endpoint == endpoint) abort_unended(goal, LogLevel::kInfo, "its server was destroyed");
  if (endpoint != answering_) bus_.remove(endpoint);  // else whoever asks the callback removes it, after the answer
}

bool ActionBinding::is_open(const std::string& server, bus::EndpointId endpoint) const {
  const auto found = servers_.find(server);
  return found != servers_.end() && found->second.endpoint == endpoint;
}

void ActionBinding::abort_unended(const ServedGoal& goal, LogLevel level, const char* why) {
  bus_.execute(goal.endpoint, goal.id);
  if (bus_.finish(goal.endpoint, goal.id, bus::GoalStatus::kAborted, std::make_shared<bus::Message>(*type_.result)))
    log(level,
        "goal " + bus::to_string(goal.id) + " of server " + goal.server + " is aborted: " + why + " before its end");
}

std::int64_t ActionBinding::ask(const std::string& callback, std::initializer_list<Value> args, std::int64_t most) {
  if (!engine_.callable(callback)) {
    log(LogLevel::kDebug, callback + " not defined, accept");
    return kAccept;
  }
  const std::vector<Value> list(args);
  const auto said = engine_.call(callback, list);
  if (!said) return kReject;  // the error is in the engine's next report
  const bool known = said->is(ValueType::kInteger) && said->as_integer() >= kReject && said->as_integer() <= most;
  if (known) return said->as_integer();
  log(LogLevel::kError, callback + " returned " + said->print() + ", expected an INTEGER from 1 to " +
                            std::to_string(most) + ": rejected");
  return kReject;
}

void ActionBinding::take_goal(const std::string& server, const bus::Delivery& delivery) {
  environment_.note_input("goal", server, delivery);
  const Handle message = store_.receive(delivery.message, owner_);
  answering_ = delivery.endpoint;
  const std::int64_t answer =
      ask(named("handle-goal-callback"),
          {Value::string(server), Value::handle(message), Value::string(bus::to_string(delivery.goal))}, 3);
  answering_.reset();
  bus_.answer_goal(delivery.endpoint, delivery.goal, static_cast<bus::GoalAnswer>(answer));
  const ServedGoal goal{server, delivery.endpoint, delivery.goal, delivery.message, message};
  const bool open = is_open(server, delivery.endpoint);
  if (!open) {
    abort_unended(goal, LogLevel::kInfo, "its server was destroyed");
    bus_.remove(delivery.endpoint);
  }
  if (answer == kReject || !open) {
    store_.destroy(message);
    return;
  }
  const Handle handle = engine_.new_handle();
  servers_.at(server).goals[delivery.goal] = handle;
  served_[handle] = goal;
  put(named("accepted-goal"), {{"server", Value::string(server)}, {"server-goal-handle-ptr", Value::handle(handle)}});
}

void ActionBinding::take_cancel(const std::string& server, const bus::Delivery& delivery) {
  environment_.note_input("cancel", server, delivery);
  const auto& goals = servers_.at(server).goals;
  const auto found = goals.find(delivery.goal);
  answering_ = delivery.endpoint;
  const std::int64_t answer = found == goals.end()
                                  ? kReject
                                  : ask(named("cancel-goal-callback"),
                                        {Value::string(server), Value::handle(goal_message(served_.at(found->second))),
                                         Value::handle(found->second)},
                                        2);
  answering_.reset();
  bus_.answer_cancel(delivery.endpoint, delivery, answer == kAccept);
  if (!is_open(server, delivery.endpoint)) bus_.remove(delivery.endpoint);
}

ActionBinding::ServedGoal* ActionBinding::served(Call& call) {
  const auto found = served_.find(call.handle(0));
  if (found != served_.end()) return &found->second;
  unknown_handle(call, "server goal handle");
  return nullptr;
}

Handle ActionBinding::goal_message(ServedGoal& goal) {
  if (!store_.view(goal.goal)) goal.goal = store_.receive(goal.message, owner_);
  return goal.goal;
}

void ActionBinding::end_goal(Call& call, bus::GoalStatus status) {
  const ServedGoal* goal = served(call);
  if (!goal || !has_message(call, *type_.result)) return;
  if (!bus_.finish(goal->endpoint, goal->id, status, store_.share(call.handle(1))))
    fail_state(call, *goal, status == bus::GoalStatus::kCanceled ? "CANCELING" : "EXECUTING or CANCELING");
}

void ActionBinding::destroy_served(Call& call) {
  const auto found = served_.find(call.handle(0));
  if (found == served_.end()) return;
  const ServedGoal goal = found->second;
  served_.erase(found);
  if (const auto open = servers_.find(goal.server); open != servers_.end()) open->second.goals.erase(goal.id);
  store_.destroy(goal.goal);
  abort_unended(goal, LogLevel::kWarn, "its handle was destroyed");
}

}  // namespace cxlab::cx
