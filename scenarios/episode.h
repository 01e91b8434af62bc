#pragma once
// One episode: one world, its servers, a referee, and the environments that decide. One clock, one seed.
//
//   auto episode = Episode::load(scenario, options);
//   (*episode)->start();
//   while (!(*episode)->over()) if (Status s = (*episode)->tick(); !s) ...
//   Result result = (*episode)->close();

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/bus/bus.h"
#include "cx/executive/environment_manager.h"
#include "cx/journal/journal.h"
#include "scenarios/result.h"
#include "scenarios/scenario.h"
#include "scenarios/stage.h"

namespace cxlab {

/// Measures a stretch of wall time for the caller; the episode itself reads no clock.
class WallMeter {
 public:
  virtual ~WallMeter() = default;
  virtual void begin() = 0;
  virtual void end() = 0;
};

struct EpisodeOptions {
  std::filesystem::path run_folder;            ///< empty = nothing is written
  JournalLevel journal = JournalLevel::kDecisions;
  LogSink* log = nullptr;                      ///< log lines of environments and nodes; may be none
  WallMeter* physics_meter = nullptr;          ///< around the world's steps; may be none
  bool strict = false;                         ///< unknown CX parameters are errors
  bool keep_going = false;                     ///< load errors are reported and the run goes on, as CX does
};

class Episode {
 public:
  /// Reads everything that the scenario names. Nothing has run yet.
  static Expected<std::unique_ptr<Episode>> load(Scenario scenario, EpisodeOptions options);
  ~Episode();
  Episode(const Episode&) = delete;
  Episode& operator=(const Episode&) = delete;

  /// Activation: plugins, reset, first run. Before tick 0.
  Status start();
  /// One tick, in the order of docs/contracts.md 1.
  Status tick();
  /// Whether the duration has passed, the referee has ended the game, or rules asked for shutdown.
  bool over() const;
  /// Deactivates the agents, ends the files, and says how it went. `failure` is the error that ended the run, if any.
  Result close(RunStatus status, std::optional<Error> failure = {});

  SimTime now() const;               ///< of the last tick
  const Scenario& scenario() const;
  const Stage& stage() const;
  Stage& stage();
  bus::Bus& bus();
  Journal& journal();
  std::vector<std::unique_ptr<EnvironmentManager>>& agents();
  /// What has happened so far, without the measurements of the caller.
  Result result() const;

 private:
  struct Parts;
  explicit Episode(std::unique_ptr<Parts> parts);
  Status advance();
  std::unique_ptr<Parts> parts_;
};

}  // namespace cxlab
