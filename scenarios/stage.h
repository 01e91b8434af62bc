#pragma once
// What stands and acts in an episode's world, beside the agents. Each kind of world makes one; nodes add to it.

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/time.h"
#include "cx/run/parts.h"
#include "scenarios/scene.h"
#include "scenarios/view.h"

namespace cxlab {

struct Result;

struct Stage {
  virtual ~Stage() = default;
  std::vector<std::unique_ptr<Simulation>> worlds;  ///< moved on in this order; none in an empty world
  std::vector<std::unique_ptr<Server>> servers;     ///< called in this order
  Referee* referee = nullptr;                       ///< one of the servers; may be none
  std::vector<std::filesystem::path> files;         ///< models that were read
  std::vector<std::filesystem::path> readable;      ///< real paths of files that rules may name to the servers
  std::vector<ViewMaker> views;                     ///< of the world, then of nodes beside it
  std::string without_views = "the world is empty: there is nothing to look at";  ///< the error where there are none
  std::vector<SceneLister> scenes;                    ///< of the world, then of nodes beside it: what there is to see
  std::vector<std::function<void(Result&)>> reports;  ///< of nodes beside the world: what they add to the result
  /// The inputs of the physics since the last call, for the input log.
  virtual std::string take_inputs() { return {}; }
  /// Adds the world's sections, the lines of the score board, the steps and the physics hash. It may leave out what
  /// `Result::wants` does not ask for.
  virtual void report(Result&) const {}
};

/// A recorded run to look at.
class RecordedWorld {
 public:
  virtual ~RecordedWorld() = default;
  /// The world as it was at `t`. Times come in order.
  virtual Status advance_to(SimTime t) = 0;
  virtual Expected<std::unique_ptr<View>> view(int width, int height) const = 0;
};

/// The physics of a recorded run, played again without rules and servers.
class WorldReplay : public RecordedWorld {
 public:
  /// As `physics_hash` of result.json.
  virtual std::string hash() const = 0;
};

}  // namespace cxlab
