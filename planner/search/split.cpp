#include "planner/search/split.h"

#include <algorithm>

#include "planner/ground/sorted.h"

namespace cxlab::planner {

namespace {

constexpr Micros kSignatureGrain = 50 * kSeparation;  ///< separations add up differently in another order

bool mentions_duration(const GroundEffects& effects) {
  return std::ranges::any_of(effects.numbers,
                             [](const NumericEffect& effect) { return effect.value.mentions_duration(); });
}

/// The beginning and the end of an action as two without duration; `running`: a fact between them. What the action
/// needs over all is left out.
struct Halves {
  GroundAction begin, end;

  Halves(const GroundAction& action, int running) {
    begin.schema = end.schema = action.schema;
    begin.start = action.start;
    begin.at_start = action.at_start;
    begin.at_start.add.push_back(running);
    end.start = action.end;
    end.start.facts.push_back(running);
    end.at_start = action.at_end;
    for (const ConditionalEffects& conditional : action.conditional) {
      if (!conditional.at_start.empty())
        begin.conditional.push_back({conditional.start, {}, {}, conditional.at_start, {}});
      if (!conditional.at_end.empty()) end.conditional.push_back({conditional.end, {}, {}, conditional.at_end, {}});
    }
  }
};

/// How long the action of a step may last.
DurationRange range(const SplitTask& split, const GroundTask& original, const Simulator& simulator,
                    const SequenceStep& step, const Word* state) {
  const SplitTask::Origin origin = split.origins[step.action];
  if (origin.part == SplitTask::Part::kBegin)
    if (const std::optional<DurationRange> allowed = simulator.durations(step.action, state)) return *allowed;
  const Micros duration = original.actions[origin.action].durative ? step.duration : 0;
  return {duration, duration};
}

}  // namespace

bool is_envelope(const GroundTask& task, const GroundAction& action) {
  if (!action.durative) return false;
  for (const int f : action.at_start.add)
    if (contains(action.at_end.remove, f)) return true;
  for (const NumericEffect& first : action.at_start.numbers)
    for (const NumericEffect& last : action.at_end.numbers)
      if (first.number == last.number) return true;
  const auto given = [&](int f) {
    return contains(action.start.facts, f) || contains(action.over_all.facts, f) || contains(action.at_start.add, f);
  };
  for (const int f : action.end.facts)
    if (!given(f) || contains(action.at_start.remove, f)) return true;
  for (const int f : action.over_all.facts)
    if (contains(action.at_start.remove, f)) return true;
  for (const int c : action.end.comparisons)
    if (!contains(action.over_all.comparisons, c) && task.comparisons[c].linear.duration_weight == 0) return true;
  return false;
}

bool reads_duration(const GroundAction& action) {
  return mentions_duration(action.at_start) || mentions_duration(action.at_end);
}

bool can_be_cut(const GroundTask& task, const GroundAction& action) {
  for (const auto* condition : {&action.start, &action.over_all, &action.end})
    for (const int c : condition->comparisons)
      if (task.comparisons[c].expression.mentions_duration()) return false;
  if (!action.durative || !action.continuous.empty() || reads_duration(action)) return false;
  for (const GroundDuration& duration : action.duration)
    if (duration.at_end) return false;
  return std::ranges::all_of(action.conditional, [](const ConditionalEffects& conditional) {
    return conditional.at_end.empty() || (conditional.start.empty() && conditional.over_all.empty());
  });
}

SplitTask split(const GroundTask& task, const std::vector<char>& cut) {
  SplitTask out;
  out.task = task;
  out.task.actions.clear();
  for (std::size_t a = 0; a < task.actions.size(); ++a) {
    const GroundAction& action = task.actions[a];
    const int first = static_cast<int>(out.task.actions.size());
    out.parts.emplace_back(first, cut[a] ? first + 1 : -1);
    if (!cut[a]) {
      out.task.actions.push_back(action);
      out.origins.push_back({static_cast<int>(a), SplitTask::Part::kWhole});
      continue;
    }
    const int running = static_cast<int>(out.task.facts.size()), idle = running + 1;
    out.task.facts.push_back({-1, {}, idle, false, false});
    out.task.facts.push_back({-1, {}, running, true, false});
    out.task.initial_facts.push_back(0);
    out.task.initial_facts.push_back(1);
    out.task.goal.facts.push_back(idle);
    auto [begin, end] = Halves(action, running);
    begin.duration = action.duration;  // what the beginning allows; it takes no time itself
    begin.start.facts.push_back(idle);
    for (const int f : action.over_all.facts)
      if (!contains(action.at_start.add, f) && !contains(begin.start.facts, f) && action.conditional.empty() &&
          !task.facts[f].derived)
        begin.start.facts.push_back(f);
    std::ranges::sort(begin.start.facts);
    begin.at_start.remove.push_back(idle);
    end.start.facts.insert(end.start.facts.end(), action.over_all.facts.begin(), action.over_all.facts.end());
    sort_unique(end.start.facts);
    end.at_start.add.push_back(idle);
    end.at_start.remove.push_back(running);
    out.task.actions.push_back(std::move(begin));
    out.origins.push_back({static_cast<int>(a), SplitTask::Part::kBegin});
    out.task.actions.push_back(std::move(end));
    out.origins.push_back({static_cast<int>(a), SplitTask::Part::kEnd});
  }
  return out;
}

std::optional<GroundTask> untimed(const GroundTask& task, Ends ends) {
  for (const GroundAction& action : task.actions)
    if (action.durative && !can_be_cut(task, action)) return std::nullopt;
  GroundTask out = loosened(task, false);
  if (ends == Ends::kOften) return out;
  const auto add_fact = [&out] {
    out.facts.push_back({-1, {}, -1, false, false});
    out.initial_facts.push_back(1);
    return static_cast<int>(out.facts.size()) - 1;
  };
  std::size_t part = 0;
  for (const GroundAction& action : task.actions) {
    GroundAction& begin = out.actions[part++];
    if (!action.durative) continue;
    GroundAction& end = out.actions[part++];
    const int begun = begin.at_start.add.back(), idle = add_fact(), single = add_fact();
    begin.at_start.remove.push_back(idle);
    begin.conditional.push_back({{{begun}, {}}, {}, {}, {{}, {single}, {}}, {}});
    end.at_start.add.push_back(idle);
    end.conditional.push_back({{{single}, {}}, {}, {}, {{}, {begun}, {}}, {}});
    out.goal.facts.push_back(idle);
  }
  return out;
}

GroundTask loosened(const GroundTask& task, bool hold) {
  GroundTask out = task;
  out.actions.clear();
  for (const GroundAction& action : task.actions) {
    if (!action.durative) {
      out.actions.push_back(action);
      continue;
    }
    const int begun = static_cast<int>(out.facts.size());
    out.facts.push_back({-1, {}, -1, false, false});
    out.initial_facts.push_back(0);
    auto [begin, end] = Halves(action, begun);
    if (hold) {
      end.start.facts.insert(end.start.facts.end(), action.over_all.facts.begin(), action.over_all.facts.end());
      end.start.comparisons.insert(end.start.comparisons.end(), action.over_all.comparisons.begin(),
                                   action.over_all.comparisons.end());
      std::ranges::sort(end.start.facts);
    }
    begin.continuous = end.continuous = action.continuous;
    out.actions.push_back(std::move(begin));
    out.actions.push_back(std::move(end));
  }
  return out;
}

Concurrent to_plan(const SplitTask& split, const GroundTask& original, const Simulator& simulator,
                   const Sequence& path) {
  Concurrent plan;
  std::vector<std::pair<int, int>> open;
  PackedState now = simulator.initial();
  for (const SequenceStep& step : path) {
    if (is_event(step)) {
      plan.order.push_back({SplitPoint::Kind::kEvent, event_of(step)});
      simulator.apply_event(event_of(step), now.data());
      continue;
    }
    const SplitTask::Origin origin = split.origins[step.action];
    if (origin.part == SplitTask::Part::kEnd) {
      const auto known = std::ranges::find(open, origin.action, &std::pair<int, int>::first);
      plan.order.push_back({SplitPoint::Kind::kEnd, known->second});
      open.erase(known);
    } else {
      const int index = static_cast<int>(plan.steps.size());
      plan.steps.push_back({origin.action, range(split, original, simulator, step, now.data())});
      plan.order.push_back({SplitPoint::Kind::kBegin, index});
      if (origin.part == SplitTask::Part::kWhole)
        plan.order.push_back({SplitPoint::Kind::kEnd, index});
      else
        open.emplace_back(origin.action, index);
    }
    simulator.apply_with(step.action, now.data(), step.duration);
  }
  return plan;
}

SplitCheck::SplitCheck(const SplitTask& split, const GroundTask& original, const Simulator& simulator,
                       const Touches& touches)
    : split_(split), original_(original), simulator_(simulator), stn_(touches) {
  levels_.push_back({{}, simulator_.initial(), {}, 0});
}

/// Adds a step to the network; false if it cannot be applied.
bool SplitCheck::append(const SequenceStep& step) {
  if (levels_.size() < depth_ + 2) levels_.emplace_back();
  const Level& before = levels_[depth_];
  Level& after = levels_[++depth_];
  after.step = step;
  after.state = before.state;
  after.open = before.open;
  bool applied = true;
  if (is_event(step)) {
    stn_.event();
    simulator_.apply_event(event_of(step), after.state.data());
  } else {
    const SplitTask::Origin origin = split_.origins[step.action];
    if (origin.part == SplitTask::Part::kEnd) {
      const auto known = std::ranges::find(after.open, origin.action, &std::pair<int, int>::first);
      stn_.finish(known->second);
      after.open.erase(known);
    } else {
      const int index = stn_.begin(origin.action, range(split_, original_, simulator_, step, before.state.data()));
      if (origin.part == SplitTask::Part::kWhole)
        stn_.finish(index);
      else
        after.open.emplace_back(origin.action, index);
    }
    applied = simulator_.apply_with(step.action, after.state.data(), step.duration);
  }
  after.points = stn_.points();
  return applied;
}

bool SplitCheck::accepts(const Sequence& path, const Word* state) {
  // Paths share their beginnings: the network goes back to where this one parts from the last.
  std::size_t common = 0;
  while (common < depth_ && common < path.size() && levels_[common + 1].step == path[common]) ++common;
  depth_ = common;
  stn_.truncate(levels_[depth_].points);
  while (depth_ < path.size())
    if (!append(path[depth_])) {
      stn_.truncate(levels_[--depth_].points);
      return false;
    }
  std::vector<std::pair<int, int>> open = levels_[depth_].open;
  for (const auto& [action, step] : open)
    if (!simulator_.holds(original_.actions[action].over_all, state)) return false;
  if (!stn_.solve(0)) return false;
  signature_ = stn_.steps() > 0;
  std::ranges::sort(open);
  for (const auto& [action, step] : open) {
    const Micros ran = (stn_.last_happening() - stn_.start(step)) / kSignatureGrain;
    signature_ = (signature_ ^ static_cast<Word>(ran + 1)) * std::uint64_t{0x9e3779b97f4a7c15};
  }
  return true;
}

bool SplitCheck::accepts_goal(const Sequence& path) {
  if (original_.events.empty()) return true;
  fill(stn_, to_plan(split_, original_, simulator_, path));
  depth_ = 0;  // the network is not that of the levels any more
  return (path.empty() || stn_.steps() > 0) && stn_.solve_complete(0);
}

Sequence to_parts(const SplitTask& split, const Sequence& whole) {
  Sequence parts;
  for (const SequenceStep& step : whole) {
    if (is_event(step)) {
      parts.push_back(step);
      continue;
    }
    const auto [first, last] = split.parts[step.action];
    parts.push_back({first, last < 0 ? step.duration : 0});
    if (last >= 0) parts.push_back({last, 0});
  }
  return parts;
}

void fill(Stn& stn, const Concurrent& plan) {
  stn.clear();
  for (const SplitPoint& happening : plan.order) {
    if (happening.kind == SplitPoint::Kind::kEvent)
      stn.event();
    else if (happening.kind == SplitPoint::Kind::kEnd)
      stn.finish(happening.step);
    else
      stn.begin(plan.steps[happening.step].action, plan.steps[happening.step].range);
  }
}

}  // namespace cxlab::planner
