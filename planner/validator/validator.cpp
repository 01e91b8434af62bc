#include "planner/validator/validator.h"

#include <map>

#include "planner/pddl/failure.h"
#include "planner/validator/execution.h"

namespace cxlab::planner {

const char* to_word(Violation::Kind kind) {
  constexpr const char* kWords[] = {"time", "duration", "condition", "effect", "interference", "goal"};
  return kWords[static_cast<std::size_t>(kind)];
}

namespace {

std::vector<OutsideEvent> outside_events(const Problem& problem) {
  std::map<Nanos, std::vector<Change>> by_time;
  for (const auto& [time, fact, value, _] : problem.timed_facts)
    by_time[to_nanos(time)].push_back(
        {value ? Effect::Kind::kAdd : Effect::Kind::kDelete, fact.predicate, fact.objects, 0, nullptr});
  for (const auto& [time, set, _] : problem.timed_values)
    by_time[to_nanos(time)].push_back({Effect::Kind::kAssign, set.function, set.objects, set.value, nullptr});
  std::vector<OutsideEvent> events;
  for (auto& [time, changes] : by_time) events.push_back({time, std::move(changes)});
  return events;
}

}  // namespace

Validator::Validator(const Domain& domain, const Problem& problem, Meter* meter)
    : evaluator_(domain, problem, meter),
      initial_(domain, problem),
      outside_(outside_events(problem)),
      fluents_(changing(domain, problem)),
      bases_(bases_of_derived(domain)) {
  evaluator_.derive(initial_);
}

Expected<Verdict> Validator::check(const Plan& plan, const ValidateOptions& options) const {
  if (evaluator_.is_over()) return out_of_budget("before the plan was judged");
  auto verdict = Execution(*this, plan, options).run();
  if (evaluator_.is_over()) return out_of_budget("while the plan was judged");
  return verdict;
}

std::string to_text(const Violation& violation) {
  return violation.message + (violation.advice.empty() ? "" : "\n  advice: " + violation.advice);
}

}  // namespace cxlab::planner
