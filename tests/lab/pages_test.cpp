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
            {"teams", json::object()},
            {"orders", json::array()},
            {"robots", json::array()},
            {"rule_errors", json::array()}}},
          {"reason", ""},
          {"skills", json::array()},
          {"holds", json::array()},
          {"off_field", json::array()},
          {"faults", json::array()},
          {"pauses", json::array()},
          {"decisions", json::array()},
          {"film", ""},
          {"scores", json::array()},
          {"files", {"result.json"}},
          {"pictures", json::array()}};
}

json scores(const std::vector<std::pair<double, int>>& all) {
  json run = empty_run();
  run["result"]["teams"] = {{"CYAN", {{"points", 0}, {"by_kind", {{"delivery", 0}}}}}};
  for (const auto& [t, points] : all)
    run["scores"].push_back({{"team", "CYAN"}, {"kind", "delivery"}, {"t", t}, {"points", points}});
  return run;
}

json skills(const json& all) {
  json run = empty_run();
  run["result"]["robots"] = {
      {{"name", "r1"}, {"busy_s", 1}, {"drive_s", 1}, {"skills", 1}, {"failures", 0}, {"contacts", 0}}};
  run["skills"] = all;
  return run;
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

TEST(RunPage, LabelsOfTheAxisAreWholePoints) {
  EXPECT_EQ(found(page("run.html", scores({{10, 3}})), "text-anchor=\"end\">([0-9]+)<"),
            (Texts{"0", "2", "4", "6", "8", "10"}));
  EXPECT_EQ(found(page("run.html", scores({{10, 237}})), "text-anchor=\"end\">([0-9]+)<"),
            (Texts{"0", "50", "100", "150", "200"}));
}

TEST(RunPage, PointsBelowZeroStayInsideOfThePicture) {
  const std::string text = page("run.html", scores({{10, -20}, {50, 15}}));
  EXPECT_EQ(found(text, "text-anchor=\"end\">(-?[0-9]+)<"), (Texts{"-20", "-10", "0", "10"}));
  EXPECT_EQ(found(text, "(M90 [^\"]*)"), (Texts{"M90 66.67H180.0V180.0H540.0V95.0H990"}));
}

TEST(RunPage, LateDeliveryDrawsNoSpike) {
  EXPECT_EQ(found(page("run.html", scores({{50, 30}, {50, -20}})), "(M90 [^\"]*)"),
            (Texts{"M90 180.0H540.0V10.0H990"}));
}

TEST(RunPage, PausesAreGreyAndTakeNothingFromTheSharesOfRobots) {
  json run = skills(
      {{{"robot", "r1"}, {"skill", "pick"}, {"target", "a"}, {"begin", 0}, {"end", 30}, {"state", "succeeded"}}});
  run["result"]["robots"][0]["busy_s"] = 30;
  run["result"]["robots"][0]["drive_s"] = 15;
  run["pauses"] = {{{"begin", 40}, {"end", 60}}, {{"begin", 80}, {"end", 100}}};
  const std::string text = page("run.html", run);
  EXPECT_EQ(found(text, "<rect class=\"pause\" x=\"([0-9.]+)\" y=\"0\" width=\"180.0\""), (Texts{"450.0", "810.0"}));
  EXPECT_EQ(found(text, "<title>paused, ([^<]*)"), (Texts{"40 to 60 s", "80 to 100 s"}));
  EXPECT_EQ(found(text, "<td>([0-9]+ %)"), (Texts{"50 %", "25 %"}));
  EXPECT_EQ(found(text, "<span class=\"pause\">([^<]*)"), (Texts{"the game is paused"}));
}

TEST(RunPage, ShortFailureIsSeenAndLiesOnTop) {
  const std::string text = page(
      "run.html",
      skills({{{"robot", "r1"}, {"skill", "pick"}, {"target", "t"}, {"begin", 10}, {"end", 10.02}, {"state", "failed"}},
              {{"robot", "r1"},
               {"skill", "place"},
               {"target", "t"},
               {"begin", 10.02},
               {"end", 20},
               {"state", "running"}}}));
  EXPECT_EQ(found(text, "<rect (class=\"[^ ]*\" x=[^ ]* y=[^ ]* width=[^ ]*)"),
            (Texts{"class=\"place\" x=\"180.18\" y=\"4\" width=\"89.82\"",
                   "class=\"failed\" x=\"180.0\" y=\"4\" width=\"4\""}));
  EXPECT_EQ(found(text, "<title>(pick.*|place.*)</title>"),
            (Texts{"place t, 10.02 to 20 s, still at work", "pick t, 10 to 10.02 s, failed"}));
}

TEST(RunPage, PieceInTheGripperIsSeenWhileTheRobotWaits) {
  json run = skills(
      {{{"robot", "r1"}, {"skill", "pick"}, {"target", "t"}, {"begin", 0}, {"end", 10}, {"state", "succeeded"}}});
  run["holds"] = {{{"robot", "r1"}, {"begin", 8}, {"end", 58}}, {{"robot", "other"}, {"begin", 8}, {"end", 58}}};
  EXPECT_EQ(found(page("run.html", run), "<rect class=\"holds\" x=\"([^\"]*\" y=\"29\" width=\"[^\"]*)"),
            (Texts{"162.0\" y=\"29\" width=\"450.0"}));
}

TEST(RunPage, TimeAxisEndsInsideOfThePicture) {
  for (const auto& [seconds, last] :
       std::map<double, std::string>{{0.5, "0:01"}, {5, "0:05"}, {55, "0:55"}, {1200, "20:00"}, {100000, "1666:40"}}) {
    json run = scores({{0.1, 1}});
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
