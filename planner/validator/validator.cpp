#include "planner/validator/validator.h"

#include <set>

#include "planner/validator/execution.h"

namespace cxlab::planner {
namespace {

void functions_of(const Expression& expression, std::set<FunctionId>& out) {
  if (expression.kind == Expression::Kind::kFunction) out.insert(expression.function);
  for (const Expression& operand : expression.operands) functions_of(operand, out);
}

/// Adds what a condition reads, through derived predicates, too.
void read_by(const Domain& domain, const Condition& condition, std::set<PredicateId>& predicates,
             std::set<FunctionId>& functions) {
  if (condition.kind == Condition::Kind::kAtom && predicates.insert(condition.predicate).second)
    for (const Derivation& rule : domain.derivations)
      if (rule.predicate == condition.predicate) read_by(domain, rule.condition, predicates, functions);
  for (const Expression& side : condition.sides) functions_of(side, functions);
  for (const Condition& operand : condition.operands) read_by(domain, operand, predicates, functions);
}

}  // namespace

const char* to_word(Violation::Kind kind) {
  constexpr const char* kWords[] = {"time", "duration", "condition", "effect", "interference", "goal"};
  return kWords[static_cast<std::size_t>(kind)];
}

Validator::Validator(const Domain& domain, const Problem& problem)
    : domain_(domain), problem_(problem), evaluator_(domain, problem), initial_(domain, problem) {
  find_fluents();
  find_bases();
  evaluator_.derive(initial_);
}

void Validator::find_fluents() {
  fluent_predicates_.resize(domain_.predicates.size());
  fluent_functions_.resize(domain_.functions.size());
  for (const Action& action : domain_.actions)
    for (const Effect& effect : action.effects) {
      if (effect.is_numeric())
        fluent_functions_[effect.function] = true;
      else
        fluent_predicates_[effect.predicate] = true;
    }
  for (const TimedFact& later : problem_.timed_facts) fluent_predicates_[later.fact.predicate] = true;
  for (const TimedAssignment& later : problem_.timed_values) fluent_functions_[later.assignment.function] = true;
}

void Validator::find_bases() {
  bases_.resize(domain_.predicates.size());
  for (const Derivation& rule : domain_.derivations) {
    std::set<PredicateId> predicates;
    std::set<FunctionId> functions;
    read_by(domain_, rule.condition, predicates, functions);
    for (const PredicateId predicate : predicates)
      if (!domain_.predicates[predicate].derived && fluent_predicates_[predicate])
        bases_[rule.predicate].predicates.push_back(predicate);
    for (const FunctionId function : functions)
      if (fluent_functions_[function]) bases_[rule.predicate].functions.push_back(function);
  }
}

Expected<Verdict> Validator::check(const Plan& plan, const ValidateOptions& options) const {
  return Execution(*this, plan, options).run();
}

std::string to_text(const Violation& violation) {
  return violation.message + (violation.advice.empty() ? "" : "\n  advice: " + violation.advice);
}

}  // namespace cxlab::planner
