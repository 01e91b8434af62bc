#include "cx/node/lifecycle.h"

#include <array>
#include <memory>

namespace cxlab::cx {

std::string_view to_string(LifeState state) {
  switch (state) {
    case LifeState::kUnconfigured: return "unconfigured";
    case LifeState::kInactive: return "inactive";
    case LifeState::kActive: return "active";
    case LifeState::kFinalized: break;
  }
  return "finalized";
}

std::string_view to_string(Transition transition) {
  switch (transition) {
    case Transition::kConfigure: return "configure";
    case Transition::kCleanup: return "cleanup";
    case Transition::kActivate: return "activate";
    case Transition::kDeactivate: return "deactivate";
    case Transition::kShutdown: break;
  }
  return "shutdown";
}

/// One transition out of one state; `via` is the state in between.
struct Lifecycle::Row {
  Transition transition;
  std::uint8_t id;
  LifeState from, to;
  std::uint8_t via;
  const char* via_label;
};

namespace {

struct NamedState {
  std::uint8_t id;
  const char* label;
};
constexpr std::array<NamedState, 11> kStates{{{0, "unknown"},
                                              {1, "unconfigured"},
                                              {2, "inactive"},
                                              {3, "active"},
                                              {4, "finalized"},
                                              {10, "configuring"},
                                              {11, "cleaningup"},
                                              {12, "shuttingdown"},
                                              {13, "activating"},
                                              {14, "deactivating"},
                                              {15, "errorprocessing"}}};

void put_state(const bus::MessageView& state, std::uint8_t id, std::string_view label) {
  state.set("id", static_cast<std::int64_t>(id)).set("label", label);
}
void put_state(const bus::MessageView& out, LifeState state) {
  put_state(out, static_cast<std::uint8_t>(state), to_string(state));
}

}  // namespace

using L = LifeState;
using T = Transition;
static constexpr std::uint8_t kConfiguring = 10, kCleaningUp = 11, kShuttingDown = 12, kActivating = 13,
                              kDeactivating = 14;

// In the order in which ROS 2 registers them, which is that of get_available_transitions.
static const auto& rows() {
  static constexpr std::array<Lifecycle::Row, 7> kRows{{
      {T::kConfigure, 1, L::kUnconfigured, L::kInactive, kConfiguring, "configuring"},
      {T::kCleanup, 2, L::kInactive, L::kUnconfigured, kCleaningUp, "cleaningup"},
      {T::kActivate, 3, L::kInactive, L::kActive, kActivating, "activating"},
      {T::kDeactivate, 4, L::kActive, L::kInactive, kDeactivating, "deactivating"},
      {T::kShutdown, 5, L::kUnconfigured, L::kFinalized, kShuttingDown, "shuttingdown"},
      {T::kShutdown, 6, L::kInactive, L::kFinalized, kShuttingDown, "shuttingdown"},
      {T::kShutdown, 7, L::kActive, L::kFinalized, kShuttingDown, "shuttingdown"},
  }};
  return kRows;
}

Expected<bus::EndpointId> serve(bus::Bus& bus, bus::ParticipantId node, const std::string& name,
                                const std::string& type,
                                std::function<void(const bus::MessageView&, const bus::MessageView&)> answer) {
  auto service = bus.registry().service(type);
  if (!service) return service.error();
  const auto endpoint = std::make_shared<bus::EndpointId>();
  auto made = bus.serve(node, name, **service,
                        [&bus, endpoint, service = *service, answer = std::move(answer)](const bus::Delivery& d) {
                          auto response = std::make_shared<bus::Message>(*service->response);
                          answer(d.message->view(), response->view());
                          bus.respond(*endpoint, d, std::move(response));
                        });
  if (made) *endpoint = *made;
  return made;
}

Lifecycle::Lifecycle(bus::Bus& bus, bus::ParticipantId node, Act act, Tell failed)
    : bus_(bus), node_(node), act_(std::move(act)), failed_(std::move(failed)) {}

Status Lifecycle::serve() {
  const auto fill = [](const Row& row, const bus::MessageView& out) {
    out.nested("transition").set("id", static_cast<std::int64_t>(row.id)).set("label", to_string(row.transition));
    put_state(out.nested("start_state"), row.from);
    put_state(out.nested("goal_state"), row.via, row.via_label);
  };
  auto event = bus_.registry().message("lifecycle_msgs/msg/TransitionEvent");
  if (!event) return event.error();
  event_ = *event;
  auto events = bus_.advertise(node_, "~/transition_event", *event_);
  if (!events) return events.error();
  events_ = *events;

  auto change_type = bus_.registry().service("lifecycle_msgs/srv/ChangeState");
  if (!change_type) return change_type.error();
  auto made =
      bus_.serve(node_, "~/change_state", **change_type, [this](const bus::Delivery& d) { on_change_state(d); });
  if (!made) return made.error();
  change_state_ = *made;

  struct Query {
    const char *name, *type;
    std::function<void(const bus::MessageView&, const bus::MessageView&)> answer;
  };
  const std::array<Query, 4> queries{{
      {"~/get_state", "lifecycle_msgs/srv/GetState",
       [this](const auto&, const auto& response) { put_state(response.nested("current_state"), state_); }},
      {"~/get_available_states", "lifecycle_msgs/srv/GetAvailableStates",
       [](const auto&, const auto& response) {
         for (const NamedState& s : kStates) put_state(response.append("available_states"), s.id, s.label);
       }},
      {"~/get_available_transitions", "lifecycle_msgs/srv/GetAvailableTransitions",
       [this, fill](const auto&, const auto& response) {
         for (const Row& row : rows())
           if (row.from == state_) fill(row, response.append("available_transitions"));
       }},
      {"~/get_transition_graph", "lifecycle_msgs/srv/GetAvailableTransitions",
       [fill](const auto&, const auto& response) {
         for (const Row& row : rows()) fill(row, response.append("available_transitions"));
       }},
  }};
  for (const Query& q : queries)
    if (auto s = cx::serve(bus_, node_, q.name, q.type, q.answer); !s) return s.error();
  return {};
}

const Lifecycle::Row* Lifecycle::row_of(Transition transition) const {
  for (const Row& row : rows())
    if (row.from == state_ && row.transition == transition) return &row;
  return nullptr;
}

Status Lifecycle::change(Transition transition) {
  const Row* row = row_of(transition);
  if (row == nullptr)
    return usage_error("no transition '" + std::string(to_string(transition)) + "' from state '" +
                       std::string(to_string(state_)) + "'");
  tell_event(*row, false, row->id, to_string(transition).data(), row->to);
  const Status done = act_(transition);
  state_ = !done && transition == T::kConfigure ? L::kUnconfigured : row->to;
  const auto base =
      static_cast<std::uint8_t>(static_cast<std::uint8_t>(transition) * 10);  // as the TRANSITION_ON_.. constants
  if (done)
    tell_event(*row, true, base, "transition_success", state_);
  else
    tell_event(*row, true, static_cast<std::uint8_t>(base + 1), "transition_failure", state_);
  return done;
}

void Lifecycle::tell_event(const Row& row, bool ended, std::uint8_t id, const char* label, LifeState goal) {
  if (!events_) return;
  auto message = std::make_shared<bus::Message>(*event_);
  const bus::MessageView event = message->view();
  event.set("timestamp", bus_.now().count());
  event.nested("transition").set("id", static_cast<std::int64_t>(id)).set("label", label);
  if (ended) {
    put_state(event.nested("start_state"), row.via, row.via_label);
    put_state(event.nested("goal_state"), goal);
  } else {
    put_state(event.nested("start_state"), row.from);
    put_state(event.nested("goal_state"), row.via, row.via_label);
  }
  bus_.publish(*events_, std::move(message));
}

void Lifecycle::on_change_state(const bus::Delivery& request) {
  const bus::MessageView wanted = request.message->view().nested("transition");
  const std::string label = wanted.text("label");
  const Row* found = nullptr;
  for (const Row& row : rows())
    if (row.from == state_ && (label.empty() ? row.id == wanted.integer("id") : to_string(row.transition) == label))
      found = &row;
  bool success = false;
  if (found) {
    const Status done = change(found->transition);
    success = done.ok();
    if (!success) failed_(done.error());
  } else {
    failed_(usage_error("No transition matching " +
                        (label.empty() ? std::to_string(wanted.integer("id")) : '\'' + label + '\'') +
                        " found for current state " + std::string(to_string(state_))));
  }
  auto response =
      std::make_shared<bus::Message>(*(*bus_.registry().service("lifecycle_msgs/srv/ChangeState"))->response);
  response->view().set("success", success);
  bus_.respond(change_state_, request, std::move(response));
}

}  // namespace cxlab::cx
