#include "cx/plugins/bindings/bindings_plugin.h"

#include "cx/plugins/bindings/binding.h"
#include "cx/plugins/bindings/names.h"

namespace cxlab::cx {

namespace {

/// The bindings of one interface, whose definition is read when the plugin is made.
class BindingsPlugin final : public Plugin {
 public:
  using Plugin::Plugin;

  Status initialize() override {
    bus::Registry& interfaces = context().bus.registry();
    const auto bound = find_binding(type(), interfaces);
    if (!bound) return input_error("plugin '" + name() + "': no interface is bound by " + type());
    bound_ = *bound;
    Status status;
    const auto keep = [&](auto found, auto& place) {
      if (found)
        place = *found;
      else
        status = found.error();
    };
    switch (bound_.kind) {
      case InterfaceKind::kMessage: keep(interfaces.message(bound_.interface), message_); break;
      case InterfaceKind::kService: keep(interfaces.service(bound_.interface), service_); break;
      case InterfaceKind::kAction: keep(interfaces.action(bound_.interface), action_); break;
    }
    return status;
  }

  Status clips_env_init(EnvironmentGuard environment) override {
    Status installed;
    switch (bound_.kind) {
      case InterfaceKind::kMessage:
        installed = messages_.add(*environment, *environment, name(), bound_.prefix, *message_).install();
        break;
      case InterfaceKind::kService:
        installed = services_.add(*environment, *environment, name(), bound_.prefix, *service_).install();
        break;
      case InterfaceKind::kAction:
        installed = actions_.add(*environment, *environment, name(), bound_.prefix, *action_).install();
        break;
    }
    if (!installed) remove(*environment);
    return installed;
  }

  void clips_env_destroyed(EnvironmentGuard environment) override {
    if (BusConnection* binding = find(*environment)) binding->close(left_);
    remove(*environment);
  }

  void finalize() override {
    for (const std::string& line : left_.lines()) log(LogLevel::kWarn, line);
  }

 private:
  BusConnection* find(const Environment& environment) const {
    switch (bound_.kind) {
      case InterfaceKind::kMessage: return messages_.find(environment);
      case InterfaceKind::kService: return services_.find(environment);
      case InterfaceKind::kAction: return actions_.find(environment);
    }
    return nullptr;
  }
  void remove(const Environment& environment) {
    messages_.remove(environment);
    services_.remove(environment);
    actions_.remove(environment);
  }

  BindingClass bound_;
  const bus::MessageType* message_ = nullptr;
  const bus::ServiceType* service_ = nullptr;
  const bus::ActionType* action_ = nullptr;
  PerEnvironment<MessageBinding> messages_;
  PerEnvironment<ServiceBinding> services_;
  PerEnvironment<ActionBinding> actions_;
  Leftovers left_;
};

}  // namespace

PluginType bindings_plugin() {
  PluginType family;
  family.name = "cx::CX<Pkg><Name>Plugin";
  family.make = [](PluginContext c) { return std::make_unique<BindingsPlugin>(std::move(c)); };
  family.has = [](const std::string& type, bus::Registry& interfaces) {
    return find_binding(type, interfaces).has_value();
  };
  family.classes = [](bus::Registry& interfaces) { return binding_classes(interfaces); };
  return family;
}

}  // namespace cxlab::cx
