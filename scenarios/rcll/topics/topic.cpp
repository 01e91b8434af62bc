#include "scenarios/rcll/topics/topic.h"

#include <utility>

#include "cx/bus/needed.h"

namespace cxlab::rcll {

bool Rate::due(SimTime now) {
  if (now < next) return false;
  while (next <= now) next += period;
  return true;
}

Status PeriodicTopic::open(bus::Bus& bus, bus::ParticipantId node, std::string_view name, std::string_view type,
                           SimTime period) {
  auto message = bus::needed_message(bus.registry(), std::string(kInterfaces) + "msg/" + std::string(type));
  if (!message) return message.error();
  type_ = *message;
  rate_.period = period;
  auto endpoint = bus.advertise(node, name, *type_);
  if (!endpoint) return endpoint.error();
  endpoint_ = *endpoint;
  return {};
}

bool PeriodicTopic::due(SimTime now, bool changed) {
  const bool periodic = rate_.due(now);
  return periodic || changed;
}

void PeriodicTopic::publish(bus::Bus& bus, bus::Message message) const {
  bus.publish(endpoint_, std::make_shared<const bus::Message>(std::move(message)));
}

void put_texts(const bus::MessageView& message, std::string_view field, const std::vector<std::string_view>& texts) {
  const bus::Field& list = *message.type().find(field);
  Status done = message.resize(list, texts.size());
  for (std::size_t i = 0; i < texts.size() && done; ++i) done = message.set_text(list, texts[i], i);
}

void put_pose(const bus::MessageView& message, const sim::Pose2& pose) {
  message.nested("pose").set("x", pose.x).set("y", pose.y).set("theta", pose.yaw);
}

}  // namespace cxlab::rcll
