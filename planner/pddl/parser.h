#pragma once
// Reads PDDL files. Errors name file, line, what was found, what was expected, and where a symbol was declared.

#include <string>
#include <string_view>

#include "cx/base/expected.h"
#include "planner/pddl/failure.h"
#include "planner/pddl/model.h"
#include "planner/pddl/syntax.h"

namespace cxlab::planner {

/// Parses the text of a domain; `file` is for messages.
Expected<Domain> parse_domain(std::string_view text, const std::string& file);

/// Parses the text of a problem of that domain. Fails with Failure::kLate when the deadline has passed.
Expected<Problem> parse_problem(std::string_view text, const std::string& file, const Domain& domain,
                                const Deadline& deadline = {});

/// Whether a text has `{{`, `{%` or `{#`.
bool is_template(std::string_view text);
/// Behind the name of a file in errors that count the lines of what came out of a template.
inline constexpr const char* kRendered = " (rendered)";

struct LoadOptions {
  Deadline deadline = {};
  std::string data = "{}";  ///< a JSON object: what templates see by name
  bool needs_goal = true;   ///< a problem without a goal is an error
};

/// Reads and parses both files. A template is rendered first, with its folder as the place of all that it names, and
/// errors then count the lines of what came out, as `FILE (rendered)`.
Expected<Task> load_task(const std::string& domain_file, const std::string& problem_file,
                         const LoadOptions& options = {});

}  // namespace cxlab::planner
