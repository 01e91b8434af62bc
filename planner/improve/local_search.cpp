#include "planner/improve/local_search.h"

#include <algorithm>
#include <limits>

namespace cxlab::planner {

namespace {

constexpr std::size_t kHistory = 100;
constexpr double kStartWeight = 0.05;  ///< of the mean start in the cost: earlier is better even where it does not count yet

}  // namespace

LocalSearch::LocalSearch(const Simulator& simulator, const Touches& touches, std::uint64_t seed)
    : simulator_(simulator), touches_(touches), random_(seed, "planner local search"), timeline_(touches) {
  const GroundTask& task = simulator.task();
  achievers_.resize(task.facts.size() + task.numbers.size());
  for (std::size_t a = 0; a < task.actions.size(); ++a) {
    if (simulator.whole_impossible(static_cast<int>(a))) continue;
    for (const int f : simulator.whole_effects(static_cast<int>(a)).add) achievers_[f].push_back(static_cast<int>(a));
    for (const auto* effects : {&task.actions[a].at_start, &task.actions[a].at_end})
      for (const NumericEffect& effect : effects->numbers) achievers_[task.facts.size() + effect.number].push_back(static_cast<int>(a));
  }
}

Micros LocalSearch::start(const Sequence& plan) {
  Plan decoded;
  if (!decode(plan, std::numeric_limits<double>::infinity(), decoded)) return Timeline::kNever;
  history_.assign(kHistory, decoded.cost);
  if (best_.order.empty() || decoded.makespan < best_.makespan) best_ = decoded;
  set_current(std::move(decoded));
  return current_.makespan;
}

bool LocalSearch::decode(const Sequence& list, double most_cost, Plan& plan) {
  const int words = simulator_.words();
  scratch_ = simulator_.initial();
  timeline_.clear();
  plan.order.clear();
  plan.starts.clear();
  plan.causes.clear();
  plan.makespan = 0;
  std::vector<int> next(list.size() + 1);  // linked list of what is left; index 0 is the head
  for (std::size_t i = 0; i <= list.size(); ++i) next[i] = i < list.size() ? static_cast<int>(i) + 1 : 0;
  double sum = 0;
  while (!simulator_.is_goal(scratch_.data())) {
    int before = 0, item = next[0];
    bool taken = false;
    for (; item != 0; before = item, item = next[item]) {
      ++work_;
      const SequenceStep& step = list[item - 1];
      if (is_event(step)) {
        if (!timeline_.append_event()) return false;
        simulator_.apply_event(-2 - step.action, scratch_.data());
        plan.order.push_back(step);
        plan.starts.push_back(touches_.events()[-2 - step.action].time);
        plan.causes.push_back(-1);
        taken = true;
        break;
      }
      if (!simulator_.holds(simulator_.whole_condition(step.action), scratch_.data())) continue;
      trial_ = scratch_;
      Micros duration = 0;
      if (!simulator_.apply(step.action, trial_.data(), duration)) continue;
      const Micros start = timeline_.append(step.action, duration);
      if (start == Timeline::kNever) return false;
      std::copy(trial_.begin(), trial_.begin() + words, scratch_.begin());
      plan.order.push_back({step.action, duration});
      plan.starts.push_back(start);
      plan.causes.push_back(timeline_.cause());
      sum += static_cast<double>(start);
      taken = true;
      break;
    }
    if (!taken) return false;
    next[before] = next[item];
    if (static_cast<double>(timeline_.makespan()) > most_cost) return false;
  }
  plan.makespan = timeline_.makespan();
  plan.cost = static_cast<double>(plan.makespan) + kStartWeight * sum / std::max<double>(1, static_cast<double>(plan.order.size()));
  return true;
}

void LocalSearch::set_current(Plan plan) {
  current_ = std::move(plan);
  const std::size_t words = static_cast<std::size_t>(simulator_.words());
  states_.resize((current_.order.size() + 1) * words);
  PackedState state = simulator_.initial();
  for (std::size_t i = 0; i < current_.order.size(); ++i) {
    std::ranges::copy(state, &states_[i * words]);
    const SequenceStep& step = current_.order[i];
    if (is_event(step)) simulator_.apply_event(-2 - step.action, state.data());
    else simulator_.apply_with(step.action, state.data(), step.duration);
  }
  std::ranges::copy(state, &states_[current_.order.size() * words]);
  critical_.clear();
  int last = -1;
  for (std::size_t i = 0; i < current_.order.size(); ++i)
    if (current_.starts[i] + current_.order[i].duration == current_.makespan) last = static_cast<int>(i);
  for (; last >= 0; last = current_.causes[last]) critical_.push_back(last);
}

int LocalSearch::critical_step() { return critical_[random_.below(critical_.size())]; }

void LocalSearch::run(Budget& budget, std::int64_t most_idle, const OnBetter& on_better) {
  if (current_.order.empty()) return;
  Sequence list;
  Plan tried;
  for (std::int64_t idle = 0; idle < most_idle; ++idle) {
    list = current_.order;
    make_move(list);
    work_ = 0;
    double& late = history_[static_cast<std::size_t>(moves_++) % history_.size()];
    const double threshold = std::max(late, current_.cost);
    const bool accepted = decode(list, threshold, tried) && tried.cost <= threshold;
    budget.spend(Work::kSchedule, work_ + static_cast<std::int64_t>(tried.order.size()) + 10);
    if (accepted) {
      set_current(tried);
      if (current_.makespan < best_.makespan) {
        best_ = current_;
        idle = 0;
        if (on_better) on_better(best_.order, best_.makespan);
      }
    }
    if (current_.cost < late) late = current_.cost;
    if (budget.slice_over()) return;
  }
}

void LocalSearch::make_move(Sequence& list) {
  const int size = static_cast<int>(list.size());
  const double kind = random_.uniform();
  if (kind < 0.45) {  // a critical step before the one that it waits for
    const int step = critical_step(), cause = current_.causes[step];
    const int to = cause < 0 ? static_cast<int>(random_.below(static_cast<std::uint64_t>(step) + 1))
                             : std::max(0, cause - static_cast<int>(random_.below(4) == 0 ? random_.below(12) : 0));
    pull(list, step, std::min(to, step));
  } else if (kind < 0.7) {  // any step forward
    const int step = static_cast<int>(random_.below(static_cast<std::uint64_t>(size)));
    pull(list, step, static_cast<int>(std::max<std::int64_t>(0, step - random_.between(1, 30))));
  } else if (kind < 0.88) {  // a critical step later
    const int step = critical_step();
    const int to = static_cast<int>(std::min<std::int64_t>(size - 1, step + random_.between(1, 20)));
    std::rotate(list.begin() + step, list.begin() + step + 1, list.begin() + to + 1);
  } else {
    exchange(list);
    if (random_.chance(0.5)) exchange(list);
  }
}

void LocalSearch::pull(Sequence& list, int step, int to) const {
  // Providers between `to` and the step come along, unless what they provide is already true at `to`.
  const Word* state = &states_[static_cast<std::size_t>(to) * static_cast<std::size_t>(simulator_.words())];
  const GroundTask& task = simulator_.task();
  std::vector<int> facts, comparisons;
  const auto need = [&](const SequenceStep& of) {
    if (is_event(of)) return;
    const GroundCondition& condition = simulator_.whole_condition(of.action);
    for (const int f : condition.facts)
      if (!is_set(state, f)) facts.push_back(f);
    for (const int c : condition.comparisons)
      if (!task.comparisons[c].holds(simulator_.numbers(state))) comparisons.push_back(c);
  };
  need(list[step]);
  std::vector<char> comes(static_cast<std::size_t>(step - to) + 1, 0);
  comes[step - to] = 1;
  for (int i = step - 1; i >= to; --i) {
    if (is_event(list[i])) continue;
    const GroundEffects& effects = simulator_.whole_effects(list[i].action);
    bool provides = false;
    std::erase_if(facts, [&](int f) {
      const bool added = std::ranges::binary_search(effects.add, f);
      provides |= added;
      return added;
    });
    std::erase_if(comparisons, [&](int c) {
      bool changed = false;
      for (const auto* timed : {&task.actions[list[i].action].at_start, &task.actions[list[i].action].at_end})
        for (const NumericEffect& effect : timed->numbers)
          for (const auto& [number, weight] : task.comparisons[c].linear.weights)
            changed |= number == effect.number && effect.value.is_constant() && effect.value.steps[0].value * weight > 0;
      provides |= changed;
      return changed;
    });
    if (!provides) continue;
    comes[i - to] = 1;
    need(list[i]);
  }
  Sequence segment;
  for (int pass = 1; pass >= 0; --pass)
    for (int i = to; i <= step; ++i)
      if (comes[i - to] == pass) segment.push_back(list[i]);
  std::ranges::copy(segment, list.begin() + to);
}

std::vector<int> LocalSearch::alternatives(int action) const {
  std::vector<int> found;
  for (const int f : simulator_.whole_effects(action).add) found.insert(found.end(), achievers_[f].begin(), achievers_[f].end());
  const GroundTask& task = simulator_.task();
  for (const auto* effects : {&task.actions[action].at_start, &task.actions[action].at_end})
    for (const NumericEffect& effect : effects->numbers) {
      const auto& more = achievers_[task.facts.size() + effect.number];
      found.insert(found.end(), more.begin(), more.end());
    }
  std::erase(found, action);
  return found;
}

void LocalSearch::exchange(Sequence& list) {
  const std::size_t at = random_.chance(0.5) ? static_cast<std::size_t>(critical_step()) : random_.below(list.size());
  if (at >= list.size() || is_event(list[at])) return;
  const double kind = random_.uniform();
  if (kind < 0.15 && list.size() > 1) {
    list.erase(list.begin() + static_cast<std::ptrdiff_t>(at));
    return;
  }
  const std::vector<int> others = alternatives(list[at].action);
  if (others.empty()) return;
  const SequenceStep other{others[random_.below(others.size())], 0};
  if (kind < 0.7) list[at] = other;
  else list.insert(list.begin() + static_cast<std::ptrdiff_t>(at), other);
}

}  // namespace cxlab::planner
