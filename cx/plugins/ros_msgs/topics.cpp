// Messages and topics of the rules.

#include "cx/plugins/ros_msgs/fields.h"
#include "cx/plugins/ros_msgs/ros_interface.h"

namespace cxlab::cx {

std::vector<RosInterface::Entry> RosInterface::message_functions(const std::string& owner) {
  using F = FunctionKind;
  return {
      {{"ros-msgs-create-message", "e", 1, 1, ";sy", F::kActing, owner, "A new message of a type, e.g. std_msgs/msg/String."}, &RosInterface::create_message},
      {{"ros-msgs-destroy-message", "v", 1, 1, ";e", F::kActing, owner, "Drops a message and what is nested in it."}, &RosInterface::destroy_message},
      {{"ros-msgs-get-field", "*", 2, 2, ";e;sy", F::kPure, owner, "A field of a message."}, &RosInterface::get_field},
      {{"ros-msgs-set-field", "v", 3, 3, ";e;sy;*", F::kActing, owner, "Sets a field of a message."}, &RosInterface::set_field},
  };
}

std::vector<RosInterface::Entry> RosInterface::topic_functions(const std::string& owner) {
  using F = FunctionKind;
  return {
      {{"ros-msgs-create-publisher", "v", 2, 2, ";sy;sy", F::kActing, owner, "Opens a topic for publishing."}, &RosInterface::create_publisher},
      {{"ros-msgs-destroy-publisher", "v", 1, 1, ";sy", F::kActing, owner, "Closes a publisher."}, &RosInterface::destroy_publisher},
      {{"ros-msgs-create-subscription", "v", 2, 2, ";sy;sy", F::kActing, owner, "Subscribes: each message becomes a ros-msgs-message fact."}, &RosInterface::create_subscription},
      {{"ros-msgs-destroy-subscription", "v", 1, 1, ";s", F::kActing, owner, "Ends a subscription."}, &RosInterface::destroy_subscription},
      {{"ros-msgs-publish", "v", 2, 2, ";e;sy", F::kActing, owner, "Publishes a message on a topic."}, &RosInterface::publish},
  };
}

void RosInterface::create_message(Call& call) {
  auto type = bus_.registry().message(std::string(call.text(0)));
  if (!type) return call.fail(type.error().text());
  call.give_handle(store_.create(**type));
}

void RosInterface::destroy_message(Call& call) { store_.destroy(call.handle(0)); }
void RosInterface::get_field(Call& call) { give_field(call, store_, call.handle(0), call.text(1)); }
void RosInterface::set_field(Call& call) { cx::set_field(call, store_, call.handle(0), call.text(1), call.arg(2)); }

void RosInterface::create_publisher(Call& call) {
  const std::string topic(call.text(0)), type_name(call.text(1));
  if (publishers_.contains(topic)) return log(LogLevel::kWarn, "Already publishing to topic " + topic);
  auto type = bus_.registry().message(type_name);
  if (!type) return call.fail(type.error().text());
  auto endpoint = bus_.advertise(environment_.participant(), topic, **type);
  if (!endpoint) return call.fail(endpoint.error().text());
  publishers_[topic] = {*endpoint, *type};
  put("ros-msgs-publisher", {{"topic", Value::string(topic)}, {"type", Value::string(type_name)}});
}

void RosInterface::destroy_publisher(Call& call) {
  const std::string topic(call.text(0));
  const auto found = publishers_.find(topic);
  if (found == publishers_.end()) return log(LogLevel::kWarn, "No publisher for topic " + topic);
  bus_.remove(found->second.endpoint);
  publishers_.erase(found);
  take_back("ros-msgs-publisher", "topic", topic);
}

void RosInterface::create_subscription(Call& call) {
  const std::string topic(call.text(0)), type_name(call.text(1));
  if (subscriptions_.contains(topic)) return log(LogLevel::kWarn, "Already subscribed to topic " + topic);
  auto type = bus_.registry().message(type_name);
  if (!type) return call.fail(type.error().text());
  auto endpoint = bus_.subscribe(environment_.participant(), topic, **type, [this, topic](const bus::Delivery& delivery) {
    environment_.note_input("topic", topic, delivery);
    put("ros-msgs-message", {{"topic", Value::string(topic)}, {"msg-ptr", Value::handle(store_.receive(delivery.message))}});
  });
  if (!endpoint) return call.fail(endpoint.error().text());
  subscriptions_[topic] = {*endpoint, *type};
  put("ros-msgs-subscription", {{"topic", Value::string(topic)}, {"type", Value::string(type_name)}});
}

void RosInterface::destroy_subscription(Call& call) {
  const std::string topic(call.text(0));
  const auto found = subscriptions_.find(topic);
  if (found == subscriptions_.end()) return log(LogLevel::kWarn, "No subscription to topic " + topic);
  bus_.remove(found->second.endpoint);
  subscriptions_.erase(found);
  take_back("ros-msgs-subscription", "topic", topic);
}

void RosInterface::publish(Call& call) {
  const std::string_view topic = call.text(1);
  const bus::MessageView view = store_.view(call.handle(0));
  if (!view) return log(LogLevel::kError, "Failed to publish invalid msg pointer");
  const auto found = publishers_.find(topic);
  if (found == publishers_.end()) return call.fail("no publisher for topic " + std::string(topic) + ": call ros-msgs-create-publisher before");
  if (&view.type() != found->second.type)
    return call.fail("found a message of type " + view.type().name() + ", topic " + std::string(topic) + " has " + found->second.type->name());
  bus_.publish(found->second.endpoint, store_.share(call.handle(0)), engine_.cause());
}

}  // namespace cxlab::cx
