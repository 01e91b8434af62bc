#pragma once
// One episode: one world, its servers, a referee, and the environments that decide. One clock, one seed.
//
//   auto episode = Episode::load(scenario, options);
//   (*episode)->start();
//   while (!(*episode)->over()) if (auto step = (*episode)->step(t += 1s); !step) ...
//   Result result = (*episode)->close(...);

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/scratch_folder.h"
#include "cx/bus/bus.h"
#include "cx/executive/environment_manager.h"
#include "cx/executive/run_control.h"
#include "cx/journal/journal.h"
#include "cx/network/network.h"
#include "cx/run/loop.h"
#include "scenarios/inputs.h"
#include "scenarios/kept_files.h"
#include "scenarios/result.h"
#include "scenarios/run_spec.h"
#include "scenarios/scenario.h"
#include "scenarios/scene.h"
#include "scenarios/scene_log.h"
#include "scenarios/seat.h"
#include "scenarios/stage.h"

namespace cxlab {

/// Measures stretches of wall time for the caller; the episode itself reads no clock.
class WallMeter {
 public:
  virtual ~WallMeter() = default;
  virtual void begin() = 0;
  virtual void end() = 0;
};

/// What the stretches are of; each may be none.
struct WallMeters {
  WallMeter* physics = nullptr;  ///< the world's steps
  WallMeter* nodes = nullptr;    ///< nodes beside the world, such as the PDDL manager with its planner
  WallMeter* rules = nullptr;    ///< agents: what they perceive becomes facts, rules fire
};

/// A former run, from which its environments alone are played again: without world, servers and stimuli.
struct ReplaySource {
  std::filesystem::path inputs;  ///< its inputs.bin
  std::filesystem::path copies;  ///< its files, laid out by name (`StoredFiles::materialise`)
  std::vector<Shares> shares;    ///< by agent: what its packages' share directories were
  std::filesystem::path folder;  ///< where the run was recorded, to which its rules may have paths
};

struct EpisodeOptions {
  /// Exists; empty = nothing is written. A replay writes its journal there, and what rules write.
  std::filesystem::path run_folder;
  RunSpec spec;
  std::vector<Seat> seats = {};       ///< agents that are programs, after those of the scenario
  std::vector<PastAct> acts = {};     ///< what a former run's program did between ticks, which is done again
  cx::RunControl* control = nullptr;  ///< of a person, or of what is planned; may be none
  cx::LogSink* log = nullptr;         ///< lines of environments and nodes; may be none
  WallMeters meters;
  std::filesystem::path interfaces;  ///< folder of the packages that come with cxlab
  std::filesystem::path models;      ///< MJCF parts
  std::optional<ReplaySource> replay;
  Counting counting = Counting::kNothing;                               ///< what engines count
  std::function<void(const cx::Environment&)> on_environment_end = {};  ///< `cx::RunSettings::on_environment_end`
  std::function<void(const std::filesystem::path&)> file_read = {};     ///< called with each file that is read
};

/// What a step was.
struct StepReport {
  SimTime now{};           ///< time of the last tick; before the first: less than 0
  std::int64_t ticks = 0;  ///< that it played
  bool over = false;       ///< another step plays none
};

class Episode {
 public:
  /// Reads everything that the scenario names. Nothing has run yet.
  static Expected<std::unique_ptr<Episode>> load(Scenario scenario, EpisodeOptions options);
  ~Episode();
  Episode(const Episode&) = delete;
  Episode& operator=(const Episode&) = delete;

  /// What it reaches of the machine from now on. Before `start`.
  Wall wall() const;
  /// Activation: plugins, reset, first run. Before tick 0.
  Status start();
  /// One tick (cx/run/loop.h).
  Status tick() { return tick_at(next_tick()); }
  /// The same for who has asked next_tick() already.
  Status tick_at(SimTime next);
  /// Plays the ticks up to that time, one at it included. In steps an episode is byte for byte the one in ticks.
  Expected<StepReport> step(SimTime until);
  /// A seat that joins now, between two ticks: as one that was there from the start, but later.
  Status join(const Seat& seat);
  /// Does something in an environment between two ticks: the value of an evaluation, the fact ("f-12"), or nothing. It
  /// is an input from outside, which the log has. What it changes counts when the rules run next.
  Expected<std::string> act(cx::Environment& environment, cx::ControlAct::Verb verb, const std::string& text);
  /// Whether the duration has passed, the referee has ended the game, or rules asked for the end.
  bool over() const;
  /// Whether it has ended by itself: duration or game.
  bool completed() const;
  /// Deactivates the agents and ends the files. `failure` is what ended the run early, if anything did. A run that was
  /// stopped in the middle of a tick has no hashes: it cannot be played again to the same place.
  Result close(RunStatus status, std::optional<Error> failure = {});

  /// What the journal and the log of inputs hold reaches their files at once: the process may end at any time.
  void flush() {
    (void)journal_.flush();
    inputs_->flush();
    if (scene_log_) (void)scene_log_->flush();
  }

  SimTime next_tick() const { return loop_->next_tick(); }  ///< time of the next tick
  SimTime now() const { return loop_->now(); }              ///< time of the last tick; before the first: less than 0
  const Scenario& scenario() const { return scenario_; }
  Stage& stage() { return *stage_; }
  /// What there is to see in the world now. A replay of rules has no world, and no entities.
  Scene scene() const;
  bus::Bus& bus() { return *bus_; }
  Journal& journal() { return journal_; }
  std::vector<std::unique_ptr<cx::EnvironmentManager>>& agents() { return agents_; }
  /// The present environments of all agents.
  std::vector<cx::Environment*> environments() const;
  /// In a replay: how far the log goes, and whether it is whole; success where nothing is replayed.
  SimTime replay_end() const { return inputs_->end(); }
  Status replay_log_status() const { return inputs_->log_status(); }
  /// The result so far, without the measurements of the caller.
  Result result() const;
  /// The same as `result().at(path)`. For a path in a section of the world, only that section is made.
  std::string result_at(const std::string& path) const;

 private:
  Episode(Scenario scenario, EpisodeOptions options);

  // Assembly (episode_assembly.cpp), in this order
  Status open_files();
  Status build_bus();
  Status build_stage();
  Status build_stimuli();
  Status build_bag();
  Status open_sockets();
  Status build_agents();
  Status build_seats();
  Status seat_agent(const Seat& seat);
  Status check_stimuli();
  std::vector<std::string> manager_names() const;
  cx::ManagerOptions manager_options(std::size_t agent);
  void build_loop();

  /// The next tick comes at `next`: writes the scene until then to its file.
  void write_scene(SimTime next);
  /// Writes the inputs so far to the log. Returns whether all files could be written so far.
  Status write_out();
  /// What the world and the nodes beside it say. `only`: see `Result::only`.
  Result reported(std::string only = {}) const;
  /// Does what the program of the recorded run did after the last tick.
  Status repeat_acts();

  Scenario scenario_;
  EpisodeOptions options_;
  LimitsInUse limits_;
  std::vector<Shares> shares_;  // by agent
  std::vector<std::string> strange_configs_;
  Journal journal_;
  std::optional<KeptFiles> files_;
  bus::Registry registry_;
  std::unique_ptr<bus::Bus> bus_;
  std::unique_ptr<net::Network> network_;
  std::unique_ptr<Inputs> inputs_;
  std::unique_ptr<Stage> stage_;
  cx::RunControl* control_ = nullptr;  ///< that of the stage, of the caller, or both; may be none
  std::optional<cx::BothControls> both_;
  std::optional<SceneWriter> scene_log_;         ///< none: nothing is written
  std::unique_ptr<ScratchFolder> rules_folder_;  ///< what rules write where the run has no folder
  std::vector<std::unique_ptr<cx::EnvironmentManager>> agents_;
  std::vector<std::unique_ptr<Agent>> seats_;
  std::size_t next_seat_ = 0, next_act_ = 0;      ///< of those of a former run, in order of their time
  std::vector<std::unique_ptr<Agent>> measured_;  ///< around the agents, where they are measured
  std::optional<Loop> loop_;
};

/// The node of an agent's environment manager, as its remaps name it.
bus::NodeName manager_node(const AgentSpec& agent);

}  // namespace cxlab
