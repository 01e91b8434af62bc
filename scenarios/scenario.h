#pragma once
// A scenario: everything that an episode is made of, read from one YAML file. The structs are the schema: each field
// has its unit and default. Unknown keys are errors.

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/time.h"
#include "cx/node/parameters.h"
#include "cx/yaml/yaml.h"
#include "planner/cost.h"
#include "scenarios/pddl/config.h"
#include "scenarios/rcll/read_config.h"
#include "scenarios/turtlesim/config.h"
#include "sim/faults/fault.h"
#include "sim/skills/timed_skills.h"

namespace cxlab {

enum class Tier : std::uint8_t { kPhysics, kTimed };

/// One environment manager with its environments.
struct AgentSpec {
  std::string config;  ///< YAML of the CX, relative to the scenario file
  std::string name_space = "/";
  std::vector<std::pair<std::string, std::string>> remaps;  ///< FROM := TO
  std::map<std::string, std::string> packages;              ///< package -> folder, relative to the scenario file
  std::map<std::string, int> package_lines;                 ///< where they stand, for errors
  std::vector<cx::GivenParameter> params;
  bool activate = true;  ///< configured and activated at the start; else only with its parameter `autostart_node`
};

/// A node beside world and agents: an item of `servers:` (scenarios/nodes.h).
struct ServerSpec {
  std::string node;             ///< which kind
  turtlesim::Config turtlesim;  ///< of kind turtlesim
  pddl::Config pddl;            ///< of kind pddl_manager
};

/// Something that happens at a time whatever the rules do: exactly one of the verbs.
struct Stimulus {
  enum class Verb {
    kPublish,
    kCall,
    kServe,
    kSendGoal,
    kCancelGoal,
    kSetParam,
    kLoadPlugin,
    kUnloadPlugin,
    kCreateEnv,
    kDestroyEnv,
    kStopNode
  };
  SimTime at{};
  Verb verb{};
  std::string target;   ///< topic, service, action, NODE.NAME of a parameter, environment or node
  std::string type;     ///< interface
  std::string content;  ///< data, request, response, goal or value as YAML
  std::string plugin;   ///< to load or unload
  std::string manager;  ///< of the environment; empty = the only one
  std::string file;     ///< where it stands, for errors
  int line = 0;
};

/// What must hold of the result; otherwise `cxlab run` ends with exit code 1.
struct Expectation {
  std::string path;  ///< into result.json, e.g. "teams.CYAN.points"
  std::optional<double> min, max;
  std::optional<std::string> equals;
  int line = 0;
};

struct Scenario {
  std::string name;  ///< the file's name without extension
  std::filesystem::path file;
  std::string text;                    ///< of the file
  std::vector<std::string> overrides;  ///< as given by --set

  enum class WorldKind { kNone, kRcll, kTurtlesim };
  WorldKind world_kind = WorldKind::kNone;
  rcll::WorldConfig rcll;           ///< of kind rcll
  turtlesim::Config turtlesim;      ///< of kind turtlesim
  std::vector<ServerSpec> servers;  ///< nodes beside the world

  Tier tier = Tier::kPhysics;
  sim::TimedSkillsConfig timed;  ///< durations and failures of the timed tier
  std::uint64_t seed = 1;
  double epoch = 1767225600;  ///< s since 1970 at simulated time 0 (default 2026-01-01)
  SimTime duration = from_seconds(60);
  SimTime tick = from_seconds(0.02);
  SimTime physics_step = from_seconds(0.01);
  std::map<std::string, std::string> packages;  ///< interface and share folders, for all agents
  std::map<std::string, int> package_lines;     ///< where they stand, for errors
  std::vector<AgentSpec> agents;
  planner::PlanningCost planner;  ///< what plans cost in simulated time
  std::vector<Stimulus> stimuli;
  std::vector<sim::Fault> faults;              ///< what goes wrong with robots and machines
  bool stop_on_rule_error = true;              ///< on_rule_error: stop | continue
  std::int64_t max_firings_per_tick = 100000;  ///< 0 = no limit
  bool trust_rules = false;
  std::vector<Expectation> expect;

  /// Reads the file, applies the overrides, checks everything that can be checked without loading more.
  static Expected<Scenario> load(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});
  /// The same from its text; `file` names it in errors, and paths are relative to its folder.
  static Expected<Scenario> parse(const std::string& text, const std::filesystem::path& file,
                                  const std::vector<std::string>& overrides = {});
  /// `relative` as a path from the scenario's folder.
  std::filesystem::path resolve(const std::string& relative) const;
  /// The share directory of each package that an agent sees: an absolute path without '.' or '..'.
  std::map<std::string, std::string> shares(const AgentSpec& agent) const;
};

/// A list of stimuli, from a scenario or from a file of its own.
std::vector<Stimulus> read_stimuli(const yaml::Value& list);
/// The list below `faults:`.
std::vector<sim::Fault> read_faults(const yaml::Value& list);

}  // namespace cxlab
