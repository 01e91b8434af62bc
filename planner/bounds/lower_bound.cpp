#include "planner/bounds/lower_bound.h"

#include <algorithm>

#include "planner/ground/mutex.h"
#include "planner/search/landmarks.h"
#include "planner/search/split.h"

namespace cxlab::planner {

namespace {

constexpr Micros kNever = DurationRange::kForever;

class Bounds {
 public:
  Bounds(const Simulator& simulator, Budget& budget) : simulator_(simulator), task_(simulator.task()), budget_(budget) {}

  Micros run() {
    find_durations();
    find_earliest();
    const Micros shared = resources(), bound = earliest_goal();
    return bound >= kNever ? 0 : std::max(bound, shared);
  }

 private:
  /// Shortest duration of each action in any state; 0 where that depends.
  void find_durations() {
    const PackedState none(static_cast<std::size_t>(simulator_.words()), 0);
    for (std::size_t a = 0; a < task_.actions.size(); ++a) {
      const GroundAction& action = task_.actions[a];
      Micros least = 0;
      for (const GroundDuration& duration : action.duration)
        if (duration.bound.is_constant() && duration.comparison != Comparison::kLessEqual)
          least = std::max(least, static_cast<Micros>(duration.bound.steps[0].value * kMicrosPerSecond));
      durations_.push_back(action.durative ? least : 0);
    }
  }

  Micros latest(const GroundCondition& condition) const {
    Micros time = 0;
    for (const int f : condition.facts) time = std::max(time, fact_[f]);
    for (const int c : condition.comparisons) time = std::max(time, comparison_[c]);
    return time;
  }

  /// What others may bring about while it runs does not hold up the beginning.
  Micros earliest_start(std::size_t a) const { return latest(task_.actions[a].start); }
  Micros earliest_end(std::size_t a) const {
    const GroundAction& action = task_.actions[a];
    return std::max({earliest_start(a) + durations_[a], latest(action.over_all), latest(action.end)});
  }

  void find_earliest() {
    fact_.assign(task_.facts.size(), kNever);
    comparison_.assign(task_.comparisons.size(), kNever);
    const PackedState initial = simulator_.initial();
    for (std::size_t f = 0; f < task_.facts.size(); ++f)
      if (is_set(initial.data(), static_cast<int>(f)) || (task_.facts[f].derived && task_.facts[f].is_complement)) fact_[f] = 0;
    // A comparison can come true as soon as one of its numbers changes.
    readers_.assign(task_.numbers.size(), {});
    for (std::size_t c = 0; c < task_.comparisons.size(); ++c) {
      if (task_.comparisons[c].holds(simulator_.numbers(initial.data())) || task_.comparisons[c].linear.duration_weight != 0) comparison_[c] = 0;
      for (const auto& step : task_.comparisons[c].expression.steps)
        if (step.kind == GroundExpression::Kind::kNumber) readers_[step.number].push_back(static_cast<int>(c));
    }
    bool changed = true;
    const auto lower = [&changed](Micros& time, Micros to) {
      if (to < time) time = to, changed = true;
    };
    const auto apply = [&](const GroundEffects& effects, Micros time) {
      for (const int f : effects.add) lower(fact_[f], time);
      for (const NumericEffect& effect : effects.numbers)
        for (const int c : readers_[effect.number]) lower(comparison_[c], time);
    };
    for (const TimedEvent& event : task_.events) apply(event.effects, event.time);
    while (changed) {
      changed = false;
      budget_.spend(Work::kBound, static_cast<std::int64_t>(task_.actions.size()));
      for (std::size_t a = 0; a < task_.actions.size(); ++a) {
        const GroundAction& action = task_.actions[a];
        const Micros start = earliest_start(a);
        if (start >= kNever) continue;
        apply(action.at_start, start);
        for (const ConditionalEffects& conditional : action.conditional) apply(conditional.at_start, start);
        for (const ContinuousEffect& effect : action.continuous)
          for (const int c : readers_[effect.number]) lower(comparison_[c], start);
        const Micros end = earliest_end(a);
        if (end >= kNever) continue;
        apply(action.at_end, end);
        for (const ConditionalEffects& conditional : action.conditional) apply(conditional.at_end, end);
      }
      for (const Axiom& axiom : task_.axioms) lower(fact_[axiom.head], latest(axiom.body));
    }
  }

  /// What events bring about of the goal may come after the end of the plan.
  Micros earliest_goal() {
    for (const TimedEvent& event : task_.events) {
      for (const int f : event.effects.add) fact_[f] = 0;
      for (const NumericEffect& effect : event.effects.numbers)
        for (const int c : readers_[effect.number]) comparison_[c] = 0;
    }
    for (bool changed = !task_.events.empty(); changed;) {
      changed = false;
      for (const Axiom& axiom : task_.axioms)
        if (const Micros time = latest(axiom.body); time < fact_[axiom.head]) fact_[axiom.head] = time, changed = true;
    }
    return latest(task_.goal);
  }

  /// Actions that take a fact at their start and give it back at their end cannot overlap if they share it.
  Micros resources() {
    const std::optional<GroundTask> parts = untimed(task_);  // its landmarks are those of overlapping plans, too
    if (!task_.axioms.empty() || !parts) return 0;
    const Simulator simulator(*parts);
    const RelaxedTask relaxed(simulator, true);
    const Landmarks landmarks(simulator, relaxed, 20'000'000);
    budget_.spend(Work::kBound, landmarks.work());
    const PackedState initial = simulator_.initial();
    std::vector<std::vector<int>> achievers(task_.facts.size());
    for (std::size_t a = 0; a < task_.actions.size(); ++a)
      for (const auto* effects : {&task_.actions[a].at_start, &task_.actions[a].at_end})
        for (const int f : effects->add) achievers[f].push_back(static_cast<int>(a));
    for (const GroundAction& action : task_.actions)
      for (const ConditionalEffects& conditional : action.conditional)
        for (const auto* effects : {&conditional.at_start, &conditional.at_end})
          for (const int f : effects->add) achievers[f].clear();  // not known which actions
    for (const TimedEvent& event : task_.events)
      for (const int f : event.effects.add) achievers[f].clear();
    std::vector<std::vector<int>> locks(task_.facts.size());  // by resource: actions
    for (std::size_t a = 0; a < task_.actions.size(); ++a)
      for (const int f : task_.actions[a].start.facts)
        if (std::ranges::binary_search(task_.actions[a].at_start.remove, f)) locks[f].push_back(static_cast<int>(a));
    Micros best = 0;
    for (std::size_t resource = 0; resource < locks.size(); ++resource) {
      if (locks[resource].size() < 2) continue;
      bool unary = true;  // nothing else gives it back
      for (const int a : achievers[resource]) unary = unary && std::ranges::binary_search(locks[resource], a) && std::ranges::binary_search(task_.actions[a].at_end.add, static_cast<int>(resource));
      if (!unary || achievers[resource].empty()) continue;
      std::vector<char> used(task_.actions.size(), 0);
      Micros work = 0, head = kNever;
      for (const int atom : landmarks.atoms()) {
        if (atom >= static_cast<int>(task_.facts.size()) || is_set(initial.data(), atom) || achievers[atom].empty()) continue;
        const std::vector<int>& ways = achievers[atom];
        if (!std::ranges::all_of(ways, [&](int a) { return !used[a] && std::ranges::binary_search(locks[resource], a); })) continue;
        Micros shortest = kNever;
        for (const int a : ways) {
          used[a] = 1;
          const bool returns = std::ranges::binary_search(task_.actions[a].at_end.add, static_cast<int>(resource));
          shortest = std::min(shortest, returns ? durations_[a] : 0);
          head = std::min(head, earliest_start(static_cast<std::size_t>(a)));
        }
        work += shortest;
      }
      if (work > 0) best = std::max(best, head + work);
    }
    return best;
  }

  const Simulator& simulator_;
  const GroundTask& task_;
  Budget& budget_;
  std::vector<Micros> durations_, fact_, comparison_;
  std::vector<std::vector<int>> readers_;  ///< by number: comparisons
};

}  // namespace

Micros lower_bound(const GroundTask& task, Budget& budget) {
  const std::vector<char> possible = possible_actions(task);
  GroundTask reduced = task;
  std::size_t kept = 0;
  for (std::size_t a = 0; a < task.actions.size(); ++a)
    if (possible[a]) reduced.actions[kept++] = task.actions[a];
  reduced.actions.resize(kept);
  budget.spend(Work::kBound, static_cast<std::int64_t>(task.actions.size() * (1 + task.facts.size() / 64)));
  const Simulator simulator(reduced);
  return Bounds(simulator, budget).run();
}

}  // namespace cxlab::planner
