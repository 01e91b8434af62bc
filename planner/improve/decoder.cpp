#include "planner/improve/decoder.h"

#include <algorithm>

namespace cxlab::planner {

namespace {

constexpr int kMostPasses = 20;
constexpr double kLeastTimeWeight = 1e-6;  ///< where time does not count
constexpr double kStartWeight =
    0.05;  ///< of the mean time in the cost: earlier is better even where it does not count yet

}  // namespace

void Decoder::clear(const Sequence& list) {
  scratch_ = simulator_.initial();
  timeline_.clear();
  running_.clear();
  releases_.assign(list.size(), {0, -1});
  shifted_ = false;
  next_event_ = 0;
  next_.resize(list.size() + 1);
  for (std::size_t i = 0; i <= list.size(); ++i) next_[i] = i < list.size() ? static_cast<int>(i) + 1 : 0;
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
  clear(list);
  plan.order.clear();
  plan.times.clear();
  plan.causes.clear();
  plan.late.clear();
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
    if (!place(plan, plan.order.size() - 1) || too_dear(most_cost)) return false;
  }
  if (end < plan.order.size()) {  // scheduled once more without the rest
    plan.order.resize(end);
    scratch_ = end_;
    shifted_ = true;
  }
  return schedule(plan, most_cost);
}

bool Decoder::too_dear(double most_cost) const {
  if (objective_.is_makespan()) return static_cast<double>(timeline_.makespan()) > most_cost;
  return objective_.never_falls() &&
         objective_.value(simulator_.numbers(scratch_.data()), timeline_.makespan()) > most_cost;
}

bool Decoder::advance(const Sequence& list, Sequence& order, PackedState& state) {
  clear(list);
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

/// Gives the next step of the order its time.
bool Decoder::place(DecodedPlan& plan, std::size_t index) {
  const SequenceStep& step = plan.order[index];
  const Micros late_before = timeline_.lateness();
  Micros time = 0;
  int cause = -1;
  if (is_event(step)) {
    if (!timeline_.append_event()) return false;
    time = touches_.events()[event_of(step)].time;
  } else {
    const SplitTask::Origin origin = split_.origins[step.action];
    if (origin.part == SplitTask::Part::kWhole) {
      time = timeline_.append(origin.action, step.duration);
      cause = timeline_.cause();
    } else if (origin.part == SplitTask::Part::kBegin) {
      const auto [release, waits_for] = releases_[index];
      time = timeline_.append_start(origin.action, release);
      cause = timeline_.cause() < 0 ? waits_for : timeline_.cause();
      running_.push_back({origin.action, static_cast<int>(index), time, step.duration});
    } else {
      const auto own = std::ranges::find(running_, origin.action, &Running::action);
      const Micros due = own->start + own->duration;
      time = timeline_.append_end(origin.action, due);
      cause = timeline_.cause() < 0 ? own->begin : timeline_.cause();
      if (time > due) {  // the beginning must wait: the times are computed again
        releases_[own->begin] = {time - own->duration, timeline_.cause()};
        shifted_ = true;
      }
      running_.erase(own);
    }
    if (time == Timeline::kNever) return false;
  }
  if (timeline_.lateness() > late_before) plan.late.push_back(static_cast<int>(index));
  plan.times.push_back(time);
  plan.causes.push_back(cause);
  return true;
}

bool Decoder::schedule(DecodedPlan& plan, double most_cost) {
  for (int pass = 0; shifted_; ++pass) {
    if (pass == kMostPasses) return false;
    shifted_ = false;
    timeline_.clear();
    running_.clear();
    plan.times.clear();
    plan.causes.clear();
    plan.late.clear();
    work_ += static_cast<std::int64_t>(plan.order.size());
    for (std::size_t i = 0; i < plan.order.size(); ++i)
      if (!place(plan, i) || too_dear(most_cost)) return false;
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
