#include "planner/templates/template.h"

#include <fstream>
#include <sstream>

#include "planner/templates/interpreter.h"

namespace cxlab::planner::templates {

Loader folder_loader(const std::string& folder) {
  return [folder](const std::string& name) -> std::optional<std::string> {
    for (std::size_t at = 0; at <= name.size();) {  // as Jinja: no part of a name leads upwards
      const std::size_t end = std::min(name.find('/', at), name.size());
      if (name.substr(at, end - at) == "..") return std::nullopt;
      at = end + 1;
    }
    std::ifstream in(folder + "/" + name, std::ios::binary);
    if (!in) return std::nullopt;
    if (in.peek() == std::ifstream::traits_type::eof()) return in.bad() ? std::nullopt : std::optional<std::string>("");
    std::ostringstream text;
    text << in.rdbuf();
    if (!text || in.bad()) return std::nullopt;
    return std::move(text).str();
  };
}

Expected<std::string> render(const Loader& loader, const std::string& name,
                             const std::vector<std::pair<std::string, Value>>& variables, const Limits& limits) {
  return Interpreter(loader, limits).render(name, variables);
}

Expected<std::string> render_file(const std::string& folder, const std::string& file) {
  auto text = render(folder_loader(folder), file);
  if (text) return text;
  Error error = text.error();
  error.file = folder + "/" + error.file;
  return error;
}

}  // namespace cxlab::planner::templates
