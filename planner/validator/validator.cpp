#include "planner/validator/validator.h"

#include <set>

#include "planner/validator/execution.h"

namespace cxlab::planner {
namespace {

void functions_of(const Expression& expression, std::set<FunctionId>& out) {
  if (expression.kind == Expression::Kind::kFunction) out.insert(expression.function);
  for (const Expression& operand : expression.operands) functions_of(operand, out);
}

void read_by(const Condition& condition, std::set<PredicateId>& predicates, std::set<FunctionId>& functions) {
  if (condition.kind == Condition::Kind::kAtom) predicates.insert(condition.predicate);
  for (const Expression& side : condition.sides) functions_of(side, functions);
  for (const Condition& operand : condition.operands) read_by(operand, predicates, functions);
}

}  // namespace

const char* to_word(Violation::Kind kind) {
  switch (kind) {
    case Violation::Kind::kTime: return "time";
    case Violation::Kind::kDuration: return "duration";
    case Violation::Kind::kCondition: return "condition";
    case Violation::Kind::kEffect: return "effect";
    case Violation::Kind::kInterference: return "interference";
    case Violation::Kind::kGoal: return "goal";
  }
  return "condition";
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
      if (effect.is_numeric()) {
        fluent_functions_[effect.function] = true;
      } else {
        fluent_predicates_[effect.predicate] = true;
      }
    }
  for (const TimedFact& later : problem_.timed_facts) fluent_predicates_[later.fact.predicate] = true;
  for (const TimedAssignment& later : problem_.timed_values) fluent_functions_[later.assignment.function] = true;
}

void Validator::find_bases() {
  bases_.resize(domain_.predicates.size());
  base_functions_.resize(domain_.predicates.size());
  for (PredicateId derived = 0; derived < static_cast<PredicateId>(domain_.predicates.size()); ++derived) {
    if (!domain_.predicates[derived].derived) continue;
    std::set<PredicateId> seen = {derived};
    std::set<FunctionId> functions;
    std::vector<PredicateId> open = {derived};
    while (!open.empty()) {
      const PredicateId next = open.back();
      open.pop_back();
      std::set<PredicateId> read;
      for (const Derivation& rule : domain_.derivations)
        if (rule.predicate == next) read_by(rule.condition, read, functions);
      for (const PredicateId predicate : read)
        if (seen.insert(predicate).second) open.push_back(predicate);
    }
    for (const PredicateId predicate : seen)
      if (!domain_.predicates[predicate].derived && fluent_predicates_[predicate]) bases_[derived].push_back(predicate);
    for (const FunctionId function : functions)
      if (fluent_functions_[function]) base_functions_[derived].push_back(function);
  }
}

Expected<Verdict> Validator::check(const Plan& plan, const ValidateOptions& options) const {
  return Execution(*this, plan, options).run();
}

std::string to_text(const Violation& violation) {
  return violation.message + (violation.advice.empty() ? "" : "\n  advice: " + violation.advice);
}

}  // namespace cxlab::planner
