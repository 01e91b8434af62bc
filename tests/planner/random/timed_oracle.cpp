#include "tests/planner/random/timed_oracle.h"

#include <algorithm>
#include <set>

namespace cxlab::planner {

namespace {

struct Situation {
  unsigned facts = 0;
  int count = 0;
  std::vector<int> left;  ///< by action: instants until it ends, -1 where it does not run
  auto operator<=>(const Situation&) const = default;
};

bool holds(const std::vector<Literal>& literals, unsigned facts) {
  return std::ranges::all_of(literals, [&](const Literal& literal) {
    return ((facts >> literal.fact) & 1) == static_cast<unsigned>(literal.value);
  });
}

/// What the happenings of one instant read and write.
struct Footprint {
  unsigned read = 0, add = 0, remove = 0;
  bool reads_count = false, changes_count = false;

  bool interferes(const Footprint& other) const {
    return (read & (other.add | other.remove)) || (other.read & (add | remove)) || (add & other.remove) ||
           (remove & other.add) || (reads_count && other.changes_count) || (other.reads_count && changes_count);
  }
  bool coincides(const Footprint& other) const { return (add & other.add) || (remove & other.remove); }
};

Footprint footprint(const std::vector<Literal>& conditions, const std::vector<Literal>& effects) {
  Footprint made;
  for (const Literal& literal : conditions) made.read |= 1u << literal.fact;
  for (const Literal& literal : effects) (literal.value ? made.add : made.remove) |= 1u << literal.fact;
  return made;
}

class Oracle {
 public:
  Oracle(const RandomProblem& problem, const OracleLimits& limits) : problem_(problem), limits_(limits) {}

  OracleAnswer run() { return visit(true); }

  /// Instants of the shortest plan; 0 until one is known.
  int end() const { return end_; }

  std::optional<int> least_metric() { return visit(false) == OracleAnswer::kTooLarge ? std::nullopt : best_; }

 private:
  /// Visits everything, or up to the first plan.
  OracleAnswer visit(bool first_only) {
    Situation first;
    for (int f = 0; f < problem_.facts; ++f)
      first.facts |= static_cast<unsigned>(problem_.initial[static_cast<std::size_t>(f)] != 0) << f;
    first.count = problem_.count;
    first.left.assign(problem_.actions.size(), -1);
    if (is_lasting_goal(first.facts, -1)) note_plan(0, first);
    if (best_ && first_only) return OracleAnswer::kSolvable;
    std::set<Situation> now = {first};
    std::size_t visited = 0;
    for (int instant = 0; instant < limits_.seconds * limits_.instants; ++instant) {
      std::set<Situation> after;
      for (const Situation& situation : now) {
        for (unsigned starts = 0; starts < (1u << problem_.actions.size()); ++starts) {
          Situation next = situation;
          if (!step(next, instant, starts)) continue;
          if (is_plan(next, situation, instant, starts)) {
            note_plan(instant / limits_.instants, next);
            if (end_ == 0) end_ = instant;
          }
          if (best_ && first_only) return OracleAnswer::kSolvable;
          after.insert(std::move(next));
        }
        if (++visited > limits_.most_situations) return OracleAnswer::kTooLarge;
      }
      now = std::move(after);
    }
    return OracleAnswer::kNoPlanInHorizon;
  }

 private:
  void note_plan(int seconds, const Situation& situation) {
    const int metric = problem_.time_weight * seconds + problem_.count_weight * situation.count;
    best_ = std::min(metric, best_.value_or(metric));
  }

  /// The goal holds and will after the events to come.
  bool is_lasting_goal(unsigned facts, int instant) const {
    if (!holds(problem_.goal, facts)) return false;
    std::vector<const RandomEvent*> later;
    for (const RandomEvent& event : problem_.events)
      if (event.time * limits_.instants > instant) later.push_back(&event);
    // At one time what is made true stays true.
    std::ranges::sort(later, {}, [](const RandomEvent* event) { return std::pair(event->time, event->effect.value); });
    for (const RandomEvent* event : later)
      facts = event->effect.value ? facts | (1u << event->effect.fact) : facts & ~(1u << event->effect.fact);
    return holds(problem_.goal, facts);
  }

  /// The last action ends.
  bool is_plan(const Situation& situation, const Situation& before, int instant, unsigned starts) const {
    return starts == 0 && std::ranges::all_of(situation.left, [](int left) { return left < 0; }) &&
           std::ranges::any_of(before.left, [](int left) { return left >= 0; }) &&
           is_lasting_goal(situation.facts, instant);
  }

  bool step(Situation& situation, int instant, unsigned starts) const {
    std::vector<Footprint> footprints;
    std::vector<const std::vector<Literal>*> effects;
    int change = 0;
    for (std::size_t a = 0; a < problem_.actions.size(); ++a) {
      const RandomAction& action = problem_.actions[a];
      int& left = situation.left[a];
      if (left > 0) --left;
      if (left == 0) {
        if (!holds(action.end, situation.facts)) return false;
        footprints.push_back(footprint(action.end, action.end_effects));
        footprints.back().changes_count = action.change != 0;
        effects.push_back(&action.end_effects);
        change += action.change;
      }
      if (!((starts >> a) & 1)) continue;
      if (left >= 0 || !holds(action.start, situation.facts) ||
          (action.least_count >= 0 && situation.count < action.least_count))
        return false;
      footprints.push_back(footprint(action.start, action.start_effects));
      footprints.back().reads_count = action.least_count >= 0;
      effects.push_back(&action.start_effects);
      left = action.duration * limits_.instants;
    }
    std::vector<std::vector<Literal>> events;
    for (const RandomEvent& event : problem_.events)
      if (event.time * limits_.instants == instant) events.push_back({event.effect});
    for (const auto& event : events) {
      footprints.push_back(footprint({}, event));
      effects.push_back(&event);
    }
    for (std::size_t i = 0; i < footprints.size(); ++i)
      for (std::size_t j = i + 1; j < footprints.size(); ++j)
        if (footprints[i].interferes(footprints[j]) ||
            (!limits_.may_coincide && footprints[i].coincides(footprints[j])))
          return false;
    for (const bool value : {false, true})
      for (const auto* list : effects)
        for (const Literal& literal : *list)
          if (literal.value == value)
            situation.facts = value ? situation.facts | (1u << literal.fact) : situation.facts & ~(1u << literal.fact);
    situation.count += change;
    for (std::size_t a = 0; a < problem_.actions.size(); ++a) {
      if (situation.left[a] == 0) situation.left[a] = -1;
      if (situation.left[a] > 0 && !holds(problem_.actions[a].over_all, situation.facts)) return false;
    }
    return true;
  }

  const RandomProblem& problem_;
  const OracleLimits limits_;
  std::optional<int> best_;  ///< least metric of a plan
  int end_ = 0;
};

}  // namespace

OracleAnswer ask_oracle(const RandomProblem& problem, const OracleLimits& limits) {
  return Oracle(problem, limits).run();
}

std::optional<int> ask_oracle_for_metric(const RandomProblem& problem, const OracleLimits& limits) {
  return Oracle(problem, limits).least_metric();
}

std::optional<int> shortest_plan_s(const RandomProblem& problem, const OracleLimits& limits) {
  Oracle oracle(problem, limits);
  if (oracle.run() != OracleAnswer::kSolvable) return std::nullopt;
  return oracle.end() / limits.instants;
}

}  // namespace cxlab::planner
