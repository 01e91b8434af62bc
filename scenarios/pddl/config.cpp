#include "scenarios/pddl/config.h"

#include "cx/bus/names.h"

namespace cxlab::pddl {

Status validate(const Config& config) {
  if (Status s = bus::check_node(config.name_space, config.remaps); !s) return s;
  if (config.bond_period < 0) return input_error("bond_heartbeat_period: must be 0 (no heartbeats) or more");
  if (!config.command.empty() && config.command.find("{plan}") == std::string::npos)
    return input_error("command: found no {plan} in it, expected a command that writes its plan to {plan}");
  if (!config.command.empty() && !config.engine.empty())
    return input_error("engine: found beside command, expected one of the two");
  if (config.engine.empty() && config.python != Config().python)
    return input_error("python: says which interpreter has the engine, but there is no engine");
  return {};
}

}  // namespace cxlab::pddl
