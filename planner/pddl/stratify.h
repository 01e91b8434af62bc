#pragma once
// Orders derived predicates so that negation reaches only what is already known.

#include <cstddef>
#include <optional>

#include "planner/pddl/model.h"

namespace cxlab::planner {

/// Sets Predicate::stratum of derived predicates, from 0. Returns the index of a derivation that is part of a cycle
/// through a negation, if there is one.
std::optional<std::size_t> stratify(Domain& domain);

}  // namespace cxlab::planner
