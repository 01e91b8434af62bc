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

/// Reads and parses both files. A template is rendered first, with its folder as the place of all that it names, and
/// errors then count the lines of what came out, as `FILE (rendered)`. `data` is a JSON object: what the templates see
/// by name. Fails if the problem has no goal.
Expected<Task> load_task(const std::string& domain_file, const std::string& problem_file, const Deadline& deadline = {},
                         const std::string& data = "{}");

}  // namespace cxlab::planner
