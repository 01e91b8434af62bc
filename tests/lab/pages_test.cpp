// The templates of lab/pages with data made by hand.

#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <regex>

#include "cx/template/template.h"

namespace cxlab {
namespace {

using nlohmann::json;

std::string page(const std::string& name, const json& data) {
  const auto made = templates::render_file(std::string(std::getenv("CXLAB_SOURCE_DIR")) + "/lab/pages", name,
                                           {.variables = data.dump(), .html = true});
  return made ? *made : "error " + made.error().text();
}

std::vector<std::string> found(const std::string& page, const std::string& pattern) {
  const std::regex regex(pattern);
  std::vector<std::string> out;
  for (std::sregex_iterator it(page.begin(), page.end(), regex), end; it != end; ++it) out.push_back((*it)[1]);
  return out;
}
using Texts = std::vector<std::string>;

/// A run of 100 s without anything in it.
json empty_run() {
  return {{"result",
           {{"scenario", "s"},
            {"seed", 1},
            {"tier", "none"},
            {"status", "completed"},
            {"reason", nullptr},
            {"sim_time_s", 100},
            {"real_time_factor", 7.6},
            {"rule_errors", json::array()}}},
          {"reason", ""},
          {"kinds", json::array()},
          {"tables", json::array()},
          {"film", ""},
          {"files", {"result.json"}},
          {"pictures", json::array()}};
}

TEST(RunPage, EmptyRunHasItsHeadAndItsFiles) {
  const std::string text = page("run.html", empty_run());
  EXPECT_NE(text.find("completed after 1:40 of simulated time, 8 x real time"), std::string::npos) << text;
  EXPECT_EQ(found(text, "<h2>([^<]*)"), (Texts{"Files of this run"}));
  EXPECT_EQ(text.rfind("<!doctype html>", 0), 0u);
}

TEST(RunPage, WarningsAreShown) {
  json run = empty_run();
  run["result"]["warnings"] = {"nobody asked for <x>"};
  const std::string text = page("run.html", run);
  EXPECT_EQ(found(text, "<h2>([^<]*)"), (Texts{"Warnings", "Files of this run"}));
  EXPECT_NE(text.find("nobody asked for &lt;x&gt;"), std::string::npos) << text;
}

TEST(RunPage, NamesCannotWriteHtml) {
  json run = empty_run();
  run["result"]["scenario"] = "<script>alert(1)</script>";
  run["result"]["reason"] = {{"code", "x"}};
  run["reason"] = "a & \"b\" <c>";
  run["files"] = {"logs/\" onclick=\"x"};
  const std::string text = page("run.html", run);
  EXPECT_EQ(text.find("<script>alert"), std::string::npos);
  EXPECT_EQ(text.find("<c>"), std::string::npos);
  EXPECT_EQ(text.find("\" onclick"), std::string::npos);
}

TEST(RunPage, TablesAreAsTheWorldMakesThem) {
  json run = empty_run();
  const auto cell = [](const std::string& text, bool bold, const std::string& kind) {
    return json{{"text", text}, {"bold", bold}, {"kind", kind}};
  };
  run["tables"] = {
      {{"title", "Orders <1>"},
       {"columns", {"a", "b<"}},
       {"rows", {{cell("CYAN", true, "CYAN"), cell("<5>", true, "")}, {cell("x&", false, ""), cell("", false, "")}}},
       {"note", "and more"}},
      {{"title", ""}, {"columns", {"c"}}, {"rows", json::array()}, {"note", ""}}};
  const std::string text = page("run.html", run);
  EXPECT_EQ(found(text, "<h2>([^<]*)"), (Texts{"Orders &lt;1&gt;", "Files of this run"}));
  EXPECT_NE(text.find("<tr><th>a<th>b&lt;</tr>\n"
                      "<tr><td><b class=\"ink-CYAN\">CYAN</b><td><b>&lt;5&gt;</b></tr>\n"
                      "<tr><td>x&amp;<td></tr>\n</table></div>\n<p>and more</p>"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("<tr><th>c</tr>\n</table></div>"), std::string::npos);
}

TEST(RunPage, WordsHaveTheInkOfTheirKind) {
  json run = empty_run();
  run["kinds"] = {{{"name", "CYAN"}, {"ink", "#0093b8"}}, {{"name", "pick"}, {"ink", ""}}};
  const std::string text = page("run.html", run);
  EXPECT_NE(text.find("\n.ink-CYAN { --ink: #0093b8 }\n"), std::string::npos) << text;
  EXPECT_EQ(text.find("ink-pick"), std::string::npos);
}

json plan_step(const std::string& action, double start, double duration) {
  return {{"action", action},
          {"arguments", {"a", "<b>"}},
          {"start", start},
          {"duration", duration},
          {"latest_end", start + duration + 1}};
}

TEST(PlanPicture, OneBarAStepAndOneArrowAnOrdering) {
  const json plan = {{"makespan_s", 2.5},
                     {"steps", {plan_step("go", 0, 1), plan_step("stay", 1, 1.5)}},
                     {"orderings",
                      {{{"from", "origin"}, {"to", {{"step", 0}, {"at", "start"}}}},
                       {{"from", {{"step", 0}, {"at", "start"}}}, {"to", {{"step", 0}, {"at", "end"}}}},
                       {{"from", {{"step", 0}, {"at", "end"}}}, {"to", {{"step", 1}, {"at", "start"}}}}}}};
  const std::string text = page("plan.svg", plan);
  EXPECT_EQ(text.rfind("<svg ", 0), 0u) << text;
  EXPECT_EQ(found(text, "fill=\"(#[0-9a-f]*)\"><title>"), (Texts{"#4e79a7", "#f28e2b"}));
  EXPECT_EQ(found(text, ">(\\([^<]*)</text>"), (Texts{"(go a &lt;b&gt;)", "(stay a &lt;b&gt;)"}));
  EXPECT_EQ(found(text, "stroke=\"#999\" stroke-width=\"0.7\" (marker-end)").size(),
            2u);  // one of them is the legend's
  EXPECT_EQ(found(text, ">([0-9.]+) s</text>"), (Texts{"0", "0.5", "1", "1.5", "2", "2.5"}));
  EXPECT_EQ(json::parse(found(text, "<metadata>(.*)</metadata>").at(0))["steps"], plan["steps"]);
}

TEST(PlanPicture, EmptyPlanIsAPicture) {
  const std::string text =
      page("plan.svg", {{"makespan_s", 0}, {"steps", json::array()}, {"orderings", json::array()}});
  EXPECT_EQ(text.rfind("<svg ", 0), 0u) << text;
}

TEST(Junit, StoriesAndTheirMessages) {
  const json report = {
      {"stories",
       {{{"file", "a.yaml"}, {"name", "x<&\""}, {"wall_s", 0.1234}, {"word", "failure"}, {"messages", {"m\n1", "m2"}}},
        {{"file", "b.yaml"}, {"name", "y"}, {"wall_s", 1}, {"word", "failure"}, {"messages", json::array()}}}},
      {"failures", 1},
      {"errors", 0},
      {"wall_s", 2}};
  EXPECT_EQ(page("junit.xml", report), R"(<?xml version="1.0" encoding="UTF-8"?>
<testsuite name="cxlab" tests="2" failures="1" errors="0" skipped="0" time="2.000">
  <testcase classname="a.yaml" name="x&lt;&amp;&quot;" time="0.123">
    <failure type="failure" message="m&#10;1">m
1
m2</failure>
  </testcase>
  <testcase classname="b.yaml" name="y" time="1.000">
  </testcase>
</testsuite>)");
}

}  // namespace
}  // namespace cxlab
