#pragma once
// Finds plans for PDDL problems with time, numbers and events.
//
//   Expected<Task> task = load_task("domain.pddl", "problem.pddl");
//   Expected<PlanAnswer> answer = find_plan(*task, {.timeout_s = 1.0, .anytime = true});
//   if (answer && answer->plan) puts(to_text(answer->plan->steps, task->domain, task->problem).c_str());
//
// One thread, one result: the same problem and the same budget of work units give the same answer. A timeout is wall
// time and returns what was found by then. The validator checks every plan before it is returned.

#include <functional>
#include <optional>

#include "cx/base/expected.h"
#include "planner/explain/out_of_reach.h"
#include "planner/pddl/failure.h"
#include "planner/pddl/plan.h"
#include "planner/schedule/stn.h"

namespace cxlab::planner {

/// A plan as times and as what the times must keep to.
struct TimedPlan {
  Plan steps;  ///< by start; times as early as possible
  double makespan_s = 0;
  std::optional<double> metric;  ///< value of the problem's metric
  /// Distances between starts (2 k) and ends (2 k + 1) of steps: any times that keep them are a plan too.
  std::vector<Ordering> orderings;
  std::vector<Micros> latest;  ///< by point: latest time that keeps the makespan
};

struct PlanOptions {
  std::int64_t budget = 60'000'000;   ///< work units; a unit is about a microsecond
  std::optional<double> timeout_s{};  ///< wall time
  /// Better: a better metric if the problem has one, a shorter makespan among equals.
  bool anytime = false;                    ///< look for better plans until the budget ends or a plan is proved best
  std::optional<std::int64_t> patience{};  ///< work units after a plan within which a better one must come
  bool bound = true;                       ///< false: none where it cannot prove that no plan has a better metric
  /// A plan under execution, its steps in their order; the first ones may have been done. The planner tries what is
  /// left of it first, repairs it and improves it.
  Plan warm_start{};
  /// Called with every plan that is better than all before it.
  std::function<void(const TimedPlan&, std::int64_t units)> on_plan{};
  std::size_t most_memory_mb = 2048;
  std::string initial_state = ":init";  ///< its name in explanations
};

struct PlanAnswer {
  PlanStatus status = PlanStatus::kEnded;
  std::string reason;  ///< one sentence
  /// Why the goal is out of reach, where facts one by one or in pairs prove it. Costs no units, but ends with the
  /// budget.
  std::optional<OutOfReach> out_of_reach{};
  std::optional<TimedPlan> plan;
  double lower_bound_s = 0;  ///< no plan is shorter
  /// The bound holds only for plans in which no two actions change the same fact at the same instant.
  bool bound_assumes_order = false;
  bool by_metric = false;              ///< the problem's metric decides which plan is better, not the makespan alone
  std::optional<double> metric_bound;  ///< no plan has a better metric; none: not known
  std::int64_t units = 0;              ///< spent
  int refused = 0;                     ///< plans that the validator rejected, which is a fault of the planner
  std::string refusal;                 ///< why it rejected the last of them
  double first_plan_s = 0;             ///< wall time to the first plan; for people, not for decisions

  /// How far the plan can be from the shortest one, as a share of it: 0.05 = at most 5 %; none without plan or bound.
  std::optional<double> gap() const {
    if (plan && plan->makespan_s == 0) return 0;
    return plan && lower_bound_s > 0 ? std::optional(plan->makespan_s / lower_bound_s - 1) : std::nullopt;
  }
};

/// Fails where the problem cannot be written out (Failure::kOutOfMemory) or judged (kUnsupported).
Expected<PlanAnswer> find_plan(const Task& task, const PlanOptions& options = {});

}  // namespace cxlab::planner
