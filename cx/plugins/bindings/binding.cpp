// The base of all bindings, and the bindings of messages and services.

#include "cx/plugins/bindings/binding.h"

#include <algorithm>

namespace cxlab::cx {

std::string Binding::named(std::string_view suffix) const { return prefix_ + '-' + std::string(suffix); }

Status Binding::add(std::string_view suffix, const char* returns, const char* arg_types, FunctionKind kind,
                    const char* doc, Function function) {
  const std::string_view types(arg_types);
  const auto size = static_cast<std::uint16_t>(std::count(types.begin(), types.end(), ';'));
  return engine_.add_function({named(suffix), returns, size, size, arg_types, kind, logger_, doc}, std::move(function));
}

Status Binding::add_fields(const std::string& create, const std::string& destroy, const std::string& fields,
                           const bus::MessageType& type) {
  using F = FunctionKind;
  if (Status s = add(create, "e", "", F::kActing, "A new message.",
                     [this, &type](Call& call) { call.give_handle(store_.create(type, owner_)); });
      !s)
    return s;
  // As in CX, this function does not destroy a message of another type: it stays, and is reported at the end.
  if (Status s = add(destroy, "v", ";e", F::kActing, "Drops a message and what is nested in it.",
                     [this, &type](Call& call) {
                       const bus::MessageView view = store_.view(call.handle(0));
                       if (view && &view.type() == &type) store_.destroy(call.handle(0));
                     });
      !s)
    return s;
  if (Status s = add(fields + "get-field", "*", ";e;sy", F::kPure, "A field of a message.",
                     [this, &type](Call& call) {
                       const auto fault = fields_.give(call, call.handle(0), call.arg(1), &type);
                       if (!fault) return;
                       if (fault->kind == FieldFault::Kind::kNoField)
                         log(LogLevel::kError,
                             call.spec().name + ": cannot retrieve unknown slot name " + std::string(call.text(1)));
                       call.fail(fault->text);
                     });
      !s)
    return s;
  return add(fields + "set-field", "v", ";e;sy;*", F::kActing, "Sets a field of a message.", [this, &type](Call& call) {
    const auto fault = fields_.set(call.handle(0), call.arg(1), call.arg(2), &type);
    if (!fault) return;
    if (fault->kind == FieldFault::Kind::kNoField)
      log(LogLevel::kError, call.spec().name + ": cannot set unknown slot name " + std::string(call.text(1)));
    call.fail(fault->text);
  });
}

Status Binding::add_all(std::vector<Template> suffixes) {
  for (Template& t : suffixes) t.name = named(t.name);
  if (Status s = add_templates(suffixes); !s) return s;
  templates_ = std::move(suffixes);
  return {};
}

void Binding::close(Leftovers& left) {
  BusConnection::close(left);
  remove_templates(templates_);
}

bool Binding::is_a(Call& call, Handle message, const bus::MessageType& type) {
  const bus::MessageView view = store_.view(message);
  if (view && &view.type() == &type) return true;
  call.fail(view ? "found a message of type " + view.type().name() + ", expected " + type.name()
                 : "invalid message pointer");
  return false;
}

void Binding::unknown_handle(Call& call, const std::string& what) {
  log(LogLevel::kError, "Unknown " + what + ": map::at");
  const bool null = call.handle(0) == Handle::kNone;
  call.complain("the " + what +
                (null ? " is a null pointer, as of a goal that was rejected" : " was destroyed, or is none"));
}

// --- Messages

Status MessageBinding::install() {
  using F = FunctionKind;
  Status status = add_all({{"publisher", "(slot topic (type STRING))"},
                           {"subscription", "(slot topic (type STRING))"},
                           {"message", "(slot topic (type STRING)) (slot msg-ptr (type EXTERNAL-ADDRESS))"}});
  if (status) status = add_fields("create-message", "destroy-message", "", type_);
  const auto more = [&](const char* suffix, const char* types, const char* doc, Function f) {
    if (status) status = add(suffix, "v", types, F::kActing, doc, std::move(f));
  };
  more("create-publisher", ";sy", "Opens a topic for publishing.", [this](Call& call) {
    const std::string topic(call.text(0));
    if (open_publisher(call, topic, type_)) put(named("publisher"), {{"topic", Value::string(topic)}});
  });
  // As in CX, the fact stays.
  more("destroy-publisher", ";sy", "Closes a publisher; its fact stays.",
       [this](Call& call) { close_publisher(std::string(call.text(0))); });
  more("create-subscription", ";s", "Subscribes: each message becomes a fact.", [this](Call& call) {
    const std::string topic(call.text(0));
    if (open_subscription(call, topic, type_)) put(named("subscription"), {{"topic", Value::string(topic)}});
  });
  more("destroy-subscription", ";s", "Ends a subscription.", [this](Call& call) {
    const std::string topic(call.text(0));
    if (close_subscription(topic)) take_back(named("subscription"), "topic", topic);
  });
  more("publish", ";e;sy", "Publishes a message on a topic.",
       [this](Call& call) { publish(call, call.handle(0), call.text(1)); });
  return status;
}

void MessageBinding::on_message(const std::string& topic, Handle message) {
  put(named("message"), {{"topic", Value::string(topic)}, {"msg-ptr", Value::handle(message)}});
}

// --- Services

Status ServiceBinding::install() {
  using F = FunctionKind;
  Status status = add_all({{"client", "(slot service (type STRING))"},
                           {"service", "(slot name (type STRING))"},
                           {"response", "(slot service (type STRING)) (slot msg-ptr (type EXTERNAL-ADDRESS))"}});
  if (status) status = add_fields("request-create", "request-destroy", "request-", *type_.request);
  if (status) status = add_fields("response-create", "response-destroy", "response-", *type_.response);
  const auto more = [&](const char* suffix, const char* types, const char* doc, Function f) {
    if (status) status = add(suffix, "v", types, F::kActing, doc, std::move(f));
  };
  more("create-service", ";sy", "Serves: requests call the deffunction <prefix>-service-callback.", [this](Call& call) {
    const std::string service(call.text(0));
    if (open_service(call, service, type_)) put(named("service"), {{"name", Value::string(service)}});
  });
  // As in CX, the fact stays.
  more("destroy-service", ";sy", "Ends a service; its fact stays.",
       [this](Call& call) { close_service(std::string(call.text(0))); });
  more("create-client", ";s", "Opens a client of a service.", [this](Call& call) {
    const std::string service(call.text(0));
    if (open_client(call, service, type_)) put(named("client"), {{"service", Value::string(service)}});
  });
  more("destroy-client", ";s", "Closes a client.", [this](Call& call) {
    const std::string service(call.text(0));
    if (close_client(service)) take_back(named("client"), "service", service);
  });
  more("send-request", ";e;sy", "Sends a request; it waits until the service is there.",
       [this](Call& call) { request(call, call.handle(0), std::string(call.text(1)), true); });
  return status;
}

void ServiceBinding::on_response(const std::string& service, std::uint64_t, Handle response) {
  put(named("response"), {{"service", Value::string(service)}, {"msg-ptr", Value::handle(response)}});
}

}  // namespace cxlab::cx
