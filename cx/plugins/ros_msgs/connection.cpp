#include "cx/plugins/ros_msgs/connection.h"

#include <array>

namespace cxlab::cx {

std::vector<std::string> Leftovers::lines() const {
  std::vector<std::string> out;
  const auto found = [&out](std::size_t count, const char* what) {
    if (count > 0) out.push_back("Found " + std::to_string(count) + ' ' + what + ", cleaning up ...");
  };
  found(messages, "message(s)");
  for (const std::string& name : open) out.push_back(name + ", cleaning up ...");
  found(server_goals, "server goal handle(s)");
  found(client_goals, "client goal handle(s)");
  return out;
}

BusConnection::BusConnection(Environment& environment, std::string logger)
    : environment_(environment),
      engine_(environment.engine()),
      bus_(environment.bus()),
      logger_(std::move(logger)),
      store_(environment.common<MessageStore>()),
      owner_(store_.new_owner()),
      fields_(store_) {}

BusConnection::~BusConnection() = default;

void BusConnection::on_message(const std::string&, Handle) {}
void BusConnection::on_response(const std::string&, std::uint64_t, Handle) {}
void BusConnection::on_goal_response(const std::string&, Handle) {}
void BusConnection::on_feedback(const std::string&, Handle, Handle) {}
void BusConnection::on_result(const std::string&, const bus::Delivery&, Handle) {}
void BusConnection::on_cancel_response(const std::string&, const bus::Delivery&) {}
std::string BusConnection::callback_of(const std::string& service) const { return service; }

void BusConnection::close(Leftovers& left) {
  close_all(publishers_, "publishers", left);
  close_all(subscriptions_, "subscription", left);
  close_all(clients_, "clients", left);
  close_all(services_, "services", left);
  close_all(action_clients_, "action clients", left);
  left.messages += store_.size(owner_);
  store_.destroy_all(owner_);
  left.client_goals += goals_.size();
  goals_.clear();
}

// --- Templates, facts, log

Status BusConnection::add_templates(std::span<const Template> templates) {
  for (const Template& t : templates)
    if (!engine_.has("deftemplate", t.name))
      if (Status s = engine_.build("(deftemplate " + t.name + ' ' + t.slots + ')', logger_, 1); !s) return s;
  return {};
}

void BusConnection::remove_templates(std::span<const Template> templates) {
  if (environment_.ending()) return;
  for (const Template& t : templates)
    if (Status s = engine_.undefine("deftemplate", t.name); !s) log(LogLevel::kWarn, t.name + " cant be undefined");
}

void BusConnection::put(const std::string& deftemplate, std::initializer_list<RuleEngine::Slot> slots) {
  if (auto fact = engine_.assert_fact(deftemplate, slots); !fact) log(LogLevel::kError, fact.error().message);
}

void BusConnection::take_back(const std::string& deftemplate, std::string_view slot, std::string_view value) {
  for (const FactCopy& fact : engine_.facts(deftemplate)) {
    const Value* found = fact.slot(slot);
    if (found && found->text() == value) engine_.retract(fact.index);
  }
}

// --- Topics

bool BusConnection::open_publisher(Call& call, const std::string& topic, const bus::MessageType& type) {
  if (publishers_.contains(topic)) {
    log(LogLevel::kWarn, "Already publishing to topic " + topic);
    return false;
  }
  auto endpoint = bus_.advertise(environment_.participant(), topic, type);
  if (!endpoint) {
    call.fail(endpoint.error().text());
    return false;
  }
  publishers_[topic] = {*endpoint, &type};
  return true;
}

bool BusConnection::close_publisher(const std::string& topic) {
  return close_one(publishers_, topic, "No publisher for topic ");
}

void BusConnection::publish(Call& call, Handle message, std::string_view topic) {
  const bus::MessageView view = store_.view(message);
  if (!view) return log(LogLevel::kError, "Failed to publish invalid msg pointer");
  const auto found = publishers_.find(topic);
  if (found == publishers_.end())
    return call.fail("no publisher for topic " + std::string(topic) + ", it has to be created before");
  if (&view.type() != found->second.type)
    return call.fail("found a message of type " + view.type().name() + ", topic " + std::string(topic) + " has " +
                     found->second.type->name());
  bus_.publish(found->second.endpoint, store_.share(message), engine_.cause());
}

bool BusConnection::open_subscription(Call& call, const std::string& topic, const bus::MessageType& type) {
  if (subscriptions_.contains(topic)) {
    log(LogLevel::kWarn, "Already subscribed to topic " + topic);
    return false;
  }
  auto endpoint = bus_.subscribe(environment_.participant(), topic, type, [this, topic](const bus::Delivery& delivery) {
    environment_.note_input("topic", topic, delivery);
    on_message(topic, store_.receive(delivery.message, owner_));
  });
  if (!endpoint) {
    call.fail(endpoint.error().text());
    return false;
  }
  subscriptions_[topic] = {*endpoint, &type};
  return true;
}

bool BusConnection::close_subscription(const std::string& topic) {
  return close_one(subscriptions_, topic, "No subscription to topic ");
}

// --- Services

bool BusConnection::open_client(Call& call, const std::string& service, const bus::ServiceType& type) {
  if (clients_.contains(service)) {
    log(LogLevel::kWarn, "Already have a client for service " + service);
    return false;
  }
  auto endpoint =
      bus_.create_client(environment_.participant(), service, type, [this, service](const bus::Delivery& delivery) {
        environment_.note_input("response", service, delivery);
        Service& client = clients_.at(service);
        if (client.waited) log(LogLevel::kInfo, "service " + service + " is finally reachable");
        client.waited = false;
        on_response(service, delivery.request_id, store_.receive(delivery.message, owner_));
      });
  if (!endpoint) {
    call.fail(endpoint.error().text());
    return false;
  }
  clients_[service] = {*endpoint, &type, false};
  return true;
}

bool BusConnection::close_client(const std::string& service) {
  return close_one(clients_, service, "No client for service ");
}

std::optional<std::uint64_t> BusConnection::request(Call& call, Handle request, const std::string& service, bool wait) {
  const bus::MessageView view = store_.view(request);
  if (!view) {
    call.fail("Failed to send request: invalid message pointer");
    return std::nullopt;
  }
  const auto found = clients_.find(service);
  if (found == clients_.end()) {
    call.fail("no client for service " + service + ", it has to be created before");
    return std::nullopt;
  }
  Service& client = found->second;
  if (&view.type() != client.type->request) {
    call.fail("found a message of type " + view.type().name() + ", service " + service + " takes " +
              client.type->request->name());
    return std::nullopt;
  }
  const Value ready = environment_.look("service-ready " + service,
                                        [&] { return Value::boolean(bus_.service_ready(client.endpoint)); });
  if (!ready.is_true() && !wait) {
    log(LogLevel::kWarn, "service " + service + " not available, abort request.");
    return std::nullopt;
  }
  if (!ready.is_true() && !client.waited) {
    log(LogLevel::kWarn, "service " + service + " not available, the request waits for it");
    client.waited = true;
  }
  return bus_.call(client.endpoint, store_.share(request), engine_.cause());
}

bool BusConnection::open_service(Call& call, const std::string& service, const bus::ServiceType& type) {
  if (services_.contains(service)) {
    log(LogLevel::kWarn, "Already providing service " + service);
    return false;
  }
  auto endpoint = bus_.serve(environment_.participant(), service, type,
                             [this, service](const bus::Delivery& request) { answer(service, request); });
  if (!endpoint) {
    call.fail(endpoint.error().text());
    return false;
  }
  services_[service] = {*endpoint, &type, false};
  return true;
}

bool BusConnection::close_service(const std::string& service) {
  const auto found = services_.find(service);
  if (found == services_.end() || found->second.endpoint != answering_)
    return close_one(services_, service, "No service ");
  services_.erase(found);  // `answer` removes it, after its answer
  return true;
}

void BusConnection::answer(const std::string& service, const bus::Delivery& request) {
  environment_.note_input("request", service, request);
  const Service open = services_.at(service);
  const std::string callback = callback_of(service);
  const Handle asked = store_.receive(request.message, owner_);
  const Handle answered = store_.create(*open.type->response, owner_);
  answering_ = open.endpoint;
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
  answering_.reset();
  const auto still = services_.find(service);
  if (still == services_.end() || still->second.endpoint != open.endpoint) bus_.remove(open.endpoint);
}

}  // namespace cxlab::cx
