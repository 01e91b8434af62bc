#include "planner/validator/execution.h"

#include <algorithm>
#include <cmath>

#include "planner/pddl/text.h"
#include "planner/validator/crossing.h"

namespace cxlab::planner {
namespace {

constexpr std::int64_t kOfAFrame = 50;  ///< combinations that cost as much as one that stays in memory

}  // namespace

Execution::Execution(const Validator& validator, const Plan& plan, const ValidateOptions& options)
    : validator_(validator),
      evaluator_(validator.evaluator()),
      domain_(evaluator_.domain()),
      problem_(evaluator_.problem()),
      plan_(plan),
      options_(options),
      epsilon_(to_nanos(options.epsilon)),
      state_(validator.initial()) {}

Expected<Verdict> Execution::run() {
  verdict_.makespan = makespan(plan_);
  if (!lay_out()) return std::move(verdict_);
  Nanos now = 0;
  bool right = true;
  for (std::size_t first = 0; right && first < happenings_.size() && !evaluator_.is_over();) {
    std::size_t last = first;
    while (last < happenings_.size() && happenings_[last].time == happenings_[first].time) ++last;
    current_ = first;
    right = pass(now, happenings_[first].time) && happen(first, last);
    now = happenings_[first].time;
    first = last;
  }
  current_ = happenings_.size();
  right = right && check_goal();
  verdict_.valid = right;
  if (right && problem_.metric)
    verdict_.metric = evaluator_.number(problem_.metric->value, Frame{}, state_, verdict_.makespan);
  return std::move(verdict_);
}

/// Fills starts, ends and happenings up to the end of the plan.
bool Execution::lay_out() {
  running_.resize(plan_.size());
  for (int step = 0; step < static_cast<int>(plan_.size()); ++step) {
    const PlanStep& planned = plan_[step];
    const Action& action = action_of(step);
    const double end = planned.start + planned.duration;
    const auto fail_at_start = [&](Violation::Kind kind, const std::string& what, std::string advice) {
      return fail({kind, planned.start, step, -1, {}, {}, describe_step(step) + what, std::move(advice)});
    };
    if (!(std::abs(planned.start) < kLatestTime) || !(std::abs(end) < kLatestTime))
      return fail_at_start(Violation::Kind::kTime,
                           ": found a time that is not below " + number_text(kLatestTime) + " s", {});
    starts_.push_back(to_nanos(planned.start));
    ends_.push_back(action.durative ? to_nanos(end) : starts_.back());
    if (starts_.back() < 0)
      return fail_at_start(Violation::Kind::kTime, " begins before 0",
                           "let all steps begin " + time_text(-planned.start) + " s later");
    if (ends_.back() < starts_.back()) return fail_at_start(Violation::Kind::kDuration, " has a negative duration", {});
    end_ = std::max(end_, ends_.back());
    running_[step].frame.assign(planned.arguments.begin(), planned.arguments.end());
    running_[step].frame.resize(static_cast<std::size_t>(action.slots));
    if (action.durative) {
      happenings_.push_back({starts_.back(), Happening::Kind::kStart, step});
      happenings_.push_back({ends_.back(), Happening::Kind::kEnd, step});
    } else {
      happenings_.push_back({starts_.back(), Happening::Kind::kInstant, step});
    }
  }
  for (const OutsideEvent& event : validator_.outside())
    happenings_.push_back({event.time, Happening::Kind::kOutside, -1, &event});
  std::ranges::stable_sort(happenings_, {}, [](const Happening& each) { return std::pair(each.time, each.kind); });
  return true;
}

/// Time goes on with nothing happening.
bool Execution::pass(Nanos from, Nanos to) {
  if (from == to) return true;
  const double length = to_seconds(to - from);
  for (const int step : active_) {
    if (!hold_over_all(step, length)) return false;
    drop_pending(step, length);
  }
  if (!state_.has_rates()) return true;
  state_.advance(length);
  evaluator_.derive(state_);
  return true;
}

/// Looks ahead to where a condition over all is first broken; none if it holds until then.
std::optional<double> Execution::look_to_break(const Condition& condition, Frame& frame, int step, double length) {
  const auto broken = first_break(evaluator_, condition, frame, state_, duration_of_step(step), length);
  if (broken) state_.look_ahead(*broken);  // for the explanation
  return broken;
}

bool Execution::hold_over_all(int step, double length) {
  const Condition& condition = action_of(step).condition.over_all;
  if (condition.is_true()) return true;
  const double began = to_seconds(happenings_[current_].time) - length;
  const auto broken = look_to_break(condition, running_[step].frame, step, length);
  return !broken || fail_condition(step, condition, "over all", state_.has_rates() ? began + *broken : began);
}

/// Forgets conditional effects whose condition over all was broken.
void Execution::drop_pending(int step, double length) {
  for (Pending& pending : running_[step].pending) {
    const Condition& condition = pending.effect->condition.over_all;
    if (condition.is_true()) continue;
    std::erase_if(pending.frames, [&](Frame& frame) {
      const bool broken = look_to_break(condition, frame, step, length).has_value();
      state_.look_ahead(0);
      return broken;
    });
  }
}

/// All that happens at one time: conditions first, then effects together.
bool Execution::happen(std::size_t first, std::size_t last) {
  for (std::size_t i = first; i < last; ++i)
    if (!conditions_of(happenings_[i])) return false;
  const std::size_t known = records_.size();
  for (std::size_t i = first; i < last; ++i) {
    Record record{happenings_[i], {}};
    if (!collect(happenings_[i], record.by_step)) return false;
    records_.push_back(std::move(record));
  }
  if (!check_interference(first, last)) return false;
  bool rates_change = state_.has_rates();
  for (std::size_t i = first; i < last; ++i) {
    const Happening& happening = happenings_[i];
    const Record& record = records_[known + (i - first)];
    if (!apply_changes(record.changes(), state_)) {
      for (const Change& change : record.changes())
        if (change.effect != nullptr && change.effect->is_numeric())
          return fail_effect(happening.step, *change.effect, to_seconds(happening.time));
    }
    if (happening.kind == Happening::Kind::kEnd) std::erase(active_, happening.step);
    if (happening.kind != Happening::Kind::kStart) continue;
    active_.insert(std::ranges::lower_bound(active_, happening.step), happening.step);
    for (const Effect& effect : action_of(happening.step).effects)
      rates_change = rates_change || effect.time == Effect::Time::kContinuous;
  }
  evaluator_.derive(state_);
  return !rates_change || set_rates();
}

bool Execution::duration_of(const Happening& happening) {
  const Action& action = action_of(happening.step);
  const double duration = duration_of_step(happening.step);
  for (const DurationConstraint& constraint : action.duration) {
    if (constraint.at_end != (happening.kind == Happening::Kind::kEnd)) continue;
    const auto bound = evaluator_.number(constraint.bound, running_[happening.step].frame, state_);
    const double gap = bound ? duration - *bound : 0;
    const bool low =
        bound && constraint.comparison != Comparison::kLessEqual && gap < -options_.duration_tolerance - 1e-9;
    const bool high =
        bound && constraint.comparison != Comparison::kGreaterEqual && gap > options_.duration_tolerance + 1e-9;
    if (bound && !low && !high) continue;
    Violation violation{Violation::Kind::kDuration, to_seconds(happening.time), happening.step};
    violation.when = constraint.at_end ? "at end" : "at start";
    Printer printer(domain_, problem_.objects);
    printer.name_objects(plan_[happening.step].arguments);
    violation.condition = printer.expression(constraint.bound);
    violation.message = describe_step(happening.step) + ": the duration is " + time_text(duration);
    if (!bound) {
      violation.message += ", but its bound " + violation.condition + " has no value";
    } else {
      const char* verb = constraint.comparison == Comparison::kEqual ? "" : low ? "at least " : "at most ";
      violation.message += ", expected " + (verb + time_text(*bound));
      violation.advice = "write [" + time_text(*bound) + "]";
    }
    return fail(violation);
  }
  return true;
}

bool Execution::conditions_of(const Happening& happening) {
  if (happening.kind == Happening::Kind::kOutside) return true;
  if (!duration_of(happening)) return false;
  const TimedCondition& condition = action_of(happening.step).condition;
  const bool at_end = happening.kind == Happening::Kind::kEnd;
  const Condition& now = at_end ? condition.end : condition.start;
  if (!holds(now, happening.step)) {
    const char* when = happening.kind == Happening::Kind::kInstant ? "" : at_end ? "at end" : "at start";
    return fail_condition(happening.step, now, when, to_seconds(happening.time));
  }
  if (happening.kind == Happening::Kind::kStart) enable_pending(happening.step);
  return true;
}

void Execution::enable_pending(int step) {
  Running& running = running_[step];
  for (const Effect& effect : action_of(step).effects) {
    if (effect.time != Effect::Time::kEnd) continue;
    Pending& pending = running.pending.emplace_back(Pending{&effect, {}});
    evaluator_.each_binding(effect.variables, running.frame, [&] {
      if (!effect.variables.empty() && !evaluator_.spend(kOfAFrame)) return false;
      if (holds(effect.condition.start, step)) pending.frames.push_back(running.frame);
      return true;
    });
  }
}

bool Execution::collect(const Happening& happening, std::vector<Change>& changes) {
  if (happening.kind == Happening::Kind::kOutside) return true;
  const int step = happening.step;
  const double duration = duration_of_step(step), now = to_seconds(happening.time);
  if (happening.kind == Happening::Kind::kEnd) {
    for (auto& [effect, frames] : running_[step].pending)
      for (Frame& frame : frames)
        if (evaluator_.holds(effect->condition.end, frame, state_, duration) &&
            !evaluator_.ground(*effect, frame, state_, duration, changes))
          return fail_effect(step, *effect, now);
    return true;
  }
  for (const Effect& effect : action_of(step).effects) {
    const auto enabled = [&](Frame&) { return holds(effect.condition.start, step); };
    if (effect.time == Effect::Time::kStart &&
        !evaluator_.collect(effect, running_[step].frame, state_, duration, enabled, changes))
      return fail_effect(step, effect, now);
  }
  return true;
}

/// Rates of change of all running steps.
bool Execution::set_rates() {
  state_.clear_rates();
  for (const int step : active_)
    for (const Effect& effect : action_of(step).effects) {
      if (effect.time != Effect::Time::kContinuous) continue;
      Frame& frame = running_[step].frame;
      const bool right = evaluator_.each_binding(effect.variables, frame, [&] {
        const Objects objects(effect.terms, frame);
        const auto rate = evaluator_.number(effect.value, frame, state_, duration_of_step(step));
        if (!rate || !state_.value(effect.function, objects))
          return fail_effect(step, effect, to_seconds(happenings_[current_].time));
        state_.add_rate(effect.function, objects, effect.kind == Effect::Kind::kIncrease ? *rate : -*rate);
        return true;
      });
      if (!right) return false;
    }
  return true;
}

Footprint Execution::footprint_of(const Happening& happening, const std::vector<Change>& changes) {
  Footprint footprint(validator_);
  footprint.write(changes);
  if (happening.kind == Happening::Kind::kOutside) return footprint;
  const Action& action = action_of(happening.step);
  Frame& frame = running_[happening.step].frame;
  const bool at_end = happening.kind == Happening::Kind::kEnd;
  footprint.read(at_end ? action.condition.end : action.condition.start, frame);
  for (const DurationConstraint& constraint : action.duration)
    if (constraint.at_end == at_end) footprint.read(constraint.bound, frame);
  for (const Effect& effect : action.effects) {
    if (effect.time == Effect::Time::kContinuous) continue;
    const bool now = (effect.time == Effect::Time::kEnd) == at_end;
    evaluator_.each_binding(effect.variables, frame, [&] {
      // The condition at the start also decides about effects at the end.
      footprint.read_guard(at_end ? effect.condition.end : effect.condition.start, frame);
      if (now) footprint.read(effect.value, frame);
      return true;
    });
  }
  return footprint;
}

bool Execution::check_interference(std::size_t first, std::size_t last) {
  const Nanos now = happenings_[first].time;
  std::erase_if(recent_, [&](const Recent& each) { return now - each.happening.time >= epsilon_; });
  const bool soon = last < happenings_.size() && happenings_[last].time - now < epsilon_;
  if (recent_.empty() && last - first < 2 && !soon) return true;
  for (std::size_t i = first; i < last; ++i) {
    Recent fresh{happenings_[i], footprint_of(happenings_[i], records_[records_.size() - (last - i)].changes())};
    for (const Recent& earlier : recent_) {
      if (earlier.happening.event && fresh.happening.event) continue;  // no plan can move them
      const std::string what = Footprint::interference(earlier.footprint, fresh.footprint);
      if (!what.empty()) return fail_interference(earlier.happening, fresh.happening, what);
    }
    recent_.push_back(std::move(fresh));
  }
  return true;
}

bool Execution::check_goal() {
  Frame frame(static_cast<std::size_t>(problem_.goal_slots), 0);
  if (evaluator_.holds(problem_.goal, frame, state_)) return true;
  const Nanos last = happenings_.empty() ? 0 : happenings_.back().time;
  Violation violation{Violation::Kind::kGoal, to_seconds(last)};
  violation.when = "at end";
  const Condition& part = failing_part(problem_.goal, frame, 0);
  violation.message = std::string("the goal does not hold ") +
                      (last > end_ ? "after the last event from outside (" : "at the end of the plan (") +
                      time_text(violation.time) + ")";
  explain(part, frame, violation, 0);
  return fail(violation);
}

}  // namespace cxlab::planner
