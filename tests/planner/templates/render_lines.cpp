// Renders templates for random_templates.py: one JSON object of templates a line in, {"out": TEXT} or {"err": MESSAGE}
// out.

#include <iostream>
#include <map>
#include <nlohmann/json.hpp>

#include "planner/templates/template.h"

int main() {
  using cxlab::planner::templates::Loader;
  std::string line;
  while (std::getline(std::cin, line)) {
    const auto templates = nlohmann::json::parse(line).get<std::map<std::string, std::string>>();
    const Loader loader = [&](const std::string& name) -> std::optional<std::string> {
      const auto found = templates.find(name);
      return found == templates.end() ? std::nullopt : std::optional(found->second);
    };
    const auto text = cxlab::planner::templates::render(loader, "main");
    const nlohmann::json answer = text ? nlohmann::json{{"out", *text}} : nlohmann::json{{"err", text.error().text()}};
    std::cout << answer.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace) << "\n";
  }
}
