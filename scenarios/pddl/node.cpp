#include "scenarios/pddl/node.h"

#include "cx/base/append_file.h"
#include "cx/base/remedy.h"
#include "cx/bus/names.h"
#include "cx/executive/files.h"
#include "cx/executive/reach.h"
#include "planner/manager/manager.h"
#include "scenarios/pddl/files.h"
#include "scenarios/result.h"
#include "scenarios/share.h"

namespace cxlab::pddl {

namespace {

/// `{node: pddl_manager, ...}` under `servers:`.
struct Config {
  planner::PddlManagerOptions options;
  std::string compat = "none";                ///< or "original"
  std::string engine;                         ///< of the Unified Planning Framework, instead of a command; empty = none
  std::string python = "python3";             ///< the interpreter that has the engine
  std::optional<planner::PlanningCost> cost;  ///< none: that of the scenario

  template <class Keys>
  void fields(Keys& keys) {
    keys("name", options.node.name);
    keys("namespace", options.node.name_space);
    keys("remap", options.node.remaps);
    keys("autostart_node", options.autostart);
    keys("bond_heartbeat_period", options.bond_period);
    keys("anytime", options.anytime);
    keys("warm_start", options.warm_start);
    keys("command", options.other.command);
    keys("engine", engine);
    keys("python", python);
    keys.word("compat", compat, {"none", "original"});
    keys("planner", cost);
  }
};

constinit const SectionKind kPlanner = section_of<planner::PlanningCost>("planner");

Status validate(const Config& config) {
  const std::string& command = config.options.other.command;
  if (Status s = bus::check_node(config.options.node.name_space, config.options.node.remaps); !s) return s;
  if (config.options.bond_period < 0) return input_error("bond_heartbeat_period: must be 0 (no heartbeats) or more");
  if (!command.empty() && command.find("{plan}") == std::string::npos)
    return input_error("command: " + found_expected("no {plan} in it", "a command that writes its plan to {plan}"));
  if (!command.empty() && !config.engine.empty())
    return input_error("engine: " + found_expected("beside command", "one of the two"));
  if (config.engine.empty() && config.python != Config().python)
    return input_error("python: says which interpreter has the engine, but there is no engine");
  return {};
}

/// Below the run's folder, whatever path an agent named.
Status write_below(const std::filesystem::path& run_folder, const std::filesystem::path& file,
                   const std::string& text) {
  const std::filesystem::path path = run_folder / "written" / cx::outside_name(file);
  std::error_code error;
  std::filesystem::create_directories(path.parent_path(), error);
  auto out = AppendFile::create(path);
  if (!out) return out.error();
  (void)out->append(text);
  return out->close();
}

Status add_manager(const ServerSpec& spec, const StageSetup& setup, Stage& stage) {
  const Config& config = spec.get<Config>();
  planner::PddlManagerOptions options = config.options;
  options.original = config.compat == "original";
  if (!config.engine.empty())
    options.other = planner::up_engine(find_share().engines / "up_engine.py", config.python, config.engine);
  const bool outside = !options.other.command.empty();
  if (outside && !setup.programs)
    return usage_error("pddl_manager starts a program, which can read, write and run anything: " +
                       options.other.command + "; if it may: --trust-programs")
        .with_code(kUntrusted);
  options.cost = config.cost.value_or(setup.scenario.section<planner::PlanningCost>(kPlanner));
  options.log = setup.log;
  options.on_read = setup.keep;
  options.resolve = [&scenario = setup.scenario](const std::string& directory) { return scenario.resolve(directory); };
  const std::set<std::filesystem::path> named = files(setup.scenario);
  stage.readable.insert(stage.readable.end(), named.begin(), named.end());
  options.may_read = [&scenario = setup.scenario, run_folder = setup.run_folder,
                      named](const std::filesystem::path& file) {
    if (scenario.trust_rules) return true;
    for (const AgentSpec& agent : scenario.agents)
      for (const auto& [name, share] : scenario.shares(agent))
        if (cx::really_below(file, share)) return !cx::is_hidden(file.lexically_normal().lexically_relative(share));
    if (!run_folder.empty() && cx::really_below(file, run_folder / "written")) return true;
    std::error_code error;
    return named.contains(std::filesystem::canonical(file, error)) && !error;
  };
  if (!setup.run_folder.empty())
    options.write = [folder = setup.run_folder](const std::filesystem::path& file, const std::string& text) {
      return write_below(folder, file, text);
    };
  auto manager = planner::PddlManager::create(std::move(options), setup.bus, setup.sink);
  if (!manager) return manager.error();
  stage.reports.push_back([&node = **manager, outside](Result& result) {
    if (outside) result.deterministic = false;
    for (const std::string& warning : node.warnings()) result.warnings.push_back(warning);
    result.plans += node.plans();
    result.replans += node.replans();
  });
  stage.servers.push_back(*std::move(manager));
  return {};
}

constexpr const SectionKind* kReads[]{&kPlanner};

}  // namespace

constinit const NodeKind kNode{.name = "pddl_manager",
                               .what = "keeps PDDL instances and plans (docs/reference/pddl-manager.md)",
                               .settings = settings_of<Config>(),
                               .reads = kReads,
                               .add = add_manager};

}  // namespace cxlab::pddl
