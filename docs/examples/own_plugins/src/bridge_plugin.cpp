// One instance in two environments: what rules of one send becomes a fact of the other, at the next tick.

#include <cx/executive/export_plugins.h>

#include <algorithm>
#include <list>
#include <string>
#include <vector>

namespace own {

namespace cx = cxlab::cx;

/// (bridge-send ENVIRONMENT FACT): FACT, a string like "(seen cup)", is asserted in ENVIRONMENT at the next tick. Both
/// environments list this instance.
class BridgePlugin final : public cx::Plugin {
 public:
  using Plugin::Plugin;

  cxlab::Status clips_env_init(cx::EnvironmentGuard environment) override {
    ends_.push_back({&*environment, {}});
    return environment.engine().add_function({.name = "bridge-send",
                                              .returns = "v",
                                              .min_args = 2,
                                              .max_args = 2,
                                              .arg_types = ";sy;s",
                                              .kind = cxlab::FunctionKind::kActing,
                                              .owner = name(),
                                              .doc = "Asserts a fact in another environment, at the next tick."},
                                             [this, &from = *environment](cxlab::Call& call) { send(from, call); });
  }

  /// What waits for this environment goes with it; the other end may go on.
  void clips_env_destroyed(cx::EnvironmentGuard environment) override {
    ends_.remove_if([&](const End& end) { return end.environment == &*environment; });
  }

  cxlab::SimTime next_due(const cx::Environment& environment) const override {
    const End* end = find(&environment);
    return end && !end->waiting.empty() ? end->waiting.front().sent + cxlab::SimTime{1} : cxlab::kNever;
  }

  /// Before rules run: asserts what was sent at an earlier tick.
  cxlab::Status perceive(cx::EnvironmentGuard environment) override {
    End& end = *find(&*environment);
    while (!end.waiting.empty() && end.waiting.front().sent < environment->now()) {
      const Item item = std::move(end.waiting.front());
      end.waiting.erase(end.waiting.begin());
      environment.engine().set_cause(item.cause);
      const auto fact = environment.engine().assert_string(item.fact);
      environment.engine().clear_cause();
      if (!fact) return fact.error();
    }
    return {};
  }

 private:
  struct Item {
    std::string fact;
    cxlab::SimTime sent{};
    std::vector<cxlab::RecordRef> cause;  ///< the firing of the rule that sent it, for the journal
  };
  struct End {
    cx::Environment* environment;
    std::vector<Item> waiting;
  };

  const End* find(const cx::Environment* environment) const {
    const auto found =
        std::find_if(ends_.begin(), ends_.end(), [&](const End& end) { return end.environment == environment; });
    return found == ends_.end() ? nullptr : &*found;
  }
  End* find(const cx::Environment* environment) { return const_cast<End*>(std::as_const(*this).find(environment)); }

  void send(cx::Environment& from, cxlab::Call& call) {
    for (End& end : ends_) {
      if (end.environment->name() != call.text(0)) continue;
      const auto cause = from.engine().cause();
      end.waiting.push_back({std::string(call.text(1)), from.now(), {cause.begin(), cause.end()}});
      return;
    }
    call.fail("no environment '" + std::string(call.text(0)) + "' has the plugin '" + name() + "'");
  }

  std::list<End> ends_;
};

}  // namespace own

CXLAB_PLUGINS(own::BridgePlugin);
