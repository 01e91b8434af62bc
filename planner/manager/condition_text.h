#pragma once
// Conditions as agents of the PDDL manager read them: the notation of the Unified Planning Framework.

#include <span>
#include <string>
#include <vector>

#include "planner/pddl/model.h"

namespace cxlab::planner {

/// `p(a, b)`, `(not p)`, `(x(a) <= 3)`, `Forall (block y) p(y)`. Slots below the size of `bound` are those objects.
std::string framework_text(const Condition& condition, const Domain& domain, const std::vector<Object>& objects,
                           std::span<const ObjectId> bound);

}  // namespace cxlab::planner
