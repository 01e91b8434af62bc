#include "cx/template/template.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <map>

namespace cxlab::templates {
namespace {

using Templates = std::map<std::string, std::string>;

Expected<std::string> rendered(const Templates& templates, const Options& options = {}) {
  const Loader loader = [&](const std::string& name) -> std::optional<std::string> {
    const auto found = templates.find(name);
    return found == templates.end() ? std::nullopt : std::optional(found->second);
  };
  return render(loader, "main", options);
}

/// The text, or the error.
std::string outcome(const Templates& templates, const Options& options = {}) {
  const auto made = rendered(templates, options);
  return made ? *made : "error " + made.error().text();
}
std::string outcome(const std::string& main, const Options& options = {}) {
  return outcome(Templates{{"main", main}}, options);
}
std::string with(const std::string& variables, const std::string& main) {
  return outcome(main, {.variables = variables});
}

TEST(Template, VariablesHaveTheTypesOfTheirJson) {
  EXPECT_EQ(with(R"({"a": null, "b": true, "c": -7, "d": 2.5, "e": "x", "f": [1, "y"], "g": {"k": [], "h": 0.1}})",
                 "{{ a }} {{ b }} {{ c }} {{ d }} {{ e }} {{ f }} {{ g }}"),
            "None True -7 2.5 x [1, 'y'] {'k': [], 'h': 0.1}");
  EXPECT_EQ(with(R"({"v": {}})", "{{ v is mapping }} {{ v.x is defined }}"), "True False");
  EXPECT_EQ(with(R"({"v": 1e3, "w": 1E-2})", "{{ v }} {{ w }} {{ v is float }}"), "1000.0 0.01 True");
}

TEST(Template, VariablesMayBeAnyWholeNumberAndAnyText) {
  EXPECT_EQ(with(R"({"v": [9223372036854775807, -9223372036854775808, 18446744073709551615]})", "{{ v }}"),
            "[9223372036854775807, -9223372036854775808, 18446744073709551615]");
  EXPECT_EQ(with(R"({"v": "\"\\\/\b\f\n\r\t\u0001\u00e4\ud83d\ude00{{ 1 }}"})", "{{ v }}"),
            "\"\\/\b\f\n\r\t\x01ä😀{{ 1 }}");
  EXPECT_EQ(with(R"({"": 1, "a b": 2, "loop": 3})", "{{ loop }}"), "3");
}

TEST(Template, VariablesThatAreNoJsonAreErrors) {
  EXPECT_EQ(with("{", "x"), "error main: the variables cannot be read: unexpected end of input, expected expression");
  EXPECT_EQ(with("\xff", "x").find("error main: the variables cannot be read"), 0u);
  EXPECT_EQ(with("{\"v\": " + std::string(1000, '[') + std::string(1000, ']') + "}", "x"),
            "error main: the variables cannot be read: template exceeds maximum recursion limits");
}

TEST(Template, NumbersAreThoseOfPythonWithinTheirBounds) {
  EXPECT_EQ(outcome("{{ 7 // 2 }} {{ -7 // 2 }} {{ -7 % 3 }} {{ 7 / 2 }} {{ 4 / 2 }} {{ 2 ** 10 }} {{ 0.1 + 0.2 }}"),
            "3 -4 2 3.5 2.0 1024 0.30000000000000004");
  EXPECT_EQ(outcome("{{ 9223372036854775807 + 1 }} {{ 2 ** 126 }}"),
            "9223372036854775808 85070591730234615865843651857942052864");
  EXPECT_EQ(outcome("\n{{ 2 ** 127 }}"), "error main:2: unable to calculate 2 ** 127");
  EXPECT_EQ(outcome("{{ 1 / 0 }}"), "error main:1: unable to calculate 1 / 0");
  EXPECT_EQ(outcome("{{ 1 // 0 }}"), "error main:1: unable to calculate 1 // 0");
}

TEST(Template, UndefinedNamesAreEmptyUntilTheyAreUsed) {
  EXPECT_EQ(outcome("[{{ a }}{% for i in a %}x{% endfor %}{% if a %}x{% endif %}{{ a | default('d') }}]"), "[d]");
  EXPECT_EQ(outcome("\n\n{{ a.b }}"), "error main:3: `a` is undefined");
  EXPECT_EQ(outcome("{{ a + 1 }}"),
            "error main:1: tried to use + operator on unsupported types undefined and number (`a` is undefined)");
}

TEST(Template, HtmlIsEscapedAndKnowsAllItsNames) {
  const Options html{.variables = R"({"t": "<a href='x'>&\"</a>"})", .html = true};
  EXPECT_EQ(outcome("{{ t }}{{ '<b>' | safe }}", html), "&lt;a href=&#x27;x&#x27;&gt;&amp;&quot;&lt;&#x2f;a&gt;<b>");
  EXPECT_EQ(outcome("{{ t | tojson }}", html), R"("\u003ca href=\u0027x\u0027\u003e\u0026\"\u003c/a\u003e")");
  EXPECT_EQ(outcome("\n{{ tt }}", html), "error main:2: `tt` is undefined");
  EXPECT_EQ(outcome(Templates{{"main", "{% include 'part.txt' %}"}, {"part.txt", "{{ '<' }}"}}, html), "&lt;");
  EXPECT_EQ(outcome(Templates{{"main", "{% include 'part.html' %}"}, {"part.html", "{{ '<' }}"}}), "<");
}

TEST(Template, ErrorsNameTheTemplateAndItsLine) {
  EXPECT_EQ(outcome("a\n{% fr x in y %}"), "error main:2: unknown statement fr");
  EXPECT_EQ(outcome("{% if x %}\n{{ 1 }}"), "error main:2: unexpected end of input, expected end of block");
  EXPECT_EQ(outcome("{{ 'x'|uper }}"), "error main:1: filter uper is unknown");
  EXPECT_EQ(outcome("{{ 1 is od }}"), "error main:1: test od is unknown");
  EXPECT_EQ(outcome("{{ f() }}"), "error main:1: f is unknown");
  EXPECT_EQ(outcome("{{ 'x'.f() }}"), "error main:1: string has no method named f");
  EXPECT_EQ(outcome("{{ 1\n+ 'a' }}"), "error main:2: tried to use + operator on unsupported types number and string");
}

TEST(Template, ErrorsNameTheInnermostTemplate) {
  const std::string wrong = "\n{{ 1 / 0 }}";
  const std::string error = "error part:2: unable to calculate 1 / 0";
  EXPECT_EQ(outcome({{"main", "{% include 'part' %}"}, {"part", wrong}}), error);
  EXPECT_EQ(outcome({{"main", "{% import 'part' as p %}"}, {"part", wrong}}), error);
  EXPECT_EQ(outcome({{"main", "{% from 'part' import m %}{{ m() }}"},
                     {"part", "{% macro m() %}" + wrong + "{% endmacro %}"}}),
            error);
  EXPECT_EQ(outcome({{"main", "{% extends 'part' %}"}, {"part", wrong}}), error);
  EXPECT_EQ(outcome({{"main", "{% extends 'base' %}{% block a %}\n{{ 1 / 0 }}{% endblock %}"},
                     {"base", "\n\n\n{% block a %}{% endblock %}"}}),
            "error main:2: unable to calculate 1 / 0");
  EXPECT_EQ(outcome({{"main", "{% include 'part' %}"}, {"part", "\n\n{% endif %}"}}),
            "error part:3: unknown statement endif");
}

TEST(Template, MissingTemplatesAreErrorsWhereTheyAreNamed) {
  EXPECT_EQ(outcome(Templates{}), "error main: template \"main\" does not exist");
  EXPECT_EQ(outcome("\n{% include 'no' %}"), "error main:2: tried to include non-existing template 'no'");
  EXPECT_EQ(outcome("\n{% extends 'no' %}"), "error main:2: template \"no\" does not exist");
  EXPECT_EQ(outcome("\n{% import 'no' as n %}"), "error main:2: tried to include non-existing template 'no'");
  EXPECT_EQ(outcome("[{% include 'no' ignore missing %}]"), "[]");
}

TEST(Template, BytesThatAreNotUtf8AreErrors) {
  EXPECT_EQ(outcome("a\nb\n\xe4"), "error main:3: found bytes that are not UTF-8");
  EXPECT_EQ(outcome({{"main", "{% include 'part' %}"}, {"part", "\n\xff"}}),
            "error part:2: found bytes that are not UTF-8");
  EXPECT_EQ(outcome(std::string("ä\0ö", 5)), std::string("ä\0ö", 5));
}

TEST(Template, RecursionEndsWithAnError) {
  EXPECT_EQ(outcome("{% macro m() %}{{ m() }}{% endmacro %}{{ m() }}"), "error main:1: recursion limit exceeded");
  EXPECT_EQ(outcome("\n{% include 'main' %}"), "error main:2: recursion limit exceeded");
  EXPECT_EQ(outcome("{% extends 'main' %}"),
            "error main:1: cycle in template inheritance. \"main\" was referenced more than once");
  for (const auto& [open, close] : std::map<std::string, std::string>{{"[", "]"}, {"(", ")"}, {"{1:", "}"}})
    for (const int depth : {1000, 100000}) {
      std::string nested = "{{ ";
      for (int i = 0; i < depth; ++i) nested += open;
      nested += "1";
      for (int i = 0; i < depth; ++i) nested += close;
      EXPECT_EQ(outcome(nested + " }}"), "error main:1: template exceeds maximum recursion limits") << open;
    }
  EXPECT_EQ(outcome("{{ " + std::string(100000, '-') + "1 }}"), "1");
}

TEST(Template, WorkIsBounded) {
  const Options few{.limits = {.steps = 1000}};
  const std::string loops = "{% for i in range(9000) %}{% for j in range(9000) %}\n{% endfor %}{% endfor %}";
  EXPECT_EQ(outcome(loops, few), "error main:1: the template takes more than 1000 steps");
  EXPECT_EQ(outcome(Templates{{"main", "{% include 'part' %}"}, {"part", "\n" + loops}}, few),
            "error part:2: the template takes more than 1000 steps");
  EXPECT_EQ(outcome("{{ range(1000000) }}"), "error main:1: range has too many elements");
}

TEST(Template, TextIsBounded) {
  const Options little{.limits = {.output = 1000}};
  EXPECT_EQ(outcome("{{ 'x' * 1000 }}", little), std::string(1000, 'x'));
  EXPECT_EQ(outcome("{{ 'x' * 1001 }}", little), "error main: the template makes more than 1000 bytes of text");
  EXPECT_EQ(outcome("{% for i in range(2000) %}x{% endfor %}", little),
            "error main: the template makes more than 1000 bytes of text");
}

TEST(Template, MemoryIsBounded) {
  const Options little{.limits = {.memory = 1 << 20}};
  const std::string error = "error main: the template needs more than 1048576 bytes of memory";
  EXPECT_EQ(
      outcome("{% set n = namespace(x='aaaaaaaa') %}{% for a in range(99) %}{% set n.x = n.x ~ n.x %}{% endfor %}",
              little),
      error);
  EXPECT_EQ(
      outcome(
          "{% set n = namespace(x=[1]) %}{% for a in range(99) %}{% set n.x = n.x + n.x %}{% endfor %}{{ n.x|sum }}",
          little),
      error);
  EXPECT_EQ(outcome("{{ 'a'|replace('a','b'*99999)|replace('b','c'*99999) }}", little), error);
  EXPECT_EQ(outcome("{{ '%1000000000000d'|format(3) }}", little), error);
  EXPECT_EQ(outcome("{{ 1 }}", little), "1");  // another template can be rendered after that
}

TEST(Template, NestedValuesDoNotFillTheStack) {
  const std::string deep =
      "{% set n = namespace(x=[]) %}{% for i in range(20000) %}{% set n.x = [n.x] %}{% endfor %}{{ n.x|string|length "
      "}}";
  EXPECT_EQ(outcome(deep), "40002");
  EXPECT_EQ(outcome("{% set n = namespace(x=[]) %}{% set n.x = [n] %}{{ n.x|string }}"),
            "error main: a value is nested too deep");
}

TEST(Template, ProgrammingErrorsOfTheRendererAreErrors) {
  EXPECT_EQ(outcome("{{ '%.1000000000f'|format(3) }}"),
            "error main: minijinja failed: Formatting argument out of range");
}

TEST(Template, ClockAndChanceAreNotThere) {
  EXPECT_EQ(outcome("{{ now() }}"), "error main:1: now is unknown");
  EXPECT_EQ(outcome("{{ [1]|random }}"), "error main:1: filter random is unknown");
  EXPECT_EQ(outcome("{{ debug() }}"), "error main:1: debug is unknown");
}

TEST(Template, ManyTemplatesAndLongTextsAreRendered) {
  Templates templates{{"main", "{% for i in range(2000) %}{% include 'part' ~ i %}{% endfor %}"}};
  for (int i = 0; i < 2000; ++i) templates["part" + std::to_string(i)] = std::string(1000, 'x');
  EXPECT_EQ(outcome(templates).size(), 2000u * 1000);
}

TEST(Template, FilesAreFoundBelowTheFolderOnly) {
  const auto folder = std::filesystem::temp_directory_path() / ("cxlab-templates-" + std::to_string(getpid()));
  std::filesystem::create_directories(folder / "parts");
  std::ofstream(folder / "domain.pddl") << "(define {% include 'parts/name' %})\n";
  std::ofstream(folder / "parts/name") << "(domain {{ 'd' }})\n";
  std::ofstream(folder / "empty").close();
  std::ofstream(folder / "bad") << "\n{% include '../secret' %}";
  std::ofstream(folder / "worse") << "{% include '/etc/passwd' %}{% include 'parts/../../secret' %}";
  EXPECT_EQ(*render_file(folder, "domain.pddl"), "(define (domain d))");
  EXPECT_EQ(*render_file(folder, "empty"), "");
  EXPECT_EQ(render_file(folder, "bad").error().text(),
            folder.string() + "/bad:2: tried to include non-existing template '../secret'");
  EXPECT_EQ(render_file(folder, "worse").error().text(),
            folder.string() + "/worse:1: tried to include non-existing template '/etc/passwd'");
  EXPECT_EQ(render_file(folder, "parts").error().text(), folder.string() + "/parts: template \"parts\" does not exist");
  EXPECT_EQ(render_file(folder, "none").error().text(), folder.string() + "/none: template \"none\" does not exist");
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace cxlab::templates
