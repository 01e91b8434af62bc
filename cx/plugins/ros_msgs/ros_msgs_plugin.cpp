#include "cx/plugins/ros_msgs/ros_msgs_plugin.h"

#include <array>

#include "cx/plugins/ros_msgs/ros_interface.h"

namespace cxlab::cx {

namespace {

struct Template {
  const char* name;
  const char* text;
};

constexpr std::array<Template, 11> kTemplates{{
    {"ros-msgs-subscription", "(deftemplate ros-msgs-subscription (slot topic (type STRING)) (slot type (type STRING)))"},
    {"ros-msgs-publisher", "(deftemplate ros-msgs-publisher (slot topic (type STRING)) (slot type (type STRING)))"},
    {"ros-msgs-message", "(deftemplate ros-msgs-message (slot topic (type STRING)) (slot msg-ptr (type EXTERNAL-ADDRESS)))"},
    {"ros-msgs-client", "(deftemplate ros-msgs-client (slot service (type STRING)) (slot type (type STRING)))"},
    {"ros-msgs-response", "(deftemplate ros-msgs-response (slot service (type STRING)) (slot request-id (type INTEGER)) "
                          "(slot msg-ptr (type EXTERNAL-ADDRESS)))"},
    {"ros-msgs-service", "(deftemplate ros-msgs-service (slot service (type STRING)) (slot type (type STRING)))"},
    {"ros-msgs-action-client", "(deftemplate ros-msgs-action-client (slot server (type STRING)) (slot type (type STRING)))"},
    {"ros-msgs-goal-response", "(deftemplate ros-msgs-goal-response (slot server (type STRING)) "
                               "(slot client-goal-handle-ptr (type EXTERNAL-ADDRESS)))"},
    {"ros-msgs-wrapped-result", "(deftemplate ros-msgs-wrapped-result (slot server (type STRING)) (slot goal-id (type SYMBOL)) "
                                "(slot code (type SYMBOL) (allowed-values UNKNOWN SUCCEEDED CANCELED ABORTED)) "
                                "(slot result-ptr (type EXTERNAL-ADDRESS)))"},
    {"ros-msgs-feedback", "(deftemplate ros-msgs-feedback (slot server (type STRING)) (slot client-goal-handle-ptr (type EXTERNAL-ADDRESS)) "
                          "(slot feedback-ptr (type EXTERNAL-ADDRESS)))"},
    {"ros-msgs-cancel-response", "(deftemplate ros-msgs-cancel-response (slot server (type STRING)) "
                                 "(slot client-goal-handle-ptr (type EXTERNAL-ADDRESS)) (slot cancel-response-ptr (type EXTERNAL-ADDRESS)))"},
}};

/// The bus for rules, with any message type.
class RosMsgsPlugin final : public Plugin {
 public:
  using Plugin::Plugin;

  Status clips_env_init(EnvironmentGuard environment) override {
    const Status installed = interfaces_.add(*environment, *environment, name()).install();
    if (!installed) interfaces_.remove(*environment);
    return installed;
  }

  void clips_env_destroyed(EnvironmentGuard environment) override {
    interfaces_.find(*environment)->close();
    interfaces_.remove(*environment);
  }

 private:
  PerEnvironment<RosInterface> interfaces_;
};

}  // namespace

Status RosInterface::install() {
  for (const Template& t : kTemplates)
    if (!engine_.has("deftemplate", t.name))
      if (Status s = engine_.build(t.text, "cx_ros_msgs_plugin/ros_msgs.clp", 1); !s) return s;
  for (const auto& functions : {message_functions(logger_), topic_functions(logger_), service_functions(logger_), action_functions(logger_)})
    for (const Entry& entry : functions)
      if (Status s = engine_.add_function(entry.spec, [this, f = entry.function](Call& call) { (this->*f)(call); }); !s) return s;
  return {};
}

void RosInterface::put(const char* deftemplate, std::initializer_list<RuleEngine::Slot> slots) {
  if (auto fact = engine_.assert_fact(deftemplate, slots); !fact) log(LogLevel::kError, fact.error().message);
}

void RosInterface::take_back(const char* deftemplate, std::string_view slot, std::string_view value) {
  for (const FactCopy& fact : engine_.facts(deftemplate)) {
    const Value* found = fact.slot(slot);
    if (found && found->text() == value) engine_.retract(fact.index);
  }
}

template <class Open>
void RosInterface::close_all(ByName<Open>& open, const std::string& what) {
  for (const auto& [name, entry] : open) {
    log(LogLevel::kWarn, "Environment " + environment_.name() + " has open " + name + ' ' + what + ", cleaning up ...");
    bus_.remove(entry.endpoint);
  }
  open.clear();
}

void RosInterface::close() {
  close_all(publishers_, "publishers");
  close_all(subscriptions_, "subscription");
  close_all(clients_, "clients");
  close_all(services_, "services");
  close_all(action_clients_, "action clients");
  if (store_.size() > 0) log(LogLevel::kWarn, "Found " + std::to_string(store_.size()) + " message(s), cleaning up ...");
  if (!goals_.empty()) log(LogLevel::kWarn, "Found " + std::to_string(goals_.size()) + " client goal handle(s), cleaning up ...");
  if (environment_.ending()) return;
  for (const Template& t : kTemplates)
    if (Status s = engine_.undefine("deftemplate", t.name); !s) log(LogLevel::kWarn, std::string(t.name) + " cant be undefined");
}

PluginType ros_msgs_plugin() {
  return {"cx::RosMsgsPlugin", {}, [](PluginContext c) { return std::make_unique<RosMsgsPlugin>(std::move(c)); }};
}

}  // namespace cxlab::cx
