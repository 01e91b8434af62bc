#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cx/bus/needed.h"
#include "cx/node/lifecycle.h"
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
    bool autostart = true;
    if (Status s = parameter("publish_on_refresh", publish_on_refresh_); !s) return s;
    if (Status s = parameter("assert_time", assert_time_); !s) return s;
    if (Status s = parameter("refresh_rate", refresh_rate_); !s) return s;
    if (Status s = parameter("autostart", autostart); !s) return s;
    if (refresh_rate_ <= 0)
      return context().parameters.error_at(name() + ".refresh_rate",
                                           "parameter '" + name() + ".refresh_rate': " +
                                               found_expected(std::to_string(refresh_rate_), "a rate in Hz above 0"));
    start_ = context().bus.now();
    paused_ = !autostart;
    if (Status s = serve_control(); !s) return s;
    return publish_on_refresh_ ? advertise_refresh() : Status();
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
    if (!context().run.next)
      if (Status s = engine.load_text(kTimeRules, "cx_executive_plugin/time.clp", LoadMode::kBatch).status(); !s)
        return s;
    State state{environment.operator->(), {{"MAIN"}}, next_};
    Parameters& parameters = context().parameters;
    if (Status s = parameters.declare(environment->name() + ".focus_stack", state.pass.focus_stack); !s) return s;
    if (Status s = parameters.declare(environment->name() + ".rule_limit", state.pass.rule_limit); !s) return s;
    // The released CX gives no focus: what an error has left on the stack goes on.
    if (!context().run.next && state.pass.focus_stack == std::vector<std::string>{"MAIN"})
      state.pass.focus_stack.clear();
    states_.push_back(std::move(state));
    return {};
  }

  void clips_env_destroyed(EnvironmentGuard environment) override {
    std::erase_if(states_, [&](const State& state) { return state.environment == environment.operator->(); });
    if (environment->ending() || context().run.next) return;
    for (const auto& [kind, construct] :
         {std::pair{"defrule", "time-retract"}, std::pair{"defglobal", "PRIORITY-TIME-RETRACT"}})
      if (Status s = environment.engine().undefine(kind, construct); !s)
        log(*environment, LogLevel::kWarn, std::string(construct) + " cant be undefined");
  }

  void finalize() override {
    if (publisher_) context().bus.remove(*publisher_);
    for (const bus::EndpointId service : services_) context().bus.remove(service);
  }

  SimTime next_due(const Environment& environment) const override {
    if (!failure_) return SimTime::zero();
    return paused_ ? kNever : due_time(start_, find(environment)->next, static_cast<double>(refresh_rate_));
  }

  Status on_due(EnvironmentGuard environment) override {
    if (!failure_) return std::exchange(failure_, Status());
    State& state = *find(*environment);
    const SimTime now = environment->now();
    // Dues that a long tick stepped over are one run.
    state.next = due_after(now, start_, state.next, static_cast<double>(refresh_rate_));
    next_ = std::max(next_, state.next);
    auto fired = run(state);
    if (!fired) return fired.error();
    fired_ += *fired;
    if (&state == &states_.back()) publish_refresh();
    return {};
  }

 private:
  struct State {
    Environment* environment = nullptr;
    Environment::Pass pass;
    std::int64_t next = 0;  ///< the k of the next due time
  };

  const State* find(const Environment& environment) const {
    const auto found = std::find_if(states_.begin(), states_.end(),
                                    [&](const State& state) { return state.environment == &environment; });
    return found == states_.end() ? nullptr : &*found;
  }
  State* find(const Environment& environment) { return const_cast<State*>(std::as_const(*this).find(environment)); }

  // --- Running

  /// What an environment does in a refresh. Returns how many rules fired.
  Expected<std::int64_t> run(State& state) {
    Environment& environment = *state.environment;
    RuleEngine& engine = environment.engine();
    std::erase_if(state.pass.focus_stack, [&](const std::string& module) {
      if (engine.has("defmodule", module)) return false;
      log(environment, LogLevel::kError,
          "Focus stack entry '" + module + "' is not a valid module, removing from stack.");
      return true;
    });
    std::int64_t time_fact = 0;
    if (assert_time_) {
      engine.clear_cause();
      if (context().run.next) engine.use_module("MAIN");
      const Value time = Value::number(to_seconds(environment.now()));
      auto fact = engine.assert_ordered("time", {&time, 1});
      if (!fact) return fact.error();
      time_fact = *fact;
    }
    std::int64_t all = 0;
    Environment::Pass pass = state.pass;
    while (true) {
      auto fired = environment.run(pass);
      if (!fired) return fired.error();
      all += *fired;
      if (pass.rule_limit >= 0 && *fired == pass.rule_limit)
        log(environment, LogLevel::kError,
            "Env '" + environment.name() + "': Rule fire limit of " + std::to_string(state.pass.rule_limit) +
                " was reached.");
      if (!context().run.next) return all;
      if (time_fact > 0) engine.retract(std::exchange(time_fact, 0));
      if (*fired == 0 || (pass.rule_limit >= 0 && *fired == pass.rule_limit)) return all;
      if (pass.rule_limit >= 0) pass.rule_limit -= *fired;
    }
  }

  Status advertise_refresh() {
    const bool next = context().run.next;
    auto type = bus::needed_message(context().bus.registry(), next ? "std_msgs/msg/Int64" : "std_msgs/msg/Empty");
    if (!type) return type.error();
    auto publisher = context().bus.advertise(context().node,
                                             next ? topic("refresh_agenda") : "clips_executive/refresh_agenda", **type);
    if (!publisher) return publisher.error();
    publisher_ = *publisher;
    refresh_type_ = *type;
    return {};
  }

  /// All environments have run.
  void publish_refresh() {
    const std::int64_t fired = std::exchange(fired_, 0);
    if (!publisher_) return;
    bus::Message message(*refresh_type_);
    if (context().run.next) message.view().set("data", fired);
    context().bus.publish(*publisher_, std::make_shared<const bus::Message>(std::move(message)));
  }

  // --- Control, through services of the node

  std::string topic(const std::string& last) const { return "~/" + name() + '/' + last; }

  Status serve_control() {
    const std::vector<std::string> names{topic("pause"), topic("resume"), topic("tick_once"), topic("eval"),
                                         topic("build")};
    const char* const trigger = "std_srvs/srv/Trigger";
    const char* const command = "cx_msgs/srv/ClipsCommand";
    auto served =
        serve(context().bus, context().node,
              {{names[0].c_str(), trigger, [this](const auto&, const auto& answer) { pause(true, answer); }},
               {names[1].c_str(), trigger, [this](const auto&, const auto& answer) { pause(false, answer); }},
               {names[2].c_str(), trigger, [this](const auto&, const auto& answer) { tick_once(answer); }},
               {names[3].c_str(), command,
                [this](const auto& request, const auto& answer) {
                  carry_out(request, answer, [](Environment& environment, const std::string& text) -> std::string {
                    auto value = environment.engine().eval(text);
                    if (value) return {};
                    return value.error().code == kSyntaxCode
                               ? "Eval failed: syntax error while parsing the expression."
                               : "Eval failed: error occurred while executing the parsed expression.";
                  });
                }},
               {names[4].c_str(), command, [this](const auto& request, const auto& answer) {
                  carry_out(request, answer, [](Environment& environment, const std::string& text) -> std::string {
                    const Status built = environment.engine().build(text);
                    if (built) return {};
                    environment.print("stderr", built.error().message + '\n');
                    return built.error().code == kSyntaxCode ? "Build failed: syntax error while parsing the construct."
                           : built.error().code == kUnknownConstructCode
                               ? "Build failed: construct name not recognized."
                               : "Build failed: construct could not be added to the environment.";
                  });
                }}});
    if (!served) return served.error();
    services_ = *std::move(served);
    return {};
  }

  void pause(bool pause, const bus::MessageView& answer) {
    const bool changes = paused_ != pause;
    const std::string text = name() + (changes ? "" : " already") +
                             (pause     ? " paused."
                              : changes ? " resumed."
                                        : " running.");
    if (changes) {
      paused_ = pause;
      for (State& state : states_)
        state.next = due_after(context().bus.now(), start_, state.next, static_cast<double>(refresh_rate_));
      log(LogLevel::kInfo, text);
    }
    answer.set("success", changes).set("message", text);
  }

  void tick_once(const bus::MessageView& answer) {
    for (State& state : states_) {
      auto fired = run(state);
      if (fired)
        fired_ += *fired;
      else if (failure_)
        failure_ = fired.error();
    }
    publish_refresh();
    answer.set("success", true).set("message", "Tick executed.");
  }

  /// What it is asked to carry out in a tick may ask for more: rules end where that has no end.
  void count_one(Environment& environment) {
    if (std::exchange(asked_at_, context().bus.now()) != context().bus.now()) asked_ = 0;
    const std::int64_t most = context().run.max_firings;
    if (most != 0 && ++asked_ > most && failure_)
      failure_ = run_error("environment '" + environment.name() + "': " + std::to_string(asked_) +
                           " commands of eval and build came in one tick; if they are right, allow more with "
                           "max_firings_per_tick (now " +
                           std::to_string(most) + ", 0 = no limit), or with --max-firings of cxlab env")
                     .with_code("rule_loop");
  }

  /// `act` returns what went wrong, or nothing.
  template <class Act>
  void carry_out(const bus::MessageView& request, const bus::MessageView& answer, Act act) {
    const std::string wanted = request.text("env_name");
    const auto found = std::find_if(states_.begin(), states_.end(), [&](const State& state) {
      return wanted.empty() || state.environment->name() == wanted;
    });
    std::string wrong;
    if (states_.empty()) {
      wrong = "No environments available.";
    } else if (found == states_.end()) {
      wrong = "Environment '" + wanted + "' not found.";
    } else {
      Environment& environment = *found->environment;
      count_one(environment);
      const bool logged = environment.set_topic_logging(true);
      wrong = act(environment, request.text("command"));
      environment.set_topic_logging(logged);
      (void)environment.engine().take_errors();  // the answer reports them
    }
    answer.set("success", wrong.empty()).set("message", wrong);
  }

  bool publish_on_refresh_ = false;
  bool assert_time_ = true;
  bool paused_ = false;
  std::int64_t refresh_rate_ = 10;  ///< Hz
  SimTime start_{};
  std::int64_t next_ = 0;   ///< that of an environment which comes now: all keep one beat
  std::int64_t fired_ = 0;  ///< in this refresh
  std::int64_t asked_ = 0;  ///< commands of eval and build in the tick `asked_at_`
  SimTime asked_at_{};
  std::vector<bus::EndpointId> services_;
  std::optional<bus::EndpointId> publisher_;
  const bus::MessageType* refresh_type_ = nullptr;
  std::vector<State> states_;  ///< in order of loading
  Status failure_;             ///< of a tick that was asked for
};

}  // namespace

PluginType executive_plugin() {
  return {"cx::ExecutivePlugin",
          {"publish_on_refresh", "assert_time", "refresh_rate", "autostart"},
          [](PluginContext c) { return std::make_unique<ExecutivePlugin>(std::move(c)); }};
}

}  // namespace cxlab::cx
