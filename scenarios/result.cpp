#include "scenarios/result.h"

#include <algorithm>

#include "cx/base/json.h"
#include "scenarios/catalogue.h"

namespace cxlab {

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

Json section_json(const Result::Section& section) {
  Json value = parse_json(section.json);
  return value.is_discarded() ? Json(section.json) : value;
}

Json result_json(const Result& r) {
  Json out;
  out["schema"] = 1;
  out["scenario"] = r.scenario;
  out["seed"] = r.seed;
  out["tier"] = r.tier;
  out["status"] = to_string(r.status);
  out["reason"] = reason_json(r.reason);
  out["deterministic"] = r.deterministic;
  out["sim_time_s"] = to_seconds(r.sim_time);
  out["wall_time_s"] = r.wall_time_s;
  out["physics_wall_s"] = r.physics_wall_s;
  out["real_time_factor"] = r.real_time_factor;
  out["ticks"] = r.ticks;
  out["steps"] = r.steps;
  out["peak_rss_mb"] = r.peak_rss_mb;
  for (const Result::Section& section : r.sections) out[section.key] = section_json(section);
  out["plans"] = r.plans;
  out["replans"] = r.replans;
  out["rule_errors"] = Json::array();
  for (const RuleErrorResult& e : r.rule_errors)
    out["rule_errors"].push_back({{"rule", e.rule},
                                  {"file", e.file},
                                  {"line", e.line},
                                  {"side", e.side},
                                  {"tick", e.tick},
                                  {"message", e.message}});
  out["warnings"] = r.all_warnings();
  out["journal_hash"] = r.journal_hash;
  out["physics_hash"] = r.physics_hash.empty() ? Json(nullptr) : Json(r.physics_hash);
  out["stream_hashes"] = Json::object();
  for (const auto& [name, hash] : r.stream_hashes) out["stream_hashes"][name] = hash;
  return out;
}

/// The sections of the world, then those of the nodes.
std::vector<ResultSection> sections_of(const Scenario& scenario) {
  std::vector<ResultSection> out(scenario.world.kind->sections.begin(), scenario.world.kind->sections.end());
  for (const ServerSpec& server : scenario.servers)
    out.insert(out.end(), server.kind->sections.begin(), server.kind->sections.end());
  return out;
}

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

std::vector<std::string> Result::all_warnings() const {
  std::vector<std::string> all = warnings;
  all.insert(all.end(), tallies.begin(), tallies.end());
  return all;
}

std::string section_of_path(const std::string& path) { return path.substr(0, path.find_first_of(".[")); }

std::string Result::at(const std::string& path) const {
  const auto section = std::ranges::find(sections, section_of_path(path), &Section::key);
  const Json value =
      value_at(section == sections.end() ? result_json(*this) : Json{{section->key, section_json(*section)}}, path);
  return value.is_null() ? std::string() : json_text(value);
}

void Result::set(const std::string& key, std::string json) {
  if (const auto known = std::ranges::find(sections, key, &Section::key); known != sections.end())
    known->json = std::move(json);
  else
    sections.push_back({key, std::move(json)});
}

std::string Result::to_json() const { return json_text(result_json(*this), 2) + '\n'; }

Result initial_result(const Scenario& scenario) {
  Result result;
  result.scenario = scenario.name;
  result.seed = scenario.seed;
  result.tier = scenario.tier_name();
  for (const ResultSection& section : sections_of(scenario))
    result.set(std::string(section.key), std::string(section.initial));
  return result;
}

Result unfinished_result(const Scenario& scenario) {
  Result result = initial_result(scenario);
  result.reason = run_error("the run has not ended").with_code("unfinished");
  return result;
}

Result sample_result(const Scenario& scenario) {
  Result sample = initial_result(scenario);
  sample.reason = run_error("message", "file", 1).with_code("code");
  sample.rule_errors.emplace_back();
  sample.warnings.emplace_back();
  for (const ResultSection& section : sections_of(scenario))
    if (section.sample) sample.set(std::string(section.key), section.sample());
  return sample;
}

namespace {

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

Status check_result_path(const std::string& path, const Scenario& scenario) {
  Json at = result_json(sample_result(scenario));
  std::string rest = path, before;
  while (!rest.empty()) {
    if (before == "stream_hashes") return {};  // then the name of a stream
    const std::string step = take_step(rest);
    if (at.is_array()) {
      if (!is_index(step)) return input_error(found_text(path, "an index like " + before + "[0]"));
      if (at.empty())
        return input_error("in a world of kind " + std::string(scenario.world.kind->name) + ", '" + before +
                           "' is empty");
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
  return before.empty() ? Status(input_error("expected a path into result.json, for example rule_errors[0].rule"))
                        : Status();
}

Status check_expectations(const std::vector<Expectation>& expectations, const std::string& result_json) {
  const Json result = parse_json(result_json);
  for (const Expectation& e : expectations) {
    const Json value = value_at(result, e.path);
    const std::string found = value.is_string() ? value.get<std::string>() : json_text(value);
    std::string wanted;
    if (e.equals && found != *e.equals) wanted = "'" + *e.equals + "'";
    if ((e.min || e.max) && !value.is_number())
      wanted = "a number";
    else if (e.min && value.get<double>() < *e.min)
      wanted = "at least " + json_text(Json(*e.min));
    else if (e.max && value.get<double>() > *e.max)
      wanted = "at most " + json_text(Json(*e.max));
    if (wanted.empty()) continue;
    return at(e.origin, negative("expected " + e.path + " to be " + wanted + ", found " + found))
        .with_code("expectation");
  }
  return {};
}

}  // namespace cxlab
