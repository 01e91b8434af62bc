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
#include "scenarios/result.h"
#include "sim/server.h"
#include "sim/simulation.h"

namespace cxlab {

/// Looks at the world after the servers and gives points.
class Referee {
 public:
  virtual ~Referee() = default;
  virtual Status judge(SimTime now) = 0;
  virtual SimTime next_due() const = 0;
  /// Whether the game has ended before the scenario's duration.
  virtual bool over() const = 0;
};

struct Stage {
  virtual ~Stage() = default;
  std::vector<std::unique_ptr<sim::Simulation>> worlds;  ///< moved on in this order; none in an empty world
  std::vector<std::unique_ptr<sim::Server>> servers;     ///< called in this order
  std::unique_ptr<Referee> referee;                      ///< may be none
  std::vector<std::filesystem::path> files;              ///< models that were read
  std::vector<std::function<void(Result&)>> reports;     ///< of nodes beside the world: what they add to the result
  /// What has entered the physics since the last call, for the input log.
  virtual std::string take_inputs() { return {}; }
  /// Writes teams, orders, deliveries, robots, steps and the physics hash.
  virtual void report(Result&) const {}
};

}  // namespace cxlab
