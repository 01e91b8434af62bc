// Bindings of actions: what both sides share, and the client.

#include "cx/plugins/bindings/binding.h"

namespace cxlab::cx {

namespace {

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

Status ActionBinding::install() {
  Status status = add_all({
      {"client", "(slot server (type STRING))"},
      {"server", "(slot name (type STRING))"},
      {"goal-response", "(slot server (type STRING)) (slot client-goal-handle-ptr (type EXTERNAL-ADDRESS))"},
      {"goal-feedback",
       "(slot server (type STRING)) (slot client-goal-handle-ptr (type EXTERNAL-ADDRESS)) (slot feedback-ptr (type "
       "EXTERNAL-ADDRESS))"},
      {"wrapped-result",
       "(slot server (type STRING)) (slot goal-id (type STRING)) "
       "(slot code (type SYMBOL) (allowed-values UNKNOWN SUCCEEDED CANCELED ABORTED)) (slot result-ptr (type "
       "EXTERNAL-ADDRESS))"},
      {"accepted-goal", "(slot server (type STRING)) (slot server-goal-handle-ptr (type EXTERNAL-ADDRESS))"},
      {"cancel-goal-response",
       "(slot server (type STRING)) (slot return-code (type SYMBOL) (allowed-values ERROR_NONE ERROR_REJECTED "
       "ERROR_UNKNOWN_GOAL_ID ERROR_GOAL_TERMINATED ERROR_UNKNOWN)) (slot num-goals (type INTEGER))"},
      {"cancel-goal-entry", "(slot server (type STRING)) (slot goal-id (type STRING)) (slot stamp (type FLOAT))"},
  });
  if (status) status = add_fields("goal-create", "goal-destroy", "goal-", *type_.goal);
  if (status) status = add_fields("feedback-create", "feedback-destroy", "feedback-", *type_.feedback);
  if (status) status = add_fields("result-create", "result-destroy", "result-", *type_.result);
  if (status) status = install_server();
  if (status) status = install_client();
  return status;
}

void ActionBinding::close(Leftovers& left) {
  close_all(servers_, "action servers", left);
  left.server_goals += served_.size();
  for (const auto& [handle, goal] : served_) store_.destroy(goal.goal);
  served_.clear();
  Binding::close(left);
}

Status ActionBinding::install_client() {
  using F = FunctionKind;
  Status status;
  const auto more = [&](const char* suffix, const char* returns, const char* types, F kind, const char* doc,
                        Function f) {
    if (status) status = add(suffix, returns, types, kind, doc, std::move(f));
  };
  more("create-client", "v", ";s", F::kActing, "Opens a client of an action server.", [this](Call& call) {
    const std::string server(call.text(0));
    if (open_action_client(call, server, type_)) put(named("client"), {{"server", Value::string(server)}});
  });
  more("destroy-client", "v", ";s", F::kActing, "Closes an action client.", [this](Call& call) {
    const std::string server(call.text(0));
    if (close_action_client(server)) take_back(named("client"), "server", server);
  });
  more("send-goal", "v", ";e;sy", F::kActing, "Sends a goal; it waits until the server is there.",
       [this](Call& call) { send_goal(call, call.handle(0), std::string(call.text(1))); });
  more("client-cancel-goal", "v", ";sy;e", F::kActing, "Asks the server to cancel a goal.",
       [this](Call& call) { cancel_goal(call, call.text(0), call.handle(1)); });
  more("client-cancel-all-goals", "v", ";sy", F::kActing, "Asks the server to cancel all its goals.",
       [this](Call& call) {
         if (const ActionClient* client = action_client(call, call.text(0)))
           bus_.cancel_all_goals(client->endpoint, engine_.cause());
       });
  more("client-cancel-goals-before", "v", ";sy;ld", F::kActing,
       "Asks the server to cancel the goals accepted until then (s).", [this](Call& call) {
         if (const ActionClient* client = action_client(call, call.text(0)))
           bus_.cancel_goals_before(client->endpoint, from_seconds(call.number(1)), engine_.cause());
       });
  more("client-goal-handle-get-goal-id", "s", ";e", F::kPure, "The goal's id, 32 hex digits.", [this](Call& call) {
    const Goal* goal = sent(call);
    call.give_string(goal ? bus::to_string(goal->id) : std::string());
  });
  more("client-goal-handle-get-goal-stamp", "d", ";e", F::kPure, "When the goal was accepted, in seconds.",
       [this](Call& call) {
         const Goal* goal = sent(call);
         call.give_number(goal ? to_seconds(goal->stamp) : 0.0);
       });
  more("client-goal-handle-get-status", "l", ";e", F::kPure,
       "0 unknown, 1 accepted, 2 executing, 3 canceling, 4 succeeded, 5 canceled, 6 aborted.", [this](Call& call) {
         const Goal* goal = sent(call);
         call.give_integer(goal ? static_cast<std::int64_t>(bus_.goal_status(goal->client, goal->id)) : 0);
       });
  for (const char* aware : {"client-goal-handle-is-feedback-aware", "client-goal-handle-is-result-aware"})
    more(aware, "b", ";e", F::kPure, "Whether it becomes a fact.",
         [this](Call& call) { call.give_boolean(sent(call) != nullptr); });
  more("client-goal-handle-destroy", "d", ";e", F::kActing, "Drops a goal handle.",
       [this](Call& call) { destroy_goal(call.handle(0)); });
  return status;
}

const BusConnection::Goal* ActionBinding::sent(Call& call) {
  const Goal* goal = find_goal(call.handle(0));
  if (!goal) unknown_handle(call, "client goal handle");
  return goal;
}

void ActionBinding::on_goal_response(const std::string& server, Handle goal) {
  put(named("goal-response"), {{"server", Value::string(server)}, {"client-goal-handle-ptr", Value::handle(goal)}});
}

void ActionBinding::on_feedback(const std::string& server, Handle goal, Handle feedback) {
  put(named("goal-feedback"), {{"server", Value::string(server)},
                               {"client-goal-handle-ptr", Value::handle(goal)},
                               {"feedback-ptr", Value::handle(feedback)}});
}

void ActionBinding::on_result(const std::string& server, const bus::Delivery& end, Handle result) {
  put(named("wrapped-result"), {{"server", Value::string(server)},
                                {"goal-id", Value::string(bus::to_string(end.goal))},
                                {"code", Value::symbol(result_word(end.status))},
                                {"result-ptr", Value::handle(result)}});
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

}  // namespace cxlab::cx
