// Durative actions that take no time.

#include <algorithm>
#include <cmath>
#include <utility>

#include "planner/ground/passes.h"
#include "planner/ground/sorted.h"

namespace cxlab::planner {

namespace {

bool meet(const std::vector<int>& a, const std::vector<int>& b) {
  return std::ranges::any_of(a, [&b](int item) { return std::ranges::find(b, item) != b.end(); });
}

void append(const std::vector<int>& more, std::vector<int>& to) { to.insert(to.end(), more.begin(), more.end()); }

void append(const GroundCondition& more, GroundCondition& to) {
  append(more.facts, to.facts);
  append(more.comparisons, to.comparisons);
  sort_unique(to.facts);
  sort_unique(to.comparisons);
}

void append(const GroundEffects& more, GroundEffects& to) {
  append(more.add, to.add);
  append(more.remove, to.remove);
  to.numbers.insert(to.numbers.end(), more.numbers.begin(), more.numbers.end());
  sort_unique(to.add);
  sort_unique(to.remove);
}

using Bases = ById<std::vector<int>>;

/// What the beginning or the end of an action reads and writes.
struct Use {
  std::vector<int> reads, adds, removes, number_reads, assigned, increased;
  const Symbols* derived = nullptr;  ///< what it reads by derived predicates; may be none

  void read(const GroundTask& task, const Bases& bases, const GroundCondition& condition) {
    const int facts = static_cast<int>(task.facts.size());
    for (const int f : condition.facts)
      for (const int base : bases[f])
        (base < facts ? reads : number_reads).push_back(base < facts ? base : base - facts);
    for (const int c : condition.comparisons) read(task.comparisons[c].expression);
  }
  void read(const GroundExpression& expression) {
    expression.for_each_number([this](int number) { number_reads.push_back(number); });
  }
  void write(const GroundEffects& effects) {
    append(effects.add, adds);
    append(effects.remove, removes);
    for (const NumericEffect& effect : effects.numbers) {
      (effect.kind == NumericEffect::Kind::kIncrease ? increased : assigned).push_back(effect.number);
      read(effect.value);
    }
  }

  bool is_disturbed_by(const GroundTask& task, const Use& other) const {
    return (derived && reads_changes(task, *derived, other)) || meet(reads, other.adds) || meet(reads, other.removes) ||
           meet(adds, other.removes) || meet(number_reads, other.assigned) || meet(number_reads, other.increased) ||
           meet(assigned, other.assigned) || meet(assigned, other.increased);
  }

 private:
  static bool reads_changes(const GroundTask& task, const Symbols& symbols, const Use& other) {
    const auto has = [](const ById<char>& some, int id) { return id >= 0 && id < std::ssize(some) && some[id]; };
    const auto fact = [&](int f) { return has(symbols.predicates, task.facts[f].predicate); };
    const auto number = [&](int n) { return has(symbols.functions, task.numbers[n].function); };
    return std::ranges::any_of(other.adds, fact) || std::ranges::any_of(other.removes, fact) ||
           std::ranges::any_of(other.assigned, number) || std::ranges::any_of(other.increased, number);
  }
};

/// Whether beginning and end can be one happening; `always`: also where all of its conditional effects come about.
bool can_coincide(const GroundTask& task, const Bases& bases, const GroundAction& action, bool always) {
  Use begin, end;
  begin.read(task, bases, action.start);
  end.read(task, bases, action.end);
  begin.write(action.at_start);
  end.write(action.at_end);
  for (const ConditionalEffects& conditional : action.conditional) {
    begin.read(task, bases, conditional.start);
    end.read(task, bases, conditional.end);
    if (!always) continue;
    begin.write(conditional.at_start);
    end.write(conditional.at_end);
  }
  for (const GroundDuration& duration : action.duration) (duration.at_end ? end : begin).read(duration.bound);
  if (!task.derived_reads.empty()) {
    begin.derived = &task.derived_reads[action.schema].start;
    end.derived = &task.derived_reads[action.schema].end;
  }
  return !begin.is_disturbed_by(task, end) && !end.is_disturbed_by(task, begin);
}

/// Adds to the condition that the constraint allows a duration of 0; false if it never does.
bool ask_for_zero(GroundTask& task, const GroundDuration& duration, GroundCondition& condition) {
  if (duration.bound.is_constant()) {
    const Micros bound = in_micros(duration.bound.steps[0].value);
    return duration.comparison == Comparison::kLessEqual      ? bound >= 0
           : duration.comparison == Comparison::kGreaterEqual ? bound <= 0
                                                              : bound == 0;
  }
  using Kind = GroundComparison::Kind;
  const GroundExpression zero = GroundExpression::constant(0);
  condition.comparisons.push_back(static_cast<int>(task.comparisons.size()));
  task.comparisons.push_back(duration.comparison == Comparison::kLessEqual
                                 ? GroundComparison::of(Kind::kNotNegative, duration.bound, zero)
                             : duration.comparison == Comparison::kGreaterEqual
                                 ? GroundComparison::of(Kind::kNotNegative, zero, duration.bound)
                                 : GroundComparison::of(Kind::kZero, duration.bound, zero));
  return true;
}

/// The action that takes no time as an instantaneous one; false if there is none. It stays as it is, without what is
/// asked over all, where it depends on the state whether its beginning and its end interfere.
bool merge(GroundTask& task, const Bases& bases, GroundAction& action) {
  if (!can_coincide(task, bases, action, false)) return false;
  if (!can_coincide(task, bases, action, true)) {
    action.over_all = {};
    action.continuous.clear();
    for (ConditionalEffects& conditional : action.conditional) conditional.over_all = {};
    return true;
  }
  for (const GroundDuration& duration : action.duration)
    if (!ask_for_zero(task, duration, action.start)) return false;
  append(action.end, action.start);
  append(action.at_end, action.at_start);
  std::vector<ConditionalEffects> conditional;
  for (ConditionalEffects& from : action.conditional) {
    if (!from.at_start.empty()) conditional.push_back({from.start, {}, {}, std::move(from.at_start), {}});
    if (from.at_end.empty()) continue;
    append(from.end, from.start);
    conditional.push_back({std::move(from.start), {}, {}, std::move(from.at_end), {}});
  }
  action.conditional = std::move(conditional);
  action.end = {};
  action.at_end = {};
  action.duration.clear();
  action.continuous.clear();
  action.durative = false;
  return true;
}

}  // namespace

bool is_surely_positive(const GroundTask& task, const GroundExpression& bound, const GroundCondition& condition) {
  if (bound.is_constant()) return in_micros(bound.steps[0].value) > 0;
  const LinearForm form = linear_form(bound);
  if (!form.is_linear || form.weights.empty() || form.duration_weight != 0) return false;
  // At least a positive multiple of what the condition says is positive.
  return std::ranges::any_of(condition.comparisons, [&](int c) {
    const GroundComparison& comparison = task.comparisons[c];
    const LinearForm& positive = comparison.linear;
    if (comparison.kind != GroundComparison::Kind::kPositive || !positive.is_linear || positive.duration_weight != 0 ||
        positive.weights.size() != form.weights.size())
      return false;
    const double share = form.weights[0].second / positive.weights[0].second;
    constexpr double kRounding = 1e-9;
    const auto is_share = [&](double of, double value) {
      return std::abs(of * share - value) <= kRounding * std::max(std::abs(of * share), std::abs(value));
    };
    for (std::size_t i = 0; i < form.weights.size(); ++i)
      if (form.weights[i].first != positive.weights[i].first ||
          !is_share(positive.weights[i].second, form.weights[i].second))
        return false;
    return share > 0 && (form.constant >= positive.constant * share || is_share(positive.constant, form.constant));
  });
}

void merge_instants(GroundTask& task) {
  const auto may_take_no_time = [](const GroundAction& action) {
    const DurationRange range = constant_durations(action);
    return action.durative && (range.most <= 0 || range.least < kValidSeparation);
  };
  if (std::ranges::none_of(task.actions, may_take_no_time)) return;
  const Bases bases = bases_of_facts(task);
  ById<GroundAction> kept;
  for (GroundAction& action : task.actions) {
    const DurationRange range = constant_durations(action);
    if (action.durative && range.most <= 0 && !merge(task, bases, action)) continue;
    if (action.durative && range.most > 0 && range.least < kValidSeparation &&
        !can_coincide(task, bases, action, false))
      action.duration.push_back(
          {Comparison::kGreaterEqual, GroundExpression::constant(in_seconds(kValidSeparation)), false});
    kept.push_back(std::move(action));
  }
  task.actions = std::move(kept);
}

}  // namespace cxlab::planner
