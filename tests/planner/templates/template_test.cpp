#include "planner/templates/template.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>

#include "planner/pddl/parser.h"

namespace cxlab::planner::templates {
namespace {

Loader loader_of(std::map<std::string, std::string> templates) {
  return [templates = std::move(templates)](const std::string& name) -> std::optional<std::string> {
    const auto found = templates.find(name);
    return found == templates.end() ? std::nullopt : std::optional(found->second);
  };
}

std::string error_of(const std::string& text, const Limits& limits = {}) {
  const auto made = render(loader_of({{"main", text}}), "main", {}, limits);
  return made ? "no error: " + *made : made.error().text();
}

TEST(Template, SeesTheVariablesThatAreGiven) {
  const auto text = render(loader_of({{"main", "{% include 'part' %}{{ n + 1 }}"}, {"part", "{{ names|join('-') }} "}}),
                           "main", {{"n", Value(1)}, {"names", Value::list({"a", "b"})}});
  ASSERT_TRUE(text) << text.error().text();
  EXPECT_EQ(*text, "a-b 2");
}

TEST(Template, ImportsWithoutContextSeeNoVariables) {
  const auto text = render(
      loader_of(
          {{"main", "{% import 'part' as alone %}{% import 'part' as with with context %}{{ alone.n }} {{ with.n }}"},
           {"part", "{% set n = given|default('none') %}"}}),
      "main", {{"given", Value(7)}});
  ASSERT_TRUE(text) << text.error().text();
  EXPECT_EQ(*text, "none 7");
}

TEST(Template, MacrosTakeTheArgumentsThatTheyHave) {
  EXPECT_EQ(error_of("{% macro m(a) %}{% endmacro %}\n{{ m(1, 2) }}"),
            "main:2: found 2 arguments of the macro 'm', expected at most 1");
  EXPECT_EQ(error_of("{% macro m(a) %}{% endmacro %}\n{{ m(b=1) }}"),
            "main:2: found the argument 'b' of the macro 'm', which it does not have or has already");
  EXPECT_EQ(error_of("{% macro m() %}{% endmacro %}\n{% call m() %}{% endcall %}"),
            "main:2: found {% call %} of the macro 'm', which does not use its caller");
  EXPECT_EQ(error_of("{% macro m() %}\n{{ caller() }}{% endmacro %}{{ m() }}"),
            "main:2: found no caller of the macro 'm', expected {% call %}");
  EXPECT_EQ(error_of("\n{% macro m(caller) %}{{ caller() }}{% endmacro %}"),
            "main:2: found the parameter 'caller' without default, expected one");
}

TEST(Template, NumbersBeyondSixtyFourBitsAreErrors) {
  EXPECT_EQ(error_of("{{ (-9223372036854775807 - 1)|abs }}"), "main:1: the number is too large");
  EXPECT_EQ(error_of("{{ 9223372036854775807|round(-1) }}"), "main:1: the number is too large");
  EXPECT_EQ(error_of("{{ 1e20|int }}"), "main:1: the number is too large");
  EXPECT_EQ(error_of("{{ '%d' % 1e20 }}"), "main:1: found 1e+20, which is too large for a whole number");
  EXPECT_EQ(error_of("{{ [1]|batch(1e20)|list }}"), "main:1: found 1e+20, expected a whole number");
}

TEST(Template, StatementsOutOfTheirPlaceAreErrors) {
  EXPECT_EQ(error_of("\n{% for i in [1] %}{% extends 'base' %}{% endfor %}"),
            "main:2: found 'extends' inside another statement, expected it at the top level (or in an if there)");
  EXPECT_EQ(error_of("{% for i in [1] %}\n{% set loop = 2 %}{% endfor %}"),
            "main:2: found an assignment to 'loop' inside a loop, which has that name already");
  EXPECT_EQ(error_of("{% block a required %}\nx{% endblock %}"),
            "main:1: found contents of the block 'a', which is required: expected only blanks and comments");
  EXPECT_EQ(error_of("\n{% block a required %}{% endblock %}"),
            "main:2: block 'a' is required, expected a template that fills it");
}

TEST(Template, ErrorsTellTheTemplateAndItsLine) {
  const std::string statements =
      "for, if, set, block, extends, include, import, from, macro, call, filter, with, do, raw, else, elif, endfor, "
      "endif, endset, endblock, endmacro, endcall, "
      "endfilter, endwith, endraw";
  EXPECT_EQ(error_of("a\n{% fr x in y %}"),
            "main:2: found 'fr', expected a statement: " + statements + "; did you mean 'for'?");
  EXPECT_EQ(error_of("{% for x in y %}\n{% enfor %}"),
            "main:2: found 'enfor', expected a statement: " + statements + "; did you mean 'endfor'?");
  EXPECT_EQ(error_of("{% endforr %}"),
            "main:1: found 'endforr', expected a statement: " + statements + "; did you mean 'endfor'?");
  EXPECT_EQ(error_of("{% endif %}"), "main:1: found {% endif %}, which ends or continues nothing");
  EXPECT_EQ(error_of("{{ 'x'|uper }}"), "main:1: found 'uper', expected a filter; did you mean 'upper'?");
  EXPECT_EQ(error_of("{{ 1 is od }}"), "main:1: found 'od', expected a test; did you mean 'odd'?");
  EXPECT_EQ(error_of("\n\n{{ a.b }}"), "main:3: 'a' is undefined");
  EXPECT_EQ(error_of("{% if x %}\n{{ 1 }}"), "main:1: found the end of the template, expected {% endif %}");
  EXPECT_EQ(error_of("{% include 'no' %}"), "main:1: found no template 'no' to include");
  EXPECT_EQ(error_of("{{ 1\n+ 'a' }}"), "main:2: unsupported operand types for +: 'int' and 'str'");
  const auto made = render(loader_of({{"main", "{% extends 'base' %}{% block a %}\n{{ 1 / 0 }}{% endblock %}"},
                                      {"base", "\n\n\n{% block a %}{% endblock %}"}}),
                           "main");
  EXPECT_EQ(made.error().text(), "main:2: division by zero");
}

TEST(Template, WhatIsLeftOutIsNamed) {
  for (const char* text : {"{{ 'a'|urlize }}", "{% break %}", "{% trans %}{% endtrans %}"}) {
    const auto made = render(loader_of({{"main", text}}), "main");
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().code, "unsupported") << made.error().text();
  }
}

TEST(Template, RunawayTemplatesAreStopped) {
  EXPECT_EQ(error_of("{% macro m() %}{{ m() }}{% endmacro %}{{ m() }}"),
            "main:1: templates, macros and expressions are nested more than 1000 deep");
  EXPECT_EQ(error_of("{% include 'main' %}"),
            "main:1: templates, macros and expressions are nested more than 1000 deep");
  EXPECT_EQ(error_of("{% extends 'main' %}"), "main:1: found more than 100 templates that extend each other");
  EXPECT_EQ(error_of("{{ 'x' * 100000000 }}"), "main:1: the template makes more than 67108864 bytes of text");
  EXPECT_EQ(error_of("{% for i in range(9000) %}{% for j in range(9000) %}{% endfor %}{% endfor %}", {1000, 100000}),
            "main:1: the template takes more than 100000 steps");
  EXPECT_EQ(error_of(std::string(1000, '(')), "no error: " + std::string(1000, '('));
  EXPECT_EQ(error_of("{{ " + std::string(1000, '[') + " }}"), "main:1: found '}', expected ']'");
  EXPECT_EQ(error_of("{{ " + std::string(1000, '[') + std::string(1000, ']') + " }}"),
            "main:1: expressions are nested more than 100 deep");
  EXPECT_EQ(error_of("{% set a = [] %}{% do a.append([a]) %}"), "main:1: a list or dict cannot hold itself");
}

TEST(Template, ExampleOfTheDocsMakesADomain) {
  const auto text =
      render_file(std::string(std::getenv("CXLAB_SOURCE_DIR")) + "/docs/examples/planning", "stations.pddl");
  ASSERT_TRUE(text) << text.error().text();
  const auto domain = parse_domain(*text, "stations.pddl");
  ASSERT_TRUE(domain) << domain.error().text() << *text;
  EXPECT_EQ(domain->actions.size(), 2u);
  EXPECT_EQ(domain->actions[1].duration.at(0).bound.value, 10);
}

TEST(Template, FilesAreFoundBelowTheFolderOnly) {
  const auto folder = std::filesystem::temp_directory_path() /
                      ("cxlab-templates-" + std::to_string(::testing::UnitTest::GetInstance()->random_seed()) + "-" +
                       std::to_string(getpid()));
  std::filesystem::create_directories(folder / "parts");
  std::ofstream(folder / "domain.pddl") << "(define {% include 'parts/name' %})\n";
  std::ofstream(folder / "parts/name") << "(domain {{ 'd' }})\n";
  std::ofstream(folder / "empty").close();
  std::ofstream(folder / "bad") << "\n{% include '../secret' %}";
  EXPECT_EQ(*render_file(folder, "domain.pddl"), "(define (domain d))");
  EXPECT_EQ(*render_file(folder, "empty"), "");
  EXPECT_EQ(render_file(folder, "bad").error().text(),
            folder.string() + "/bad:2: found no template '../secret' to include");
  EXPECT_EQ(render_file(folder, "none").error().text(), folder.string() + "/none: found no template 'none'");
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace cxlab::planner::templates
