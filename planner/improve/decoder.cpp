#include "planner/improve/decoder.h"

#include <algorithm>

namespace cxlab::planner {

namespace {

constexpr int kMostPasses = 20;
constexpr double kLeastTimeWeight = 1e-6;  ///< where time does not count
constexpr double kStartWeight =
    0.05;  ///< of the mean time in the cost: earlier is better even where it does not count yet

std::size_t in_common(const Sequence& a, const Sequence& b) {
  return static_cast<std::size_t>(std::ranges::mismatch(a, b).in1 - a.begin());
}

}  // namespace

void Decoder::keep(const DecodedPlan& plan) {
  const std::size_t words = static_cast<std::size_t>(simulator_.words());
  std::size_t step = in_common(kept_.order, plan.order);
  kept_ = plan;
  kept_states_.resize((plan.order.size() + 1) * words);
  for (; step < plan.order.size(); ++step) {
    Word* state = &kept_states_[(step + 1) * words];
    std::copy_n(state - words, words, state);
    const SequenceStep& next = plan.order[step];
    if (is_event(next))
      simulator_.apply_event(event_of(next), state);
    else
      simulator_.apply_with(next.action, state, next.duration);
  }
}

/// Prepares to schedule the list from step `same` on: the kept plan has the same steps before.
void Decoder::set_out(const Sequence& list, std::size_t same) {
  scratch_.assign(kept_state(same), kept_state(same + 1));
  running_.clear();
  releases_.assign(list.size(), {0, -1});
  shifted_ = false;
  next_event_ =
      static_cast<int>(std::count_if(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(same), is_event));
  next_.resize(list.size() + 1);
  next_[0] = same < list.size() ? static_cast<int>(same) + 1 : 0;
  for (std::size_t i = same + 1; i <= list.size(); ++i) next_[i] = i < list.size() ? static_cast<int>(i) + 1 : 0;
}

/// Takes over what the kept plan has in common with the list; how many steps. Each could be applied where it stands,
/// and none is too dear, as the whole plan is not.
std::size_t Decoder::take_kept(const Sequence& list, double most_cost, DecodedPlan& plan) {
  std::size_t same = 0;
  if (objective_.never_falls() && kept_.cost <= most_cost)
    for (const std::size_t most = in_common(kept_.order, list); same < most && !is_part(list[same]);) ++same;
  const auto take = [same](auto& to, const auto& from) {
    to.assign(from.begin(), from.begin() + static_cast<std::ptrdiff_t>(same));
  };
  take(plan.order, list);
  take(plan.times, kept_.times);
  take(plan.causes, kept_.causes);
  plan.late.assign(kept_.late.cbegin(), std::ranges::lower_bound(std::as_const(kept_.late), static_cast<int>(same)));
  const std::size_t on_timeline = in_common(scheduled_, plan.order);
  timeline_.take_back_to(on_timeline);
  scheduled_.resize(on_timeline);
  for (std::size_t i = on_timeline; i < same; ++i) append(list[i], i);
  work_ += static_cast<std::int64_t>(same);
  return same;
}

/// Applies the first step of what is left that can be applied.
Decoder::Taken Decoder::take_next(const Sequence& list, SequenceStep& step) {
  for (int before = 0, item = next_[0]; item != 0; before = item, item = next_[item]) {
    ++work_;
    step = list[item - 1];
    if (is_event(step)) {
      if (event_of(step) != next_event_) continue;
      ++next_event_;
      simulator_.apply_event(event_of(step), scratch_.data());
      if (!keeps_running(scratch_.data(), -1)) return Taken::kFailed;
      next_[before] = next_[item];
      return Taken::kYes;
    }
    if (!simulator_.holds(simulator_.whole_condition(step.action), scratch_.data())) continue;
    trial_ = scratch_;
    if (!simulator_.apply(step.action, trial_.data(), step.duration)) continue;
    const SplitTask::Origin origin = split_.origins[step.action];
    if (origin.part == SplitTask::Part::kBegin) {
      const std::optional<DurationRange> range = simulator_.durations(step.action, scratch_.data());
      if (!range || !simulator_.holds(original_.actions[origin.action].over_all, trial_.data())) continue;
      step.duration = range->least;
    }
    if (!running_.empty() && !keeps_running(trial_.data(), origin.part == SplitTask::Part::kEnd ? origin.action : -1))
      continue;
    std::swap(trial_, scratch_);
    next_[before] = next_[item];
    return Taken::kYes;
  }
  return Taken::kNo;
}

bool Decoder::decode(const Sequence& list, double most_cost, DecodedPlan& plan) {
  set_out(list, take_kept(list, most_cost, plan));
  SequenceStep step;
  std::size_t end = 0;
  bool reached = false;
  for (;;) {
    if (simulator_.is_lasting_goal(scratch_.data(), next_event_)) {
      if (objective_.never_falls()) return running_.empty() && schedule(plan, most_cost);
      if (running_.empty()) {
        reached = true;
        end = plan.order.size();
        end_ = scratch_;
      }
    }
    const Taken taken = take_next(list, step);
    if (taken == Taken::kNo && reached) break;
    if (taken != Taken::kYes) return false;
    plan.order.push_back(step);
    place(plan, plan.order.size() - 1);
    if (too_dear(most_cost)) return false;
  }
  if (end < plan.order.size()) {  // scheduled again without the rest
    plan.order.resize(end);
    scratch_ = end_;
    shifted_ = true;
  }
  return schedule(plan, most_cost);
}

bool Decoder::too_dear(double most_cost) const {
  return objective_.never_falls() &&
         objective_.exceeds(simulator_.numbers(scratch_.data()), timeline_.makespan(), most_cost);
}

bool Decoder::advance(const Sequence& list, Sequence& order, PackedState& state) {
  set_out(list, 0);
  order.clear();
  SequenceStep step;
  for (Taken taken = take_next(list, step); taken != Taken::kNo; taken = take_next(list, step)) {
    if (taken == Taken::kFailed) return false;
    order.push_back(step);
    if (is_event(step)) continue;
    const SplitTask::Origin origin = split_.origins[step.action];
    if (origin.part == SplitTask::Part::kBegin) running_.push_back({origin.action, 0, 0, 0});
    if (origin.part == SplitTask::Part::kEnd)
      running_.erase(std::ranges::find(running_, origin.action, &Running::action));
  }
  state = scratch_;
  return running_.empty();
}

bool Decoder::keeps_running(const Word* state, int except) const {
  return std::ranges::all_of(running_, [&](const Running& running) {
    return running.action == except || simulator_.holds(original_.actions[running.action].over_all, state);
  });
}

bool Decoder::is_part(const SequenceStep& step) const {
  return !is_event(step) && split_.origins[step.action].part != SplitTask::Part::kWhole;
}

/// Puts an event or a whole action on the timeline; its time.
Micros Decoder::append(const SequenceStep& step, std::size_t index) {
  if (scheduled_.size() == index) scheduled_.push_back(step);
  if (!is_event(step)) return timeline_.append(split_.origins[step.action].action, step.duration);
  timeline_.append_event();
  return touches_.events()[event_of(step)].time;
}

/// Gives the next step of the order its time.
void Decoder::place(DecodedPlan& plan, std::size_t index) {
  const SequenceStep& step = plan.order[index];
  const Micros late_before = timeline_.lateness();
  Micros time = 0;
  int cause = -1;
  if (!is_part(step)) {
    time = append(step, index);
    if (!is_event(step)) cause = timeline_.cause();
  } else if (const auto [action, part] = split_.origins[step.action]; part == SplitTask::Part::kBegin) {
    const auto [release, waits_for] = releases_[index];
    time = timeline_.append_start(action, release);
    cause = timeline_.cause() < 0 ? waits_for : timeline_.cause();
    running_.push_back({action, static_cast<int>(index), time, step.duration});
  } else {
    const auto own = std::ranges::find(running_, action, &Running::action);
    const Micros due = own->start + own->duration;
    time = timeline_.append_end(action, due);
    cause = timeline_.cause() < 0 ? own->begin : timeline_.cause();
    if (time > due) {  // the beginning must wait: the times are computed again
      releases_[own->begin] = {time - own->duration, timeline_.cause()};
      shifted_ = true;
    }
    running_.erase(own);
  }
  if (timeline_.lateness() > late_before) plan.late.push_back(static_cast<int>(index));
  plan.times.push_back(time);
  plan.causes.push_back(cause);
}

bool Decoder::schedule(DecodedPlan& plan, double most_cost) {
  for (int pass = 0; shifted_; ++pass) {
    if (pass == kMostPasses) return false;
    shifted_ = false;
    timeline_.take_back_to(0);
    scheduled_.clear();
    running_.clear();
    plan.times.clear();
    plan.causes.clear();
    plan.late.clear();
    work_ += static_cast<std::int64_t>(plan.order.size());
    for (std::size_t i = 0; i < plan.order.size(); ++i) {
      place(plan, i);
      if (too_dear(most_cost)) return false;
    }
  }
  timeline_.finish();
  plan.makespan = timeline_.makespan();
  plan.lateness = timeline_.lateness();
  double sum = 0;
  for (const Micros time : plan.times) sum += static_cast<double>(time);
  plan.value = objective_.value(simulator_.numbers(scratch_.data()), plan.makespan);
  const double start_weight = std::max(kLeastTimeWeight, objective_.time_weight()) * kStartWeight;
  plan.cost = plan.aim() + start_weight * sum / std::max<double>(1, static_cast<double>(plan.order.size()));
  return true;
}

}  // namespace cxlab::planner
