#include "cx/journal/replay.h"

#include <algorithm>

#include <memory>
#include <span>

#include "cx/base/number_text.h"

namespace cxlab {
namespace {

std::string in_seconds(SimTime t) { return general_text(to_seconds(t), 15) + " s"; }

Error differs(const std::string& environment, SimTime t, const std::string& what) {
  return negative("the replay differs: " + environment + " at " + in_seconds(t) + ": " + what);
}

}  // namespace

// --- Recording

void RecordingTap::watch(bus::ParticipantId participant) {
  watched_[participant] = journal_.stream_name(bus_.stream_of(participant));
}

void RecordingTap::delivered(bus::ParticipantId to, const std::vector<bus::Delivery>& deliveries) {
  const auto watched = watched_.find(to);
  if (watched == watched_.end()) return;
  messages_.clear();
  LoggedTake take{bus_.now(), watched->second, {}};
  take.deliveries.reserve(deliveries.size());
  for (const bus::Delivery& delivery : deliveries) {
    LoggedDelivery& logged = take.deliveries.emplace_back();
    logged.delivery = delivery;
    logged.from = journal_.stream_name(bus_.stream_of(delivery.from));
    logged.endpoint = bus_.number_of(delivery.endpoint);
    if (delivery.message) {
      logged.type = delivery.message->view().type().name();
      delivery.message->serialize(messages_.emplace_back());
      logged.message = messages_.back();
    }
    logged.cause_stream = journal_.stream_name(delivery.cause.stream);
  }
  log_.add(take);
}

// --- Replaying

Replayer::Replayer(InputLogReader log, bus::Bus& bus, Journal& journal)
    : log_(std::move(log)), bus_(bus), journal_(journal) {
  while (auto entry = log_.next()) {
    if (auto* take = std::get_if<LoggedTake>(&*entry)) {
      inputs_[std::string(take->to)].takes.push_back(std::move(*take));
    } else if (const auto* result = std::get_if<LoggedResult>(&*entry)) {
      if (result->key == kSeatKey) continue;  // what it did to environments is among their takes
      Inputs& inputs = inputs_[std::string(result->environment)];
      (result->key == kControlKey ? inputs.controls : inputs.results).push_back(*result);
    }
  }
  end_ = log_.reached();
}

SimTime Replayer::next_due() const {
  SimTime due = kNever;
  for (const auto& [name, inputs] : inputs_)
    for (const auto* first : {inputs.takes.empty() ? nullptr : &inputs.takes.front().t,
                              inputs.controls.empty() ? nullptr : &inputs.controls.front().t})
      if (first) due = std::min(due, *first);
  return due;
}

void Replayer::watch(bus::ParticipantId participant) {
  senders_[journal_.stream_name(bus_.stream_of(participant))] = participant;
}

Status Replayer::feed(bus::ParticipantId environment) {
  const std::string& name = journal_.stream_name(bus_.stream_of(environment));
  senders_[name] = environment;
  const auto inputs = inputs_.find(name);
  if (inputs == inputs_.end() || inputs->second.takes.empty()) return {};
  auto& takes = inputs->second.takes;
  if (takes.front().t < bus_.now()) {
    return differs(name, takes.front().t, "then it took messages, now it does not");
  }
  if (takes.front().t > bus_.now()) return {};

  const LoggedTake take = std::move(takes.front());
  takes.pop_front();
  std::vector<bus::Delivery> deliveries;
  for (const LoggedDelivery& logged : take.deliveries) {
    auto delivery = to_delivery(logged, environment, name);
    if (!delivery) return delivery.error();
    deliveries.push_back(std::move(*delivery));
  }
  bus_.inject(environment, deliveries);
  return {};
}

Expected<bus::Delivery> Replayer::to_delivery(const LoggedDelivery& logged, bus::ParticipantId to,
                                              const std::string& name) {
  if (logged.delivery.kind > bus::DeliveryKind::kTopic) {
    return input_error("the input log holds a delivery of unknown kind " +
                       std::to_string(static_cast<int>(logged.delivery.kind)));
  }
  const auto endpoint = bus_.endpoint_of(to, logged.endpoint);
  if (!endpoint) {
    return differs(name, bus_.now(),
                   "it has not made its endpoint " + std::to_string(logged.endpoint) + " to which " +
                       (logged.type.empty() ? "an answer" : std::string(logged.type)) + " from " +
                       std::string(logged.from) + " went");
  }
  bus::Delivery delivery = logged.delivery;
  delivery.from = sender(logged.from);
  delivery.endpoint = *endpoint;
  if (!logged.type.empty()) {
    const auto type = bus_.registry().message(std::string(logged.type));
    if (!type) return type.error();
    std::size_t position = 0;
    auto message = bus::Message::deserialize(**type, std::as_bytes(std::span(logged.message)), position);
    if (!message) return message.error();
    delivery.message = std::make_shared<const bus::Message>(std::move(*message));
  }
  delivery.cause.stream = journal_.open_stream(logged.cause_stream);
  return delivery;
}

/// Those who are not there are joined under the name of their stream: nobody hears of it.
bus::ParticipantId Replayer::sender(std::string_view stream) {
  if (const auto known = senders_.find(stream); known != senders_.end()) return known->second;
  bus::NodeName name;
  name.name = stream;
  const auto id = bus_.join(bus::ParticipantKind::kNode, std::move(name), journal_.open_stream(stream));
  senders_.emplace(stream, id);
  return id;
}

Expected<std::string_view> Replayer::next_result(std::string_view environment, std::string_view key) {
  const auto inputs = inputs_.find(environment);
  if (inputs == inputs_.end() || inputs->second.results.empty()) {
    return differs(std::string(environment), bus_.now(),
                   "it asks for a result of " + std::string(key) + ", then it did not");
  }
  const LoggedResult result = inputs->second.results.front();
  if (result.key != key) {
    return differs(std::string(environment), bus_.now(),
                   "it asks for a result of " + std::string(key) + ", then of " + std::string(result.key));
  }
  inputs->second.results.pop_front();
  return result.bytes;
}

std::optional<LoggedResult> Replayer::next_control(std::string_view environment) const {
  const auto inputs = inputs_.find(environment);
  if (inputs == inputs_.end() || inputs->second.controls.empty()) return {};
  return inputs->second.controls.front();
}

void Replayer::take_control(std::string_view environment) { inputs_.find(environment)->second.controls.pop_front(); }

Status Replayer::all_used() const {
  for (const auto& [name, inputs] : inputs_) {
    if (!inputs.takes.empty()) return differs(name, inputs.takes.front().t, "then it took messages, now it does not");
    if (!inputs.controls.empty())
      return differs(name, inputs.controls.front().t, "it never comes to where a person did something");
    if (!inputs.results.empty()) {
      return differs(name, inputs.results.front().t,
                     "then it asked for a result of " + std::string(inputs.results.front().key) + ", now it does not");
    }
  }
  return {};
}

}  // namespace cxlab
