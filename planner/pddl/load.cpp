// Files to tasks.

#include <filesystem>
#include <utility>

#include "cx/base/file.h"
#include "cx/template/template.h"
#include "planner/pddl/parser.h"

namespace cxlab::planner {
namespace {

/// The text of a file, rendered where it is a template, and its name for messages.
Expected<std::pair<std::string, std::string>> read_source(const std::string& file, const std::string& data) {
  auto text = read_file(file);
  if (!text) return text.error();
  if (!is_template(*text)) return std::pair(*std::move(text), file);
  const std::filesystem::path path = file;
  auto rendered = templates::render_file(path.has_parent_path() ? path.parent_path().string() : ".", path.filename(),
                                         {.variables = data});
  if (!rendered) return rendered.error();
  return std::pair(*std::move(rendered), file + kRendered);
}

}  // namespace

bool is_template(std::string_view text) {
  return text.find("{{") != text.npos || text.find("{%") != text.npos || text.find("{#") != text.npos;
}

Expected<Task> load_task(const std::string& domain_file, const std::string& problem_file, const LoadOptions& options) {
  const auto domain_text = read_source(domain_file, options.data);
  if (!domain_text) return domain_text.error();
  const auto problem_text = read_source(problem_file, options.data);
  if (!problem_text) return problem_text.error();
  auto domain = parse_domain(domain_text->first, domain_text->second);
  if (!domain) return domain.error();
  auto problem = parse_problem(problem_text->first, problem_text->second, *domain, options.deadline);
  if (!problem) return problem.error();
  if (options.needs_goal && !problem->has_goal)
    return input_error(found_expected("no :goal", "(:goal CONDITION); (:goal (and)) always holds"),
                       problem_text->second);
  return Task{std::move(*domain), std::move(*problem)};
}

}  // namespace cxlab::planner
