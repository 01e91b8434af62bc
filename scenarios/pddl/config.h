#pragma once
// A PDDL manager as a scenario describes it, `{node: pddl_manager, ...}` under `servers:`, and what planning costs.

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "planner/cost.h"

namespace cxlab::pddl {

struct Config {
  std::string name = "pddl_manager";
  std::string name_space = "/";
  std::vector<std::pair<std::string, std::string>> remaps;  ///< FROM := TO
  bool autostart = true;                                    ///< else somebody configures and activates it
  double bond_period = 0;                                   ///< s between heartbeats; 0 = none
  std::string compat = "none";                              ///< or "original"
  bool anytime = false;                                     ///< plans are improved until the budget ends
  bool warm_start = true;          ///< plans for a goal begin with what is left of its last one
  std::string command;             ///< another planner, as a command with {domain}, {problem} and {plan}; empty = ours
  std::string engine;              ///< another planner, an engine of the Unified Planning Framework; empty = none
  std::string python = "python3";  ///< the interpreter that has the engine
  std::optional<planner::PlanningCost> cost;  ///< none: that of the scenario

  template <class Keys>
  void fields(Keys& keys) {
    keys("name", name);
    keys("namespace", name_space);
    keys("remap", remaps);
    keys("autostart_node", autostart);
    keys("bond_heartbeat_period", bond_period);
    keys("anytime", anytime);
    keys("warm_start", warm_start);
    keys("command", command);
    keys("engine", engine);
    keys("python", python);
    keys.word("compat", compat, {"none", "original"});
    keys("planner", cost);
  }
};

Status validate(const Config& config);

}  // namespace cxlab::pddl
