#include "planner/ground/derived_reads.h"

namespace cxlab::planner {

namespace {

/// Collects what one condition reads.
class ReadsOfCondition {
 public:
  ReadsOfCondition(const Domain& domain, DerivedReads& reads)
      : domain_(domain), reads_(reads), seen_(domain.predicates.size(), 0) {}

  /// `inside`: of a rule, where plain facts count, too.
  void look_at(const Condition& condition, bool inside) {
    if (condition.kind == Condition::Kind::kAtom) {
      const PredicateId predicate = condition.predicate;
      const bool derived = domain_.predicates[predicate].derived;
      if (inside && !derived) {
        prepare();
        reads_.predicates[predicate] = 1;
      }
      if (derived && !seen_[predicate]) {
        seen_[predicate] = 1;
        for (const Derivation& rule : domain_.derivations)
          if (rule.predicate == predicate) look_at(rule.condition, true);
      }
    }
    if (inside)
      for (const Expression& side : condition.sides) look_at(side);
    for (const Condition& operand : condition.operands) look_at(operand, inside);
  }

 private:
  void look_at(const Expression& expression) {
    prepare();
    if (expression.kind == Expression::Kind::kFunction) reads_.functions[expression.function] = 1;
    for (const Expression& operand : expression.operands) look_at(operand);
  }
  void prepare() {
    reads_.predicates.resize(domain_.predicates.size(), 0);
    reads_.functions.resize(domain_.functions.size(), 0);
  }

  const Domain& domain_;
  DerivedReads& reads_;
  ById<char> seen_;  ///< by predicate
};

void add_reads(const Domain& domain, const TimedCondition& condition, SchemaReads& to) {
  ReadsOfCondition(domain, to.start).look_at(condition.start, false);
  ReadsOfCondition(domain, to.over_all).look_at(condition.over_all, false);
  ReadsOfCondition(domain, to.end).look_at(condition.end, false);
}

}  // namespace

ById<SchemaReads> find_derived_reads(const Domain& domain) {
  ById<SchemaReads> found;
  if (domain.derivations.empty()) return found;
  for (const Action& action : domain.actions) {
    SchemaReads& reads = found.emplace_back();
    add_reads(domain, action.condition, reads);
    for (const Effect& effect : action.effects) add_reads(domain, effect.condition, reads);
  }
  return found;
}

}  // namespace cxlab::planner
