#include "lab/env_scenario.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "cx/bag/bag_server.h"
#include "cx/base/file.h"
#include "cx/base/number_text.h"
#include "cx/bus/names.h"
#include "cx/executive/environment_manager.h"
#include "cx/executive/reach.h"
#include "cx/yaml/yaml.h"
#include "lab/packages.h"
#include "scenarios/episode.h"
#include "scenarios/share.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;

/// "A=B" as (A, B).
Expected<std::pair<std::string, std::string>> split(const std::string& option, const std::string& text,
                                                    const std::string& sign, const char* form) {
  const std::size_t at = text.find(sign);
  if (at == std::string::npos || at == 0) return usage_error(option + ": " + found_text(text, form));
  return std::pair(text.substr(0, at), text.substr(at + sign.size()));
}

// --- Packages around a configuration

/// The package that a configuration lies in: the nearest folder above it with a package.xml; without one, or below the
/// folder share of a prefix, the folder above "params" or "config", or the folder of the file.
fs::path package_of(const fs::path& config) {
  fs::path usual = config.parent_path();
  if (usual.filename() == "params" || usual.filename() == "config") usual = usual.parent_path();
  if (usual.parent_path().filename() == "share") return usual;
  return nearest_package(config.parent_path()).value_or(usual);
}

/// Packages beside this one: those with a package.xml in the folder that it lies in; in the folder share of a prefix,
/// also those that only have a manifest or definitions, as our CMake makes them; and those of an install space with a
/// prefix for each package (install/NAME/share/NAME, as colcon makes it).
std::set<fs::path> neighbours_of(const fs::path& package) {
  std::error_code ignored;
  std::set<fs::path> found;
  const auto add = [&](const fs::path& folder) {
    if (fs::is_regular_file(folder / "package.xml", ignored)) found.insert(folder);
  };
  const fs::path share = package.parent_path(), prefix = share.parent_path();
  if (share.filename() == "share")
    if (const auto below = packages_below({prefix.string()}))
      for (const auto& [name, folder] : *below) found.insert(folder);
  if (!is_file(package / "package.xml")) return found;
  for (const auto& entry : fs::directory_iterator(share, ignored)) add(entry.path());
  if (share.filename() == "share" && prefix.filename() == package.filename())
    for (const auto& entry : fs::directory_iterator(prefix.parent_path(), ignored))
      add(entry.path() / "share" / entry.path().filename());
  return found;
}

/// Those named by the user, else those around the configurations: theirs, and the packages beside these.
Status add_packages(const EnvOptions& options, Scenario& scenario) {
  auto named = named_packages(options.packages);
  if (!named) return named.error();
  for (const auto& [name, folder] : *named) scenario.packages[name] = {folder, {"--package " + name + '=' + folder}};
  for (const std::string& config : options.configs) {
    const fs::path own = package_of(fs::absolute(config).lexically_normal());
    if (!options.trust_rules && cx::holds_a_home(own)) {
      if (!options.packages.empty()) continue;
      return input_error("lies in " + own.string() +
                             ", so that all of it would be the package that rules may read; expected a folder of its "
                             "own, or its package by --package NAME=DIR",
                         config);
    }
    scenario.packages.emplace(package_name(own), PackageSpec{own.string()});
    for (const fs::path& neighbour : neighbours_of(own))
      scenario.packages.emplace(package_name(neighbour), PackageSpec{neighbour.string()});
  }
  return {};
}

// --- World, nodes, agents

const WorldKind* find_world(const Catalogue& catalogue, const std::string& name) {
  const WorldKind* kind = catalogue.find_world(name);
  return kind == &kEmptyWorld ? nullptr : kind;
}

/// The first of `with` that is no node, else the first that is a world as well; nullptr if there is none.
const WorldKind* world_among(const EnvOptions& options, const Catalogue& catalogue) {
  const WorldKind* either = nullptr;
  for (const std::string& name : options.with) {
    const WorldKind* kind = find_world(catalogue, name);
    if (kind && !catalogue.find_node(name)) return kind;
    if (!either) either = kind;
  }
  return either;
}

Status check_companions(const EnvOptions& options, const Catalogue& catalogue, const WorldKind* world) {
  std::set<std::string> seen;
  for (const std::string& name : options.with) {
    if (!seen.insert(name).second) return usage_error("--with: '" + name + "' was named twice");
    if ((world && name == world->name) || catalogue.find_node(name)) continue;
    if (find_world(catalogue, name))
      return usage_error("--with: " +
                         found_expected("the worlds '" + std::string(world->name) + "' and '" + name + "'", "one"));
    std::vector<std::string> known;
    for (const WorldKind* kind : catalogue.worlds) known.emplace_back(kind->name);
    for (const NodeKind* kind : catalogue.nodes) known.emplace_back(kind->name);
    return usage_error("--with: " +
                       found_text(name, "one of: " + known_companions(catalogue) + did_you_mean(name, known, "; ")));
  }
  return {};
}

/// Reads the settings of a world or node from the --param options that begin with its name. Their paths below `at`
/// are what errors show.
template <class Kind>
Expected<Chosen<Kind>> chosen(const Kind& kind, const std::string& at, const std::vector<std::string>& params) {
  Chosen<Kind> out{&kind, {}, {"--with " + std::string(kind.name)}};
  auto document = yaml::Document::parse("{" + at + ": {}}", out.origin.source);
  if (!document) return document.error();
  const std::string prefix = std::string(kind.name) + '.';
  for (const std::string& param : params) {
    auto named = split("--param", param, "=", "NODE.NAME=VALUE");
    if (!named) return named.error();
    if (!named->first.starts_with(prefix)) continue;
    if (Status s = document->set(at + '.' + named->first.substr(prefix.size()), named->second, "--param " + param); !s)
      return s.error();
  }
  yaml::Map root = document->root().as_map(), keys = root.get(at).as_map();
  if (kind.settings.read) kind.settings.read(keys, out.config);
  keys.finish();
  if (Status s = document->status(); !s) return s.error();
  return out;
}

Status add_companions(const EnvOptions& options, const Catalogue& catalogue, Scenario& scenario) {
  const WorldKind* world = world_among(options, catalogue);
  if (Status s = check_companions(options, catalogue, world); !s) return s;
  if (world) {
    auto spec = chosen(*world, "world", options.params);
    if (!spec) return spec.error();
    scenario.set_world(*std::move(spec));
  }
  for (const std::string& name : options.with) {
    if (world && name == world->name) continue;
    auto spec = chosen(*catalogue.find_node(name), name, options.params);
    if (!spec) return spec.error();
    scenario.servers.push_back(*std::move(spec));
  }
  return {};
}

bool is_of(const std::string& param, const std::vector<std::string>& nodes) {
  return std::ranges::any_of(nodes, [&](const std::string& node) { return param.starts_with(node + '.'); });
}

/// The parameters of the managers; each --param is for a node that there will be.
Expected<std::vector<cx::GivenParameter>> manager_params(const EnvOptions& options, const AgentSpec& agent) {
  const bus::NodeName manager = manager_node(agent);
  std::vector<cx::GivenParameter> out;
  for (const std::string& param : options.params) {
    if (is_of(param, options.with)) continue;
    auto named = split("--param", param, "=", "NODE.NAME=VALUE");
    if (!named) return named.error();
    const std::string option = "--param " + param;
    if (!is_of(param, {manager.name, manager.full_name()})) {
      std::string names = manager.name;
      for (const std::string& node : options.with) names += ", " + node;
      return usage_error("--param: " + found_text(param, "NODE.NAME=VALUE with one of the nodes " + names));
    }
    auto value = yaml::Document::parse(named->second, option);
    if (!value) return value.error();
    out.push_back({named->first, value->root().dump(), {option}});
  }
  return out;
}

Status add_agents(const EnvOptions& options, Scenario& scenario) {
  AgentSpec agent;
  agent.name_space = options.name_space;
  agent.activate = options.activate;
  if (const std::string fault = bus::namespace_fault(agent.name_space); !fault.empty())
    return usage_error("--namespace: the name '" + agent.name_space + "' " + fault);
  for (const std::string& remap : options.remaps) {
    auto names = split("--remap", remap, ":=", "FROM:=TO");
    if (!names) return names.error();
    if (const std::string fault = bus::remap_fault(*names); !fault.empty())
      return usage_error("--remap " + remap + ": " + fault);
    agent.remaps.push_back(*std::move(names));
  }
  auto params = manager_params(options, agent);
  if (!params) return params.error();
  agent.params = *std::move(params);
  const bus::NodeName manager = manager_node(agent);
  for (const std::string& config : options.configs) {
    if (auto read = cx::Parameters::load(config, manager.name, manager.name_space); !read) return read.error();
    agent.config = fs::absolute(config).lexically_normal().string();
    scenario.agents.push_back(agent);
  }
  return {};
}

// --- Stimuli

/// A transition of a manager, as the call that asks for it.
Expected<Stimulus> transition(const Scenario& scenario, const std::string& text) {
  const char* form = "SECONDS:NAME or SECONDS:NAME@NODE";
  auto parts = split("--transition", text, ":", form);
  if (!parts) return parts.error();
  const auto at = read_number<double>(parts->first);
  if (!at || !(*at >= 0 && *at < 1e9)) return usage_error("--transition: " + found_text(text, form));
  const std::size_t where = parts->second.find('@');
  const std::string name = parts->second.substr(0, where);
  const std::vector<std::string> known{"configure", "activate", "deactivate", "cleanup", "shutdown"};
  if (std::ranges::find(known, name) == known.end())
    return usage_error("--transition: " + found_text(name, "configure, activate, deactivate, cleanup or shutdown" +
                                                               did_you_mean(name, known, "; ")));
  if (where + 1 == parts->second.size()) return usage_error("--transition: " + found_text(text, form));
  const std::string node =
      where == std::string::npos ? manager_node(scenario.agents.front()).full_name() : parts->second.substr(where + 1);
  return Stimulus{.at = from_seconds(*at),
                  .verb = Stimulus::Verb::kCall,
                  .target = node + "/change_state",
                  .type = "lifecycle_msgs/srv/ChangeState",
                  .content = "{transition: {label: " + name + "}}",
                  .origin = {"--transition " + text},
                  .to_a_node_there = true};
}

Status add_stimuli(const EnvOptions& options, Scenario& scenario) {
  if (!options.stimuli.empty()) {
    auto file = yaml::Document::load(options.stimuli);
    if (!file) return file.error();
    scenario.stimuli = read_stimuli(file->root());
    if (Status s = file->status(); !s) return s;
  }
  for (const std::string& text : options.transitions) {
    auto call = transition(scenario, text);
    if (!call) return call.error();
    scenario.stimuli.push_back(*std::move(call));
  }
  sort_stimuli(scenario.stimuli);
  return {};
}

// --- A recording

constexpr double kDefaultEnd = 60;  // s

/// The bag that is played, and the end of the run.
Status add_bag(const EnvOptions& options, Scenario& scenario) {
  auto changes = overrides_of(options.bag);
  if (!changes) return changes.error();
  auto document = yaml::Document::parse("{}", "--bag");
  if (!document) return document.error();
  for (const Override& change : *changes)
    if (Status s = document->set(change.assignment, change.option); !s) return s;
  yaml::Map keys = document->root().as_map();
  read_bag(keys, scenario.bag);
  if (Status s = document->status(); !s) return s;
  scenario.duration = from_seconds(options.until.value_or(kDefaultEnd));
  if (options.until || !scenario.bag) return {};
  const auto recording = bag::Recording::open(scenario.bag.file);
  if (!recording) return at(scenario.bag.origin, recording.error());
  scenario.duration = bag::end_of(*recording, scenario.bag) + std::chrono::seconds(1);
  return {};
}

}  // namespace

std::vector<Companion> companions(const Catalogue& catalogue) {
  std::vector<Companion> all;
  for (const WorldKind* kind : catalogue.worlds)
    if (kind != &kEmptyWorld && !catalogue.find_node(kind->name)) all.push_back({kind->name, kind->what});
  for (const NodeKind* kind : catalogue.nodes) all.push_back({kind->name, kind->what});
  return all;
}

std::string known_companions(const Catalogue& catalogue) {
  std::string known;
  for (const Companion& companion : companions(catalogue))
    known += (known.empty() ? "" : "; ") + std::string(companion.name) + ", " + std::string(companion.what);
  return known;
}

Expected<Scenario> env_scenario(const EnvOptions& options, const Catalogue& catalogue) {
  for (const std::string& config : options.configs) {
    if (is_folder(config)) return input_error("is a folder, expected a configuration (YAML)", config);
  }
  Scenario scenario;
  scenario.name = fs::path(options.configs.front()).stem().string();
  scenario.file = scenario.name + ".yaml";
  for (const auto add : {add_agents, add_packages, add_stimuli})
    if (Status s = add(options, scenario); !s) return s.error();
  if (Status s = add_companions(options, catalogue, scenario); !s) return s.error();
  if (Status s = add_bag(options, scenario); !s) return s.error();
  scenario.stop_on_rule_error = options.stop_on_rule_error;
  scenario.trust_rules = options.trust_rules;
  scenario.seed = options.seed.value_or(scenario.seed);
  scenario.max_firings_per_tick = options.max_firings.value_or(scenario.max_firings_per_tick);
  return scenario;
}

}  // namespace cxlab::lab
