#pragma once
// What stands and acts in an episode's world, beside the agents. Each kind of world makes one, in one explicit list
// (`rcll::make_stage`).

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/time.h"
#include "cx/run/parts.h"
#include "scenarios/result.h"

namespace cxlab {

struct Stage {
  virtual ~Stage() = default;
  std::vector<std::unique_ptr<Simulation>> worlds;    ///< moved on in this order; none in an empty world
  std::vector<std::unique_ptr<Server>> servers;       ///< called in this order
  Referee* referee = nullptr;                         ///< one of the servers; may be none
  std::vector<std::filesystem::path> files;           ///< models that were read
  std::vector<std::function<void(Result&)>> reports;  ///< of nodes beside the world: what they add to the result
  /// What has entered the physics since the last call, for the input log.
  virtual std::string take_inputs() { return {}; }
  /// Writes teams, orders, deliveries, robots, steps and the physics hash.
  virtual void report(Result&) const {}
};

}  // namespace cxlab
