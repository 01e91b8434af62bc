#pragma once
// Names in patterns that people write.

#include "cx/base/expected.h"
#include "cx/explain/pattern.h"

namespace cxlab::explain {

/// What a pattern that a person wrote names and the engine does not have, with the nearest name: its template or a
/// slot.
Status check_names(const Pattern& pattern, const RuleEngine& engine);

}  // namespace cxlab::explain
