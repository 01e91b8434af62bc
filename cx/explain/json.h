#pragma once
// Answers as JSON, for `--json`.

#include "cx/base/json.h"

#include "cx/base/json.h"
#include "cx/explain/why_not.h"

namespace cxlab::explain {

Json to_json(const WhyNot& answer);

}  // namespace cxlab::explain
