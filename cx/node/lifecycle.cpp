#include "cx/node/lifecycle.h"

#include <algorithm>
#include <array>
#include <memory>

#include "cx/bus/needed.h"

namespace cxlab::cx {

namespace {

/// A state of lifecycle_msgs: the primary ones, and those between them.
struct NamedState {
  std::uint8_t id;
  std::string_view label;
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

std::string_view label_of(std::uint8_t state) {
  return std::find_if(kStates.begin(), kStates.end(), [&](const NamedState& s) { return s.id == state; })->label;
}

void put_state(const bus::MessageView& out, std::uint8_t state) {
  out.set("id", static_cast<std::int64_t>(state)).set("label", label_of(state));
}
void put_state(const bus::MessageView& out, LifeState state) { put_state(out, static_cast<std::uint8_t>(state)); }

}  // namespace

std::string_view to_string(LifeState state) { return label_of(static_cast<std::uint8_t>(state)); }

std::string_view to_string(Transition transition) {
  static constexpr std::string_view kWords[] = {"", "configure", "cleanup", "activate", "deactivate", "shutdown"};
  return kWords[static_cast<std::size_t>(transition)];
}

/// One transition out of one state; `via` is the state in between.
struct Lifecycle::Row {
  Transition transition;
  std::uint8_t id;
  LifeState from, to;
  std::uint8_t via;
};

using L = LifeState;
using T = Transition;

// In the order in which ROS 2 registers them, which is that of get_available_transitions.
static const auto& rows() {
  static constexpr std::array<Lifecycle::Row, 7> kRows{{
      {T::kConfigure, 1, L::kUnconfigured, L::kInactive, 10},
      {T::kCleanup, 2, L::kInactive, L::kUnconfigured, 11},
      {T::kActivate, 3, L::kInactive, L::kActive, 13},
      {T::kDeactivate, 4, L::kActive, L::kInactive, 14},
      {T::kShutdown, 5, L::kUnconfigured, L::kFinalized, 12},
      {T::kShutdown, 6, L::kInactive, L::kFinalized, 12},
      {T::kShutdown, 7, L::kActive, L::kFinalized, 12},
  }};
  return kRows;
}

Expected<std::vector<bus::EndpointId>> serve(bus::Bus& bus, bus::ParticipantId node,
                                             std::vector<ServiceOfNode> services) {
  std::vector<bus::EndpointId> endpoints;
  for (ServiceOfNode& service : services) {
    auto type = bus.registry().service(service.type);
    if (!type) return type.error();
    if (!bus::can_offer(bus.registry(), "service " + bus.name_of(node).expand(service.name), service.type)) continue;
    const auto endpoint = std::make_shared<bus::EndpointId>();
    auto made = bus.serve(node, service.name, **type,
                          [&bus, endpoint, type = *type, answer = std::move(service.answer)](const bus::Delivery& d) {
                            auto response = std::make_shared<bus::Message>(*type->response);
                            answer(d.message->view(), response->view());
                            bus.respond(*endpoint, d, std::move(response));
                          });
    if (!made) return made.error();
    endpoints.push_back(*endpoint = *made);
  }
  return endpoints;
}

Lifecycle::Lifecycle(bus::Bus& bus, bus::ParticipantId node, Act act, Report failed)
    : bus_(bus), node_(node), act_(std::move(act)), failed_(std::move(failed)) {}

Status Lifecycle::serve() {
  const auto fill = [](const Row& row, const bus::MessageView& out) {
    out.nested("transition").set("id", static_cast<std::int64_t>(row.id)).set("label", to_string(row.transition));
    put_state(out.nested("start_state"), row.from);
    put_state(out.nested("goal_state"), row.via);
  };
  auto event = bus_.registry().message("lifecycle_msgs/msg/TransitionEvent");
  if (!event) return event.error();
  if (bus::can_offer(bus_.registry(), "topic " + bus_.name_of(node_).expand("~/transition_event"), (*event)->name())) {
    event_ = *event;
    auto events = bus_.advertise(node_, "~/transition_event", *event_);
    if (!events) return events.error();
    events_ = *events;
  }
  auto services =
      cx::serve(bus_, node_,
                {{"~/change_state", "lifecycle_msgs/srv/ChangeState",
                  [this](const auto& request, const auto& response) {
                    response.set("success", change_as_wanted(request.nested("transition")));
                  }},
                 {"~/get_state", "lifecycle_msgs/srv/GetState",
                  [this](const auto&, const auto& response) { put_state(response.nested("current_state"), state_); }},
                 {"~/get_available_states", "lifecycle_msgs/srv/GetAvailableStates",
                  [](const auto&, const auto& response) {
                    for (const NamedState& s : kStates) put_state(response.append("available_states"), s.id);
                  }},
                 {"~/get_available_transitions", "lifecycle_msgs/srv/GetAvailableTransitions",
                  [this, fill](const auto&, const auto& response) {
                    for (const Row& row : rows())
                      if (row.from == state_) fill(row, response.append("available_transitions"));
                  }},
                 {"~/get_transition_graph", "lifecycle_msgs/srv/GetAvailableTransitions",
                  [fill](const auto&, const auto& response) {
                    for (const Row& row : rows()) fill(row, response.append("available_transitions"));
                  }}});
  return services ? Status() : services.error();
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
  report_event(*row, false, row->id, to_string(transition), row->to);
  const Status done = act_(transition);
  state_ = !done && transition == T::kConfigure ? L::kUnconfigured : row->to;
  const auto base =
      static_cast<std::uint8_t>(static_cast<std::uint8_t>(transition) * 10);  // as the TRANSITION_ON_.. constants
  if (done)
    report_event(*row, true, base, "transition_success", state_);
  else
    report_event(*row, true, static_cast<std::uint8_t>(base + 1), "transition_failure", state_);
  return done;
}

void Lifecycle::report_event(const Row& row, bool ended, std::uint8_t id, std::string_view label, LifeState goal) {
  if (!events_) return;
  auto message = std::make_shared<bus::Message>(*event_);
  const bus::MessageView event = message->view();
  event.set("timestamp", bus_.now().count());
  event.nested("transition").set("id", static_cast<std::int64_t>(id)).set("label", label);
  if (ended) {
    put_state(event.nested("start_state"), row.via);
    put_state(event.nested("goal_state"), goal);
  } else {
    put_state(event.nested("start_state"), row.from);
    put_state(event.nested("goal_state"), row.via);
  }
  bus_.publish(*events_, std::move(message));
}

bool Lifecycle::change_as_wanted(const bus::MessageView& wanted) {
  const std::string label = wanted.text("label");
  for (const Row& row : rows()) {
    if (row.from != state_ || (label.empty() ? row.id != wanted.integer("id") : to_string(row.transition) != label))
      continue;
    const Status done = change(row.transition);
    if (!done) failed_(done.error());
    return done.ok();
  }
  failed_(usage_error("No transition matching " +
                      (label.empty() ? std::to_string(wanted.integer("id")) : '\'' + label + '\'') +
                      " found for current state " + std::string(to_string(state_))));
  return false;
}

}  // namespace cxlab::cx
