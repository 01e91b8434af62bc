// Messages, topics and services of the rules, with any type.

#include "cx/plugins/ros_msgs/ros_interface.h"

namespace cxlab::cx {

namespace {

/// As in ros_msgs.clp of CX.
const std::vector<BusConnection::Template>& templates() {
  static const std::vector<BusConnection::Template> all{
      {"ros-msgs-subscription", "(slot topic (type STRING)) (slot type (type STRING))"},
      {"ros-msgs-publisher", "(slot topic (type STRING)) (slot type (type STRING))"},
      {"ros-msgs-message", "(slot topic (type STRING)) (slot msg-ptr (type EXTERNAL-ADDRESS))"},
      {"ros-msgs-client", "(slot service (type STRING)) (slot type (type STRING))"},
      {"ros-msgs-response",
       "(slot service (type STRING)) (slot request-id (type INTEGER)) (slot msg-ptr (type EXTERNAL-ADDRESS))"},
      {"ros-msgs-service", "(slot service (type STRING)) (slot type (type STRING))"},
      {"ros-msgs-action-client", "(slot server (type STRING)) (slot type (type STRING))"},
      {"ros-msgs-goal-response", "(slot server (type STRING)) (slot client-goal-handle-ptr (type EXTERNAL-ADDRESS))"},
      {"ros-msgs-wrapped-result",
       "(slot server (type STRING)) (slot goal-id (type SYMBOL)) "
       "(slot code (type SYMBOL) (allowed-values UNKNOWN SUCCEEDED CANCELED ABORTED)) (slot result-ptr (type "
       "EXTERNAL-ADDRESS))"},
      {"ros-msgs-feedback",
       "(slot server (type STRING)) (slot client-goal-handle-ptr (type EXTERNAL-ADDRESS)) (slot feedback-ptr (type "
       "EXTERNAL-ADDRESS))"},
      {"ros-msgs-cancel-response",
       "(slot server (type STRING)) (slot client-goal-handle-ptr (type EXTERNAL-ADDRESS)) "
       "(slot cancel-response-ptr (type EXTERNAL-ADDRESS))"},
  };
  return all;
}

}  // namespace

Status RosInterface::install() {
  if (Status s = add_templates(templates()); !s) return s;
  for (const auto& list : {functions(logger_), action_functions(logger_)})
    for (const Entry& entry : list)
      if (Status s = engine_.add_function(entry.spec, [this, f = entry.function](Call& call) { (this->*f)(call); }); !s)
        return s;
  return {};
}

void RosInterface::close(Leftovers& left) {
  BusConnection::close(left);
  remove_templates(templates());
}

std::vector<RosInterface::Entry> RosInterface::functions(const std::string& owner) {
  using F = FunctionKind;
  using R = RosInterface;
  return {
      {{"ros-msgs-create-message", "e", 1, 1, ";sy", F::kActing, owner,
        "A new message of a type, e.g. std_msgs/msg/String."},
       &R::create_message},
      {{"ros-msgs-destroy-message", "v", 1, 1, ";e", F::kActing, owner, "Drops a message and what is nested in it."},
       &R::destroy_message},
      {{"ros-msgs-get-field", "*", 2, 2, ";e;sy", F::kPure, owner, "A field of a message."}, &R::get_field},
      {{"ros-msgs-set-field", "v", 3, 3, ";e;sy;*", F::kActing, owner, "Sets a field of a message."}, &R::set_field},
      {{"ros-msgs-create-publisher", "v", 2, 2, ";sy;sy", F::kActing, owner, "Opens a topic for publishing."},
       &R::create_publisher},
      {{"ros-msgs-destroy-publisher", "v", 1, 1, ";sy", F::kActing, owner, "Closes a publisher."},
       &R::destroy_publisher},
      {{"ros-msgs-create-subscription", "v", 2, 2, ";sy;sy", F::kActing, owner,
        "Subscribes: each message becomes a ros-msgs-message fact."},
       &R::create_subscription},
      {{"ros-msgs-destroy-subscription", "v", 1, 1, ";s", F::kActing, owner, "Ends a subscription."},
       &R::destroy_subscription},
      {{"ros-msgs-publish", "v", 2, 2, ";e;sy", F::kActing, owner, "Publishes a message on a topic."}, &R::publish},
      {{"ros-msgs-create-client", "v", 2, 2, ";sy;sy", F::kActing, owner, "Opens a client of a service."},
       &R::create_client},
      {{"ros-msgs-destroy-client", "v", 1, 1, ";sy", F::kActing, owner, "Closes a client."}, &R::destroy_client},
      {{"ros-msgs-create-request", "e", 1, 1, ";sy", F::kActing, owner, "A new request of a service type."},
       &R::create_request},
      {{"ros-msgs-async-send-request", "bl", 2, 2, ";e;sy", F::kActing, owner,
        "Sends a request; its number, or FALSE if there is no such service."},
       &R::send_request},
      {{"ros-msgs-create-service", "v", 2, 2, ";sy;sy", F::kActing, owner,
        "Serves: requests call <service>-service-callback."},
       &R::create_service},
      {{"ros-msgs-destroy-service", "v", 1, 1, ";sy", F::kActing, owner, "Ends a service."}, &R::destroy_service},
  };
}

// --- Messages

const bus::MessageType* RosInterface::message_type(Call& call, const ValueRef& name) {
  Known& known = known_[(reinterpret_cast<std::uintptr_t>(name.atom()) >> 5) % known_.size()];
  if (known.atom == name.atom()) return known.type;
  auto type = bus_.registry().message(std::string(name.text()));
  if (!type) {
    call.fail(type.error().text());
    return nullptr;
  }
  engine_.keep(name);
  known = {name.atom(), *type};
  return *type;
}

void RosInterface::create_message(Call& call) {
  if (const auto* type = message_type(call, call.arg(0))) call.give_handle(store_.create(*type, owner_));
}

void RosInterface::destroy_message(Call& call) { store_.destroy(call.handle(0)); }

// CX logs an unknown field and goes on with a result that is not defined; here it is FALSE.

void RosInterface::get_field(Call& call) {
  const auto fault = fields_.give(call, call.handle(0), call.arg(1));
  if (!fault) return;
  const std::string failed = "Failed to retrieve field " + std::string(call.text(1));
  if (fault->kind != FieldFault::Kind::kNoField) return call.fail(failed + ": " + fault->text);
  log(LogLevel::kError, failed);
  call.complain(fault->text);
  call.give_boolean(false);
}

void RosInterface::set_field(Call& call) {
  const auto fault = fields_.set(call.handle(0), call.arg(1), call.arg(2));
  if (!fault) return;
  const std::string failed = "Failed to set field " + std::string(call.text(1));
  switch (fault->kind) {
    case FieldFault::Kind::kNoMessage:
    case FieldFault::Kind::kValue: return call.fail(failed + ": " + fault->text);
    case FieldFault::Kind::kNoField: log(LogLevel::kError, failed); break;
    case FieldFault::Kind::kNotMultifield: log(LogLevel::kError, "expected multifield value!"); break;
    case FieldFault::Kind::kUnknownMessage: log(LogLevel::kError, "Failed to set unknown message"); break;
  }
  call.complain(fault->text);
}

// --- Topics

void RosInterface::create_publisher(Call& call) {
  const std::string topic(call.text(0));
  const auto* type = message_type(call, call.arg(1));
  if (type && open_publisher(call, topic, *type))
    put("ros-msgs-publisher", {{"topic", Value::string(topic)}, {"type", Value::string(std::string(call.text(1)))}});
}

void RosInterface::destroy_publisher(Call& call) {
  const std::string topic(call.text(0));
  if (close_publisher(topic)) take_back("ros-msgs-publisher", "topic", topic);
}

void RosInterface::create_subscription(Call& call) {
  const std::string topic(call.text(0));
  const auto* type = message_type(call, call.arg(1));
  if (type && open_subscription(call, topic, *type))
    put("ros-msgs-subscription", {{"topic", Value::string(topic)}, {"type", Value::string(std::string(call.text(1)))}});
}

void RosInterface::destroy_subscription(Call& call) {
  const std::string topic(call.text(0));
  if (close_subscription(topic)) take_back("ros-msgs-subscription", "topic", topic);
}

void RosInterface::publish(Call& call) { BusConnection::publish(call, call.handle(0), call.text(1)); }

void RosInterface::on_message(const std::string& topic, Handle message) {
  static const std::string kMessage = "ros-msgs-message";
  put(kMessage, {{"topic", Value::string(topic)}, {"msg-ptr", Value::handle(message)}});
}

// --- Services

void RosInterface::create_client(Call& call) {
  const std::string service(call.text(0)), name(call.text(1));
  auto type = bus_.registry().service(name);
  if (!type) return call.fail(type.error().text());
  if (open_client(call, service, **type))
    put("ros-msgs-client", {{"service", Value::string(service)}, {"type", Value::string(name)}});
}

void RosInterface::destroy_client(Call& call) {
  const std::string service(call.text(0));
  if (close_client(service)) take_back("ros-msgs-client", "service", service);
}

void RosInterface::create_request(Call& call) {
  auto type = bus_.registry().service(std::string(call.text(0)));
  if (!type) return call.fail(type.error().text());
  call.give_handle(store_.create(*(*type)->request, owner_));
}

void RosInterface::send_request(Call& call) {
  const auto number = request(call, call.handle(0), std::string(call.text(1)), false);
  if (number) return call.give_integer(static_cast<std::int64_t>(*number));
  call.give_boolean(false);
}

void RosInterface::create_service(Call& call) {
  const std::string service(call.text(0)), name(call.text(1));
  auto type = bus_.registry().service(name);
  if (!type) return call.fail(type.error().text());
  if (open_service(call, service, **type))
    put("ros-msgs-service", {{"service", Value::string(service)}, {"type", Value::string(name)}});
}

void RosInterface::destroy_service(Call& call) {
  const std::string service(call.text(0));
  if (close_service(service)) take_back("ros-msgs-service", "service", service);
}

void RosInterface::on_response(const std::string& service, std::uint64_t request, Handle response) {
  put("ros-msgs-response", {{"service", Value::string(service)},
                            {"request-id", Value::integer(static_cast<std::int64_t>(request))},
                            {"msg-ptr", Value::handle(response)}});
}

}  // namespace cxlab::cx
