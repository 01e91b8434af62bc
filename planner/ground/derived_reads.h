#pragma once
// What conditions read through derived predicates.

#include "planner/ground/task.h"

namespace cxlab::planner {

/// By action of the domain; empty without derived predicates.
ById<SchemaReads> find_derived_reads(const Domain& domain);

}  // namespace cxlab::planner
