#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "cx/base/expected.h"
#include "planner/templates/tree.h"

namespace cxlab::planner::templates {

/// Parses one template; `name` is for messages. Unknown statements, filters and tests are errors.
Expected<std::unique_ptr<Template>> parse_template(std::string_view source, const std::string& name);

}  // namespace cxlab::planner::templates
