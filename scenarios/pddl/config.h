#pragma once
// A PDDL manager as a scenario describes it, `{node: pddl_manager, ...}` under `servers:`, and what planning costs.

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cx/yaml/yaml.h"
#include "planner/cost.h"

namespace cxlab::pddl {

struct Config {
  std::string name = "pddl_manager";
  std::string name_space = "/";
  std::vector<std::pair<std::string, std::string>> remaps;  ///< FROM := TO
  bool autostart = true;                                    ///< else somebody configures and activates it
  double bond_period = 0;                                   ///< s between heartbeats; 0 = none
  bool original = false;                                    ///< compat: original
  bool anytime = false;                                     ///< plans are improved until the budget ends
  bool warm_start = true;          ///< plans for a goal begin with what is left of its last one
  std::string command;             ///< another planner, as a command with {domain}, {problem} and {plan}; empty = ours
  std::string engine;              ///< another planner, an engine of the Unified Planning Framework; empty = none
  std::string python = "python3";  ///< the interpreter that has the engine
  std::optional<planner::PlanningCost> cost;  ///< none: that of the scenario
};

void read_config(yaml::Map& map, Config& config);
/// `planner:` of a scenario: latency {a, b}, budget, charge.
void read_cost(const yaml::Value& value, planner::PlanningCost& cost);

}  // namespace cxlab::pddl
