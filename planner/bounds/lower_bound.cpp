#include "planner/bounds/lower_bound.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "planner/bounds/sequencing.h"
#include "planner/ground/sorted.h"
#include "planner/search/landmarks.h"
#include "planner/search/split.h"

namespace cxlab::planner {

namespace {

constexpr Micros kNever = DurationRange::kForever;
constexpr std::int64_t kLandmarkWork = 10;                  ///< word operations by unit of the slice
constexpr std::size_t kMostBytes = std::size_t{512} << 20;  ///< of the times of pairs
constexpr std::size_t kMostWays = 16;  ///< actions of an activity; more of them are seldom far apart

class Bounds {
 public:
  Bounds(const Simulator& simulator, Budget& budget)
      : simulator_(simulator), task_(simulator.task()), budget_(budget) {}

  LowerBound run(std::int64_t slice) {
    for (const GroundAction& action : task_.actions) durations_.push_back(constant_durations(action).least);
    find_earliest();
    LowerBound bound;
    if (budget_.late()) return {0, false, false};
    const ById<Micros> released = comparison_;
    bound.makespan = earliest_goal();
    if (bound.makespan >= kNever)
      bound.makespan = 0;
    else if (task_.axioms.empty())
      raise_by_pairs(bound, released, slice);
    return bound;
  }

 private:
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
      if (is_set(initial.data(), static_cast<int>(f)) || (task_.facts[f].derived && task_.facts[f].is_complement))
        fact_[f] = 0;
    // A comparison can come true as soon as one of its numbers changes.
    readers_.assign(task_.numbers.size(), {});
    for (std::size_t c = 0; c < task_.comparisons.size(); ++c) {
      if (task_.comparisons[c].holds(simulator_.numbers(initial.data())) ||
          task_.comparisons[c].linear.duration_weight != 0)
        comparison_[c] = 0;
      task_.comparisons[c].expression.for_each_number([&](int n) { readers_[n].push_back(static_cast<int>(c)); });
    }
    const auto apply = [&](const GroundEffects& effects, Micros time) {
      for (const int f : effects.add) lower(fact_[f], time);
      for (const NumericEffect& effect : effects.numbers)
        for (const int c : readers_[effect.number]) lower(comparison_[c], time);
    };
    for (const TimedEvent& event : task_.events) apply(event.effects, event.time);
    for (changed_ = true; changed_ && !budget_.late();) {
      changed_ = false;
      budget_.spend(Work::kBound, static_cast<std::int64_t>(task_.actions.size()));
      for (std::size_t a = 0; a < task_.actions.size(); ++a) {
        const GroundAction& action = task_.actions[a];
        const Micros start = earliest_start(a);
        if (start >= kNever) continue;
        for_each_share(action, [&](const ConditionalEffects& share) { apply(share.at_start, start); });
        for (const ContinuousEffect& effect : action.continuous)
          for (const int c : readers_[effect.number]) lower(comparison_[c], start);
        const Micros end = earliest_end(a);
        if (end >= kNever) continue;
        for_each_share(action, [&](const ConditionalEffects& share) { apply(share.at_end, end); });
      }
      apply_axioms();
    }
  }

  void lower(Micros& time, Micros to) {
    if (to >= time) return;
    time = to;
    changed_ = true;
  }

  void apply_axioms() {
    for (const Axiom& axiom : task_.axioms) lower(fact_[axiom.head], latest(axiom.body));
  }

  /// What events bring about of the goal may come after the end of the plan.
  Micros earliest_goal() {
    for (const TimedEvent& event : task_.events) {
      for (const int f : event.effects.add) fact_[f] = 0;
      for (const NumericEffect& effect : event.effects.numbers)
        for (const int c : readers_[effect.number]) comparison_[c] = 0;
    }
    for (changed_ = !task_.events.empty(); std::exchange(changed_, false);) apply_axioms();
    return latest(task_.goal);
  }

  /// `released` by comparison: earliest time.
  void raise_by_pairs(LowerBound& bound, const ById<Micros>& released, std::int64_t slice) {
    goal_ = task_.goal.facts;
    for (const TimedEvent& event : task_.events)
      std::erase_if(goal_, [&](int f) { return contains(event.effects.add, f); });
    const std::int64_t began = budget_.units();
    const BudgetSlice all_of_it(budget_, slice);
    const Micros unit = find_unit();
    const auto raise = [&](Micros to) {
      if (to > bound.makespan) {
        bound.makespan = to;
        bound.assumes_order = true;
      }
    };
    const HappeningTask happenings(task_, durations_, released, unit, budget_);
    budget_.spend(Work::kBound, static_cast<std::int64_t>(task_.actions.size()));
    const bool fits = 2 * PairTimes::bytes(happenings) <= kMostBytes;
    bound.complete = !fits;
    if (budget_.late() || !fits || units_of(Work::kBound, PairTimes::round_work(happenings)) > slice) return;
    PairTimes all(happenings);
    if (all.solve(budget_)) {
      raise(unit * all.time(goal_));
      Activities activities;
      {
        const BudgetSlice without_orders(budget_, began + slice - slice / 5 - budget_.units());
        activities = find_activities(happenings, all, unit, slice);
        bound.complete = !budget_.slice_over();
      }
      raise(unit * shortest_sequence(activities, budget_));
      bound.assumes_order = bound.assumes_order && all.assumes_order();
    }
    bound.complete = bound.complete && !budget_.slice_over();
  }

  Activities find_activities(const HappeningTask& happenings, const PairTimes& all, Micros unit, std::int64_t slice) {
    std::vector<std::vector<int>> ways;  // by activity: its actions
    for (std::vector<int>& actions : find_landmarks(slice)) {
      std::erase_if(actions, [&](int a) { return all.beginning(a) >= PairTimes::kNever; });
      if (!actions.empty() && actions.size() <= kMostWays && std::ranges::find(ways, actions) == ways.end())
        ways.push_back(std::move(actions));
    }
    std::ranges::stable_sort(ways, {}, &std::vector<int>::size);
    // By action: from its beginning to that of each other, last to the goal.
    ById<ById<PairTime>> after(task_.actions.size());
    PairTimes then(happenings);
    const auto look_after = [&](int a) {
      if (!after[a].empty()) return true;
      if (!then.solve_after(a, all, budget_)) return false;
      for (std::size_t b = 0; b < task_.actions.size(); ++b) after[a].push_back(then.beginning(static_cast<int>(b)));
      after[a].push_back(std::max(then.time(goal_), static_cast<PairTime>(durations_[a] / unit)));
      return true;
    };
    const auto first_unknown =
        std::ranges::find_if_not(ways, [&](const auto& actions) { return std::ranges::all_of(actions, look_after); });
    ways.erase(first_unknown, ways.end());
    Activities activities;
    for (const auto& first : ways) {
      PairTime head = PairTimes::kNever, tail = PairTimes::kNever;
      for (const int a : first) {
        head = std::min(head, all.beginning(a));
        tail = std::min(tail, after[a].back());
      }
      activities.heads.push_back(head);
      activities.tails.push_back(tail);
      activities.apart.emplace_back();
      for (const auto& second : ways) {
        PairTime least = PairTimes::kNever;
        for (const int a : first)
          for (const int b : second) least = std::min(least, a == b ? 0 : after[a][b]);
        activities.apart.back().push_back(least);
      }
    }
    return activities;
  }

  /// The longest unit of which all durations are multiples, unless that is too short to count with.
  Micros find_unit() const {
    Micros unit = 0, longest = 1;
    for (const Micros duration : durations_) {
      unit = std::gcd(unit, duration);
      longest = std::max(longest, duration);
    }
    return std::max<Micros>({unit, longest >> 17, 1});
  }

  /// Sets of actions of which every plan has one: all that add a landmark.
  std::vector<std::vector<int>> find_landmarks(std::int64_t slice) {
    std::vector<std::vector<int>> found;
    const std::optional<GroundTask> parts =
        untimed(task_, Ends::kOften);  // its landmarks are those of overlapping plans, too
    if (!parts || budget_.late()) return found;
    const Simulator simulator(*parts);
    const RelaxedTask relaxed(simulator, true);
    const Landmarks landmarks(simulator, relaxed, slice * kLandmarkWork, budget_);
    budget_.spend(Work::kBound, landmarks.work());
    ById<std::vector<int>> achievers(task_.facts.size());
    for (std::size_t a = 0; a < task_.actions.size(); ++a)
      for_each_effects(task_.actions[a], [&](const GroundEffects& effects) {
        for (const int f : effects.add) achievers[f].push_back(static_cast<int>(a));
      });
    for (const TimedEvent& event : task_.events)
      for (const int f : event.effects.add) achievers[f].clear();  // no action need do it
    for (const int atom : landmarks.atoms()) {
      if (atom >= static_cast<int>(task_.facts.size()) || task_.initial_facts[atom]) continue;
      std::vector<int>& actions = achievers[atom];
      actions.erase(std::unique(actions.begin(), actions.end()), actions.end());
      if (!actions.empty()) found.push_back(actions);
    }
    return found;
  }

  const Simulator& simulator_;
  const GroundTask& task_;
  Budget& budget_;
  ById<Micros> durations_, fact_, comparison_;
  ById<std::vector<int>> readers_;  ///< by number: comparisons
  std::vector<int> goal_;           ///< facts that no event brings about
  bool changed_ = false;            ///< a time was lowered
};

}  // namespace

LowerBound lower_bound(const GroundTask& task, Budget& budget, std::int64_t slice) {
  const Simulator simulator(task);
  return Bounds(simulator, budget).run(slice);
}

}  // namespace cxlab::planner
