#include <algorithm>
#include <limits>

#include "tests/planner/random/wide_problem.h"

namespace cxlab::planner {

namespace {

constexpr Ticks kUndefined = std::numeric_limits<Ticks>::min();
constexpr Ticks kOne = 1'000'000;  ///< numbers are counted in millionths
constexpr Ticks kSecond = 1000;
constexpr Ticks kGrid = 500, kOffsets = 3;  ///< steps begin at multiples of the grid, and up to two milliseconds later
constexpr Ticks kHorizon = 9000, kLongest = 5000;
constexpr int kMostSteps = 3;

struct Run {
  int action = 0;
  Ticks start = 0, end = 0;
  std::vector<char> fires;  ///< its conditional effects, as far as is known
  auto operator<=>(const Run&) const = default;
};

struct Situation {
  unsigned facts = 0;
  std::vector<Ticks> numbers;
  std::vector<Run> runs;  ///< ascending
  int left = 0;           ///< steps that may still begin
  auto operator<=>(const Situation&) const = default;
};

bool is_true(const Literal& literal, unsigned facts) {
  return ((facts >> literal.fact) & 1) == static_cast<unsigned>(literal.value);
}

/// A sum with ?duration known, in millionths; kUndefined if a number is.
Ticks value(const WideSum& sum, const std::vector<Ticks>& numbers, Ticks duration) {
  Ticks total = sum.halves * (kOne / 2) + sum.duration * duration * (kOne / kSecond);
  for (const auto& [number, weight] : sum.numbers) {
    const Ticks each = numbers[static_cast<std::size_t>(number)];
    if (each == kUndefined) return kUndefined;
    total += weight * each;
  }
  return total;
}

/// Left minus right; kUndefined if a number is.
Ticks gap(const WideTest& test, const std::vector<Ticks>& numbers, Ticks duration) {
  const Ticks left = value(test.left, numbers, duration), right = value(test.right, numbers, duration);
  return left == kUndefined || right == kUndefined ? kUndefined : left - right;
}

bool accepts(const std::string& op, Ticks gap) {
  if (gap == kUndefined) return false;
  return op == "<" ? gap < 0 : op == "<=" ? gap <= 0 : op == "=" ? gap == 0 : op == ">=" ? gap >= 0 : gap > 0;
}

bool facts_hold(const WideCondition& condition, unsigned facts) {
  return std::ranges::all_of(condition.facts, [&](const Literal& each) { return is_true(each, facts); }) &&
         (condition.any.empty() ||
          std::ranges::any_of(condition.any, [&](const Literal& each) { return is_true(each, facts); }));
}

bool holds(const WideCondition& condition, const Situation& situation, Ticks duration) {
  return facts_hold(condition, situation.facts) && std::ranges::all_of(condition.tests, [&](const WideTest& test) {
           return accepts(test.op, gap(test, situation.numbers, duration));
         });
}

/// Whether a condition holds at all times between two situations, the two left out; numbers are linear in between.
bool holds_between(const WideCondition& condition, const Situation& first, const Situation& last, Ticks duration) {
  if (!facts_hold(condition, first.facts)) return false;
  return std::ranges::all_of(condition.tests, [&](const WideTest& test) {
    const Ticks a = gap(test, first.numbers, duration), b = gap(test, last.numbers, duration);
    if (a == kUndefined || b == kUndefined) return false;
    if (test.op == "=") return a == 0 && b == 0;
    const bool strict = test.op == "<" || test.op == ">";
    const int sign = test.op[0] == '<' ? -1 : 1;
    return sign * a >= 0 && sign * b >= 0 && (!strict || a != 0 || b != 0);
  });
}

/// What one happening reads and changes.
struct Uses {
  unsigned read = 0, add = 0, remove = 0, numbers_read = 0, assigned = 0, moved = 0;

  void read_sum(const WideSum& sum) {
    for (const auto& [number, weight] : sum.numbers) numbers_read |= 1u << number;
  }
  void read_all(const WideCondition& condition) {
    for (const auto* list : {&condition.facts, &condition.any})
      for (const Literal& literal : *list) read |= 1u << literal.fact;
    for (const WideTest& test : condition.tests) read_sum(test.left), read_sum(test.right);
  }
  void write_all(const WideEffects& effects) {
    for (const Literal& literal : effects.facts) (literal.value ? add : remove) |= 1u << literal.fact;
    for (const WideChange& change : effects.numbers) {
      (change.kind == "increase" || change.kind == "decrease" ? moved : assigned) |= 1u << change.number;
      read_sum(change.value);
    }
  }
  bool disturbs(const Uses& other) const {
    const unsigned written = add | remove, changed = assigned | moved;
    return (written & other.read) || (add & other.remove) || (changed & other.numbers_read) ||
           (assigned & (other.assigned | other.moved));
  }
};

class Finder {
 public:
  Finder(const WideProblem& problem, std::size_t most) : problem_(problem), most_(most) {}

  WideAnswer run() {
    Situation first;
    for (int f = 0; f < problem_.facts; ++f)
      first.facts |= static_cast<unsigned>(problem_.initial[static_cast<std::size_t>(f)] != 0) << f;
    for (const auto& initial : problem_.values) first.numbers.push_back(initial ? *initial * kOne : kUndefined);
    first.left = kMostSteps;
    WideAnswer answer;
    if (ends_well(first, -1) || visit(first, 0)) {
      answer.plan.emplace();
      for (const std::string& step : steps_) *answer.plan += step;
    }
    answer.too_large = too_large_;
    return answer;
  }

 private:
  static std::string seconds(Ticks time) {
    return std::to_string(time / kSecond) + "." + std::to_string(1000 + time % kSecond).substr(1);
  }

  /// Nothing runs, and the goal holds after the events that come later than `time`.
  bool ends_well(Situation situation, Ticks time) const {
    if (!situation.runs.empty()) return false;
    for (const WideEvent& event : problem_.events)
      if (event.time > time) {
        if (event.of_number)
          situation.numbers[static_cast<std::size_t>(event.number)] = event.value * kOne;
        else
          set(situation, event.fact);
      }
    return holds(problem_.goal, situation, 0);
  }

  static void set(Situation& situation, const Literal& literal) {
    situation.facts = literal.value ? situation.facts | (1u << literal.fact) : situation.facts & ~(1u << literal.fact);
  }

  /// Visits the situation right before a time, whose happenings are still to be chosen. True: a plan was found.
  bool visit(const Situation& situation, Ticks now) {
    if (now >= kHorizon) return false;
    if (!visited_[now].insert(situation).second) return false;
    if (++situations_ > most_) {
      too_large_ = true;
      return false;
    }
    std::vector<Run> starts;
    return choose(situation, now, 0, starts);
  }

  /// Durations that an action may choose when it begins.
  std::vector<Ticks> durations(const WideAction& action, const Situation& situation) const {
    if (!action.durative) return {0};
    Ticks least = 0, most = kLongest;
    for (const WideBound& each : action.duration) {
      if (each.at_end) continue;
      const Ticks bound = value(each.bound, situation.numbers, 0);
      if (bound == kUndefined || bound % (kOne / kSecond) != 0) return {};
      const Ticks time = bound / (kOne / kSecond);
      if (each.op != "<=") least = std::max(least, time);
      if (each.op != ">=") most = std::min(most, time);
    }
    std::vector<Ticks> found;
    for (Ticks time = least; time <= most && time <= kLongest; time = time / kGrid * kGrid + kGrid)
      found.push_back(time);
    if (most > least && most < kLongest && most % kGrid != 0) found.push_back(most);
    return found;
  }

  /// Chooses what begins: any number of copies of each action from `action` on.
  bool choose(const Situation& situation, Ticks now, std::size_t action, std::vector<Run>& starts) {
    if (too_large_) return false;
    if (action == problem_.actions.size()) return happen(situation, now, starts);
    if (choose(situation, now, action + 1, starts)) return true;
    if (static_cast<int>(starts.size()) >= situation.left || now % kGrid >= kOffsets) return false;
    const WideAction& each = problem_.actions[action];
    for (const Ticks length : durations(each, situation)) {
      if (!holds(each.start, situation, length)) continue;
      Run run{static_cast<int>(action), now, now + length, {}};
      for (const WideConditional& when : each.when) run.fires.push_back(holds(when.start, situation, length));
      starts.push_back(std::move(run));
      if (choose(situation, now, action, starts)) return true;
      starts.pop_back();
    }
    return false;
  }

  struct Happened {
    std::vector<Uses> uses;
    std::vector<Literal> facts;
    std::vector<std::pair<const WideChange*, Ticks>> changes;  ///< and the value
    bool defined = true;

    void take(const WideEffects& effects, const Situation& before, Ticks duration) {
      uses.back().write_all(effects);
      facts.insert(facts.end(), effects.facts.begin(), effects.facts.end());
      for (const WideChange& change : effects.numbers) {
        changes.emplace_back(&change, value(change.value, before.numbers, duration));
        defined = defined && changes.back().second != kUndefined;
      }
    }
  };

  void begin(const Run& run, const Situation& before, Happened& now) const {
    const WideAction& action = problem_.actions[static_cast<std::size_t>(run.action)];
    const Ticks duration = run.end - run.start;
    Uses& uses = now.uses.emplace_back();
    uses.read_all(action.start);
    for (const WideBound& each : action.duration)
      if (!each.at_end) uses.read_sum(each.bound);
    for (const WideConditional& when : action.when) uses.read_all(when.start);
    now.take(action.at_start, before, duration);
    for (std::size_t i = 0; i < action.when.size(); ++i)
      if (!action.when[i].at_end && run.fires[i]) now.take(action.when[i].effects, before, duration);
  }

  bool finish(const Run& run, const Situation& before, Happened& now) const {
    const WideAction& action = problem_.actions[static_cast<std::size_t>(run.action)];
    const Ticks duration = run.end - run.start;
    if (!holds(action.end, before, duration)) return false;
    Uses& uses = now.uses.emplace_back();
    uses.read_all(action.end);
    for (const WideBound& each : action.duration) {
      if (!each.at_end) continue;
      uses.read_sum(each.bound);
      const Ticks bound = value(each.bound, before.numbers, 0);
      if (bound == kUndefined || !accepts(each.op, duration * (kOne / kSecond) - bound)) return false;
    }
    for (const WideConditional& when : action.when)
      if (when.at_end) uses.read_all(when.end);
    now.take(action.at_end, before, duration);
    for (std::size_t i = 0; i < action.when.size(); ++i)
      if (action.when[i].at_end && run.fires[i] && holds(action.when[i].end, before, duration))
        now.take(action.when[i].effects, before, duration);
    return true;
  }

  bool happen(const Situation& before, Ticks now, const std::vector<Run>& starts) {
    Situation after = before;
    Happened happened;
    after.runs.clear();
    for (const Run& run : before.runs)
      if (run.end > now)
        after.runs.push_back(run);
      else if (!finish(run, before, happened))
        return false;
    for (const Run& run : starts) {
      begin(run, before, happened);
      if (run.end > now)
        after.runs.push_back(run);
      else if (problem_.actions[static_cast<std::size_t>(run.action)].durative && !finish(run, before, happened))
        return false;
    }
    std::ranges::sort(after.runs);
    after.left -= static_cast<int>(starts.size());
    for (const WideEvent& event : problem_.events) {
      if (event.time != now) continue;
      Uses& uses = happened.uses.emplace_back();
      if (event.of_number)
        uses.assigned |= 1u << event.number;
      else
        (event.fact.value ? uses.add : uses.remove) |= 1u << event.fact.fact;
    }
    for (std::size_t i = 0; i < happened.uses.size(); ++i)
      for (std::size_t j = 0; j < happened.uses.size(); ++j)
        if (i != j && happened.uses[i].disturbs(happened.uses[j])) return false;
    if (!happened.defined || !apply(happened, after)) return false;
    for (const WideEvent& event : problem_.events) {
      if (event.time != now) continue;
      if (event.of_number)
        after.numbers[static_cast<std::size_t>(event.number)] = event.value * kOne;
      else
        set(after, event.fact);
    }
    const std::size_t known = steps_.size();
    for (const Run& run : starts) {
      const bool durative = problem_.actions[static_cast<std::size_t>(run.action)].durative;
      steps_.push_back(seconds(run.start) + ": (a" + std::to_string(run.action) + ")" +
                       (durative ? " [" + seconds(run.end - run.start) + "]" : "") + "\n");
    }
    const bool ended = after.runs.size() < before.runs.size() || !starts.empty();
    if (ended && ends_well(after, now)) return true;
    const Ticks later = next_time(after, now);
    if (pass(after, now, later) && visit(after, later)) return true;
    steps_.resize(known);
    return false;
  }

  static bool apply(const Happened& happened, Situation& after) {
    for (const bool value : {false, true})
      for (const Literal& literal : happened.facts)
        if (literal.value == value) set(after, literal);
    for (const auto& [change, value] : happened.changes) {
      Ticks& number = after.numbers[static_cast<std::size_t>(change->number)];
      if (change->kind == "assign") {
        number = value;
        continue;
      }
      if (number == kUndefined) return false;
      if (change->kind == "scale-up") {
        if (number % 1000 != 0 || value % 1000 != 0) return false;  // off the grid
        number = number / 1000 * (value / 1000);
      } else {
        number += change->kind == "increase" ? value : -value;
      }
    }
    return true;
  }

  /// When something can happen next.
  Ticks next_time(const Situation& situation, Ticks now) const {
    Ticks next = now % kGrid < kOffsets - 1 ? now + 1 : now / kGrid * kGrid + kGrid;
    for (const Run& run : situation.runs) next = std::min(next, run.end);
    for (const WideEvent& event : problem_.events)
      if (event.time > now) next = std::min(next, event.time);
    return next;
  }

  /// Lets time pass. False if a condition over all is broken.
  bool pass(Situation& situation, Ticks from, Ticks to) const {
    std::vector<Ticks> rates(situation.numbers.size(), 0);
    for (const Run& run : situation.runs)
      for (const auto& [n, rate] : problem_.actions[static_cast<std::size_t>(run.action)].rates) {
        const Ticks each = value(rate, situation.numbers, run.end - run.start);
        if (each == kUndefined || situation.numbers[static_cast<std::size_t>(n)] == kUndefined) return false;
        rates[static_cast<std::size_t>(n)] += each;
      }
    Situation later = situation;
    for (std::size_t n = 0; n < rates.size(); ++n) {
      if (rates[n] * (to - from) % kSecond != 0) return false;  // off the grid
      if (later.numbers[n] != kUndefined) later.numbers[n] += rates[n] * (to - from) / kSecond;
    }
    for (Run& run : situation.runs) {
      const WideAction& action = problem_.actions[static_cast<std::size_t>(run.action)];
      if (!holds_between(action.over_all, situation, later, run.end - run.start)) return false;
      for (std::size_t i = 0; i < action.when.size(); ++i)
        if (!action.when[i].over_all.empty() &&
            !holds_between(action.when[i].over_all, situation, later, run.end - run.start))
          run.fires[i] = 0;
    }
    situation.numbers = later.numbers;
    std::ranges::sort(situation.runs);
    return true;
  }

  const WideProblem& problem_;
  const std::size_t most_;
  std::map<Ticks, std::set<Situation>> visited_;
  std::size_t situations_ = 0;
  bool too_large_ = false;
  std::vector<std::string> steps_;
};

}  // namespace

WideAnswer find_witness(const WideProblem& problem, std::size_t most_situations) {
  return Finder(problem, most_situations).run();
}

}  // namespace cxlab::planner
