#include "scenarios/result.h"

#include <nlohmann/json.hpp>

#include "scenarios/rcll/referee.h"

namespace cxlab {

using Json = nlohmann::ordered_json;

const char* to_string(RunStatus status) {
  switch (status) {
    case RunStatus::kCompleted: return "completed";
    case RunStatus::kStopped: return "stopped";
    case RunStatus::kFailed: return "failed";
    case RunStatus::kInterrupted: return "interrupted";
  }
  return "failed";
}

namespace {

const char* default_code(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::kNo: return "no";
    case ErrorKind::kUsage: return "usage";
    case ErrorKind::kInput: return "bad_input";
    case ErrorKind::kRun: return "run_failed";
    case ErrorKind::kResource: return "resource";
    case ErrorKind::kBug: return "bug";
  }
  return "bug";
}

Json reason_json(const std::optional<Error>& reason) {
  if (!reason) return nullptr;
  Json out{{"code", reason->code.empty() ? default_code(reason->kind) : reason->code}, {"message", reason->message}};
  out["file"] = reason->file.empty() ? Json(nullptr) : Json(reason->file);
  out["line"] = reason->line > 0 ? Json(reason->line) : Json(nullptr);
  return out;
}

}  // namespace

std::string Result::to_json() const {
  Json out;
  out["schema"] = 1;
  out["scenario"] = scenario;
  out["seed"] = seed;
  out["tier"] = !has_world ? "none" : tier == Tier::kTimed ? "timed" : "physics";
  out["status"] = to_string(status);
  out["reason"] = reason_json(reason);
  out["deterministic"] = deterministic;
  out["sim_time_s"] = to_seconds(sim_time);
  out["wall_time_s"] = wall_time_s;
  out["physics_wall_s"] = physics_wall_s;
  out["real_time_factor"] = real_time_factor;
  out["ticks"] = ticks;
  out["steps"] = steps;
  out["peak_rss_mb"] = peak_rss_mb;
  out["teams"] = Json::object();
  for (const TeamResult& team : teams) {
    Json kinds = Json::object();
    for (const auto& [kind, points] : team.by_kind) kinds[kind] = points;
    out["teams"][team.team] = {{"points", team.points}, {"by_kind", kinds}};
  }
  out["orders"] = Json::array();
  for (const OrderResult& o : orders)
    out["orders"].push_back({{"id", o.id},
                             {"complexity", o.complexity},
                             {"ordered", o.ordered},
                             {"delivered_at", o.delivered_at ? Json(*o.delivered_at) : Json(nullptr)},
                             {"correct", o.correct},
                             {"points", o.points}});
  out["deliveries"] = Json::array();
  for (const DeliveryResult& d : deliveries)
    out["deliveries"].push_back({{"order", d.order},
                                 {"team", d.team},
                                 {"time", d.time},
                                 {"correct", d.correct},
                                 {"late_s", d.late_s},
                                 {"points", d.points}});
  out["robots"] = Json::array();
  for (const RobotResult& r : robots)
    out["robots"].push_back({{"name", r.name},
                             {"busy_s", r.busy_s},
                             {"drive_s", r.drive_s},
                             {"wait_s", r.wait_s},
                             {"skills", r.skills},
                             {"failures", r.failures},
                             {"contacts", r.contacts}});
  if (!turtles.empty()) out["turtles"] = Json::array();
  for (const TurtleResult& t : turtles)
    out["turtles"].push_back({{"name", t.name},
                              {"alive", t.alive},
                              {"x", t.x},
                              {"y", t.y},
                              {"theta", t.theta},
                              {"driven_m", t.driven_m},
                              {"walls", t.walls},
                              {"touches", t.touches},
                              {"teleports", t.teleports}});
  out["plans"] = plans;
  out["replans"] = replans;
  out["rule_errors"] = Json::array();
  for (const RuleErrorResult& e : rule_errors)
    out["rule_errors"].push_back({{"rule", e.rule},
                                  {"file", e.file},
                                  {"line", e.line},
                                  {"side", e.side},
                                  {"tick", e.tick},
                                  {"message", e.message}});
  out["journal_hash"] = journal_hash;
  out["physics_hash"] = physics_hash.empty() ? Json(nullptr) : Json(physics_hash);
  out["stream_hashes"] = Json::object();
  for (const auto& [name, hash] : stream_hashes) out["stream_hashes"][name] = hash;
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

Result unfinished_result(const Scenario& scenario) {
  Result result;
  result.scenario = scenario.name;
  result.seed = scenario.seed;
  result.tier = scenario.tier;
  result.has_world = scenario.world_kind != Scenario::WorldKind::kNone;
  result.reason = run_error("the run has not ended").with_code("unfinished");
  return result;
}

namespace {

/// The value at "teams.CYAN.points" or "orders[0].points"; null if there is none.
Json value_at(const Json& root, const std::string& path) {
  std::string pointer = "/";
  for (const char c : path) {
    if (c == ']') continue;
    if (c == '/')
      pointer += "~1";
    else
      pointer += c == '.' || c == '[' ? '/' : c;
  }
  try {
    const Json::json_pointer json_pointer(pointer);
    return root.contains(json_pointer) ? root[json_pointer] : Json(nullptr);
  } catch (const Json::exception&) {  // not a path at all
    return nullptr;
  }
}

}  // namespace

namespace {

/// A result that has one of everything.
Json sample_result() {
  Result sample;
  sample.reason = run_error("message", "file", 1).with_code("code");
  for (const char* team : {"CYAN", "MAGENTA"}) {
    sample.teams.push_back({team, 0, {}});
    for (std::size_t kind = 0; kind < rcll::kPointKinds; ++kind)
      sample.teams.back().by_kind.emplace_back(to_string(static_cast<rcll::PointKind>(kind)), 0);
  }
  sample.orders.emplace_back();
  sample.deliveries.emplace_back();
  sample.robots.emplace_back();
  sample.turtles.emplace_back();
  sample.rule_errors.emplace_back();
  return Json::parse(sample.to_json());
}

/// The next step of "a.b[0].c": "a", "b", "[0]", "c".
std::string take_step(std::string& path) {
  if (path.starts_with('.')) path.erase(0, 1);
  const std::size_t end = path.starts_with('[') ? path.find(']') : path.find_first_of(".[");
  const std::size_t size = end == std::string::npos ? path.size() : path[end] == ']' ? end + 1 : end;
  std::string step = path.substr(0, size);
  path.erase(0, size);
  return step;
}

bool is_index(const std::string& step) {
  return step.size() > 2 && step.front() == '[' && step.back() == ']' &&
         step.find_first_not_of("0123456789", 1) == step.size() - 1;
}

}  // namespace

Status check_result_path(const std::string& path) {
  Json at = sample_result();
  std::string rest = path, before;
  while (!rest.empty()) {
    if (before == "stream_hashes") return {};  // then the name of a stream
    const std::string step = take_step(rest);
    if (at.is_array()) {
      if (!is_index(step)) return input_error("found '" + path + "', expected an index like " + before + "[0]");
      at = Json(at[0]);
    } else if (!at.contains(step)) {
      std::vector<std::string> known;
      if (at.is_object())
        for (const auto& [key, value] : at.items()) known.push_back(key);
      const std::string near = nearest_word(step, known);
      std::string expected;
      for (const std::string& key : known) expected += (expected.empty() ? "; known are: " : ", ") + key;
      return input_error("result.json has no '" + step + "'" + (before.empty() ? "" : " in '" + before + "'") +
                         (near.empty() ? expected : ", did you mean '" + near + "'?"));
    } else {
      at = Json(at[step]);
    }
    before += (before.empty() || step.starts_with('[') ? "" : ".") + step;
  }
  return before.empty() ? Status(input_error("expected a path into result.json, for example teams.CYAN.points"))
                        : Status();
}

Status check_expectations(const std::vector<Expectation>& expectations, const std::string& result_json,
                          const std::string& file) {
  const Json result = Json::parse(result_json);
  for (const Expectation& e : expectations) {
    const Json value = value_at(result, e.path);
    const std::string found = value.is_string() ? value.get<std::string>() : value.dump();
    std::string wanted;
    if (e.equals && found != *e.equals) wanted = "'" + *e.equals + "'";
    if ((e.min || e.max) && !value.is_number())
      wanted = "a number";
    else if (e.min && value.get<double>() < *e.min)
      wanted = "at least " + Json(*e.min).dump();
    else if (e.max && value.get<double>() > *e.max)
      wanted = "at most " + Json(*e.max).dump();
    if (wanted.empty()) continue;
    return negative("expected " + e.path + " to be " + wanted + ", found " + found, file, e.line)
        .with_code("expectation");
  }
  return {};
}

}  // namespace cxlab
