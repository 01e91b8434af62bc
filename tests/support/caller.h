#pragma once
// A node that calls services of a manager, as `ros2 service call` would.

#include "tests/support/lab.h"

namespace cxlab::cx {

/// A plugin that logs each hook, and fails or throws where its parameter `fail` says.
class LoggingPlugin final : public Plugin {
 public:
  using Plugin::Plugin;
  Status initialize() override {
    if (Status s = parameter("fail", fail_); !s) return s;
    return report("initialize");
  }
  Status clips_env_init(EnvironmentGuard environment) override {
    if (Status s =
            environment.engine().add_function({name() + "-word", "s", 0, 0, "", FunctionKind::kPure, name(), "A word."},
                                              [this](Call& call) { call.give_string(name()); });
        !s)
      return s;
    return report("init " + environment->name());
  }
  void clips_env_destroyed(EnvironmentGuard environment) override { (void)report("destroyed " + environment->name()); }
  void finalize() override { (void)report("finalize"); }

 private:
  Status report(const std::string& what) {
    log(LogLevel::kInfo, what);
    const std::string word = what.substr(0, what.find(' '));
    if (fail_ == word) return run_error(name() + " fails in " + word);
    if (fail_ == "throw-" + word) throw std::runtime_error("thrown in " + word);
    return {};
  }
  std::string fail_;
};

inline PluginType logging_plugin() {
  return {"test::Logging", {"fail"}, [](PluginContext c) { return std::make_unique<LoggingPlugin>(std::move(c)); }};
}

class Caller {
 public:
  explicit Caller(Lab& lab) : lab_(lab) {
    node_ = lab.bus.join(bus::ParticipantKind::kNode, {"caller", "/", {}}, lab.records.open_stream("node/caller"));
  }

  /// Calls, lets a tick go by and gives the answer as text; "" if none came.
  std::string call(const std::string& service, const std::string& type, const std::string& request = "{}") {
    post(service, type, request);
    const Status ticked = lab_.tick();
    EXPECT_TRUE(ticked.ok()) << ticked.error().text();
    return take();
  }
  /// The same without the tick.
  void post(const std::string& service, const std::string& type, const std::string& request = "{}") {
    auto found = lab_.registry.service(type);
    ASSERT_TRUE(found.ok()) << found.error().text();
    auto client = lab_.bus.create_client(node_, service, **found,
                                         [this](const bus::Delivery& d) { answer_ = d.message->view().to_string(); });
    ASSERT_TRUE(client.ok()) << client.error().text();
    auto message = bus::Message::from_yaml(*(*found)->request, request);
    ASSERT_TRUE(message.ok()) << message.error().text();
    answer_.clear();
    lab_.bus.call(*client, std::make_shared<const bus::Message>(*std::move(message)));
  }
  std::string take() {
    lab_.bus.deliver(node_);
    return answer_;
  }

  std::string manager_service(const std::string& name, const std::string& type, const std::string& request = "{}") {
    return call("/clips_manager/" + name, type, request);
  }
  /// The messages on a topic while `act` runs, as text.
  template <class Act>
  std::vector<std::string> listen(const std::string& topic, const std::string& type, const Act& act) {
    std::vector<std::string> heard;
    const auto found = lab_.registry.message(type);
    EXPECT_TRUE(found.ok());
    auto subscription = lab_.bus.subscribe(
        node_, topic, **found, [&](const bus::Delivery& d) { heard.push_back(d.message->view().to_string()); });
    EXPECT_TRUE(subscription.ok());
    act();
    lab_.bus.deliver(node_);
    lab_.bus.remove(*subscription);
    return heard;
  }
  std::string manager(const std::string& name, const std::string& type, const std::string& request = "{}") {
    return call("/clips_manager/" + name, "cx_msgs/srv/" + type, request);
  }
  std::string load(const std::string& env, const std::string& plugin) {
    return manager("load_plugin", "LoadClipsPlugin", "{env_name: '" + env + "', plugin_name: '" + plugin + "'}");
  }
  std::string unload(const std::string& env, const std::string& plugin) {
    return manager("unload_plugin", "UnloadClipsPlugin", "{env_name: '" + env + "', plugin_name: '" + plugin + "'}");
  }
  std::string change(const std::string& transition) {
    return call("/clips_manager/change_state", "lifecycle_msgs/srv/ChangeState",
                "{transition: {label: '" + transition + "'}}");
  }
  bus::ParticipantId node() const { return node_; }

 private:
  Lab& lab_;
  bus::ParticipantId node_{};
  std::string answer_;
};

}  // namespace cxlab::cx
