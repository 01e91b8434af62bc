// A plugin with a function for rules, a template, a parameter, and messages of its own.

#include <cx/executive/export_plugins.h>

namespace my {

namespace cx = cxlab::cx;

/// (counter-add N) adds N to the environment's counter, publishes my_plugin/msg/Count and gives the sum.
class MyPluginCounter final : public cx::Plugin {
 public:
  using Plugin::Plugin;

  /// Once, before the first environment: parameters are read and checked.
  cxlab::Status initialize() override {
    if (cxlab::Status s = parameter("start", start_); !s) return s;
    return parameter("topic", topic_);
  }

  /// Once an environment. What it adds carries this plugin's name as its owner, and goes with it.
  cxlab::Status clips_env_init(cx::EnvironmentGuard environment) override {
    const auto type = environment->bus().registry().message("my_plugin/msg/Count");
    if (!type) return type.error();
    const auto publisher = environment->bus().advertise(environment->participant(), topic_, **type);
    if (!publisher) return publisher.error();
    Counter& counter = counters_.add(*environment, Counter{start_, *publisher, *type});
    if (cxlab::Status s = environment.engine().build("(deftemplate counter (slot value (type INTEGER)))"); !s) return s;
    return environment.engine().add_function(
        {.name = "counter-add",
         .returns = "l",
         .min_args = 1,
         .max_args = 1,
         .arg_types = ";l",
         .kind = cxlab::FunctionKind::kActing,
         .owner = name(),
         .doc = "Adds to the environment's counter and gives the sum."},
        [&counter, &e = *environment](cxlab::Call& call) { call.give_integer(add(e, counter, call.integer(0))); });
  }

  /// Once an environment, in reverse order of loading: takes back what does not go by itself.
  void clips_env_destroyed(cx::EnvironmentGuard environment) override {
    if (const Counter* counter = counters_.find(*environment)) environment->bus().remove(counter->publisher);
    if (!environment->ending() && !environment.engine().undefine("deftemplate", "counter"))
      log(*environment, cx::LogLevel::kWarn, "counter cant be undefined");
    counters_.remove(*environment);
  }

 private:
  struct Counter {
    std::int64_t value = 0;
    cxlab::bus::EndpointId publisher{};
    const cxlab::bus::MessageType* type = nullptr;
  };

  static std::int64_t add(cx::Environment& environment, Counter& counter, std::int64_t amount) {
    counter.value += amount;
    auto message = std::make_shared<cxlab::bus::Message>(*counter.type);
    message->view().set("environment", environment.name()).set("value", counter.value);
    environment.bus().publish(counter.publisher, std::move(message), environment.engine().cause());
    return counter.value;
  }

  std::int64_t start_ = 0;
  std::string topic_ = "count";
  cx::PerEnvironment<Counter> counters_;
};

}  // namespace my

CXLAB_PLUGINS(my::MyPluginCounter);
