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
          {"page", {{"kinds", json::array()}, {"shades", json::array()}, {"parts", json::array()}}},
          {"decisions", json::array()},
          {"film", ""},
          {"files", {"result.json"}},
          {"pictures", json::array()}};
}

json chart(const std::vector<std::pair<double, int>>& steps) {
  json run = empty_run();
  run["page"]["kinds"] = {{{"name", "CYAN"}, {"fill", ""}, {"ink", "#0093b8"}}};
  run["page"]["parts"] = {{{"title", "Points over time"}, {"lines", {{{"kind", "CYAN"}, {"steps", json::array()}}}}}};
  for (const auto& [t, value] : steps) run["page"]["parts"][0]["lines"][0]["steps"].push_back({t, value});
  return run;
}

json lane(const json& bars) {
  json run = empty_run();
  run["page"]["parts"] = {{{"title", "What they did"},
                           {"key", {{{"kind", "pick"}, {"text", "picks"}}, {{"kind", ""}, {"text", "a fault"}}}},
                           {"lanes", {{{"name", "r1"}, {"bars", bars}, {"marks", json::array()}}}}}};
  return run;
}

json bar(const std::string& shape, const std::string& kind, double begin, double end, const std::string& text,
         const std::string& remark = "") {
  return {{"shape", shape}, {"kind", kind}, {"begin", begin}, {"end", end}, {"text", text}, {"remark", remark}};
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

TEST(RunPage, DecisionsAreATable) {
  json run = empty_run();
  for (int i = 0; i < 1001; ++i)
    run["decisions"].push_back({{"t", 60 + i}, {"by", "agent"}, {"slots", {"begin <a>", "its conditions hold"}}});
  const std::string text = page("run.html", run);
  EXPECT_EQ(found(text, "<h2>([^<]*)"), (Texts{"Decisions", "Files of this run"}));
  EXPECT_NE(text.find("<tr><td>1:00<td>agent<td>begin &lt;a&gt;<td>its conditions hold</tr>"), std::string::npos);
  EXPECT_NE(text.find("and 1 more, in journal.jsonl"), std::string::npos);
}

TEST(RunPage, NamesCannotWriteHtml) {
  json run = empty_run();
  run["result"]["scenario"] = "<script>alert(1)</script>";
  run["result"]["reason"] = {{"code", "x"}};
  run["reason"] = "a & \"b\" <c>";
  run["files"] = {"logs/\" onclick=\"x"};
  const std::string text = page("run.html", run);
  EXPECT_EQ(text.find("<script"), std::string::npos);
  EXPECT_EQ(text.find("<c>"), std::string::npos);
  EXPECT_EQ(text.find("\" onclick"), std::string::npos);
}

TEST(RunPage, TablesAreAsTheWorldMakesThem) {
  json run = empty_run();
  const auto cell = [](const std::string& text, bool bold, const std::string& kind) {
    return json{{"text", text}, {"bold", bold}, {"kind", kind}};
  };
  run["page"]["parts"] = {
      {{"title", "Orders <1>"},
       {"columns", {"a", "b<"}},
       {"rows", {{cell("CYAN", true, "CYAN"), cell("<5>", true, "")}, {cell("x&", false, ""), cell("", false, "")}}},
       {"note", "and more"}},
      {{"title", ""}, {"columns", {"c"}}, {"rows", json::array()}, {"note", ""}}};
  const std::string text = page("run.html", run);
  EXPECT_EQ(found(text, "<h2>([^<]*)"), (Texts{"Orders &lt;1&gt;", "Files of this run"}));
  EXPECT_NE(text.find("<tr><th>a<th>b&lt;</tr>\n"
                      "<tr><td><b class=\"CYAN\">CYAN</b><td><b>&lt;5&gt;</b></tr>\n"
                      "<tr><td>x&amp;<td></tr>\n</table>\n<p>and more</p>"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("<tr><th>c</tr>\n</table>"), std::string::npos);
}

TEST(RunPage, KindsHaveTheirColours) {
  json run = empty_run();
  run["page"]["kinds"] = {{{"name", "CYAN"}, {"fill", ""}, {"ink", "#0093b8"}},
                          {{"name", "pick"}, {"fill", "#f2b134"}, {"ink", ""}},
                          {{"name", "holds"}, {"fill", "#7a5c99"}, {"ink", "#fff"}}};
  const std::string text = page("run.html", run);
  for (const char* rule :
       {".line.CYAN { stroke: #0093b8 }", "b.CYAN { color: #0093b8 }", ".pick { fill: #f2b134; background: #f2b134 }",
        ".holds { fill: #7a5c99; background: #7a5c99; color: #fff }"})
    EXPECT_NE(text.find(std::string("\n") + rule + '\n'), std::string::npos) << rule << text;
}

TEST(RunPage, LabelsOfTheAxisAreWholeNumbers) {
  EXPECT_EQ(found(page("run.html", chart({{10, 3}})), "text-anchor=\"end\">([0-9]+)<"),
            (Texts{"0", "2", "4", "6", "8", "10"}));
  EXPECT_EQ(found(page("run.html", chart({{10, 237}})), "text-anchor=\"end\">([0-9]+)<"),
            (Texts{"0", "50", "100", "150", "200"}));
  json fractions = chart({{10, 3}});
  fractions["page"]["parts"][0]["lines"][0]["steps"] = {{10, 12.5}, {20, -0.25}};
  EXPECT_EQ(found(page("run.html", fractions), "text-anchor=\"end\">(-?[0-9.]+)<"), (Texts{"0", "5", "10"}));
}

TEST(RunPage, ValuesBelowZeroStayInsideOfThePicture) {
  const std::string text = page("run.html", chart({{10, -20}, {50, -5}}));
  EXPECT_EQ(found(text, "text-anchor=\"end\">(-?[0-9]+)<"), (Texts{"-20", "-10", "0", "10"}));
  EXPECT_EQ(found(text, "(M90 [^\"]*)"), (Texts{"M90 66.67H180.0V180.0H540.0V95.0H990"}));
}

TEST(RunPage, ShadesLieBehindChartsAndLanes) {
  json run = lane(json::array({bar("bar", "pick", 0, 30, "pick a")}));
  run["page"]["parts"].push_back(chart({{10, 3}})["page"]["parts"][0]);
  run["page"]["shades"] = {{{"kind", "pause"}, {"begin", 40}, {"end", 60}, {"text", "paused"}},
                           {{"kind", "pause"}, {"begin", 80}, {"end", 100}, {"text", "paused"}}};
  const std::string text = page("run.html", run);
  EXPECT_EQ(found(text, "<rect class=\"pause\" x=\"([0-9.]+)\" y=\"0\" width=\"180.0\""),
            (Texts{"450.0", "810.0", "450.0", "810.0"}));
  EXPECT_EQ(found(text, "<title>paused, ([^<]*)"), (Texts{"40 to 60 s", "80 to 100 s", "40 to 60 s", "80 to 100 s"}));
}

TEST(RunPage, BarsLieInTheirLaneByTheirShape) {
  json run =
      lane({bar("strip", "holds", 8, 58, "holds a piece"), bar("bar", "place", 10.02, 20, "place t", ", still at work"),
            bar("alert", "failed", 10, 10.02, "pick t", ", failed"), bar("inset", "away", 30, 30, "away")});
  run["page"]["parts"][0]["lanes"][0]["marks"] = {{{"kind", "fault"}, {"t", 50}, {"text", "breaks"}}};
  const std::string text = page("run.html", run);
  EXPECT_EQ(found(text, "<rect (class=\"[^ ]*\" x=[^ ]* y=[^ ]* width=[^ ]* height=[^ >]*)"),
            (Texts{"class=\"holds\" x=\"162.0\" y=\"29\" width=\"450.0\" height=\"5\"",
                   "class=\"place\" x=\"180.18\" y=\"4\" width=\"89.82\" height=\"24\"",
                   "class=\"failed\" x=\"180.0\" y=\"4\" width=\"4\" height=\"24\"",
                   "class=\"away\" x=\"360.0\" y=\"8\" width=\"1\" height=\"16\""}));
  EXPECT_EQ(found(text, "<title>((?:holds|place|pick|away|breaks)[^<]*)</title>"),
            (Texts{"holds a piece, 8 to 58 s", "place t, 10.02 to 20 s, still at work", "pick t, 10 to 10.02 s, failed",
                   "away, 30 to 30 s", "breaks, 50 s"}));
  EXPECT_EQ(found(text, "<path class=\"fault\" d=\"([^\"]*)"), (Texts{"M540.0 8l-4 -7h8z"}));
  EXPECT_EQ(found(text, "<span class=\"pick\">([^<]*)"), (Texts{"picks"}));
  EXPECT_NE(text.find("&#9660; a fault"), std::string::npos);
}

TEST(RunPage, TimeAxisEndsInsideOfThePicture) {
  for (const auto& [seconds, last] :
       std::map<double, std::string>{{0.5, "0:01"}, {5, "0:05"}, {55, "0:55"}, {1200, "20:00"}, {100000, "1666:40"}}) {
    json run = chart({{0.1, 1}});
    run["result"]["sim_time_s"] = seconds;
    const auto labels = found(page("run.html", run), ">([0-9]+:[0-9]+)<");
    EXPECT_EQ(labels.front(), "0:00");
    EXPECT_LE(labels.size(), 13u);
    EXPECT_EQ(labels.back(), last);
  }
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
