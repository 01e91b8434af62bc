// Goals: their states are those of ROS 2 (design article "Actions"); deliveries report each change.

#include <algorithm>
#include <cassert>

#include "cx/bus/bus.h"
#include "cx/bus/bus_state.h"

namespace cxlab::bus {

namespace {

constexpr std::int8_t kCancelNone = 0, kCancelRejected = 1, kCancelUnknownGoal = 2, kCancelTerminated = 3;

/// FNV-1a with two offsets: 16 bytes that depend on names and counts of the client only.
GoalId goal_id_of(const std::string& node, const std::string& action, std::uint64_t twin, std::uint64_t endpoint,
                  std::uint64_t number) {
  const std::string text = node + '\n' + action + '\n' + std::to_string(twin) + '\n' + std::to_string(endpoint) + '\n' +
                           std::to_string(number);
  GoalId id{};
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (std::size_t half = 0; half < 2; ++half) {
    for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
    for (std::size_t i = 0; i < 8; ++i) id[8 * half + i] = static_cast<std::uint8_t>(hash >> (8 * i));
  }
  return id;
}

}  // namespace

// --- Client side

bool Bus::action_ready(EndpointId client) const {
  const Endpoint* from = state_->find(client, EndpointKind::kActionClient);
  return from != nullptr && !from->channel->providers.empty();
}

GoalId Bus::send_goal(EndpointId client, SharedMessage goal, Causes causes) {
  Endpoint* from = state_->find(client, EndpointKind::kActionClient);
  if (from == nullptr) return {};
  assert(goal && &goal->view().type() == from->message);
  const Participant& owner = state_->participant(from->owner);
  Delivery delivery = state_->begin_post(DeliveryKind::kGoal, "goal", *from);
  const GoalId id = delivery.goal = goal_id_of(owner.name.full_name(), from->channel->name, owner.twin,
                                               static_cast<std::uint64_t>(client) & 0xffffffffU, from->next_number++);
  state_->data.field("goal_id", std::string_view(to_string(id)));
  state_->add_message("goal", goal);
  delivery.cause = state_->write(now_, *from, causes);
  delivery.message = std::move(goal);
  from->sent[id] = {};
  state_->send_to_server(*from, std::move(delivery));
  return id;
}

void Bus::cancel(EndpointId client, const GoalId& goal, SimTime stamp, Causes causes) {
  Endpoint* from = state_->find(client, EndpointKind::kActionClient);
  if (from == nullptr) return;
  Delivery delivery = state_->begin_post(DeliveryKind::kCancel, "cancel", *from);
  if (goal != GoalId{})
    state_->data.field("goal_id", std::string_view(to_string(goal)));
  else if (stamp != kNever)
    state_->data.field("not_after", static_cast<std::int64_t>(stamp.count()));
  delivery.goal = goal;
  delivery.stamp = stamp;
  delivery.cause = state_->write(now_, *from, causes);
  state_->send_to_server(*from, std::move(delivery));
}

void Bus::cancel_goal(EndpointId client, const GoalId& goal, Causes causes) { cancel(client, goal, kNever, causes); }
void Bus::cancel_all_goals(EndpointId client, Causes causes) { cancel(client, {}, kNever, causes); }
void Bus::cancel_goals_before(EndpointId client, SimTime stamp, Causes causes) { cancel(client, {}, stamp, causes); }

void Bus::forget_goal(EndpointId client, const GoalId& goal) {
  if (Endpoint* from = state_->find(client, EndpointKind::kActionClient)) from->sent.erase(goal);
}

GoalStatus Bus::goal_status(EndpointId client, const GoalId& goal) const {
  const Endpoint* from = state_->find(client, EndpointKind::kActionClient);
  if (from == nullptr) return GoalStatus::kUnknown;
  const auto known = from->sent.find(goal);
  return known == from->sent.end() ? GoalStatus::kUnknown : known->second;
}

// --- Server side

bool Bus::answer_goal(EndpointId server, const GoalId& id, GoalAnswer answer) {
  Endpoint* from = state_->find(server, EndpointKind::kActionServer);
  if (from == nullptr) return false;
  const auto known = from->served.find(id);
  if (known == from->served.end() || !known->second.taken || known->second.status != GoalStatus::kUnknown) return false;
  ServedGoal& goal = known->second;
  const bool accepted = answer != GoalAnswer::kReject;
  Delivery delivery = state_->begin_post(DeliveryKind::kGoalResponse, accepted ? "accept" : "reject", *from);
  state_->data.field("goal_id", std::string_view(to_string(id)));
  delivery.cause = state_->write(now_, *from, {&goal.cause, 1});
  delivery.goal = id;
  delivery.accepted = accepted;
  const EndpointId client = goal.client;
  if (accepted) {
    goal.status = answer == GoalAnswer::kDefer ? GoalStatus::kAccepted : GoalStatus::kExecuting;
    goal.accepted_at = delivery.stamp = now_;
    delivery.status = goal.status;
  } else {
    from->served.erase(known);
  }
  state_->reply(client, std::move(delivery));
  return true;
}

bool Bus::execute(EndpointId server, const GoalId& id) {
  Endpoint* from = state_->find(server, EndpointKind::kActionServer);
  if (from == nullptr) return false;
  const auto known = from->served.find(id);
  if (known == from->served.end() || known->second.status != GoalStatus::kAccepted) return false;
  known->second.status = GoalStatus::kExecuting;
  state_->begin("execute", *from).field("goal_id", std::string_view(to_string(id)));
  state_->write(now_, *from, {&known->second.cause, 1});
  return true;
}

bool Bus::publish_feedback(EndpointId server, const GoalId& id, SharedMessage feedback) {
  Endpoint* from = state_->find(server, EndpointKind::kActionServer);
  if (from == nullptr) return false;
  const auto known = from->served.find(id);
  if (known == from->served.end() || known->second.status == GoalStatus::kUnknown || known->second.ended())
    return false;
  assert(feedback && &feedback->view().type() == from->feedback);
  Delivery delivery = state_->begin_post(DeliveryKind::kFeedback, "feedback", *from);
  state_->data.field("goal_id", std::string_view(to_string(id)));
  state_->add_message("feedback", feedback);
  delivery.cause = state_->write(now_, *from, {&known->second.cause, 1});
  delivery.goal = id;
  delivery.status = known->second.status;
  delivery.message = std::move(feedback);
  state_->reply(known->second.client, std::move(delivery));
  return true;
}

bool Bus::finish(EndpointId server, const GoalId& id, GoalStatus status, SharedMessage result) {
  assert(status == GoalStatus::kSucceeded || status == GoalStatus::kAborted || status == GoalStatus::kCanceled);
  Endpoint* from = state_->find(server, EndpointKind::kActionServer);
  if (from == nullptr) return false;
  const auto known = from->served.find(id);
  if (known == from->served.end()) return false;
  ServedGoal& goal = known->second;
  const bool allowed = goal.status == GoalStatus::kCanceling ||
                       (goal.status == GoalStatus::kExecuting && status != GoalStatus::kCanceled);
  if (!allowed) return false;
  assert(result && &result->view().type() == from->answer);
  goal.status = status;
  while (!from->ended.empty() && from->ended.front().first < now_ - kEndedGoalKept) {
    from->served.erase(from->ended.front().second);
    from->ended.pop_front();
  }
  from->ended.emplace_back(now_, id);
  Delivery delivery = state_->begin_post(DeliveryKind::kResult, "result", *from);
  state_->data.field("goal_id", std::string_view(to_string(id))).field("status", static_cast<int>(status));
  state_->add_message("result", result);
  delivery.cause = state_->write(now_, *from, {&goal.cause, 1});
  delivery.goal = id;
  delivery.status = status;
  delivery.message = std::move(result);
  state_->reply(goal.client, std::move(delivery));
  return true;
}

GoalStatus Bus::server_goal_status(EndpointId server, const GoalId& goal) const {
  const Endpoint* from = state_->find(server, EndpointKind::kActionServer);
  if (from == nullptr) return GoalStatus::kUnknown;
  const auto known = from->served.find(goal);
  return known == from->served.end() ? GoalStatus::kUnknown : known->second.status;
}

// --- Cancels

void Bus::State::take_cancel(SimTime now, Endpoint& server, const Delivery& delivery) {
  OpenRequest& open = server.requests[delivery.request_id];
  open.taken = true;
  open.goal = delivery.goal;
  open.cause = delivery.cause;
  const bool one = delivery.goal != GoalId{};
  std::int8_t code = kCancelNone;
  if (one) {
    const auto known = server.served.find(delivery.goal);
    if (known == server.served.end() || known->second.status == GoalStatus::kUnknown)
      code = kCancelUnknownGoal;
    else if (!known->second.cancelable())
      code = kCancelTerminated;
    else
      open.undecided.push_back(delivery.goal);
  } else {
    for (const auto& [id, goal] : server.served)
      if (goal.cancelable() && goal.accepted_at <= delivery.stamp) open.undecided.push_back(id);
    std::sort(open.undecided.begin(), open.undecided.end(),
              [&](const GoalId& a, const GoalId& b) { return server.served.at(a).order < server.served.at(b).order; });
  }
  if (open.undecided.empty()) return answer_cancel_request(now, server, delivery.request_id, code);

  const std::vector<GoalId> asked = open.undecided;
  if (!server.handlers[handler_index(DeliveryKind::kCancel)]) {
    open.undecided.clear();
    return answer_cancel_request(now, server, delivery.request_id, kCancelRejected);
  }
  for (const GoalId& id : asked) {
    Delivery single = delivery;
    single.goal = id;
    Endpoint* still_there = find(delivery.endpoint);
    if (still_there == nullptr) return;
    call_handler(*still_there, single);
  }
}

bool Bus::answer_cancel(EndpointId server, const Delivery& cancel, bool accept) {
  Endpoint* from = state_->find(server, EndpointKind::kActionServer);
  if (from == nullptr) return false;
  const auto request = from->requests.find(cancel.request_id);
  if (request == from->requests.end()) return false;
  OpenRequest& open = request->second;
  if (std::erase(open.undecided, cancel.goal) == 0) return false;
  const auto goal = from->served.find(cancel.goal);
  if (accept && goal != from->served.end() && goal->second.cancelable()) {
    goal->second.status = GoalStatus::kCanceling;
    open.canceling.emplace_back(cancel.goal, goal->second.accepted_at);
  }
  if (open.undecided.empty())
    state_->answer_cancel_request(now_, *from, cancel.request_id,
                                  open.canceling.empty() ? kCancelRejected : kCancelNone);
  return true;
}

void Bus::State::answer_cancel_request(SimTime now, Endpoint& server, std::uint64_t request_id, std::int8_t code) {
  const auto request = server.requests.find(request_id);
  OpenRequest& open = request->second;
  Delivery delivery = begin_post(DeliveryKind::kCancelResponse, "cancel_response", server);
  data.field("code", static_cast<int>(code)).name("canceling").open_list(open.canceling.size());
  for (const auto& [goal, accepted_at] : open.canceling) data.value(std::string_view(to_string(goal)));
  delivery.cause = write(now, server, {&open.cause, 1});
  delivery.goal = open.goal;
  delivery.return_code = code;
  delivery.goals_canceling = std::move(open.canceling);
  const EndpointId client = open.client;
  server.requests.erase(request);
  reply(client, std::move(delivery));
}

}  // namespace cxlab::bus
