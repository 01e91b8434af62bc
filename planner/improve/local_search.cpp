#include "planner/improve/local_search.h"

#include <algorithm>
#include <limits>

#include "planner/ground/sorted.h"

namespace cxlab::planner {

namespace {

constexpr std::size_t kHistory = 100;
constexpr double kLateFirst = 0.3;  ///< share of moves that exchange a late step, until nothing is late
constexpr double kExchanges = 0.5;  ///< share of moves that change which actions there are, where not time alone counts

}  // namespace

LocalSearch::LocalSearch(Decoder& decoder, const Simulator& whole, std::uint64_t seed)
    : decoder_(decoder),
      split_(decoder.split()),
      original_(decoder.original()),
      simulator_(decoder.simulator()),
      whole_(whole),
      random_(seed, "planner local search") {
  const GroundTask& original = original_;
  achievers_.resize(original.facts.size() + original.numbers.size());
  for (std::size_t a = 0; a < original.actions.size(); ++a) {
    if (whole_.whole_impossible(static_cast<int>(a)) && split_.parts[a].second < 0) continue;
    for (const int f : whole_.whole_effects(static_cast<int>(a)).add) achievers_[f].push_back(static_cast<int>(a));
    for (const auto* effects : {&original.actions[a].at_start, &original.actions[a].at_end})
      for (const NumericEffect& effect : effects->numbers)
        achievers_[static_cast<int>(original.facts.size()) + effect.number].push_back(static_cast<int>(a));
    if (!decoder.objective().never_falls() && decoder.objective().change(static_cast<int>(a)) < 0)
      earners_.push_back(static_cast<int>(a));
  }
}

bool LocalSearch::start(const Sequence& plan) {
  DecodedPlan decoded;
  if (!decoder_.decode(plan, std::numeric_limits<double>::infinity(), decoded)) return false;
  history_.assign(kHistory, decoded.cost);
  if (best_.order.empty() || decoded.aim() < best_.aim()) best_ = decoded;
  set_current(std::move(decoded));
  return true;
}

void LocalSearch::set_current(DecodedPlan plan) {
  current_ = std::move(plan);
  decoder_.keep(current_);
  critical_.clear();
  const auto ends_late = [&](const SequenceStep& step) {
    return !is_event(step) && split_.origins[step.action].part == SplitTask::Part::kWhole;
  };
  int last = -1;
  for (std::size_t i = 0; i < current_.order.size(); ++i)
    if (current_.times[i] + (ends_late(current_.order[i]) ? current_.order[i].duration : 0) == current_.makespan)
      last = static_cast<int>(i);
  for (; last >= 0; last = current_.causes[last]) critical_.push_back(last);
}

int LocalSearch::critical_step() {
  return critical_.empty() ? static_cast<int>(random_.below(current_.order.size()))
                           : critical_[random_.below(critical_.size())];
}

void LocalSearch::run(Budget& budget, std::int64_t most_idle, const OnBetter& on_better) {
  Sequence list;
  DecodedPlan tried;
  for (std::int64_t idle = 0; idle < most_idle && !current_.order.empty(); ++idle) {
    list = current_.order;
    make_move(list);
    double& late = history_[static_cast<std::size_t>(moves_++) % history_.size()];
    const double threshold = std::max(late, current_.cost);
    const bool accepted = decoder_.decode(list, threshold, tried) && tried.cost <= threshold;
    budget.spend(Work::kSchedule, decoder_.take_work() + static_cast<std::int64_t>(tried.order.size()) + 10);
    if (accepted) {
      set_current(tried);
      if (current_.aim() < best_.aim()) {
        best_ = current_;
        idle = 0;
        if (best_.lateness == 0) on_better(best_);
      }
    }
    if (current_.cost < late) late = current_.cost;
    if (budget.slice_over()) return;
  }
}

void LocalSearch::make_move(Sequence& list) {
  if (exchanges_late_ && !current_.late.empty() && random_.chance(kLateFirst)) return exchange_late(list);
  const int size = static_cast<int>(list.size());
  const bool changes_actions = !decoder_.objective().is_makespan() && random_.chance(kExchanges);
  const double kind = changes_actions ? 1 : random_.uniform();
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
  // Providers between `to` and the step move with it, unless what they provide is already true at `to`.
  const Word* state = decoder_.kept_state(static_cast<std::size_t>(to));
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
  ById<char> comes(static_cast<std::size_t>(step - to) + 1, 0);
  comes[step - to] = 1;
  for (int i = step - 1; i >= to; --i) {
    if (is_event(list[i])) continue;
    const GroundEffects& effects = simulator_.whole_effects(list[i].action);
    bool provides = false;
    std::erase_if(facts, [&](int f) {
      const bool added = contains(effects.add, f);
      provides |= added;
      return added;
    });
    std::erase_if(comparisons, [&](int c) {
      bool changed = false;
      for (const auto* timed : {&task.actions[list[i].action].at_start, &task.actions[list[i].action].at_end})
        for (const NumericEffect& effect : timed->numbers)
          for (const auto& [number, weight] : task.comparisons[c].linear.weights)
            changed |=
                number == effect.number && effect.value.is_constant() && effect.value.steps[0].value * weight > 0;
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

std::vector<int> LocalSearch::alternatives(int original) const {
  std::vector<int> found;
  for (const int f : whole_.whole_effects(original).add)
    found.insert(found.end(), achievers_[f].begin(), achievers_[f].end());
  for (const auto* effects : {&original_.actions[original].at_start, &original_.actions[original].at_end})
    for (const NumericEffect& effect : effects->numbers) {
      const auto& more = achievers_[static_cast<int>(original_.facts.size()) + effect.number];
      found.insert(found.end(), more.begin(), more.end());
    }
  std::erase(found, original);
  return found;
}

void LocalSearch::insert(Sequence& list, std::size_t begin, std::size_t end, int original) const {
  const auto [first, last] = split_.parts[original];
  if (last >= 0) list.insert(list.begin() + static_cast<std::ptrdiff_t>(end), {last, 0});
  list.insert(list.begin() + static_cast<std::ptrdiff_t>(begin), {first, 0});
}

/// A whole action that comes too late for another one that makes one of its facts true.
void LocalSearch::exchange_late(Sequence& list) {
  SequenceStep& step = list[static_cast<std::size_t>(current_.late[random_.below(current_.late.size())])];
  if (is_event(step) || split_.origins[step.action].part != SplitTask::Part::kWhole) return;
  const auto& facts = whole_.whole_effects(split_.origins[step.action].action).add;
  if (facts.empty()) return;
  const std::vector<int>& others = achievers_[facts[random_.below(facts.size())]];
  if (others.empty()) return;
  const int first = split_.parts[others[random_.below(others.size())]].first;
  if (split_.origins[first].part == SplitTask::Part::kWhole) step = {first, 0};
}

void LocalSearch::exchange(Sequence& list) {
  if (list.empty()) return;
  if (!earners_.empty() && !original_.events.empty() && random_.chance(0.1)) {  // waits for the next event
    const auto last = std::ranges::find_if(list.rbegin(), list.rend(), is_event);
    const std::size_t events = static_cast<std::size_t>(std::ranges::count_if(list, is_event)),
                      from = static_cast<std::size_t>(list.rend() - last);
    if (events == original_.events.size()) return;
    list.insert(list.begin() + static_cast<std::ptrdiff_t>(from + random_.below(list.size() - from + 1)),
                {-2 - static_cast<int>(events), 0});
    return;
  }
  if (!earners_.empty() && random_.chance(0.3)) {
    const std::size_t at = random_.below(list.size() + 1);
    insert(list, at, at, earners_[random_.below(earners_.size())]);
    return;
  }
  const std::size_t at = std::min(
      list.size() - 1, random_.chance(0.5) ? static_cast<std::size_t>(critical_step()) : random_.below(list.size()));
  if (is_event(list[at])) return;
  const int original = split_.origins[list[at].action].action;
  const auto [first, last] = split_.parts[original];
  // The parts of this action nearest to the place.
  std::size_t begin = at, end = at;
  if (last >= 0 && list[at].action == last) {
    while (begin > 0 && list[begin].action != first) --begin;
    if (list[begin].action != first) return;
  } else if (last >= 0) {
    while (end + 1 < list.size() && list[end].action != last) ++end;
    if (list[end].action != last) return;
  }
  const double kind = random_.uniform();
  if (kind < 0.15 && list.size() > 2) {
    if (last >= 0) list.erase(list.begin() + static_cast<std::ptrdiff_t>(end));
    list.erase(list.begin() + static_cast<std::ptrdiff_t>(begin));
    return;
  }
  const std::vector<int> others = alternatives(original);
  if (others.empty()) return;
  const int other = others[random_.below(others.size())];
  const auto [other_first, other_last] = split_.parts[other];
  if (kind < 0.7 && (last >= 0) == (other_last >= 0)) {
    list[begin] = {other_first, 0};
    if (last >= 0) list[end] = {other_last, 0};
  } else {
    insert(list, begin, end, other);
  }
}

}  // namespace cxlab::planner
