#include "scenarios/result.h"

#include <nlohmann/json.hpp>

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
  out["tier"] = tier == Tier::kTimed ? "timed" : "physics";
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
    out["orders"].push_back({{"id", o.id}, {"complexity", o.complexity}, {"ordered", o.ordered},
                             {"delivered_at", o.delivered_at ? Json(*o.delivered_at) : Json(nullptr)},
                             {"correct", o.correct}, {"points", o.points}});
  out["deliveries"] = Json::array();
  for (const DeliveryResult& d : deliveries)
    out["deliveries"].push_back({{"order", d.order}, {"team", d.team}, {"time", d.time}, {"correct", d.correct},
                                 {"late_s", d.late_s}, {"points", d.points}});
  out["robots"] = Json::array();
  for (const RobotResult& r : robots)
    out["robots"].push_back({{"name", r.name}, {"busy_s", r.busy_s}, {"drive_s", r.drive_s}, {"wait_s", r.wait_s},
                             {"skills", r.skills}, {"failures", r.failures}, {"contacts", r.contacts}});
  if (!turtles.empty()) out["turtles"] = Json::array();
  for (const TurtleResult& t : turtles)
    out["turtles"].push_back({{"name", t.name}, {"alive", t.alive}, {"x", t.x}, {"y", t.y}, {"theta", t.theta}, {"driven_m", t.driven_m},
                              {"walls", t.walls}, {"touches", t.touches}, {"teleports", t.teleports}});
  out["plans"] = plans;
  out["replans"] = replans;
  out["rule_errors"] = Json::array();
  for (const RuleErrorResult& e : rule_errors)
    out["rule_errors"].push_back({{"rule", e.rule}, {"file", e.file}, {"line", e.line}, {"side", e.side},
                                  {"tick", e.tick}, {"message", e.message}});
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
  result.reason = Error{ErrorKind::kRun, "the run has not ended", {}, 0, "unfinished"};
  return result;
}

namespace {

/// The value at "teams.CYAN.points" or "orders[0].points"; null if there is none.
Json value_at(const Json& root, const std::string& path) {
  std::string pointer = "/";
  for (const char c : path) {
    if (c == ']') continue;
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

Status check_expectations(const std::vector<Expectation>& expectations, const std::string& result_json, const std::string& file) {
  const Json result = Json::parse(result_json);
  for (const Expectation& e : expectations) {
    const Json value = value_at(result, e.path);
    const std::string found = value.is_string() ? value.get<std::string>() : value.dump();
    std::string wanted;
    if (e.equals && found != *e.equals) wanted = "'" + *e.equals + "'";
    if ((e.min || e.max) && !value.is_number()) wanted = "a number";
    else if (e.min && value.get<double>() < *e.min) wanted = "at least " + Json(*e.min).dump();
    else if (e.max && value.get<double>() > *e.max) wanted = "at most " + Json(*e.max).dump();
    if (wanted.empty()) continue;
    return Error{ErrorKind::kNo, "expected " + e.path + " to be " + wanted + ", found " + found, file, e.line, "expectation"};
  }
  return {};
}

}  // namespace cxlab
