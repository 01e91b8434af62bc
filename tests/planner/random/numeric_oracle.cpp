#include <algorithm>
#include <limits>
#include <set>

#include "tests/planner/random/numeric_problem.h"

namespace cxlab::planner {

namespace {

constexpr int kUndefined = std::numeric_limits<int>::min();
constexpr int kThousand = 1000;  ///< numbers are counted in thousandths, times in milliseconds

struct Run {
  int action = 0, start = 0, end = 0;
  bool fires = false;  ///< its conditional effect
  auto operator<=>(const Run&) const = default;
};

struct Situation {
  unsigned facts = 0;
  std::vector<int> numbers;
  std::vector<Run> runs;  ///< ascending
  int left = 0;           ///< steps that may still begin
  auto operator<=>(const Situation&) const = default;
};

bool holds(const NumericCondition& condition, const Situation& situation) {
  for (const Literal& literal : condition.facts)
    if (((situation.facts >> literal.fact) & 1) != static_cast<unsigned>(literal.value)) return false;
  for (const NumberTest& test : condition.numbers) {
    const int value = situation.numbers[static_cast<std::size_t>(test.number)], bound = test.value * kThousand;
    if (value == kUndefined) return false;
    const bool right = test.op == "<"    ? value < bound
                       : test.op == "<=" ? value <= bound
                       : test.op == "="  ? value == bound
                       : test.op == ">=" ? value >= bound
                                         : value > bound;
    if (!right) return false;
  }
  return true;
}

/// What one happening reads and changes.
struct Uses {
  unsigned read = 0, add = 0, remove = 0, numbers_read = 0, assigned = 0, moved = 0;

  void read_all(const NumericCondition& condition) {
    for (const Literal& literal : condition.facts) read |= 1u << literal.fact;
    for (const NumberTest& test : condition.numbers) numbers_read |= 1u << test.number;
  }
  void write_all(const NumericEffects& effects) {
    for (const Literal& literal : effects.facts) (literal.value ? add : remove) |= 1u << literal.fact;
    for (const NumberEffect& effect : effects.numbers)
      (effect.kind == "assign" ? assigned : moved) |= 1u << effect.number;
  }
  bool disturbs(const Uses& other) const {
    const unsigned written = add | remove, changed = assigned | moved;
    return (written & other.read) || (add & other.remove) || (changed & other.numbers_read) ||
           (assigned & (other.assigned | other.moved));
  }
};

class Finder {
 public:
  Finder(const NumericProblem& problem, const WitnessLimits& limits)
      : problem_(problem), limits_(limits), visited_(static_cast<std::size_t>(limits.seconds * limits.instants + 1)) {}

  WitnessAnswer run() {
    Situation first;
    for (int f = 0; f < problem_.facts; ++f)
      first.facts |= static_cast<unsigned>(problem_.initial[static_cast<std::size_t>(f)] != 0) << f;
    for (const auto& value : problem_.values) first.numbers.push_back(value ? *value * kThousand : kUndefined);
    first.left = limits_.steps;
    WitnessAnswer answer;
    if (ends_well(first, -1) || visit(first, 0)) answer.plan = steps_;
    answer.too_large = too_large_;
    return answer;
  }

 private:
  int time_of(int instant) const { return instant / limits_.instants * kThousand + instant % limits_.instants; }

  /// Nothing runs, and the goal holds after the events that come later than `time`.
  bool ends_well(Situation situation, int time) const {
    if (!situation.runs.empty()) return false;
    for (const NumericEvent& event : problem_.events)
      if (event.time * kThousand > time) apply(event, situation);
    return holds(problem_.goal, situation);
  }

  static void apply(const NumericEvent& event, Situation& situation) {
    if (event.of_number)
      situation.numbers[static_cast<std::size_t>(event.number)] = event.value * kThousand;
    else
      set(situation, event.fact);
  }
  static void set(Situation& situation, const Literal& literal) {
    situation.facts = literal.value ? situation.facts | (1u << literal.fact) : situation.facts & ~(1u << literal.fact);
  }

  /// Visits the situation right before an instant, whose happenings are still to be chosen. True: a plan was found.
  bool visit(const Situation& situation, int instant) {
    if (instant >= limits_.seconds * limits_.instants) return false;
    if (!visited_[static_cast<std::size_t>(instant)].insert(situation).second) return false;
    if (++situations_ > limits_.most_situations) {
      too_large_ = true;
      return false;
    }
    std::vector<Run> starts;
    return choose(situation, instant, 0, starts);
  }

  /// Chooses what begins: any number of copies of each action from `action` on.
  bool choose(const Situation& situation, int instant, std::size_t action, std::vector<Run>& starts) {
    if (too_large_) return false;
    if (action == problem_.actions.size()) return happen(situation, instant, starts);
    if (choose(situation, instant, action + 1, starts)) return true;
    if (static_cast<int>(starts.size()) >= situation.left) return false;
    const NumericAction& each = problem_.actions[action];
    if (!holds(each.start, situation)) return false;
    int least = each.least, most = each.most;
    if (each.duration == NumericAction::Duration::kNumber) {
      const int value = situation.numbers[static_cast<std::size_t>(each.number)];
      if (value == kUndefined || value < 0 || value % kThousand != 0) return false;
      least = most = value / kThousand;
    }
    const int now = time_of(instant);
    for (int length = least; length <= most; ++length) {
      starts.push_back({static_cast<int>(action), now, now + length * kThousand, fires(each, situation)});
      if (choose(situation, instant, action, starts)) return true;
      starts.pop_back();
    }
    return false;
  }

  static bool fires(const NumericAction& action, const Situation& situation) {
    return action.when && holds({{*action.when}, {}}, situation);
  }

  bool happen(const Situation& before, int instant, const std::vector<Run>& starts) {
    const int now = time_of(instant);
    Situation after = before;
    std::vector<Uses> uses;
    std::vector<Literal> facts;
    std::vector<std::pair<NumberEffect, int>> changes;  // and the value
    const auto effects = [&](const NumericEffects& from, int duration) {
      facts.insert(facts.end(), from.facts.begin(), from.facts.end());
      for (const NumberEffect& effect : from.numbers)
        changes.emplace_back(effect, effect.value * (effect.times_duration ? duration : kThousand));
    };
    const auto begin = [&](const Run& run) {
      const NumericAction& action = problem_.actions[static_cast<std::size_t>(run.action)];
      Uses& each = uses.emplace_back();
      each.read_all(action.start);
      each.write_all(action.at_start);
      if (action.when) each.read |= 1u << action.when->fact;
      if (action.duration == NumericAction::Duration::kNumber) each.numbers_read |= 1u << action.number;
      effects(action.at_start, run.end - run.start);
    };
    const auto finish = [&](const Run& run) {
      const NumericAction& action = problem_.actions[static_cast<std::size_t>(run.action)];
      if (!holds(action.end, before)) return false;
      Uses& each = uses.emplace_back();
      each.read_all(action.end);
      each.write_all(action.at_end);
      effects(action.at_end, run.end - run.start);
      if (!run.fires) return true;
      facts.push_back(action.then);
      (action.then.value ? each.add : each.remove) |= 1u << action.then.fact;
      return true;
    };
    after.runs.clear();
    for (const Run& run : before.runs)
      if (run.end > now)
        after.runs.push_back(run);
      else if (!finish(run))
        return false;
    for (const Run& run : starts) {
      begin(run);
      if (run.end > now)
        after.runs.push_back(run);
      else if (!finish(run))
        return false;
    }
    std::ranges::sort(after.runs);
    after.left -= static_cast<int>(starts.size());
    Uses outside;
    for (const NumericEvent& event : problem_.events) {
      if (event.time * kThousand != now) continue;
      if (event.of_number) {
        outside.assigned |= 1u << event.number;
        changes.push_back({{event.number, "assign", event.value, false}, event.value * kThousand});
      } else {
        (event.fact.value ? outside.add : outside.remove) |= 1u << event.fact.fact;
        facts.push_back(event.fact);
      }
    }
    uses.push_back(outside);
    for (std::size_t i = 0; i < uses.size(); ++i)
      for (std::size_t j = 0; j < uses.size(); ++j)
        if (i != j && uses[i].disturbs(uses[j])) return false;
    for (const bool value : {false, true})
      for (const Literal& literal : facts)
        if (literal.value == value) set(after, literal);
    for (const auto& [effect, value] : changes) {
      int& number = after.numbers[static_cast<std::size_t>(effect.number)];
      if (effect.kind == "assign")
        number = value;
      else if (number == kUndefined)
        return false;
      else
        number += effect.kind == "increase" ? value : -value;
    }
    for (const Run& run : after.runs)
      for (const auto& [n, rate] : problem_.actions[static_cast<std::size_t>(run.action)].rates)
        if (after.numbers[static_cast<std::size_t>(n)] == kUndefined) return false;
    const std::size_t known = steps_.size();
    for (const Run& run : starts) steps_.push_back({run.action, run.start, run.end - run.start});
    if ((!starts.empty() || after.runs.size() < before.runs.size()) && ends_well(after, now)) return true;
    if (pass(after, now, time_of(instant + 1)) && visit(after, instant + 1)) return true;
    steps_.resize(known);
    return false;
  }

  /// Lets time pass. False if a condition over all is broken.
  bool pass(Situation& situation, int from, int to) const {
    std::vector<int> rates(situation.numbers.size(), 0);
    for (const Run& run : situation.runs)
      for (const auto& [n, rate] : problem_.actions[static_cast<std::size_t>(run.action)].rates)
        rates[static_cast<std::size_t>(n)] += rate;
    // Values are linear in between, so that a value near each end and the ends decide.
    Situation later = situation;
    for (std::size_t n = 0; n < rates.size(); ++n)
      if (later.numbers[n] != kUndefined) later.numbers[n] += rates[n] * (to - from);
    for (const Run& run : situation.runs)
      if (!holds_between(problem_.actions[static_cast<std::size_t>(run.action)].over_all, situation, later))
        return false;
    situation.numbers = later.numbers;
    return true;
  }

  /// Whether a condition holds at all times between two situations, the two left out.
  static bool holds_between(const NumericCondition& condition, const Situation& first, const Situation& last) {
    if (!holds({condition.facts, {}}, first)) return false;
    for (const NumberTest& test : condition.numbers) {
      const int a = first.numbers[static_cast<std::size_t>(test.number)];
      const int b = last.numbers[static_cast<std::size_t>(test.number)], bound = test.value * kThousand;
      if (a == kUndefined) return false;
      const bool right = test.op == "<"    ? a <= bound && b <= bound && (a < bound || b < bound)
                         : test.op == "<=" ? a <= bound && b <= bound
                         : test.op == "="  ? a == bound && b == bound
                         : test.op == ">=" ? a >= bound && b >= bound
                                           : a >= bound && b >= bound && (a > bound || b > bound);
      if (!right) return false;
    }
    return true;
  }

  const NumericProblem& problem_;
  const WitnessLimits limits_;
  std::vector<std::set<Situation>> visited_;  ///< by instant
  std::size_t situations_ = 0;
  bool too_large_ = false;
  std::vector<WitnessStep> steps_;
};

}  // namespace

WitnessAnswer find_witness(const NumericProblem& problem, const WitnessLimits& limits) {
  return Finder(problem, limits).run();
}

}  // namespace cxlab::planner
