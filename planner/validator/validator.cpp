#include "planner/validator/validator.h"

#include "planner/validator/execution.h"

namespace cxlab::planner {

const char* to_word(Violation::Kind kind) {
  constexpr const char* kWords[] = {"time", "duration", "condition", "effect", "interference", "goal"};
  return kWords[static_cast<std::size_t>(kind)];
}

Validator::Validator(const Domain& domain, const Problem& problem)
    : evaluator_(domain, problem),
      initial_(domain, problem),
      fluents_(changing(domain, problem)),
      bases_(bases_of_derived(domain)) {
  evaluator_.derive(initial_);
}

Expected<Verdict> Validator::check(const Plan& plan, const ValidateOptions& options) const {
  return Execution(*this, plan, options).run();
}

std::string to_text(const Violation& violation) {
  return violation.message + (violation.advice.empty() ? "" : "\n  advice: " + violation.advice);
}

}  // namespace cxlab::planner
