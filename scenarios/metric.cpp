#include "scenarios/metric.h"

#include <algorithm>
#include <set>

#include "cx/base/json.h"
#include "scenarios/catalogue.h"
#include "scenarios/result.h"

namespace cxlab {

namespace {

constexpr Metric kCommon[]{
    {.name = "real_time_factor",
     .what = "simulated time per second of wall time",
     .from = "real_time_factor",
     .of_machine = true,
     .title = "x real time",
     .digits = 0},
    {.name = "wall_time_s",
     .what = "wall time",
     .from = "wall_time_s",
     .unit = "s",
     .more_is_better = false,
     .of_machine = true},
    {.name = "sim_time_s", .what = "simulated time", .from = "sim_time_s", .unit = "s"},
    {.name = "plans", .what = "plans of the planner", .from = "plans"},
    {.name = "replans", .what = "plans made after the first", .from = "replans", .more_is_better = false},
};

/// Adds the numbers at the rest of a path; false where a key of it is missing.
bool collect(const Json& at, std::string_view path, std::vector<double>& out) {
  if (path.empty()) {
    if (at.is_boolean()) out.push_back(at.get<bool>() ? 1 : 0);
    if (at.is_number()) out.push_back(at.get<double>());
    return at.is_boolean() || at.is_number();
  }
  const std::size_t dot = path.find('.');
  const std::string_view step = path.substr(0, dot),
                         rest = dot == path.npos ? std::string_view() : path.substr(dot + 1);
  if (step == "*")
    return at.is_structured() && std::ranges::all_of(at, [&](const Json& part) { return collect(part, rest, out); });
  const auto found = at.is_object() ? at.find(std::string(step)) : at.end();
  return found != at.end() && collect(*found, rest, out);
}

/// The value at a path without `*`; nullptr where a key is missing.
const Json* find(const Json& at, std::string_view path) {
  const std::size_t dot = path.find('.');
  const auto found = at.is_object() ? at.find(std::string(path.substr(0, dot))) : at.end();
  if (found == at.end()) return nullptr;
  return dot == path.npos ? &*found : find(*found, path.substr(dot + 1));
}

std::optional<double> value_of(const Metric& metric, const Json& result) {
  std::vector<double> values, per;
  if (!collect(result, metric.from, values)) return std::nullopt;
  double value = 0;
  for (const double one : values) value += one;
  if (metric.fold == Metric::Fold::kMean) {
    if (values.empty()) return std::nullopt;
    value /= static_cast<double>(values.size());
  }
  if (metric.per.empty()) return value;
  if (!collect(result, metric.per, per) || per.size() != 1 || per.front() == 0) return std::nullopt;
  return value / per.front();
}

}  // namespace

std::string formula_of(const Metric& metric) {
  const bool many = metric.from.find('*') != metric.from.npos;
  std::string out = !many ? "" : metric.fold == Metric::Fold::kMean ? "mean of " : "sum of ";
  out += metric.from;
  return metric.per.empty() ? out : out + " / " + std::string(metric.per);
}

std::span<const Metric> common_metrics() { return kCommon; }

std::vector<const Metric*> metrics_of(const WorldKind& world) {
  std::vector<const Metric*> out;
  for (const auto& list : {world.metrics, common_metrics()})
    for (const Metric& metric : list) out.push_back(&metric);
  return out;
}

std::vector<std::optional<double>> measure(const std::vector<const Metric*>& metrics, const std::string& result_json) {
  const Json result = parse_json(result_json);
  std::vector<std::optional<double>> out;
  for (const Metric* metric : metrics) out.push_back(value_of(*metric, result));
  return out;
}

std::vector<std::pair<std::string, double>> measure_apart(const Metric& metric, const std::string& result_json) {
  const Json result = parse_json(result_json);
  std::vector<std::pair<std::string, double>> out;
  constexpr std::string_view kEach = ".*.";
  const std::size_t each = metric.from.find(kEach);
  const Json* map = each == metric.from.npos ? nullptr : find(result, metric.from.substr(0, each));
  if (!map || !map->is_object() || !metric.per.empty()) {
    if (const auto value = value_of(metric, result)) out.emplace_back(metric.name, *value);
    return out;
  }
  for (const auto& [key, part] : map->items()) {
    Metric one = metric;
    one.from.remove_prefix(each + kEach.size());
    const std::string_view last = metric.from.substr(metric.from.rfind('.') + 1);
    if (const auto value = value_of(one, part)) out.emplace_back(key + '.' + std::string(last), *value);
  }
  return out;
}

Status check_metrics(const Scenario& scenario) {
  const WorldKind& world = *scenario.world.kind;
  const Json sample = parse_json(sample_result(scenario).to_json());
  std::set<std::string_view> names;
  for (const Metric* metric : metrics_of(world)) {
    const std::string what =
        "the world " + std::string(world.name) + " declares a metric '" + std::string(metric->name) + "' ";
    if (!names.insert(metric->name).second) return bug_error(what + "twice");
    for (const std::string_view path : {metric->from, metric->per})
      if (std::vector<double> values; !path.empty() && (!collect(sample, path, values) || values.empty()))
        return bug_error(what + "from '" + std::string(path) + "', but its sample of result.json has no number there");
  }
  for (const Metric& metric : world.metrics)
    if (!metric.part_of.empty() && !names.contains(metric.part_of))
      return bug_error("the world " + std::string(world.name) + " declares a metric '" + std::string(metric.name) +
                       "' as a part of '" + std::string(metric.part_of) + "', which is none of its metrics");
  return {};
}

}  // namespace cxlab
