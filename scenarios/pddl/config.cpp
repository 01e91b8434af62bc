#include "scenarios/pddl/config.h"

#include "cx/bus/names.h"

namespace cxlab::pddl {

void read_cost(const yaml::Value& value, planner::PlanningCost& cost) {
  yaml::Map map = value.as_map();
  if (const yaml::Value latency = map.get("latency")) {
    yaml::Map parts = latency.as_map();
    parts.read("a", cost.latency_a).read("b", cost.latency_b);
    parts.finish();
    if (cost.latency_a < 0 || cost.latency_b < 0) latency.fail("a and b must be 0 or more");
  }
  map.read("budget", cost.budget).read("charge", cost.charge);
  if (cost.budget <= 0)
    map.get("budget").fail("found " + std::to_string(cost.budget) + ", expected work units above 0");
  map.finish();
}

void read_config(yaml::Map& map, Config& config) {
  map.read("name", config.name).read("namespace", config.name_space);
  if (const yaml::Value remap = map.get("remap"))
    for (const auto& [from, to] : remap.as_map().entries()) {
      config.remaps.emplace_back(from, to.as_string());
      if (const std::string fault = bus::remap_fault(config.remaps.back()); !fault.empty()) to.fail(fault);
    }
  if (const std::string fault = bus::namespace_fault(config.name_space); !fault.empty())
    map.get("namespace").fail("the name '" + config.name_space + "' " + fault);
  map.read("autostart_node", config.autostart)
      .read("bond_heartbeat_period", config.bond_period)
      .read("anytime", config.anytime)
      .read("warm_start", config.warm_start)
      .read("command", config.command);
  map.read("engine", config.engine).read("python", config.python);
  if (config.bond_period < 0) map.get("bond_heartbeat_period").fail("must be 0 (no heartbeats) or more");
  if (!config.command.empty() && config.command.find("{plan}") == std::string::npos)
    map.get("command").fail("found no {plan} in it, expected a command that writes its plan to {plan}");
  if (!config.command.empty() && !config.engine.empty())
    map.get("engine").fail("found beside command, expected one of the two");
  if (config.engine.empty() && map.has("python"))
    map.get("python").fail("says which interpreter has the engine, but there is no engine");
  std::string compat = "none";
  map.read_word("compat", compat, {"none", "original"});
  config.original = compat == "original";
  if (const yaml::Value planner = map.get("planner")) {
    config.cost.emplace();
    read_cost(planner, *config.cost);
  }
}

}  // namespace cxlab::pddl
