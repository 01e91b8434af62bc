#pragma once
// A change in the middle of a run, as manifests have it; the content of its file is a copy beside them.

#include <nlohmann/json.hpp>

#include "lab/what_if.h"

namespace cxlab::lab {

nlohmann::ordered_json json_of(const WhatIf& what_if);
/// Throws nlohmann::json::exception where something is missing or of another type.
WhatIf what_if_from(const nlohmann::json& json);

}  // namespace cxlab::lab
