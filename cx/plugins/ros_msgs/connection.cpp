#include "cx/plugins/ros_msgs/connection.h"

#include <algorithm>
#include <array>

namespace cxlab::cx {

namespace {

constexpr SimTime kPatience = std::chrono::seconds(1);   ///< with a server that is not there
constexpr SimTime kSayAgain = std::chrono::seconds(10);  ///< that the service of repeated requests is not there

}  // namespace

void Leftovers::add(std::string_view what, std::size_t count) {
  const auto known = std::ranges::find(handles, what, [](const auto& entry) { return entry.first; });
  if (known == handles.end())
    handles.emplace_back(what, count);
  else
    known->second += count;
}

std::vector<std::string> Leftovers::lines() const {
  std::vector<std::string> out;
  for (const std::string& name : open) out.push_back(name + ", cleaning up ...");
  for (const auto& [what, count] : handles)
    if (count > 0) out.push_back("Found " + std::to_string(count) + ' ' + what + ", cleaning up ...");
  return out;
}

Status ConnectionPlugin::clips_env_init(EnvironmentGuard environment) {
  const Status installed = connections_.add(*environment, connect(*environment))->install();
  if (!installed) connections_.remove(*environment);
  return installed;
}

void ConnectionPlugin::clips_env_destroyed(EnvironmentGuard environment) {
  if (const auto* connection = connections_.find(*environment)) (*connection)->close(left_);
  connections_.remove(*environment);
}

SimTime ConnectionPlugin::next_due(const Environment& environment) const {
  const auto* connection = connections_.find(environment);
  return connection ? (*connection)->next_warning() : kNever;
}

Status ConnectionPlugin::on_due(EnvironmentGuard environment) {
  (*connections_.find(*environment))->warn_of_missing_servers();
  return {};
}

void ConnectionPlugin::finalize() {
  for (const std::string& line : left_.lines()) {
    log(LogLevel::kWarn, line);
    if (context().run.strict) context().note_load_error(input_error("strict-cx: leak: " + name() + ": " + line));
  }
}

BusConnection::BusConnection(Environment& environment, std::string logger, std::string prefix, bool bound)
    : environment_(environment),
      engine_(environment.engine()),
      bus_(environment.bus()),
      logger_(std::move(logger)),
      prefix_(std::move(prefix)),
      bound_(bound),
      numbers_requests_(!bound || environment.settings().next),
      store_(environment.common<MessageStore>()),
      owner_(store_.new_owner()),
      fields_(store_, environment.settings().strict, [this](const std::string& text) { log(LogLevel::kWarn, text); }) {}

Status BusConnection::install() {
  add_all();
  return installed_;
}

void BusConnection::close(Leftovers& left) {
  close_all(subscriptions_, "subscription", left);
  close_all(publishers_, "publishers", left);
  close_all(clients_, bound_ ? "client" : "clients", left);
  close_all(services_, bound_ ? "service" : "services", left);
  close_all(action_clients_, bound_ ? "client" : "action clients", left);
  std::size_t others = store_.size(owner_);
  for (const auto& [type, what] : words_) {
    left.add(what, store_.size(owner_, *type));
    others -= store_.size(owner_, *type);
  }
  left.add("client_goal_handle(s)", goals_.size());
  left.add("message(s)", others);
  store_.destroy_all(owner_);
  goals_.clear();
  if (environment_.ending()) return;
  for (const std::string& name : templates_)
    if (Status s = engine_.undefine("deftemplate", name); !s) log(LogLevel::kWarn, name + " cant be undefined");
}

// --- Servers that are not there

SimTime BusConnection::next_warning() const {
  SimTime next = kNever;
  if (waiting_ == 0) return next;
  const auto look = [&](const auto& all) {
    for (const auto& [name, client] : all)
      if (client.waiting.since != kNever && !client.waiting.warned)
        next = std::min(next, client.waiting.since + kPatience);
  };
  look(clients_);
  look(action_clients_);
  return next;
}

void BusConnection::warn_of_missing_servers() {
  const auto look = [&](auto& all, const std::string& what) {
    for (auto& [name, client] : all) {
      if (client.waiting.warned || client.waiting.since > bus_.now() - kPatience) continue;
      log(LogLevel::kWarn, what + name + " not available, start waiting");
      client.waiting.warned = true;
      --waiting_;
    }
  };
  look(clients_, "service ");
  look(action_clients_, "server ");
}

void BusConnection::wait(Waiting& waiting) {
  if (waiting.since != kNever) return;
  waiting.since = bus_.now();
  ++waiting_;
}

void BusConnection::reached(Waiting& waiting, const std::string& server) {
  if (waiting.warned) log(LogLevel::kInfo, server + " is finally reachable");
  if (waiting.since != kNever && !waiting.warned) --waiting_;
  waiting = {};
}

// --- Functions, templates, facts

void BusConnection::add(std::string_view suffix, const char* returns, const char* arg_types, FunctionKind kind,
                        const char* doc, Function function) {
  if (!installed_) return;
  const std::string_view types(arg_types);
  const auto size = static_cast<std::uint16_t>(std::count(types.begin(), types.end(), ';'));
  installed_ =
      engine_.add_function({named(suffix), returns, size, size, arg_types, kind, logger_, doc}, std::move(function));
}

void BusConnection::define(std::string_view suffix, const std::string& slots) {
  templates_.push_back(named(suffix));
  if (installed_ && !engine_.has("deftemplate", templates_.back()))
    installed_ = engine_.build("(deftemplate " + templates_.back() + ' ' + slots + ')', logger_, 1);
}

void BusConnection::put(const std::string& deftemplate, std::span<const RuleEngine::Slot> slots) {
  if (auto fact = engine_.assert_fact(deftemplate, slots); !fact) log(LogLevel::kError, fact.error().message);
}

void BusConnection::take_back(std::string_view suffix, std::string_view slot, std::string_view value) {
  for (const FactCopy& fact : engine_.facts(named(suffix))) {
    const Value* found = fact.slot(slot);
    if (found && found->text() == value) engine_.retract(fact.index);
  }
}

const bus::MessageType* BusConnection::message_type(Call& call, const ValueRef& name) {
  KnownType& last = known_types_[(reinterpret_cast<std::uintptr_t>(name.atom()) >> 5) % known_types_.size()];
  if (last.atom == name.atom()) return last.type;
  const auto* type = known(call, bus_.registry().message(std::string(name.text())));
  if (!type) return nullptr;
  engine_.keep(name);
  last = {name.atom(), type};
  return type;
}

void BusConnection::unknown_handle(Call& call, const std::string& what) {
  log(LogLevel::kError, "Unknown " + what + ": map::at");
  const bool null = call.handle(0) == Handle::kNone;
  call.complain("the " + what +
                (null ? " is a null pointer, as of a goal that was rejected" : " was destroyed, or is none"));
}

std::string BusConnection::wrong_type(const bus::MessageView& found, const std::string& of,
                                      const bus::MessageType& expected) {
  return "found a message of type " + found.type().name() + ", " + of + ' ' + expected.name();
}

// --- Topics

void BusConnection::add_topics(const bus::MessageType* bound) {
  using F = FunctionKind;
  define("subscription", opened_slots("topic"));
  define("publisher", opened_slots("topic"));
  define("message", "(slot topic (type STRING)) (slot msg-ptr (type EXTERNAL-ADDRESS))");
  add("create-publisher", "v", bound ? ";sy" : ";sy;sy", F::kActing, "Opens a topic for publishing.",
      [this, bound](Call& call) {
        const auto* type = bound ? bound : message_type(call, call.arg(1));
        if (!type) return;
        if (Topic* made = open(
                call, publishers_, "publisher", "topic", "Already publishing to topic ",
                [&](const std::string& topic) { return bus_.advertise(environment_.participant(), topic, *type); }))
          made->type = type;
      });
  // As in CX, the fact of a binding stays.
  add("destroy-publisher", "v", ";sy", F::kActing,
      bound ? "Closes a publisher; its fact stays." : "Closes a publisher.", [this](Call& call) {
        const std::string topic(call.text(0));
        if (close_one(publishers_, topic, "Publisher") && !bound_) take_back("publisher", "topic", topic);
      });
  add("create-subscription", "v", bound ? ";s" : ";sy;sy", F::kActing,
      bound ? "Subscribes: each message becomes a fact." : "Subscribes: each message becomes a ros-msgs-message fact.",
      [this, bound](Call& call) {
        const auto* type = bound ? bound : message_type(call, call.arg(1));
        if (!type) return;
        open(call, subscriptions_, "subscription", "topic", "Already subscribed to topic ",
             [&](const std::string& topic) {
               return bus_.subscribe(environment_.participant(), topic, *type,
                                     [this, topic, fact = named("message")](const bus::Delivery& delivery) {
                                       environment_.note_input("topic", topic, delivery);
                                       const Handle message = store_.receive(delivery.message, owner_);
                                       put(fact,
                                           {{"topic", Value::string(topic)}, {"msg-ptr", Value::handle(message)}});
                                     });
             });
      });
  add("destroy-subscription", "v", ";s", F::kActing, "Ends a subscription.", [this](Call& call) {
    const std::string topic(call.text(0));
    if (close_one(subscriptions_, topic, "Subscription")) take_back("subscription", "topic", topic);
  });
  add("publish", "v", ";e;sy", F::kActing, "Publishes a message on a topic.", [this](Call& call) { publish(call); });
}

void BusConnection::publish(Call& call) {
  const bus::MessageView view = store_.view(call.handle(0));
  if (!view) return log(LogLevel::kError, "Failed to publish invalid msg pointer");
  const std::string_view topic = call.text(1);
  const auto found = publishers_.find(topic);
  if (found == publishers_.end())
    return call.fail("no publisher for topic " + std::string(topic) + ", it has to be created before");
  if (&view.type() != found->second.type)
    return call.fail(wrong_type(view, "topic " + std::string(topic) + " has", *found->second.type));
  bus_.publish(found->second.endpoint, store_.share(call.handle(0)), engine_.cause());
}

// --- Services

void BusConnection::add_services(const bus::ServiceType* bound) {
  using F = FunctionKind;
  const char* slot = bound ? "name" : "service";
  define("client", opened_slots("service"));
  define("response", std::string("(slot service (type STRING))") +
                         (numbers_requests_ ? " (slot request-id (type INTEGER))" : "") +
                         " (slot msg-ptr (type EXTERNAL-ADDRESS))");
  define("service", opened_slots(slot));
  const auto type_of = [this, bound](Call& call) {
    return bound ? bound : known(call, bus_.registry().service(std::string(call.text(1))));
  };
  add("create-client", "v", bound ? ";s" : ";sy;sy", F::kActing, "Opens a client of a service.",
      [this, type_of](Call& call) {
        const bus::ServiceType* type = type_of(call);
        if (!type) return;
        const auto make = [&](const std::string& service) {
          return bus_.create_client(
              environment_.participant(), service, *type, [this, service](const bus::Delivery& delivery) {
                environment_.note_input("response", service, delivery);
                Service& client = clients_.at(service);
                reached(client.waiting, "service " + service);
                std::vector<RuleEngine::Slot> slots{
                    {"service", Value::string(service)},
                    {"msg-ptr", Value::handle(store_.receive(delivery.message, owner_))}};
                if (numbers_requests_)
                  slots.push_back({"request-id", Value::integer(static_cast<std::int64_t>(delivery.request_id))});
                put(named("response"), slots);
              });
        };
        if (Service* made = open(call, clients_, "client", "service", "Already registered to client ", make))
          made->type = type;
      });
  add("destroy-client", "v", bound ? ";s" : ";sy", F::kActing, "Closes a client.", [this](Call& call) {
    const std::string service(call.text(0));
    if (close_one(clients_, service, "Client")) take_back("client", "service", service);
  });
  add(bound ? "send-request" : "async-send-request", numbers_requests_ ? "bl" : "v", ";e;sy", F::kActing,
      numbers_requests_ ? "Sends a request; its number, or FALSE if there is no such service."
                        : "Sends a request; it waits until the service is there.",
      [this](Call& call) { request(call); });
  add("create-service", "v", bound ? ";sy" : ";sy;sy", F::kActing,
      bound ? "Serves: requests call the deffunction <prefix>-service-callback."
            : "Serves: requests call <service>-service-callback.",
      [this, type_of, slot](Call& call) {
        const bus::ServiceType* type = type_of(call);
        if (!type) return;
        const auto make = [&](const std::string& service) {
          return bus_.serve(environment_.participant(), service, *type,
                            [this, service](const bus::Delivery& request) { answer(service, request); });
        };
        if (Service* made = open(call, services_, "service", slot, "Already registered to service ", make))
          made->type = type;
      });
  // As in CX, the fact of a binding stays.
  add("destroy-service", "v", ";sy", F::kActing, bound ? "Ends a service; its fact stays." : "Ends a service.",
      [this](Call& call) {
        const std::string service(call.text(0));
        if (close_service(service) && !bound_) take_back("service", "service", service);
      });
}

/// A binding waits for the server; the generic plugin, and the bindings of the next CX, give the request's number, or
/// FALSE if there is no server.
void BusConnection::request(Call& call) {
  const std::string service(call.text(1));
  const bus::MessageView view = store_.view(call.handle(0));
  if (!view) return call.fail("Failed to send request: invalid message pointer");
  const auto found = clients_.find(service);
  if (found == clients_.end()) return call.fail("no client for service " + service + ", it has to be created before");
  Service& client = found->second;
  if (&view.type() != client.type->request)
    return call.fail(wrong_type(view, "service " + service + " takes", *client.type->request));
  const Value ready = environment_.look("service-ready " + service,
                                        [&] { return Value::boolean(bus_.service_ready(client.endpoint)); });
  if (!ready.is_true() && numbers_requests_) {
    if (!client.said_missing || bus_.now() >= *client.said_missing + kSayAgain) {
      log(LogLevel::kWarn, "service " + service + " not available, abort request.");
      client.said_missing = bus_.now();
    }
    return call.give_boolean(false);
  }
  client.said_missing.reset();
  if (!ready.is_true()) wait(client.waiting);
  const std::uint64_t number = bus_.call(client.endpoint, store_.share(call.handle(0)), engine_.cause());
  if (numbers_requests_) call.give_integer(static_cast<std::int64_t>(number));
}

bool BusConnection::close_service(const std::string& service) {
  const auto found = services_.find(service);
  if (found == services_.end() || found->second.endpoint != answering_) return close_one(services_, service, "Service");
  services_.erase(found);  // `answer` removes it, after its answer
  return true;
}

void BusConnection::answer(const std::string& service, const bus::Delivery& request) {
  environment_.note_input("request", service, request);
  const Service open = services_.at(service);
  const std::string callback = (bound_ ? prefix_ : service) + "-service-callback";
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
