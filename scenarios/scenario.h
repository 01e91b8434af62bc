#pragma once
// A scenario: everything that an episode is made of. The structs are the schema: each field has its unit and default.
// A scenario is read from a YAML file, whose unknown keys are errors, or filled by code.

#include <any>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/bag/bag_spec.h"
#include "cx/base/expected.h"
#include "cx/base/origin.h"
#include "cx/base/time.h"
#include "cx/node/parameters.h"
#include "cx/yaml/writer.h"
#include "cx/yaml/yaml.h"

namespace cxlab {

struct Catalogue;
struct NodeKind;
struct SectionKind;
struct WorldKind;

enum class Tier : std::uint8_t { kPhysics, kTimed };
std::string_view to_string(Tier tier);  ///< "physics" "timed"

/// The folder of a package, relative to the scenario's.
struct PackageSpec {
  std::string folder;
  Origin origin{};
};

/// One environment manager with its environments.
struct AgentSpec {
  std::string config;  ///< YAML of the CX, relative to the scenario's folder
  Origin config_origin{};
  std::string name_space = "/";
  std::vector<std::pair<std::string, std::string>> remaps{};  ///< FROM := TO
  std::map<std::string, PackageSpec> packages{};
  std::vector<cx::GivenParameter> params{};
  bool activate = true;  ///< configured and activated at the start; else only with its parameter `autostart_node`
};

/// A world, node or section of a kind (scenarios/catalogue.h) with its settings.
template <class Kind>
struct Chosen {
  const Kind* kind = nullptr;
  std::any config{};  ///< a struct of the kind's own; empty = its defaults
  Origin origin{};

  /// `config`, which is of that type or empty.
  template <class Config>
  const Config& get() const {
    static const Config kDefaults{};
    return config.has_value() ? std::any_cast<const Config&>(config) : kDefaults;
  }
};
using WorldSpec = Chosen<WorldKind>;
/// A node beside world and agents.
using ServerSpec = Chosen<NodeKind>;
/// A part of the scenario that worlds or nodes read: the key is the kind's.
using SectionSpec = Chosen<SectionKind>;

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
  std::string target{};   ///< topic, service, action, NODE.NAME of a parameter, environment or node
  std::string type{};     ///< interface
  std::string content{};  ///< data, request, response, goal or value as YAML
  std::string plugin{};   ///< to load or unload
  std::string manager{};  ///< of the environment; empty = the only one
  Origin origin{};
  bool to_a_node_there = false;  ///< a call of a service that must exist before the first tick
};

/// A file that settings name.
struct NamedFile {
  std::filesystem::path path;
  Origin origin{};
};

/// What must hold of the result; otherwise `cxlab run` ends with exit code 1.
struct Expectation {
  std::string path;  ///< into result.json, for example "teams.CYAN.points"
  std::optional<double> min{}, max{};
  std::optional<std::string> equals{};
  Origin origin{};

  template <class Keys>
  void fields(Keys& keys) {
    keys.required("path", path);
    keys("min", min);
    keys("max", max);
    keys("equals", equals);
  }
};

/// A value changed on the command line: PATH=VALUE, and the option that errors in it name.
struct Override {
  std::string assignment, option;
  Override(std::string set) : assignment(std::move(set)), option("--set " + assignment) {}
  Override(const char* set) : Override(std::string(set)) {}
  Override(std::string set, std::string from) : assignment(std::move(set)), option(std::move(from)) {}
};

/// The world that is nothing: agents and nodes on the bus alone.
extern const WorldKind kEmptyWorld;

struct Scenario {
  std::string name = "scenario";       ///< the file's name without extension
  std::filesystem::path file;          ///< paths are relative to its folder; it need not exist
  std::string text;                    ///< of the file; empty = the scenario was built by code
  std::vector<std::string> overrides;  ///< PATH=VALUE, as given beside the text

  WorldSpec world{&kEmptyWorld};
  /// By key of the world's settings: what it names (WorldKind::files), found from the scenario's folder; from the
  /// current one if an override names it.
  std::map<std::string, NamedFile> world_files;
  std::vector<ServerSpec> servers;

  Tier tier = Tier::kPhysics;
  std::uint64_t seed = 1;
  double epoch = 1767225600;  ///< s since 1970 at simulated time 0 (default 2026-01-01)
  SimTime duration = from_seconds(60);
  SimTime tick = from_seconds(0.02);
  SimTime physics_step = from_seconds(0.01);
  std::map<std::string, PackageSpec> packages;  ///< interface and share folders, for all agents
  std::vector<AgentSpec> agents;
  std::vector<Stimulus> stimuli;               ///< in order of time
  bag::BagSpec bag;                            ///< a recording that is played; its file from the scenario's folder
  std::vector<SectionSpec> sections;           ///< at most one of each kind
  bool stop_on_rule_error = true;              ///< on_rule_error: stop | continue
  std::int64_t max_firings_per_tick = 100000;  ///< 0 = no limit
  bool trust_rules = false;
  std::vector<Expectation> expect;

  /// Reads the file, applies the overrides, checks everything that can be checked without loading more. The catalogue
  /// has the worlds and nodes that it may name, and outlives the scenario.
  static Expected<Scenario> load(const std::filesystem::path& file, const Catalogue& catalogue,
                                 const std::vector<Override>& overrides = {});
  /// The same from its text; `file` names it in errors, and paths are relative to its folder.
  static Expected<Scenario> parse(const std::string& text, const std::filesystem::path& file,
                                  const Catalogue& catalogue, const std::vector<Override>& overrides = {});
  /// The scenario as YAML, from which `parse` makes it again: for the copy that a run's folder keeps.
  std::string to_yaml() const;

  /// The settings of that section, which are of that type; their defaults if it is not there.
  template <class Config>
  const Config& section(const SectionKind& kind) const {
    static const SectionSpec kNone{};
    for (const SectionSpec& spec : sections)
      if (spec.kind == &kind) return spec.get<Config>();
    return kNone.get<Config>();
  }
  /// Sets the world, and duration, tick, step and tier to its defaults.
  void set_world(WorldSpec spec);
  /// "physics" or "timed"; "none" in a world that has neither.
  std::string_view tier_name() const;
  /// `relative` as a path from the scenario's folder.
  std::filesystem::path resolve(const std::string& relative) const;
  /// The share directory of each package that an agent sees: an absolute path without '.' or '..'.
  std::map<std::string, std::string> shares(const AgentSpec& agent) const;
  /// A warning where the agent's configuration lies in a package that its packages have in another folder; else empty.
  std::string strange_config(const AgentSpec& agent) const;
};

/// A list of stimuli, from a scenario or from a file of its own.
std::vector<Stimulus> read_stimuli(const yaml::Value& list);
yaml::Writer write_stimulus(const Stimulus& stimulus);
/// The key `bag` of a scenario. A file that an option names is looked for from the current folder.
void read_bag(yaml::Map& scenario, bag::BagSpec& bag);
/// By time; those of one time keep their order.
void sort_stimuli(std::vector<Stimulus>& stimuli);

}  // namespace cxlab
