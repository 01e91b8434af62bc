// Renders all templates of cases.json and compares with what Jinja makes of them (oracle.json, made by oracle.py).

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "planner/templates/template.h"

namespace cxlab::planner::templates {
namespace {

TEST(TemplateOracle, SameTextAsJinja) {
  std::ifstream in(std::string(std::getenv("CXLAB_SOURCE_DIR")) + "/tests/planner/templates/oracle.json");
  const auto table = nlohmann::json::parse(in);
  ASSERT_GT(table.size(), 500u);
  for (const auto& entry : table) {
    const auto templates = entry["templates"].get<std::map<std::string, std::string>>();
    const Loader loader = [&](const std::string& name) -> std::optional<std::string> {
      const auto found = templates.find(name);
      return found == templates.end() ? std::nullopt : std::optional(found->second);
    };
    const auto text = render(loader, "main");
    if (entry["output"].is_null()) {
      EXPECT_FALSE(text) << "Jinja fails; here\n" << *text << "\nis made of " << entry["templates"];
    } else if (!text) {
      ADD_FAILURE() << text.error().text() << "\nfor " << entry["templates"];
    } else {
      EXPECT_EQ(*text, entry["output"].get<std::string>()) << entry["templates"];
    }
  }
}

}  // namespace
}  // namespace cxlab::planner::templates
