#pragma once
// What is decided about names before a template runs, as Jinja decides it.

#include "cx/base/expected.h"
#include "planner/templates/tree.h"

namespace cxlab::planner::templates {

/// Fills in what tree.h says is by this function. Errors: `extends` elsewhere than at the top level, an assignment to
/// `loop` inside a loop, a parameter `caller` without default.
Status resolve_scopes(Template& parsed);

}  // namespace cxlab::planner::templates
