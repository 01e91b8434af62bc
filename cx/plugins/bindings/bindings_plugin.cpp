#include "cx/plugins/bindings/binding.h"
#include "cx/plugins/bindings/names.h"
#include "cx/plugins/builtin.h"

namespace cxlab::cx {

namespace {

/// The bindings of one interface, whose definition is read when the plugin is made.
class BindingsPlugin final : public ConnectionPlugin {
 public:
  using ConnectionPlugin::ConnectionPlugin;

  Status initialize() override {
    bus::Registry& interfaces = context().bus.registry();
    const auto bound = find_binding(type(), interfaces);
    if (!bound) return input_error("plugin '" + name() + "': no interface is bound by " + type());
    switch (bound->kind) {
      case InterfaceKind::kMessage: return bind<MessageBinding>(interfaces.message(bound->interface), bound->prefix);
      case InterfaceKind::kService: return bind<ServiceBinding>(interfaces.service(bound->interface), bound->prefix);
      case InterfaceKind::kAction: return bind<ActionBinding>(interfaces.action(bound->interface), bound->prefix);
    }
    return {};
  }

 private:
  template <class Kind, class Type>
  Status bind(const Expected<const Type*>& interface, const std::string& prefix) {
    if (!interface) return interface.error();
    make_ = [this, prefix, &type = **interface](Environment& environment) {
      return std::make_unique<Kind>(environment, name(), prefix, type);
    };
    return {};
  }
  std::unique_ptr<BusConnection> connect(Environment& environment) override { return make_(environment); }

  std::function<std::unique_ptr<BusConnection>(Environment&)> make_;
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
