#pragma once
// Answers as JSON, for `--json`.

#include <nlohmann/json_fwd.hpp>

#include "cx/explain/why_not.h"

namespace cxlab::explain {

nlohmann::ordered_json to_json(const WhyNot& answer);

}  // namespace cxlab::explain
