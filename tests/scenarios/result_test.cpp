// result.json: its keys and their order, the sections of worlds, paths into it, and what is expected of it.

#include "scenarios/result.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenarios/metric.h"
#include "scenarios/rcll/world.h"
#include "scenarios/shipped/catalogue.h"
#include "scenarios/turtlesim/world.h"

namespace cxlab {
namespace {

using testing::HasSubstr;

Scenario in(const WorldKind& kind) {
  Scenario scenario;
  scenario.set_world({&kind});
  return scenario;
}

TEST(Result, HasItsKeysInTheirOrder) {
  Result result;
  result.scenario = "game";
  result.seed = 18446744073709551615u;
  result.status = RunStatus::kCompleted;
  result.sim_time = from_seconds(1.5);
  result.rule_errors.push_back({"r", "f.clp", "RHS", "what", 3, 7});
  result.warnings.emplace_back("careful");
  result.stream_hashes = {{"a", "1"}, {"b", "2"}};
  EXPECT_EQ(result.to_json(), R"({
  "schema": 1,
  "scenario": "game",
  "seed": 18446744073709551615,
  "tier": "none",
  "status": "completed",
  "reason": null,
  "deterministic": true,
  "sim_time_s": 1.5,
  "wall_time_s": 0.0,
  "physics_wall_s": 0.0,
  "real_time_factor": 0.0,
  "ticks": 0,
  "steps": 0,
  "peak_rss_mb": 0.0,
  "plans": 0,
  "replans": 0,
  "rule_errors": [
    {
      "rule": "r",
      "file": "f.clp",
      "line": 3,
      "side": "RHS",
      "tick": 7,
      "message": "what"
    }
  ],
  "warnings": [
    "careful"
  ],
  "journal_hash": "",
  "physics_hash": null,
  "stream_hashes": {
    "a": "1",
    "b": "2"
  }
}
)");
}

TEST(Result, SectionsOfAWorldComeBeforeThePlans) {
  Result result = initial_result(in(rcll::kWorld));
  result.set("turtles", R"([{"x": 0.1, "n": 5.0}])");
  result.set("robots", "[1]");
  result.set("note", "not JSON");
  result.set("turtles", R"([{"x": 0.30000000000000004, "n": 5.0}])");
  const std::string json = result.to_json();
  const auto at = [&](const char* key) { return json.find(std::string("\n  \"") + key + "\":"); };
  EXPECT_LT(at("robots"), at("turtles"));
  EXPECT_LT(at("turtles"), at("note"));
  EXPECT_LT(at("note"), at("plans"));
  EXPECT_EQ(result.at("robots"), "[1]");
  EXPECT_EQ(result.at("turtles[0].x"), "0.30000000000000004") << "the last value, with all its digits";
  EXPECT_EQ(result.at("turtles[0].n"), "5.0");
  EXPECT_EQ(result.at("note"), "\"not JSON\"");
  EXPECT_EQ(result.at("turtles[1].x"), "");
  EXPECT_EQ(result.at("turtles[x"), "");
}

TEST(Result, ARunThatHasOnlyBegunHasTheSectionsOfItsWorld) {
  const Result game = unfinished_result(in(rcll::kWorld)), turtles = unfinished_result(in(turtlesim::kWorld));
  for (const auto& [key, value] :
       {std::pair("teams", "{}"), {"orders", "[]"}, {"deliveries", "[]"}, {"robots", "[]"}}) {
    EXPECT_EQ(game.at(key), value);
    EXPECT_EQ(turtles.at(key), "") << key;
  }
  EXPECT_EQ(turtles.at("turtles"), "[]");
}

/// What `measure` gives of one metric.
std::optional<double> value(const Metric& metric, const std::string& json) { return measure({&metric}, json).front(); }

TEST(Metric, IsComputedFromTheResult) {
  const std::string json = R"({"n": 3, "yes": true, "t": 10, "text": "x", "nil": null, "zero": 0,
    "list": [{"a": 1, "ok": true}, {"a": 2.5, "ok": false}], "map": {"x": {"a": 7}, "y": {"a": -1}}, "none": []})";
  const Metric mean{.name = "m", .what = "", .from = "list.*.a", .fold = Metric::Fold::kMean};
  EXPECT_EQ(value({.name = "m", .what = "", .from = "n"}, json), 3);
  EXPECT_EQ(value({.name = "m", .what = "", .from = "yes"}, json), 1);
  EXPECT_EQ(value({.name = "m", .what = "", .from = "list.*.a"}, json), 3.5);
  EXPECT_EQ(value({.name = "m", .what = "", .from = "list.*.ok"}, json), 1);
  EXPECT_EQ(value({.name = "m", .what = "", .from = "map.*.a"}, json), 6);
  EXPECT_EQ(value(mean, json), 1.75);
  Metric rate = mean;
  rate.per = "t";
  EXPECT_EQ(value(rate, json), 0.175);
  EXPECT_EQ(formula_of(rate), "mean of list.*.a / t");
  rate.per = "zero";
  EXPECT_EQ(value(rate, json), std::nullopt);
  EXPECT_EQ(value({.name = "m", .what = "", .from = "none.*.a"}, json), 0) << "nothing adds up to nothing";
  EXPECT_EQ(value({.name = "m", .what = "", .from = "none.*.a", .fold = Metric::Fold::kMean}, json), std::nullopt);
  for (const char* path : {"missing", "n.a", "text", "nil", "list", "list.*.b", "map.*", "*"})
    EXPECT_EQ(value({.name = "m", .what = "", .from = path}, json), std::nullopt) << path;
  EXPECT_EQ(value(mean, "no JSON"), std::nullopt);
}

TEST(Metric, IsTakenApartByTheKeysOfAMap) {
  using Values = std::vector<std::pair<std::string, double>>;
  const std::string json = R"({"teams": {"A": {"points": 3, "by": {"ring": 1}}, "B": {"points": 4, "by": {"ring": 2}}},
    "list": [{"n": 1}, {"n": 2}]})";
  EXPECT_EQ(measure_apart({.name = "points", .what = "", .from = "teams.*.points"}, json),
            (Values{{"A.points", 3}, {"B.points", 4}}));
  EXPECT_EQ(measure_apart({.name = "r", .what = "", .from = "teams.*.by.ring"}, json),
            (Values{{"A.ring", 1}, {"B.ring", 2}}));
  EXPECT_EQ(measure_apart({.name = "all", .what = "", .from = "list.*.n"}, json), (Values{{"all", 3}}));
  EXPECT_EQ(measure_apart({.name = "all", .what = "", .from = "missing.*.n"}, json), Values{});
}

TEST(Metric, OfEachShippedWorldHasAPlaceInItsResult) {
  for (const WorldKind* world : shipped().worlds) {
    const Status s = check_metrics(in(*world));
    EXPECT_TRUE(s.ok()) << s.error().text();
  }
  static constexpr Metric kTwice[]{{.name = "a", .what = "", .from = "seed"},
                                   {.name = "a", .what = "", .from = "ticks"}};
  const WorldKind twice{.name = "own", .what = "", .metrics = kTwice};
  EXPECT_EQ(check_metrics(in(twice)).error().message, "the world own declares a metric 'a' twice");
}

TEST(Result, AReasonHasACodeAndAPlace) {
  Result result = unfinished_result(in(rcll::kWorld));
  EXPECT_EQ(result.tier, "physics");
  EXPECT_EQ(result.status, RunStatus::kFailed);
  EXPECT_EQ(result.at("reason"), R"({"code":"unfinished","message":"the run has not ended","file":null,"line":null})");
  result.reason = input_error("wrong", "a.yaml", 3);
  EXPECT_EQ(result.at("reason"), R"({"code":"bad_input","message":"wrong","file":"a.yaml","line":3})");
  for (const auto& [error, code] : {std::pair(negative("x"), "no"),
                                    {usage_error("x"), "usage"},
                                    {run_error("x"), "run_failed"},
                                    {resource_error("x"), "resource"},
                                    {bug_error("x"), "bug"}}) {
    result.reason = error;
    EXPECT_EQ(result.at("reason.code"), '"' + std::string(code) + '"');
  }
  for (const auto& [status, word] : {std::pair(RunStatus::kCompleted, "completed"),
                                     {RunStatus::kStopped, "stopped"},
                                     {RunStatus::kFailed, "failed"},
                                     {RunStatus::kInterrupted, "interrupted"}})
    EXPECT_STREQ(to_string(status), word);
}

TEST(Result, PathsAreCheckedAgainstWhatTheWorldAdds) {
  const auto check = [](const std::string& path, const WorldKind& kind) {
    const Status s = check_result_path(path, in(kind));
    return s ? std::string() : s.error().message;
  };
  for (const char* path : {"status", "reason.code", "teams.CYAN.points", "teams.MAGENTA.by_kind.delivery",
                           "orders[0].delivered_at", "orders[9].points", "deliveries[0].late_s", "robots[2].busy_s",
                           "plans", "rule_errors[0].rule", "warnings[0]", "stream_hashes.env/main"})
    EXPECT_EQ(check(path, rcll::kWorld), "") << path;
  EXPECT_EQ(check("turtles[1].walls", turtlesim::kWorld), "");
  EXPECT_EQ(check("turtles[0].walls", rcll::kWorld).find("result.json has no 'turtles'; known are: schema, "), 0u);
  EXPECT_EQ(check("teams.CYAN.points", turtlesim::kWorld).find("result.json has no 'teams'; known are: schema, "), 0u);
  EXPECT_EQ(check("teams.CYAN.pionts", rcll::kWorld),
            "result.json has no 'pionts' in 'teams.CYAN', did you mean 'points'?");
  EXPECT_EQ(check("orders.points", rcll::kWorld), "found 'orders.points', expected an index like orders[0]");
  EXPECT_EQ(check("orders[].points", rcll::kWorld), "found 'orders[].points', expected an index like orders[0]");
  EXPECT_EQ(check("orders[x].points", rcll::kWorld), "found 'orders[x].points', expected an index like orders[0]");
  EXPECT_EQ(check("status.x", rcll::kWorld), "result.json has no 'x' in 'status'");
  EXPECT_EQ(check("", rcll::kWorld), "expected a path into result.json, for example rule_errors[0].rule");
}

TEST(Result, ExpectationsHoldUpToTheirLimits) {
  const std::string json = R"({"points": 5, "half": 0.5, "status": "completed", "none": null, "n": {"a": [1, 2]}})";
  const auto check = [&](Expectation e) {
    e.origin = {"s.yaml", 4};
    const Status s = check_expectations({e}, json);
    return s ? std::string() : s.error().text();
  };
  EXPECT_EQ(check({.path = "points", .min = 5, .max = 5}), "");
  EXPECT_EQ(check({.path = "points", .min = 5.5}), "s.yaml:4: expected points to be at least 5.5, found 5");
  EXPECT_EQ(check({.path = "points", .max = 4.5}), "s.yaml:4: expected points to be at most 4.5, found 5");
  EXPECT_EQ(check({.path = "points", .equals = "5"}), "");
  EXPECT_EQ(check({.path = "points", .equals = "6"}), "s.yaml:4: expected points to be '6', found 5");
  EXPECT_EQ(check({.path = "status", .equals = "completed"}), "");
  EXPECT_EQ(check({.path = "status", .min = 1}), "s.yaml:4: expected status to be a number, found completed");
  EXPECT_EQ(check({.path = "none", .max = 1}), "s.yaml:4: expected none to be a number, found null");
  EXPECT_EQ(check({.path = "n.a[1]", .equals = "2"}), "");
  EXPECT_EQ(check({.path = "n.b", .equals = "null"}), "") << "what is not there is null";
  const Status both = check_expectations({{.path = "half", .min = 0}, {.path = "points", .min = 6}}, json);
  EXPECT_EQ(both.error().kind, ErrorKind::kNo);
  EXPECT_EQ(both.error().code, "expectation");
  EXPECT_THAT(both.error().message, HasSubstr("points"));
}

}  // namespace
}  // namespace cxlab
