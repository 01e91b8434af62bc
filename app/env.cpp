// cxlab env: an unchanged configuration of the CX, with an empty world or the nodes named.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <set>

#include "app/arguments.h"
#include "app/command.h"
#include "app/play.h"
#include "cx/bus/names.h"
#include "cx/executive/environment_manager.h"
#include "cx/journal/file_store.h"
#include "cx/yaml/yaml.h"
#include "scenarios/nodes.h"
#include "scenarios/share.h"

namespace cxlab::app {

namespace {

namespace fs = std::filesystem;

constexpr double kDefaultEnd = 60;  // s

struct Options {
  std::vector<std::string> configs, nodes, packages, params, remaps;
  std::string name_space = "/", stimuli;
  std::vector<std::string> transitions;
  bool trust_rules = false, stop = false, activate = true;
  std::optional<std::int64_t> max_firings;
  PlayCommand run;
  std::optional<std::uint64_t> seed;
};

Error usage(std::string message) { return usage_error(std::move(message)); }

/// "A=B" as (A, B).
Expected<std::pair<std::string, std::string>> split(const std::string& option, const std::string& text,
                                                    const std::string& sign, const char* form) {
  const std::size_t at = text.find(sign);
  if (at == std::string::npos || at == 0) return usage(option + ": found '" + text + "', expected " + form);
  return std::pair(text.substr(0, at), text.substr(at + sign.size()));
}

/// The end of a line of the scenario that was made from this option: errors in it are blamed on the option.
constexpr const char* kFrom = "  # from ";

std::string from(const std::string& option) {
  return option.find('\n') == std::string::npos ? kFrom + option + '\n' : "\n";
}

/// The option that the line of an error, or the nearest line before it that has one, was made from.
Error blame_option(Error error, const std::string& text) {
  std::size_t end = 0;
  for (int line = 0; line < error.line && end != std::string::npos; ++line)
    end = text.find('\n', end + (line > 0 ? 1 : 0));
  const std::size_t at = text.substr(0, end).rfind(kFrom);
  if (at == std::string::npos) return error;
  const std::size_t begin = at + std::string_view(kFrom).size();
  error.file = text.substr(begin, text.find('\n', begin) - begin);
  error.line = 0;
  return error;
}

/// A scalar of YAML, whatever is in it.
std::string in_quotes(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

std::string indented(const std::string& text, int columns) {
  const std::string margin(static_cast<std::size_t>(columns), ' ');
  std::string out = margin;
  for (const char c : text) {
    out += c;
    if (c == '\n') out += margin;
  }
  return out + '\n';
}

/// <name> of a package.xml, else the folder's name.
std::string package_name(const fs::path& folder) {
  if (auto text = read_file(folder / "package.xml")) {
    const std::size_t begin = text->find("<name>"), end = text->find("</name>");
    if (begin != std::string::npos && end != std::string::npos && begin < end)
      return text->substr(begin + 6, end - begin - 6);
  }
  return folder.filename().string();
}

/// The package that a configuration lies in: the nearest folder above it with a package.xml; without one, or below the
/// folder share of a prefix, the folder above "params" or "config", or the folder of the file.
fs::path package_of(const fs::path& config) {
  fs::path usual = config.parent_path();
  if (usual.filename() == "params" || usual.filename() == "config") usual = usual.parent_path();
  if (usual.parent_path().filename() == "share") return usual;
  for (fs::path folder = config.parent_path(); folder.has_relative_path(); folder = folder.parent_path())
    if (fs::is_regular_file(folder / "package.xml")) return folder;
  return usual;
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
  if (!fs::is_regular_file(package / "package.xml")) return found;
  for (const auto& entry : fs::directory_iterator(share, ignored)) add(entry.path());
  if (share.filename() == "share" && prefix.filename() == package.filename())
    for (const auto& entry : fs::directory_iterator(prefix.parent_path(), ignored))
      add(entry.path() / "share" / entry.path().filename());
  return found;
}

/// Those named by the user, else those around the configurations: theirs, and the packages beside these.
Expected<std::map<std::string, std::string>> packages_of(const Options& options) {
  std::map<std::string, std::string> packages;
  for (const std::string& config : options.configs) {
    const fs::path own = package_of(fs::absolute(config).lexically_normal());
    packages.emplace(package_name(own), own.string());
    for (const fs::path& neighbour : neighbours_of(own)) packages.emplace(package_name(neighbour), neighbour.string());
  }
  auto named = lab::named_packages(options.packages);
  if (named) named->merge(packages);
  return named;
}

/// The Logistics League is a world of its own, not a node in the list.
constexpr const char* kLeague = "rcll";

std::string known_nodes() {
  std::string known = std::string(kLeague) + ", the Logistics League (docs/rcll.md)";
  for (const NodeKind& kind : node_kinds()) known += "; " + std::string(kind.name) + ", " + std::string(kind.what);
  return known;
}

Status check_nodes(const std::vector<std::string>& nodes) {
  std::set<std::string> seen;
  for (const std::string& node : nodes) {
    if (!seen.insert(node).second) return usage("--with: '" + node + "' was named twice");
    if (node == kLeague || find_node(node)) continue;
    return usage("--with: found '" + node + "', expected one of: " + known_nodes());
  }
  return {};
}

/// What --param says about a node, as lines of its map.
Expected<std::string> settings_of(const std::string& node, const std::vector<std::string>& params, int columns) {
  std::string text;
  const std::string prefix = node + '.', margin(static_cast<std::size_t>(columns), ' ');
  for (const std::string& param : params) {
    auto named = split("--param", param, "=", "NODE.NAME=VALUE");
    if (!named) return named.error();
    if (!named->first.starts_with(prefix)) continue;
    auto value = yaml::Document::parse(named->second, "--param " + named->first);
    if (!value) return value.error();
    text += margin + in_quotes(named->first.substr(prefix.size())) + ":" + from("--param " + param) +
            indented(value->root().dump(), columns + 2);
  }
  return text;
}

/// `world:` and `servers:`. The league is the world if it is named, else turtlesim; what else there is stands beside
/// it.
Expected<std::string> nodes_text(const Options& options) {
  if (Status s = check_nodes(options.nodes); !s) return s.error();
  const auto named = [&](const char* node) {
    return std::find(options.nodes.begin(), options.nodes.end(), node) != options.nodes.end();
  };
  const std::string world = named(kLeague) ? kLeague : named("turtlesim") ? "turtlesim" : "";
  std::string text, servers;
  for (const std::string& node : options.nodes) {
    auto settings = settings_of(node, options.params, node == world ? 2 : 4);
    if (!settings) return settings.error();
    if (node == world)
      text = "world:\n  kind: " + node + '\n' + *settings;
    else
      servers += "  - node: " + node + '\n' + *settings;
  }
  return text + (servers.empty() ? "" : "servers:\n" + servers);
}

bool is_of_a_node(const std::string& param, const std::vector<std::string>& nodes) {
  return std::any_of(nodes.begin(), nodes.end(),
                     [&](const std::string& node) { return param.starts_with(node + '.'); });
}

/// Each --param is for a node that there will be.
Status check_params(const Options& options) {
  if (const std::string fault = bus::namespace_fault(options.name_space); !fault.empty())
    return usage("--namespace: the name '" + options.name_space + "' " + fault);
  std::vector<std::pair<std::string, std::string>> remaps;
  for (const std::string& remap : options.remaps) {
    auto names = split("--remap", remap, ":=", "FROM:=TO");
    if (!names) return names.error();
    if (const std::string fault = bus::remap_fault(*names); !fault.empty())
      return usage("--remap " + remap + ": " + fault);
    remaps.push_back(*std::move(names));
  }
  bus::NodeName manager{cx::ManagerOptions().node, options.name_space, remaps};
  bus::rename_node(manager);
  std::vector<std::string> known = options.nodes;
  known.insert(known.begin(), {manager.name, manager.full_name()});
  for (const std::string& param : options.params) {
    if (is_of_a_node(param, known)) continue;
    auto named = split("--param", param, "=", "NODE.NAME=VALUE");
    if (!named) return named.error();
    std::string names = known.front();
    for (const std::string& node : options.nodes) names += ", " + node;
    return usage("--param: found '" + param + "', expected NODE.NAME=VALUE with one of the nodes " + names);
  }
  return {};
}

/// Transitions of the managers, as stimuli.
Expected<std::string> transition_items(const Options& options) {
  const std::string node = bus::NodeName{"clips_manager", options.name_space, {}}.full_name();
  std::string items;
  for (const std::string& text : options.transitions) {
    auto parts = split("--transition", text, ":", "SECONDS:NAME or SECONDS:NAME@NODE");
    if (!parts) return parts.error();
    char* end = nullptr;
    const double at = std::strtod(parts->first.c_str(), &end);
    const std::size_t where = parts->second.find('@');
    const std::string name = parts->second.substr(0, where);
    const std::vector<std::string> known{"configure", "activate", "deactivate", "cleanup", "shutdown"};
    if (*end != '\0' || at < 0)
      return usage("--transition: found '" + text + "', expected SECONDS:NAME or SECONDS:NAME@NODE");
    if (std::find(known.begin(), known.end(), name) == known.end())
      return usage("--transition: found '" + name + "', expected configure, activate, deactivate, cleanup or shutdown");
    items += "  - {at: " + parts->first + ", call: " +
             in_quotes((where == std::string::npos ? node : parts->second.substr(where + 1)) + "/change_state") +
             ", type: lifecycle_msgs/srv/ChangeState, request: {transition: {label: " + name + "}}}\n";
  }
  return items;
}

/// The scenario that these options stand for, as its file would read.
Expected<std::string> scenario_text(const Options& options) {
  std::string text = "schema: 1\nduration_s: " + std::to_string(options.run.play.until.value_or(kDefaultEnd)) +
                     "\non_rule_error: " + (options.stop ? "stop" : "continue") + '\n';
  if (options.seed) text += "seed: " + std::to_string(*options.seed) + '\n';
  if (options.trust_rules) text += "trust_rules: true\n";
  if (options.max_firings) text += "max_firings_per_tick: " + std::to_string(*options.max_firings) + '\n';
  auto packages = packages_of(options);
  if (!packages) return packages.error();
  auto nodes = nodes_text(options);
  if (!nodes) return nodes.error();
  text += *nodes + "packages:\n";
  for (const auto& [name, folder] : *packages) text += "  " + in_quotes(name) + ": " + in_quotes(folder) + '\n';
  text += "agents:\n";
  for (const std::string& config : options.configs) {
    text += "  - config: " + in_quotes(fs::absolute(config).lexically_normal().string()) +
            "\n    namespace: " + in_quotes(options.name_space) + from("--namespace " + options.name_space);
    if (!options.activate) text += "    activate: false\n";
    if (!options.remaps.empty()) text += "    remap:\n";
    for (const std::string& remap : options.remaps) {
      auto names = split("--remap", remap, ":=", "FROM:=TO");
      if (!names) return names.error();
      text += "      " + in_quotes(names->first) + ": " + in_quotes(names->second) + from("--remap " + remap);
    }
    std::string params;
    for (const std::string& param : options.params) {
      if (is_of_a_node(param, options.nodes)) continue;
      auto named = split("--param", param, "=", "NODE.NAME=VALUE");
      if (!named) return named.error();
      auto value = yaml::Document::parse(named->second, "--param " + named->first);
      if (!value) return value.error();
      params += "      " + in_quotes(named->first) + ":" + from("--param " + param) + indented(value->root().dump(), 8);
    }
    if (!params.empty()) text += "    params:\n" + params;
  }
  auto list = transition_items(options);
  if (!list) return list.error();
  if (!options.stimuli.empty()) {
    auto stimuli = yaml::Document::load(options.stimuli);
    if (!stimuli) return stimuli.error();
    (void)read_stimuli(stimuli->root());
    if (Status s = stimuli->status(); !s) return s.error();
    for (const yaml::Value& item : stimuli->root().as_list()) *list += "  -\n" + indented(item.dump(), 6);
  }
  return list->empty() ? text : text + "stimuli:\n" + *list;
}

Expected<Scenario> make_scenario(const Options& options) {
  for (const std::string& config : options.configs) {
    if (fs::is_directory(config)) return input_error("is a folder, expected a configuration (YAML)", config);
    if (!fs::is_regular_file(config)) return input_error("there is no such file", config);
  }
  if (Status s = check_params(options); !s) return s.error();
  auto text = scenario_text(options);
  if (!text) return text.error();
  const std::string name = fs::path(options.configs.front()).stem().string() + ".yaml";
  auto scenario = Scenario::parse(*text, name);
  if (!scenario && scenario.error().file == name) return blame_option(scenario.error(), *text);
  if (scenario)
    for (AgentSpec& agent : scenario->agents)
      for (cx::GivenParameter& param : agent.params) {
        const Error place = blame_option(input_error({}, param.file, param.line), *text);
        param.file = place.file;
        param.line = place.line;
      }
  if (!scenario || options.stimuli.empty()) return scenario;
  auto stimuli = yaml::Document::load(options.stimuli);  // again, for the places of later errors
  if (!stimuli) return stimuli.error();
  std::vector<Stimulus> placed = read_stimuli(stimuli->root());
  auto items = transition_items(options);
  if (!items) return items.error();
  if (!items->empty()) {
    auto transitions = yaml::Document::parse(*items, "--transition");
    if (!transitions) return transitions.error();
    for (Stimulus& transition : read_stimuli(transitions->root())) placed.push_back(std::move(transition));
    std::stable_sort(placed.begin(), placed.end(), [](const Stimulus& a, const Stimulus& b) { return a.at < b.at; });
  }
  scenario->stimuli = std::move(placed);
  return scenario;
}

int env(const Options& options) {
  auto scenario = make_scenario(options);
  if (!scenario) return fail(scenario.error());
  PlayCommand run = options.run;
  if (!run.play.until && !run.quiet)
    std::fprintf(stderr, "ends at %.0f s of simulated time; --until T for another\n", kDefaultEnd);
  run.play.until.reset();  // it is the scenario's duration
  const auto [code, played] = play(run, *std::move(scenario));
  if (played.result.journal_hash.empty()) return code;
  if (run.json) {
    std::fputs(played.result.to_json().c_str(), stdout);
    return code;
  }
  std::printf("%s after %.3f s of simulated time, %zu rule errors\n", to_string(played.result.status),
              to_seconds(played.result.sim_time), played.result.rule_errors.size());
  if (!played.folder.empty()) std::printf("%s\n", played.folder.c_str());
  return code;
}

void declare(CLI::App& command, Options& options) {
  command
      .add_option("config", options.configs,
                  "Configurations of the CLIPS-Executive (YAML), one environment manager each")
      ->required();
  command
      .add_option("--package", options.packages,
                  "NAME=DIR: where a package lies (default: what lies around the configuration)")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  command.add_option("--with", options.nodes, "Starts a node beside it: " + known_nodes())
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  command
      .add_option("--prefix,--plugin-path", options.run.play.prefixes,
                  "DIR: packages installed below it are found, with their plugins (also $CXLAB_PREFIX_PATH)")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  command.add_option("--param", options.params, "NODE.NAME=VALUE: changes a parameter")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  command.add_option("--namespace", options.name_space, "Of the nodes")->capture_default_str();
  command.add_option("--remap", options.remaps, "FROM:=TO: renames a topic, service or action")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  command.add_option("--stimuli", options.stimuli, "What happens from outside (YAML list, docs/scenario.md)");
  command.add_flag("!--no-activate", options.activate,
                   "Managers without autostart_node stay unconfigured until somebody asks");
  command
      .add_option("--transition", options.transitions,
                  "SECONDS:NAME[@NODE]: configure, activate, deactivate, cleanup or shutdown of a manager "
                  "(docs/plugins/manager.md)")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  options.run.play.keep_going = true;
  command.add_flag("--keep-going,!--no-keep-going", options.run.play.keep_going,
                   "Errors in rule files are reported and the run goes on (default); it then ends with exit code 3");
  command.add_flag("--stop-on-rule-error", options.stop,
                   "An error in a rule ends the run (exit code 4); without it the run goes on and the exit code does "
                   "not tell of it");
  command
      .add_option("--max-firings", options.max_firings,
                  "Rules that an environment may fire in a tick before the run ends as one without an end (default "
                  "100000, 0 = no limit)")
      ->check(CLI::Range(std::int64_t{0}, std::int64_t{1} << 62));
  command.add_flag("--strict-cx", options.run.play.strict,
                   "Parameters that CX does not know are errors, not INFO lines");
  command.add_flag("--trust-rules", options.trust_rules, "Rules may read, write and run anything");
  command.add_option("--until", options.run.play.until, "End, s of simulated time (default 60)")->check(not_negative());
  command.add_option("--seed", options.seed, "Seed of all chance")->check(seed_number());
  command.add_option("--out", options.run.play.out,
                     "Folder of the run; 'none' writes nothing (default runs/<config>-<seed>)");
  command.add_flag("--force", options.run.play.force, "Overwrites a folder that is in use");
  command.add_option("--journal", options.run.play.journal, "What journal.jsonl holds: none, decisions or full")
      ->capture_default_str();
  command.add_flag("--realtime", options.run.play.realtime, "Sleeps between ticks, to watch");
  command.add_flag("--json", options.run.json, "Prints result.json");
  command.add_flag("--quiet", options.run.quiet, "No progress and no log lines");
}

}  // namespace

void add_env(CLI::App& app, Action& action) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "env", "Runs a configuration of the CLIPS-Executive as it is, in an empty world or with the nodes named");
  command->footer(
      "Examples:\n  cxlab env docs/examples/hello/hello.yaml\n  cxlab env my_agent/params/agent.yaml --until 30 "
      "--stimuli tests/stimuli.yaml\n  cxlab env scenarios/turtlesim/agents/params/boundary.yaml --with turtlesim");
  declare(*command, *options);
  command->callback([options, &action] { action = [options] { return env(*options); }; });
}

}  // namespace cxlab::app
