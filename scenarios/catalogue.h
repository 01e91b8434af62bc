#pragma once
// What a scenario can name: kinds of worlds, and kinds of nodes that stand beside one. Each is a row, a constant of its
// folder; scenarios/shipped/catalogue.h lists those that come with cxlab. docs/how-to/write-a-world.md shows how to add
// one.

#include <any>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/record_sink.h"
#include "cx/base/time.h"
#include "cx/bus/bus.h"
#include "cx/network/network.h"
#include "cx/node/log.h"
#include "cx/yaml/writer.h"
#include "cx/yaml/yaml.h"
#include "scenarios/metric.h"
#include "scenarios/question.h"
#include "scenarios/result.h"
#include "scenarios/run_page.h"
#include "scenarios/scenario.h"
#include "scenarios/scene_log.h"
#include "scenarios/stage.h"

namespace cxlab {

/// What worlds and nodes are made with; all of it outlives the stage.
struct StageSetup {
  const Scenario& scenario;
  bus::Bus& bus;
  RecordSink& sink;
  net::Network* network = nullptr;     ///< that agents speak over: ports of nodes are opened on it (cx/network/host.h)
  cx::LogSink* log = nullptr;          ///< may be none
  std::filesystem::path models{};      ///< MJCF parts
  std::filesystem::path run_folder{};  ///< empty = nothing is written
  bool programs = true;                ///< nodes may start programs that the scenario names
  /// Called with each file that a node reads, before it does, for the run's copy; may be empty.
  std::function<Status(const std::string& logical_name, const std::filesystem::path& file)> keep{};
};

/// What the physics of a recorded run is played again with; all of it outlives the replay.
struct ReplaySetup {
  const Scenario& scenario;
  std::filesystem::path models;   ///< that the run read
  const std::string& log;         ///< what `Stage::take_inputs` gave
  std::filesystem::path journal;  ///< of the run; need not be there, and is for pictures only
};

/// What a recorded run without physics is looked at with; the scenario outlives it.
struct SceneSetup {
  const Scenario& scenario;
  std::filesystem::path models;   ///< that come with cxlab
  SceneReader scenes;             ///< of the run
  std::filesystem::path journal;  ///< of the run; need not be there
};

/// How the settings of a kind are read and written; `settings_of` makes one.
struct Settings {
  void (*read)(yaml::Map& keys, std::any& config) = nullptr;  ///< none: the kind has no keys
  yaml::Writer (*write)(const std::any& config) = nullptr;    ///< the keys that are not the defaults
};

/// A section of a scenario beside `world:` and `servers:`, for kinds that share it: a key and what is below it.
/// `section_of` makes one. A key counts only where a kind of the catalogue reads it.
struct SectionKind {
  std::string_view key;
  void (*read)(const yaml::Value& value, std::any& config) = nullptr;
  yaml::Writer (*write)(std::string_view key, const std::any& config) = nullptr;  ///< nothing for defaults
  /// The error for this key in a world that does not read it; none: the key has no effect there.
  std::string_view elsewhere{};
};

/// A part of result.json that a kind of world or node adds: the value of a key (Result::set).
struct ResultSection {
  std::string_view key;
  std::string_view what;     ///< one line for people
  std::string_view initial;  ///< the value of a run that has only begun, as JSON: "[]", "{}"
  /// The value with one of everything, as JSON: what metrics and the paths of `expect:` may name. None: `initial`.
  std::string (*sample)() = nullptr;
};

/// A kind of world: `world: {kind: NAME, ...}`.
struct WorldKind {
  std::string_view name;
  std::string_view what;  ///< one line for people
  Settings settings{};
  std::span<const SectionKind* const> reads{};  ///< sections of the scenario that the world reads (Scenario::section)
  /// Keys of the settings that name a file (Scenario::world_files).
  std::span<const std::string_view> files{};
  /// The one of these whose file says all that chance decides otherwise; `games:` of a suite sets it. Empty: none does.
  std::string_view games_key{};

  SimTime duration = std::chrono::seconds(60);  ///< default, as tick and step
  SimTime tick = std::chrono::milliseconds(20);
  SimTime physics_step = std::chrono::milliseconds(10);
  /// Sets those defaults of a scenario that depend on the world's settings; may be none.
  void (*set_defaults)(Scenario& scenario) = nullptr;
  std::span<const Tier> tiers{};  ///< the first is the default; none: neither physics nor timed
  bool any_tick = false;          ///< tick_s need not be a whole multiple of physics_step_s

  Expected<std::unique_ptr<Stage>> (*make_stage)(const StageSetup& setup) = nullptr;
  /// The physics of a recorded run at its start; none: this world cannot be replayed.
  Expected<std::unique_ptr<WorldReplay>> (*replay)(const ReplaySetup& setup) = nullptr;
  /// A recorded run without physics as its scene shows it; none: there is nothing to look at.
  Expected<std::unique_ptr<RecordedWorld>> (*show)(SceneSetup setup) = nullptr;
  /// What the stage adds to result.json; a run that fails early has these as well.
  std::span<const ResultSection> sections{};
  /// By which runs are compared, the first one before all others.
  std::span<const Metric> metrics{};
  /// What can be asked about a recorded run of this world, each a command of `cxlab`.
  std::span<const WorldQuestion> questions{};
  /// What of a record people hear of: rows of the page's events, and captions of films, where it is called while the
  /// run is played, too. Records are those of `kRecordsOfQuestions`, in order of writing; errors of rules are added by
  /// whoever asks. None: nothing.
  void (*happened)(const Scenario& scenario, const JournalRecord& record, std::vector<PageEvent>& out) = nullptr;
  /// What the page of a run shows of this world; none: nothing but how the run ended.
  Expected<RunPage> (*page)(const AskedRun& run, const Result& result) = nullptr;
};

/// A kind of node beside the world: an item of `servers:`, `cxlab env --with NAME`.
struct NodeKind {
  std::string_view name;
  std::string_view what;  ///< one line for people
  Settings settings{};
  std::span<const SectionKind* const> reads{};  ///< sections of the scenario that the node reads (Scenario::section)
  /// Puts the node on the stage.
  Status (*add)(const ServerSpec& spec, const StageSetup& setup, Stage& stage) = nullptr;
  std::span<const ResultSection> sections{};  ///< that it adds to result.json
};

struct Catalogue {
  std::vector<const WorldKind*> worlds;
  std::vector<const NodeKind*> nodes;

  /// nullptr if there is none of that name.
  const WorldKind* find_world(std::string_view name) const;
  const NodeKind* find_node(std::string_view name) const;
  /// All that its worlds and nodes read, in their order, each once.
  std::vector<const SectionKind*> sections() const;
};

/// As `games_key`, the path for `--set` and suites: "world.game"; empty where the world has none.
std::string games_path(const WorldKind& world);

/// The settings are that struct, read and written by the keys that it lists (yaml::Keyed).
template <yaml::Keyed Config>
constexpr Settings settings_of() {
  return {[](yaml::Map& keys, std::any& config) { keys.read(config.emplace<Config>()); },
          [](const std::any& config) {
            return config.has_value() ? yaml::Writer::changed(std::any_cast<const Config&>(config)) : yaml::Writer();
          }};
}
/// The same for a section.
template <yaml::Keyed Config>
constexpr SectionKind section_of(std::string_view key) {
  return {.key = key,
          .read =
              [](const yaml::Value& value, std::any& config) {
                yaml::Map keys = value.as_map();
                keys.read(config.emplace<Config>());
                keys.finish();
              },
          .write =
              [](std::string_view name, const std::any& config) {
                yaml::Writer out;
                if (const auto changed = settings_of<Config>().write(config); !changed.empty()) out.put(name, changed);
                return out;
              }};
}

}  // namespace cxlab
