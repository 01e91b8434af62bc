// Services of the rules: as client and as server.

#include <array>

#include "cx/plugins/ros_msgs/ros_interface.h"

namespace cxlab::cx {

std::vector<RosInterface::Entry> RosInterface::service_functions(const std::string& owner) {
  using F = FunctionKind;
  return {
      {{"ros-msgs-create-client", "v", 2, 2, ";sy;sy", F::kActing, owner, "Opens a client of a service."}, &RosInterface::create_client},
      {{"ros-msgs-destroy-client", "v", 1, 1, ";sy", F::kActing, owner, "Closes a client."}, &RosInterface::destroy_client},
      {{"ros-msgs-create-request", "e", 1, 1, ";sy", F::kActing, owner, "A new request of a service type."}, &RosInterface::create_request},
      {{"ros-msgs-async-send-request", "bl", 2, 2, ";e;sy", F::kActing, owner, "Sends a request; its number, or FALSE if there is no such service."}, &RosInterface::send_request},
      {{"ros-msgs-create-service", "v", 2, 2, ";sy;sy", F::kActing, owner, "Serves: requests call <service>-service-callback."}, &RosInterface::create_service},
      {{"ros-msgs-destroy-service", "v", 1, 1, ";sy", F::kActing, owner, "Ends a service."}, &RosInterface::destroy_service},
  };
}

void RosInterface::create_client(Call& call) {
  const std::string service(call.text(0)), type_name(call.text(1));
  if (clients_.contains(service)) return log(LogLevel::kWarn, "Already have a client for service " + service);
  auto type = bus_.registry().service(type_name);
  if (!type) return call.fail(type.error().text());
  auto endpoint = bus_.create_client(environment_.participant(), service, **type, [this, service](const bus::Delivery& delivery) {
    environment_.note_input("response", service, delivery);
    put("ros-msgs-response", {{"service", Value::string(service)},
                              {"request-id", Value::integer(static_cast<std::int64_t>(delivery.request_id))},
                              {"msg-ptr", Value::handle(store_.receive(delivery.message))}});
  });
  if (!endpoint) return call.fail(endpoint.error().text());
  clients_[service] = {*endpoint, *type};
  put("ros-msgs-client", {{"service", Value::string(service)}, {"type", Value::string(type_name)}});
}

void RosInterface::destroy_client(Call& call) {
  const std::string service(call.text(0));
  const auto found = clients_.find(service);
  if (found == clients_.end()) return log(LogLevel::kWarn, "No client for service " + service);
  bus_.remove(found->second.endpoint);
  clients_.erase(found);
  take_back("ros-msgs-client", "service", service);
}

void RosInterface::create_request(Call& call) {
  auto type = bus_.registry().service(std::string(call.text(0)));
  if (!type) return call.fail(type.error().text());
  call.give_handle(store_.create(*(*type)->request));
}

void RosInterface::send_request(Call& call) {
  const std::string service(call.text(1));
  const bus::MessageView view = store_.view(call.handle(0));
  if (!view) return call.fail("Failed to send request: invalid message pointer");
  const auto found = clients_.find(service);
  if (found == clients_.end()) return call.fail("no client for service " + service + ": call ros-msgs-create-client before");
  const Service& client = found->second;
  if (&view.type() != client.type->request)
    return call.fail("found a message of type " + view.type().name() + ", service " + service + " takes " + client.type->request->name());
  const Value ready = environment_.look("service-ready " + service, [&] { return Value::boolean(bus_.service_ready(client.endpoint)); });
  if (!ready.is_true()) {
    log(LogLevel::kWarn, "service " + service + " not available, abort request.");
    return call.give_boolean(false);
  }
  call.give_integer(static_cast<std::int64_t>(bus_.call(client.endpoint, store_.share(call.handle(0)), engine_.cause())));
}

void RosInterface::create_service(Call& call) {
  const std::string service(call.text(0)), type_name(call.text(1));
  if (services_.contains(service)) return log(LogLevel::kWarn, "Already providing service " + service);
  auto type = bus_.registry().service(type_name);
  if (!type) return call.fail(type.error().text());
  auto endpoint = bus_.serve(environment_.participant(), service, **type,
                             [this, service](const bus::Delivery& request) { answer(service, request); });
  if (!endpoint) return call.fail(endpoint.error().text());
  services_[service] = {*endpoint, *type};
  put("ros-msgs-service", {{"service", Value::string(service)}, {"type", Value::string(type_name)}});
}

void RosInterface::destroy_service(Call& call) {
  const std::string service(call.text(0));
  const auto found = services_.find(service);
  if (found == services_.end()) return log(LogLevel::kWarn, "No service " + service);
  bus_.remove(found->second.endpoint);
  services_.erase(found);
  take_back("ros-msgs-service", "service", service);
}

void RosInterface::answer(const std::string& service, const bus::Delivery& request) {
  environment_.note_input("request", service, request);
  const Service open = services_.at(service);
  const std::string callback = service + "-service-callback";
  const Handle asked = store_.receive(request.message);
  const Handle answered = store_.create(*open.type->response);
  if (engine_.callable(callback)) {
    const std::array<Value, 3> args{Value::string(service), Value::handle(asked), Value::handle(answered)};
    // An error in the callback is in the engine's next report; what it has filled in is sent all the same, as in CX.
    (void)engine_.call(callback, args);
  } else {
    log(LogLevel::kWarn, callback + " not defined, skip callback");
  }
  bus::SharedMessage response = store_.share(answered);
  if (!response) response = std::make_shared<const bus::Message>(*open.type->response);  // the callback destroyed it
  store_.destroy(asked);
  store_.destroy(answered);
  bus_.respond(open.endpoint, request, std::move(response));
}

}  // namespace cxlab::cx
