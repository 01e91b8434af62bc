// Files to tasks.

#include <fstream>
#include <sstream>

#include "cx/template/template.h"
#include "planner/pddl/parser.h"

namespace cxlab::planner {
namespace {

struct SourceText {
  std::string text;
  std::string name;  ///< for messages
};

bool is_template(const std::string& text) {
  return text.find("{{") != std::string::npos || text.find("{%") != std::string::npos ||
         text.find("{#") != std::string::npos;
}

Expected<SourceText> read_source(const std::string& file) {
  auto text = read_text(file);
  if (!text) return text.error();
  if (!is_template(*text)) return SourceText{std::move(*text), file};
  const std::size_t slash = file.rfind('/');
  const std::string folder = slash == std::string::npos ? "." : file.substr(0, slash);
  auto rendered = templates::render_file(folder, file.substr(slash == std::string::npos ? 0 : slash + 1));
  if (!rendered) return rendered.error();
  return SourceText{std::move(*rendered), file + " (rendered)"};
}

}  // namespace

Expected<std::string> read_text(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return input_error("cannot be read; expected a file", file);
  if (in.peek() == std::ifstream::traits_type::eof() && !in.bad()) return std::string{};
  std::ostringstream text;
  text << in.rdbuf();
  if (in.bad() || !text) return input_error("cannot be read; expected a file", file);
  return std::move(text).str();
}

Expected<Task> load_task(const std::string& domain_file, const std::string& problem_file, const Deadline& deadline) {
  const auto domain_text = read_source(domain_file);
  if (!domain_text) return domain_text.error();
  const auto problem_text = read_source(problem_file);
  if (!problem_text) return problem_text.error();
  auto domain = parse_domain(domain_text->text, domain_text->name);
  if (!domain) return domain.error();
  auto problem = parse_problem(problem_text->text, problem_text->name, *domain, deadline);
  if (!problem) return problem.error();
  return Task{std::move(*domain), std::move(*problem)};
}

}  // namespace cxlab::planner
