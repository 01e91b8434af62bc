#include "planner/strategies/incumbent.h"

#include <algorithm>
#include <numeric>

#include "planner/pddl/failure.h"

namespace cxlab::planner {

namespace {

constexpr std::int64_t kPortion = 20;       ///< combinations of objects between two looks at the budget
constexpr std::int64_t kGrace = 500'000;    ///< of them, for plans that were found when the budget ended
constexpr std::int64_t kStatesOfStep = 10;  ///< work of judging a step of a plan, in pieces of Work::kNode

/// By point: the latest time that keeps the makespan.
std::vector<Micros> latest_times(const TimedPlan& plan, Micros makespan) {
  ById<Micros> latest(2 * plan.steps.size(), makespan);
  bool changed = true;
  const auto lower = [&](int point, Micros to) {
    if (point < 0 || to >= latest[point]) return;
    latest[point] = to;
    changed = true;
  };
  while (changed) {
    changed = false;
    for (const Ordering& ordering : plan.orderings) {
      lower(ordering.from, latest[ordering.to] - ordering.least);
      if (ordering.most < DurationRange::kForever)
        lower(ordering.to, (ordering.from < 0 ? 0 : latest[ordering.from]) + ordering.most);
    }
  }
  return latest;
}

}  // namespace

Incumbent::Incumbent(const Task& task, const GroundTask& ground, const Touches& touches, const Objective& objective,
                     Budget& budget, const decltype(PlanOptions::on_plan)& on_plan, Clock::time_point began)
    : task_(task),
      ground_(ground),
      touches_(touches),
      objective_(objective),
      budget_(budget),
      on_plan_(on_plan),
      began_(began),
      meter_([&budget, grace = kGrace]() mutable -> std::int64_t {
        budget.spend(Work::kGround, kPortion);
        if (budget.over()) grace -= kPortion;
        return grace > 0 ? kPortion : 0;
      }),
      validator_(task.domain, task.problem, &meter_) {}

double Incumbent::cost() const {
  return plan_ && plan_->metric ? signed_metric(*plan_->metric) : std::numeric_limits<double>::quiet_NaN();
}

bool Incumbent::offer(const Concurrent& plan) {
  Stn stn(touches_);
  fill(stn, plan);
  const bool solved = stn.solve_complete(kSeparation) || stn.solve_complete(0);
  budget_.spend(Work::kTimes, stn.take_work());
  if (!solved) return false;
  std::vector<int> by_start(plan.steps.size());
  std::iota(by_start.begin(), by_start.end(), 0);
  std::ranges::stable_sort(by_start, {}, [&](int step) { return stn.start(step); });
  TimedPlan timed;
  ById<int> place(by_start.size());
  for (const int step : by_start) {
    place[step] = static_cast<int>(timed.steps.size());
    const GroundAction& action = ground_.actions[plan.steps[step].action];
    timed.steps.push_back(
        {in_seconds(stn.start(step)), action.schema, action.arguments, in_seconds(stn.end(step) - stn.start(step)), 0});
  }
  const auto placed = [&](int point) { return 2 * place[point / 2] + point % 2; };
  for (Ordering ordering : stn.orderings()) {
    if (ordering.from >= 0) ordering.from = placed(ordering.from);
    ordering.to = placed(ordering.to);
    timed.orderings.push_back(ordering);
  }
  return offer(std::move(timed), stn.makespan());
}

bool Incumbent::offer(const std::vector<ClockStep>& steps) {
  TimedPlan timed;
  Micros makespan = 0;
  for (const ClockStep& step : steps) {
    const GroundAction& action = ground_.actions[step.action];
    const int point = static_cast<int>(2 * timed.steps.size());
    const Micros length = step.end - step.start;
    timed.steps.push_back({in_seconds(step.start), action.schema, action.arguments, in_seconds(length), 0});
    timed.orderings.push_back({Ordering::kOrigin, point, step.start, step.start});
    timed.orderings.push_back({point, point + 1, length, length});
    makespan = std::max(makespan, step.end);
  }
  return offer(std::move(timed), makespan);
}

bool Incumbent::offer(TimedPlan plan, Micros makespan) {
  if (plan_ && !by_metric() && makespan >= makespan_) return false;
  plan.makespan_s = in_seconds(makespan);
  plan.latest = latest_times(plan, makespan);
  const Expected<Verdict> verdict = validator_.check(plan.steps);
  budget_.spend(Work::kNode, kStatesOfStep * static_cast<std::int64_t>(plan.steps.size()));
  if (!verdict) return false;  // the budget ended
  if (!verdict->valid) {
    ++refused_;
    refusal_ = verdict->violation->message;
    return false;
  }
  plan.metric = verdict->metric;
  double value = static_cast<double>(makespan);
  if (by_metric())
    value = Objective::value_of(plan.metric ? signed_metric(*plan.metric) : std::numeric_limits<double>::quiet_NaN(),
                                makespan);
  if (plan_ && (value > value_ || (value == value_ && makespan >= makespan_))) return false;
  value_ = value;
  makespan_ = makespan;
  if (!plan_) first_plan_s_ = std::chrono::duration<double>(Clock::now() - began_).count();
  plan_ = std::move(plan);
  budget_.improved();
  if (on_plan_) on_plan_(*plan_, budget_.units());
  return true;
}

void Incumbent::report(PlanAnswer& answer) && {
  answer.by_metric = by_metric();
  answer.plan = std::move(plan_);
  answer.refused = refused_;
  answer.refusal = std::move(refusal_);
  answer.first_plan_s = first_plan_s_;
}

}  // namespace cxlab::planner
