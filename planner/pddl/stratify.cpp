#include "planner/pddl/stratify.h"

#include <algorithm>

namespace cxlab::planner {
namespace {

/// The lowest stratum in which a rule with this condition can stand.
int needed_stratum(const Domain& domain, const Condition& condition, bool negated) {
  int stratum = 0;
  if (condition.kind == Condition::Kind::kAtom) {
    const Predicate& predicate = domain.predicates[condition.predicate];
    return predicate.derived ? predicate.stratum + (negated ? 1 : 0) : 0;
  }
  for (std::size_t i = 0; i < condition.operands.size(); ++i) {
    const bool flips = condition.kind == Condition::Kind::kNot || (condition.kind == Condition::Kind::kImply && i == 0);
    stratum = std::max(stratum, needed_stratum(domain, condition.operands[i], negated != flips));
  }
  return stratum;
}

}  // namespace

std::optional<std::size_t> stratify(Domain& domain) {
  const int highest = static_cast<int>(domain.derivations.size());
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < domain.derivations.size(); ++i) {
      const Derivation& rule = domain.derivations[i];
      int& stratum = domain.predicates[rule.predicate].stratum;
      const int needed = needed_stratum(domain, rule.condition, false);
      if (needed <= stratum) continue;
      if (needed > highest) return i;
      stratum = needed;
      changed = true;
    }
  }
  return std::nullopt;
}

}  // namespace cxlab::planner
