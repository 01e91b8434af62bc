#pragma once
// Templates in the language of Jinja, as files of domains and problems may be: extends, block, include, import, for,
// if, set, macro, call, filter, with, raw; expressions, filters and tests. See docs/planning.md for what is left out.

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "planner/templates/value.h"

namespace cxlab::planner::templates {

/// Gives the text of a template by the name that extends, include and import say; none if there is no such template.
using Loader = std::function<std::optional<std::string>(const std::string& name)>;

/// Templates below a folder. Names that lead out of it are not found.
Loader folder_loader(const std::string& folder);

/// What a template may use up before it is stopped with an error.
struct Limits {
  std::size_t output = 64u << 20;  ///< bytes of text, in all strings that are made
  std::size_t steps = 20'000'000;  ///< evaluated expressions, items and statements
};

/// Renders the template of that name. `variables` are seen by it, by what it extends, and by what it includes or
/// imports with its context. Errors carry the name as `file`, and the line; what Jinja has and this has not carries the
/// code "unsupported".
Expected<std::string> render(const Loader& loader, const std::string& name,
                             const std::vector<std::pair<std::string, Value>>& variables = {},
                             const Limits& limits = {});

/// Renders `file`, found below `folder`.
Expected<std::string> render_file(const std::string& folder, const std::string& file);

}  // namespace cxlab::planner::templates
