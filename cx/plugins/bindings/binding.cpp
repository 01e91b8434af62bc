// The common base of all bindings, and the bindings of messages and services.

#include "cx/plugins/bindings/binding.h"

namespace cxlab::cx {

void Binding::add_fields(const std::string& what, const std::string& create, const std::string& destroy,
                         const std::string& fields, const bus::MessageType& type) {
  using F = FunctionKind;
  words_.emplace_back(&type, what + "(s)");
  add(create, "e", "", F::kActing, "A new message.",
      [this, &type](Call& call) { call.give_handle(store_.create(type, owner_)); });
  // As in CX, this function does not destroy a message of another type: it stays, and is reported at the end.
  add(destroy, "v", ";e", F::kActing, "Drops a message and what is nested in it.", [this, &type](Call& call) {
    const bus::MessageView view = store_.view(call.handle(0));
    if (view && &view.type() == &type) store_.destroy(call.handle(0));
  });
  const auto fail = [this](Call& call, const FieldFault& fault, const char* verb) {
    if (fault.kind == FieldFault::Kind::kNoField)
      log(LogLevel::kError, call.spec().name + ": cannot " + verb + " unknown slot name " + std::string(call.text(1)));
    call.fail(fault.text);
  };
  add(fields + "get-field", "*", ";e;sy", F::kPure, "A field of a message.", [this, &type, fail](Call& call) {
    if (const auto fault = fields_.give(call, call.handle(0), call.arg(1), &type)) fail(call, *fault, "retrieve");
  });
  add(fields + "set-field", "v", ";e;sy;*", F::kActing, "Sets a field of a message.", [this, &type, fail](Call& call) {
    if (const auto fault = fields_.set(call.handle(0), call.arg(1), call.arg(2), &type)) fail(call, *fault, "set");
  });
}

void MessageBinding::add_all() {
  add_fields("message", "create-message", "destroy-message", "", type_);
  add_topics(&type_);
}

void ServiceBinding::add_all() {
  add_fields("request", "request-create", "request-destroy", "request-", *type_.request);
  add_fields("response", "response-create", "response-destroy", "response-", *type_.response);
  add_services(&type_);
}

}  // namespace cxlab::cx
