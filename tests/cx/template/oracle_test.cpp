// Renders all templates of cases.json and compares with what Jinja makes of them (oracle.json, made by oracle.py), but
// for the differences that are explained in differences.json and in docs/reference/pddl-templates.md.

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "cx/template/template.h"

namespace cxlab::templates {
namespace {

using Templates = std::map<std::string, std::string>;

std::string read(const std::string& file) {
  std::ifstream in(std::getenv("CXLAB_SOURCE_DIR") + ("/" + file));
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// The rendered text; none if rendering fails.
std::optional<std::string> text_of(const Templates& templates) {
  const Loader loader = [&](const std::string& name) -> std::optional<std::string> {
    const auto found = templates.find(name);
    return found == templates.end() ? std::nullopt : std::optional(found->second);
  };
  auto text = render(loader, "main");
  return text ? std::optional(*std::move(text)) : std::nullopt;
}

std::optional<std::string> expected(const nlohmann::json& output) {
  return output.is_null() ? std::nullopt : std::optional(output.get<std::string>());
}

TEST(TemplateOracle, SameTextAsJinjaExceptForTheExplainedDifferences) {
  std::map<Templates, std::optional<std::string>> different;
  for (const auto& group : nlohmann::json::parse(read("tests/cx/template/differences.json")))
    for (const auto& entry : group["cases"]) different[entry["templates"]] = expected(entry["output"]);

  const auto table = nlohmann::json::parse(read("tests/cx/template/oracle.json"));
  ASSERT_GT(table.size(), 700u);
  for (const auto& entry : table) {
    const auto templates = entry["templates"].get<Templates>();
    const auto jinja = expected(entry["output"]);
    const auto known = different.find(templates);
    if (known == different.end()) {
      EXPECT_EQ(text_of(templates), jinja) << entry["templates"];
      continue;
    }
    EXPECT_EQ(text_of(templates), known->second) << entry["templates"];
    EXPECT_NE(known->second, jinja) << "no difference: " << entry["templates"];
    different.erase(known);
  }
  EXPECT_TRUE(different.empty()) << "cases.json has no template " << nlohmann::json(different.begin()->first);
}

TEST(TemplateOracle, DocumentationExplainsTheDifferences) {
  const std::string docs =
      std::regex_replace(read("docs/reference/pddl-templates.md"), std::regex("\n  "), " ");  // lines are wrapped
  for (const auto& group : nlohmann::json::parse(read("tests/cx/template/differences.json")))
    EXPECT_NE(docs.find("\n- " + group["why"].get<std::string>() + "\n"), std::string::npos) << group["why"];
}

}  // namespace
}  // namespace cxlab::templates
