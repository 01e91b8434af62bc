#include <algorithm>
#include <optional>

#include "cx/plugins/builtin.h"

namespace cxlab::cx {

namespace {

constexpr const char* kTimeRules = R"((defglobal ?*PRIORITY-TIME-RETRACT* = -10000)
(defrule time-retract
  "A time fact lives until the end of the run in which it was asserted."
  (declare (salience ?*PRIORITY-TIME-RETRACT*))
  ?f <- (time $?)
  =>
  (retract ?f))
(unwatch facts time)
(unwatch rules time-retract)
)";

/// Runs its environments at a rate.
class ExecutivePlugin final : public Plugin {
 public:
  using Plugin::Plugin;

  Status initialize() override {
    if (Status s = parameter("publish_on_refresh", publish_on_refresh_); !s) return s;
    if (Status s = parameter("assert_time", assert_time_); !s) return s;
    if (Status s = parameter("refresh_rate", refresh_rate_); !s) return s;
    if (refresh_rate_ <= 0)
      return context().parameters.error_at(name() + ".refresh_rate", "parameter '" + name() + ".refresh_rate': found " +
                                                                         std::to_string(refresh_rate_) +
                                                                         ", expected a rate in Hz above 0");
    start_ = context().bus.now();
    if (!publish_on_refresh_) return {};
    auto type = context().bus.registry().message("std_msgs/msg/Empty");
    if (!type) return type.error();
    auto publisher = context().bus.advertise(context().node, "clips_executive/refresh_agenda", **type);
    if (!publisher) return publisher.error();
    publisher_ = *publisher;
    tick_message_ = std::make_shared<const bus::Message>(**type);
    return {};
  }

  Status clips_env_init(EnvironmentGuard environment) override {
    RuleEngine& engine = environment.engine();
    const double epoch = context().run.epoch;
    if (Status s =
            engine.add_function({"now", "d", 0, 0, "", FunctionKind::kPure, name(), "Simulated time in seconds."},
                                [](Call& call) { call.give_number(to_seconds(call.engine().now())); });
        !s)
      return s;
    if (Status s =
            engine.add_function({"now-systime", "d", 0, 0, "", FunctionKind::kPure, name(),
                                 "Seconds since 1970: the epoch and simulated time."},
                                [epoch](Call& call) { call.give_number(epoch + to_seconds(call.engine().now())); });
        !s)
      return s;
    if (Status s = engine.load_text(kTimeRules, "cx_executive_plugin/time.clp", LoadMode::kBatch).status(); !s)
      return s;
    states_.add(*environment, State{next_});
    return {};
  }

  void clips_env_destroyed(EnvironmentGuard environment) override {
    states_.remove(*environment);
    if (environment->ending()) return;
    for (const auto& [kind, construct] :
         {std::pair{"defrule", "time-retract"}, std::pair{"defglobal", "PRIORITY-TIME-RETRACT"}})
      if (Status s = environment.engine().undefine(kind, construct); !s)
        log(*environment, LogLevel::kWarn, std::string(construct) + " cant be undefined");
  }

  void finalize() override {
    if (publisher_) context().bus.remove(*publisher_);
  }

  SimTime next_due(const Environment& environment) const override {
    const State* state = states_.find(environment);
    return due_time(start_, state->next, static_cast<double>(refresh_rate_));
  }

  Status on_due(EnvironmentGuard environment) override {
    State& state = *states_.find(*environment);
    const SimTime now = environment->now();
    // Dues that a long tick stepped over are one run.
    while (due_time(start_, state.next, static_cast<double>(refresh_rate_)) <= now) ++state.next;
    next_ = std::max(next_, state.next);
    if (assert_time_) {
      environment.engine().clear_cause();
      const Value time = Value::number(to_seconds(now));
      if (auto fact = environment.engine().assert_ordered("time", {&time, 1}); !fact) return fact.error();
    }
    if (Status s = environment->run(); !s) return s;
    if (publisher_ && states_.is_last(*environment)) context().bus.publish(*publisher_, tick_message_);
    return {};
  }

 private:
  struct State {
    std::int64_t next = 0;  ///< the k of the next due time
  };

  bool publish_on_refresh_ = false;
  bool assert_time_ = true;
  std::int64_t refresh_rate_ = 10;  ///< Hz
  SimTime start_{};
  std::int64_t next_ = 0;  ///< that of an environment which comes now: all keep one beat
  std::optional<bus::EndpointId> publisher_;
  bus::SharedMessage tick_message_;
  PerEnvironment<State> states_;
};

}  // namespace

PluginType executive_plugin() {
  return {"cx::ExecutivePlugin", {"publish_on_refresh", "assert_time", "refresh_rate"}, [](PluginContext c) {
            return std::make_unique<ExecutivePlugin>(std::move(c));
          }};
}

}  // namespace cxlab::cx
