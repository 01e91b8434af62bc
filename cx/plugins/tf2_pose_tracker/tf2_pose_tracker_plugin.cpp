#include <algorithm>
#include <array>
#include <cmath>

#include "cx/base/number_text.h"
#include "cx/bus/transforms.h"
#include "cx/plugins/builtin.h"

namespace cxlab::cx {

namespace {

constexpr const char* kPoseTemplate = R"((deftemplate tf2-tracked-pose
  (slot parent (type STRING))
  (slot child (type STRING))
  (slot stamp (type FLOAT))
  (multislot translation (type FLOAT) (cardinality 3 3))
  (multislot rotation (type FLOAT) (cardinality 4 4))
  (slot timer (type EXTERNAL-ADDRESS))))";

/// As CLIPS reads the shortest spelling of the number: a whole one has no point and is an INTEGER.
Value component(double number) {
  const auto integer = read_number<std::int64_t>(shortest_text(number));
  return integer ? Value::integer(*integer) : Value::number(number);
}

Value list(std::initializer_list<double> numbers) {
  std::vector<Value> items;
  for (const double n : numbers) items.push_back(component(n));
  return Value::multifield(std::move(items));
}

/// One lookup that repeats, and the fact that it keeps.
struct Timer {
  Handle handle{};
  std::string parent, child;
  SimTime start{};
  double hz = 0;
  std::int64_t next = 1;  ///< the k of the next due time
  std::optional<std::int64_t> fact;

  SimTime due() const { return due_time(start, next, hz); }
};

struct Tracking {
  std::unique_ptr<bus::TransformListener> listener;
  std::vector<Timer> timers;  ///< in order of making
};

/// Whether it is the fact of that timer: after a reset another one may have its index.
bool is_of(const Timer& timer, const Expected<FactCopy>& fact) {
  if (!fact || fact->template_name != "tf2-tracked-pose") return false;
  const Value* owner = fact->slot("timer");
  return owner != nullptr && owner->as_handle() == timer.handle;
}

/// Keeps facts of where frames are.
class Tf2PoseTrackerPlugin final : public Plugin {
 public:
  using Plugin::Plugin;

  Status initialize() override {
    bool ignored = true;  // lookups never wait here, with or without a thread
    return parameter("spin_thread", ignored);
  }

  Status clips_env_init(EnvironmentGuard environment) override {
    Environment& e = *environment;
    RuleEngine& engine = e.engine();
    if (!engine.has("deftemplate", "tf2-tracked-pose"))
      if (Status s = engine.build(kPoseTemplate, "cx_tf2_pose_tracker_plugin/tf2-tracked-pose.clp", 1); !s) return s;
    auto listener = bus::TransformListener::create(
        e.bus(), e.participant(), [this, &e](const std::string& why) { log(e, LogLevel::kError, why); });
    if (!listener) return listener.error();
    if (Status s = engine.add_function({"tf2-start-periodic-lookup", "b", 3, 3, ";sy;sy;d", FunctionKind::kActing,
                                        name(), "Keeps a tf2-tracked-pose fact of CHILD in PARENT, HZ times a second."},
                                       [this, &e](Call& call) { start(e, call); });
        !s)
      return s;
    if (Status s = engine.add_function({"tf2-stop-periodic-lookup", "b", 1, 1, ";e", FunctionKind::kActing, name(),
                                        "Ends the lookup of that timer; its fact stays."},
                                       [this, &e](Call& call) { stop(e, call); });
        !s)
      return s;
    states_.add(e).listener = *std::move(listener);
    return {};
  }

  void clips_env_destroyed(EnvironmentGuard environment) override {
    states_.remove(*environment);
    if (environment->ending()) return;
    if (Status s = environment.engine().undefine("deftemplate", "tf2-tracked-pose"); !s)
      log(*environment, LogLevel::kWarn, "tf2-tracked-pose cant be undefined");
  }

  SimTime next_due(const Environment& environment) const override {
    SimTime first = kNever;
    if (const Tracking* tracking = states_.find(environment))
      for (const Timer& timer : tracking->timers) first = std::min(first, timer.due());
    return first;
  }

  Status perceive(EnvironmentGuard environment) override {
    Tracking& tracking = *states_.find(*environment);
    for (Timer& timer : tracking.timers) {
      const SimTime now = environment->now();
      if (timer.due() > now) continue;
      // Dues that a long tick stepped over are one lookup.
      timer.next = due_after(now, timer.start, timer.next, timer.hz);
      if (Status s = look_up(*environment, tracking.listener->buffer(), timer); !s) return s;
    }
    return {};
  }

 private:
  void start(Environment& environment, Call& call) {
    const double hz = call.number(2);
    if (!(hz >= 1e-9) || hz > 1e9) {
      log(environment, LogLevel::kError,
          "Failed to create pose updater: " +
              found_expected("a rate of " + print_float(hz) + " Hz", "one from 1e-9 to 1e9"));
      call.give_boolean(false);
      return;
    }
    states_.find(environment)
        ->timers.push_back({call.engine().new_handle(),
                            std::string(call.text(0)),
                            std::string(call.text(1)),
                            environment.now(),
                            hz,
                            1,
                            {}});
    call.give_boolean(true);
  }

  void stop(Environment& environment, Call& call) {
    auto& timers = states_.find(environment)->timers;
    const auto found =
        std::find_if(timers.begin(), timers.end(), [&](const Timer& t) { return t.handle == call.handle(0); });
    if (found == timers.end()) log(environment, LogLevel::kWarn, "tf2-stop-periodic-lookup: invalid pointer!");
    call.give_boolean(found != timers.end());
    if (found != timers.end()) timers.erase(found);
  }

  Status look_up(Environment& environment, const bus::TransformBuffer& buffer, Timer& timer) {
    auto found = buffer.lookup(timer.parent, timer.child);
    if (!found) {
      log(environment, LogLevel::kWarn, "TF lookup failed: " + found.error().message);
      return {};
    }
    const auto& [position, turn] = found->pose;
    const std::array<RuleEngine::Slot, 3> changing{{{"stamp", Value::number(to_seconds(found->stamp))},
                                                    {"translation", list({position.x(), position.y(), position.z()})},
                                                    {"rotation", list({turn.x(), turn.y(), turn.z(), turn.w()})}}};
    RuleEngine& engine = environment.engine();
    engine.clear_cause();
    if (timer.fact && is_of(timer, engine.fact(*timer.fact))) return engine.modify_fact(*timer.fact, changing);
    if (timer.fact)
      log(environment, LogLevel::kWarn,
          "the tf2-tracked-pose of " + timer.child + " in " + timer.parent + " was retracted, asserting a new one");
    const std::array<RuleEngine::Slot, 6> slots{{{"parent", Value::string(timer.parent)},
                                                 {"child", Value::string(timer.child)},
                                                 changing[0],
                                                 changing[1],
                                                 changing[2],
                                                 {"timer", Value::handle(timer.handle)}}};
    auto fact = engine.assert_fact("tf2-tracked-pose", slots);
    if (!fact) return fact.error();
    timer.fact = *fact;
    return {};
  }

  PerEnvironment<Tracking> states_;
};

}  // namespace

PluginType tf2_pose_tracker_plugin() {
  return {"cx::Tf2PoseTrackerPlugin", {"spin_thread"}, [](PluginContext c) {
            return std::make_unique<Tf2PoseTrackerPlugin>(std::move(c));
          }};
}

}  // namespace cxlab::cx
