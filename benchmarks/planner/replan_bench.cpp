// Measures how much a plan under execution helps when the planner plans again. It carries out half of the steps. Then
// it plans the rest twice: from scratch, and with the plan as a warm start. Prints a line for each problem, and sums.
//
//   bench_replan BUDGET DOMAIN PROBLEM...     BUDGET: work units of the plan that is carried out

#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "planner/manager/instance.h"
#include "planner/pddl/parser.h"
#include "planner/planner.h"

using namespace cxlab::planner;

namespace {

/// The state after a step as a whole. False if it cannot be done now.
bool carry_out(Instance& instance, const PlanStep& step) {
  const ActionCall call{step.action, step.arguments};
  if (!instance.unsatisfied(call, Instance::When::kAtStart).empty()) return false;
  instance.remember_start(call);
  for (const bool at_end : {false, true}) {
    const auto effects = instance.effects(call);
    if (!effects) return false;
    for (const bool value : {false, true})
      for (const ReportedEffect& effect : *effects) {
        if (effect.at_end != at_end || effect.numeric || effect.value != value) continue;
        if (!instance.set(*instance.fact(effect.name, effect.arguments), value)) return false;
      }
    for (const ReportedEffect& effect : *effects) {
      if (effect.at_end != at_end || !effect.numeric) continue;
      const Fact number = *instance.number(effect.name, effect.arguments);
      double now = 0;
      for (const Assignment& v : instance.values())
        if (v.function == number.predicate && v.objects == number.objects) now = v.value;
      instance.set_value(
          number, effect.operation == '=' ? effect.number : now + (effect.operation == '-' ? -1 : 1) * effect.number);
    }
  }
  return true;
}

struct Sums {
  std::int64_t units = 0;
  double makespan = 0;
  void add(const PlanAnswer& answer) {
    units += answer.units;
    makespan += answer.plan->makespan_s;
  }
  void print() const { std::printf(" %9lld units %9.3f s", static_cast<long long>(units), makespan); }
};

/// Exit code.
int replan(const char* domain, const char* problem, std::int64_t budget, Sums& anew, Sums& warm) {
  const auto task = load_task(domain, problem);
  if (!task) {
    std::fprintf(stderr, "%s\n", task.error().text().c_str());
    return 3;
  }
  const auto first = find_plan(*task, {.budget = budget, .anytime = true});
  if (!first || !first->plan) {
    std::printf("%s: no plan\n", problem);
    return 0;
  }
  Instance instance(*task);
  const Plan& plan = first->plan->steps;
  for (std::size_t i = 0; i < plan.size() / 2; ++i)
    if (!carry_out(instance, plan[i])) std::printf("%s: step %zu waits for one that comes later\n", problem, i);
  auto now = instance.planning_task(*instance.goal("base"), 0);
  now->problem.goal = task->problem.goal;
  now->problem.goal_slots = task->problem.goal_slots;
  const auto a = find_plan(*now), b = find_plan(*now, {.warm_start = plan});
  if (!a || !b || !a->plan || !b->plan) {
    std::printf("%s: no plan after half of the steps\n", problem);
    return 0;
  }
  std::printf("%-16s %3zu steps, from scratch", std::filesystem::path(problem).stem().c_str(), plan.size());
  Sums one, other;
  one.add(*a);
  other.add(*b);
  one.print();
  std::printf(", warm");
  other.print();
  std::printf("\n");
  anew.add(*a);
  warm.add(*b);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "usage: bench_replan BUDGET DOMAIN PROBLEM...\n");
    return 2;
  }
  Sums anew, warm;
  for (int i = 3; i < argc; ++i)
    if (const int code = replan(argv[2], argv[i], std::atoll(argv[1]), anew, warm); code != 0) return code;
  std::printf("%-16s            from scratch", "sum");
  anew.print();
  std::printf(", warm");
  warm.print();
  std::printf("\n");
}
