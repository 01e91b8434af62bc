#include "planner/search/relaxed.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "planner/ground/sorted.h"

namespace cxlab::planner {

namespace {

constexpr int kInfinite = std::numeric_limits<int>::max() / 4;
constexpr int kMostBuckets = 1 << 16;
constexpr double kMostSteps = 1000;

/// Costs of actions by their durations: tenths of the mean one, and 1.
std::vector<int> duration_costs(const Simulator& simulator) {
  const GroundTask& task = simulator.task();
  std::vector<double> lengths;
  double sum = 0;
  const PackedState initial = simulator.initial();
  for (std::size_t a = 0; a < task.actions.size(); ++a) {
    const std::optional<DurationRange> range =
        task.actions[a].durative ? simulator.durations(static_cast<int>(a), initial.data()) : DurationRange{};
    lengths.push_back(range ? static_cast<double>(range->least) : 0.0);
    sum += lengths.back();
  }
  const double mean = std::max(sum / std::max<double>(1, static_cast<double>(lengths.size())), 1.0);
  std::vector<int> costs;
  for (const double length : lengths) costs.push_back(1 + static_cast<int>(std::min(100.0, 10 * length / mean)));
  return costs;
}

}  // namespace

RelaxedTask::RelaxedTask(const Simulator& simulator, bool unit_costs)
    : RelaxedTask(simulator,
                  unit_costs ? std::vector<int>(simulator.task().actions.size(), 1) : duration_costs(simulator)) {}

RelaxedTask::RelaxedTask(const Simulator& simulator, const std::vector<int>& costs) {
  const GroundTask& task = simulator.task();
  facts_ = static_cast<int>(task.facts.size());
  atoms_ = facts_ + static_cast<int>(task.comparisons.size());
  for (std::size_t a = 0; a < task.actions.size(); ++a)
    if (!simulator.whole_impossible(static_cast<int>(a))) add_operators(simulator, static_cast<int>(a), costs[a]);
  const auto atoms_of = [&](const GroundCondition& condition) {
    std::vector<int> atoms = condition.facts;
    for (const int c : condition.comparisons) atoms.push_back(facts_ + c);
    return atoms;
  };
  for (const Axiom& axiom : task.axioms) operators_.push_back({-1, true, 0, atoms_of(axiom.body), {axiom.head}, {}});
  for (std::size_t e = 0; e < task.events.size(); ++e) {
    RelaxedOperator made{-2 - static_cast<int>(e), true, 1, {}, {}, {}};
    add_effects(task, made, task.events[e].effects, -1);
    operators_.push_back(std::move(made));
  }
  goal_ = atoms_of(task.goal);
  ById<std::vector<int>> readers(static_cast<std::size_t>(atoms_));
  for (std::size_t o = 0; o < operators_.size(); ++o) {
    const RelaxedOperator& op = operators_[o];
    for (const int atom : op.conditions) readers[atom].push_back(static_cast<int>(o));
    adds_.add(op.adds);
    conditions_.push_back(static_cast<int>(op.conditions.size()));
    base_actions_.push_back(op.base && op.action >= 0 ? op.action : -1);
    has_gains_.push_back(!op.gains.empty());
    if (op.conditions.empty()) unconditional_.push_back(static_cast<int>(o));
  }
  for (const auto& list : readers) readers_.add(list);
}

void RelaxedTask::add_operators(const Simulator& simulator, int action, int cost) {
  const GroundTask& task = simulator.task();
  const GroundAction& a = task.actions[action];
  RelaxedOperator base{action, true, cost, {}, {}, {}};
  const GroundCondition& condition = simulator.whole_condition(action);
  base.conditions = condition.facts;
  for (const int c : condition.comparisons) base.conditions.push_back(facts_ + c);
  base.adds = simulator.whole_effects(action).add;
  GroundEffects numeric;
  numeric.numbers = a.at_start.numbers;
  numeric.numbers.insert(numeric.numbers.end(), a.at_end.numbers.begin(), a.at_end.numbers.end());
  add_effects(task, base, numeric, action);
  for (const ConditionalEffects& conditional : a.conditional) {
    RelaxedOperator made{action, false, cost, base.conditions, {}, {}};
    for (const GroundCondition* more : {&conditional.start, &conditional.over_all, &conditional.end}) {
      for (const int f : more->facts)
        if (!contains(a.at_start.add, f)) made.conditions.push_back(f);
      for (const int c : more->comparisons) made.conditions.push_back(facts_ + c);
    }
    sort_unique(made.conditions);
    add_effects(task, made, conditional.at_start, action);
    add_effects(task, made, conditional.at_end, action);
    operators_.push_back(std::move(made));
  }
  operators_.push_back(std::move(base));
}

void RelaxedTask::add_effects(const GroundTask& task, RelaxedOperator& made, const GroundEffects& effects, int action) {
  made.adds.insert(made.adds.end(), effects.add.begin(), effects.add.end());
  sort_unique(made.adds);
  // Net change of each number, infinite where it depends on the state.
  std::vector<std::pair<int, double>> changes;
  constexpr double kAny = std::numeric_limits<double>::infinity();
  for (const NumericEffect& effect : effects.numbers) {
    double change = kAny;
    if (effect.kind == NumericEffect::Kind::kIncrease && effect.value.is_constant())
      change = effect.value.steps[0].value;
    const auto known = std::ranges::find(changes, effect.number, &std::pair<int, double>::first);
    if (known == changes.end())
      changes.emplace_back(effect.number, change);
    else
      known->second += change;
  }
  if (action >= 0)
    for (const ContinuousEffect& effect : task.actions[action].continuous) changes.emplace_back(effect.number, kAny);
  if (changes.empty()) return;
  work_ += static_cast<std::int64_t>(task.comparisons.size());
  for (std::size_t c = 0; c < task.comparisons.size(); ++c) {
    const LinearForm& linear = task.comparisons[c].linear;
    double change = 0;
    for (const auto& [number, by] : changes) {
      if (!linear.is_linear) {
        if (task.comparisons[c].expression.mentions(number)) change = kAny;
        continue;
      }
      const auto weight = std::ranges::find(linear.weights, number, &std::pair<int, double>::first);
      if (weight != linear.weights.end()) change += std::isinf(by) ? kAny : weight->second * by;
    }
    if (std::isnan(change)) change = kAny;
    const bool helps = change > 0 || (change < 0 && task.comparisons[c].kind == GroundComparison::Kind::kZero);
    if (helps) made.gains.push_back({facts_ + static_cast<int>(c), change});
  }
}

RelaxedHeuristic::RelaxedHeuristic(const Simulator& simulator, const RelaxedTask& relaxed)
    : simulator_(simulator), relaxed_(relaxed) {
  const std::size_t atoms = static_cast<std::size_t>(relaxed.atoms()), operators = relaxed.operators().size();
  cost_.resize(atoms);
  achiever_.resize(atoms);
  marked_.resize(atoms);
  missing_.resize(operators);
  sum_.resize(operators);
  in_plan_.resize(operators);
  gap_.resize(simulator.task().comparisons.size());
  for (const RelaxedOperator& op : relaxed.operators()) prices_.push_back(op.cost);
  is_goal_.assign(atoms, 0);
  for (const int atom : relaxed.goal()) is_goal_[atom] = 1;
}

void RelaxedHeuristic::scatter_costs(RandomStream& random, double share) {
  for (int& price : prices_)
    if (price > 0) price += static_cast<int>(static_cast<double>(price) * share * random.uniform());
}

void RelaxedHeuristic::reach(int atom, int cost, int achiever) {
  if (cost >= cost_[atom]) return;
  cost_[atom] = cost;
  achiever_[atom] = achiever;
  const std::size_t bucket = static_cast<std::size_t>(std::min(cost, kMostBuckets - 1));
  if (bucket >= buckets_.size()) buckets_.resize(bucket + 1);
  buckets_[bucket].push_back(atom);
}

int RelaxedHeuristic::evaluate(const Word* state, int next_event) {
  const GroundTask& task = simulator_.task();
  state_ = state;
  std::ranges::fill(cost_, kInfinite);
  std::ranges::fill(sum_, 0);
  missing_ = relaxed_.conditions();
  for (auto& bucket : buckets_) bucket.clear();
  for (int f = 0; f < relaxed_.facts(); ++f)
    if (is_set(state, f) || (task.facts[f].derived && task.facts[f].is_complement)) reach(f, 0, -1);
  for (std::size_t c = 0; c < task.comparisons.size(); ++c) {
    const GroundComparison& comparison = task.comparisons[c];
    gap_[c] = comparison.gap(simulator_.numbers(state));
    if (comparison.accepts(gap_[c]) || comparison.linear.duration_weight != 0)
      reach(relaxed_.facts() + static_cast<int>(c), 0, -1);
  }
  unreached_goals_ = static_cast<int>(relaxed_.goal().size());
  explore(next_event);
  work_ += static_cast<std::int64_t>(relaxed_.operators().size() / 4 + gap_.size() + 16);

  applicable_.clear();
  plan_.clear();
  for (std::size_t o = 0; o < missing_.size(); ++o)
    if (missing_[o] == 0 && sum_[o] == 0 && relaxed_.base_actions()[o] >= 0)
      applicable_.push_back(relaxed_.base_actions()[o]);
  std::ranges::sort(applicable_);
  preferred_.clear();
  for (const int atom : relaxed_.goal())
    if (cost_[atom] >= kInfinite) return kDeadEnd;
  std::ranges::fill(marked_, 0);
  used_.clear();
  int total = 0;
  for (const int atom : relaxed_.goal()) extract(atom);
  std::ranges::sort(used_);
  for (const int o : used_) {
    const RelaxedOperator& op = relaxed_.operators()[o];
    total += prices_[o] * std::exchange(in_plan_[o], 0);
    if (op.action == -1) continue;
    plan_.push_back(op.action);
    if (op.action >= 0 && contains(applicable_, op.action)) preferred_.push_back(op.action);
  }
  sort_unique(preferred_);
  return total;
}

void RelaxedHeuristic::explore(int next_event) {
  const auto fire = [&](int o) {
    if (next_event > 0)
      if (const int action = relaxed_.operators()[o].action; action <= -2 && -2 - action < next_event) return;
    const int before = sum_[o], cost = std::min(before + prices_[o], kInfinite - 1);
    for (const int fact : relaxed_.adds(o)) reach(fact, cost, o);
    if (!relaxed_.has_gains(o)) return;
    work_ += static_cast<std::int64_t>(relaxed_.operators()[o].gains.size());
    for (const RelaxedOperator::Gain& gain : relaxed_.operators()[o].gains) {
      const std::size_t c = static_cast<std::size_t>(gain.atom - relaxed_.facts());
      const GroundComparison& comparison = simulator_.task().comparisons[c];
      double steps = 1;
      if (!std::isinf(gain.change) && !std::isnan(gap_[c])) {
        if (comparison.kind == GroundComparison::Kind::kZero && (gap_[c] > 0) == (gain.change > 0)) continue;
        steps = std::ceil(std::abs(gap_[c]) / std::abs(gain.change) - 1e-6);
        if (comparison.kind == GroundComparison::Kind::kPositive && std::abs(gap_[c] + steps * gain.change) < 1e-9)
          steps += 1;
      }
      steps = std::clamp(steps, 1.0, kMostSteps);
      reach(gain.atom, std::min(before + static_cast<int>(steps) * prices_[o], kInfinite - 1), o);
    }
  };
  for (const int o : relaxed_.unconditional()) fire(o);
  for (std::size_t bucket = 0; bucket < buckets_.size(); ++bucket) {
    for (std::size_t i = 0; i < buckets_[bucket].size(); ++i) {
      const int atom = buckets_[bucket][i];
      if (static_cast<std::size_t>(std::min(cost_[atom], kMostBuckets - 1)) != bucket || marked_[atom] == 2) continue;
      marked_[atom] = 2;  // expanded
      // Every applicable action is wanted, so the states' own atoms are all expanded before the goal may end it.
      if (is_goal_[atom] && --unreached_goals_ == 0 && bucket > 0) {
        std::ranges::fill(marked_, 0);
        return;
      }
      work_ += static_cast<std::int64_t>(relaxed_.readers(atom).size());
      for (const int o : relaxed_.readers(atom)) {
        sum_[o] = std::min(sum_[o] + cost_[atom], kInfinite - 1);
        if (--missing_[o] == 0) fire(o);
      }
    }
  }
  std::ranges::fill(marked_, 0);
}

void RelaxedHeuristic::extract(int atom) {
  std::vector<int> stack = {atom};
  while (!stack.empty()) {
    const int now = stack.back();
    stack.pop_back();
    if (marked_[now] || achiever_[now] < 0 || cost_[now] == 0) continue;
    marked_[now] = 1;
    const int o = achiever_[now];
    const RelaxedOperator& op = relaxed_.operators()[o];
    int times = 1;
    if (now >= relaxed_.facts() && prices_[o] > 0) times = std::max(1, (cost_[now] - sum_[o]) / prices_[o]);
    if (!in_plan_[o]) used_.push_back(o);
    in_plan_[o] = static_cast<char>(std::min(120, std::max<int>(in_plan_[o], times)));
    for (const int condition : op.conditions) stack.push_back(condition);
  }
}

}  // namespace cxlab::planner
