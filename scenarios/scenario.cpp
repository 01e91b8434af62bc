#include "scenarios/scenario.h"

#include <algorithm>
#include <array>

#include "cx/bus/names.h"
#include "cx/journal/file_store.h"
#include "scenarios/nodes.h"
#include "scenarios/result.h"
#include "scenarios/turtlesim/read_config.h"
#include "sim/box2d/turtle_world.h"

namespace cxlab {

namespace {

struct VerbWord {
  const char* key;
  Stimulus::Verb verb;
  const char* content;  ///< the key that carries what is sent, nullptr if none
  bool typed;
};
constexpr std::array<VerbWord, 11> kVerbs{{
    {"publish", Stimulus::Verb::kPublish, "data", true},
    {"call", Stimulus::Verb::kCall, "request", true},
    {"serve", Stimulus::Verb::kServe, "response", true},
    {"send_goal", Stimulus::Verb::kSendGoal, "goal", true},
    {"cancel_goal", Stimulus::Verb::kCancelGoal, nullptr, false},
    {"set_param", Stimulus::Verb::kSetParam, "value", false},
    {"load_plugin", Stimulus::Verb::kLoadPlugin, nullptr, false},
    {"unload_plugin", Stimulus::Verb::kUnloadPlugin, nullptr, false},
    {"create_env", Stimulus::Verb::kCreateEnv, nullptr, false},
    {"destroy_env", Stimulus::Verb::kDestroyEnv, nullptr, false},
    {"stop_node", Stimulus::Verb::kStopNode, nullptr, false},
}};

Stimulus read_stimulus(const yaml::Value& value) {
  Stimulus stimulus;
  stimulus.file = value.file();
  stimulus.line = value.line();
  yaml::Map map = value.as_map();
  map.require("at");
  map.read_seconds("at", stimulus.at);
  int verbs = 0;
  for (const VerbWord& word : kVerbs) {
    const yaml::Value target = map.get(word.key);
    if (!target) continue;
    ++verbs;
    stimulus.verb = word.verb;
    if (word.verb == Stimulus::Verb::kLoadPlugin || word.verb == Stimulus::Verb::kUnloadPlugin) {
      yaml::Map keys = target.as_map();
      stimulus.target = keys.require("env").as_string();
      stimulus.plugin = keys.require("plugin").as_string();
      keys.finish();
    } else {
      stimulus.target = target.as_string();
    }
    if (word.verb >= Stimulus::Verb::kLoadPlugin && word.verb <= Stimulus::Verb::kDestroyEnv)
      map.read("manager", stimulus.manager);
    if (word.verb == Stimulus::Verb::kSetParam) map.require("value");
    if (word.typed) stimulus.type = map.require("type").as_string();
    if (word.content)
      if (const yaml::Value content = map.get(word.content)) stimulus.content = content.dump();
  }
  map.finish();
  if (verbs != 1) {
    std::string list;
    for (const VerbWord& word : kVerbs) list += (list.empty() ? "" : ", ") + std::string(word.key);
    value.fail("found " + std::to_string(verbs) + " verbs, expected exactly one of: " + list);
  }
  return stimulus;
}

void read_packages(yaml::Map map, std::map<std::string, std::string>& out, std::map<std::string, int>& lines) {
  for (const auto& [name, folder] : map.entries()) {
    out[name] = folder.as_string();
    lines[name] = folder.line();
    if (out[name].empty()) folder.fail("expected a folder");
  }
}

AgentSpec read_agent(const yaml::Value& value) {
  AgentSpec agent;
  yaml::Map map = value.as_map();
  agent.config = map.require("config").as_string();
  map.read("namespace", agent.name_space);
  if (const yaml::Value remap = map.get("remap"))
    for (const auto& [from, to] : remap.as_map().entries()) {
      agent.remaps.emplace_back(from, to.as_string());
      if (const std::string fault = bus::remap_fault(agent.remaps.back()); !fault.empty()) to.fail(fault);
    }
  if (const yaml::Value packages = map.get("packages"))
    read_packages(packages.as_map(), agent.packages, agent.package_lines);
  if (const yaml::Value params = map.get("params"))
    for (const auto& [name, param] : params.as_map().entries())
      agent.params.push_back({name, param.dump(), param.origin()});
  map.read("activate", agent.activate);
  map.finish();
  if (const std::string fault = bus::namespace_fault(agent.name_space); !fault.empty())
    map.get("namespace").fail("the name '" + agent.name_space + "' " + fault);
  return agent;
}

void read_timed(const yaml::Value& value, sim::TimedSkillsConfig& timed) {
  yaml::Map map = value.as_map();
  map.read("pick_mean_s", timed.pick_mean_s).read("pick_sigma_s", timed.pick_sigma_s);
  map.read("place_mean_s", timed.place_mean_s).read("place_sigma_s", timed.place_sigma_s);
  map.read("shortest_s", timed.shortest_s).read("drive_failure", timed.drive_failure);
  map.read("pick_failure", timed.pick_failure).read("place_failure", timed.place_failure);
  map.finish();
  if (Status s = sim::validate(timed); !s) value.fail(s.error().message);
}

/// A node by its name alone, or a map with its settings.
ServerSpec read_server(const yaml::Value& value) {
  ServerSpec spec;
  const NodeKind* kind = nullptr;
  const auto find = [&](const yaml::Value& name) {
    spec.node = name.as_string();
    kind = find_node(spec.node);
    std::string known;
    for (const NodeKind& other : node_kinds()) known += (known.empty() ? "" : ", ") + std::string(other.name);
    if (!kind && !spec.node.empty()) name.fail("found '" + spec.node + "', expected one of: " + known);
  };
  if (value.is_scalar()) {
    find(value);
    return spec;
  }
  yaml::Map map = value.as_map();
  const yaml::Value name = map.require("node");
  find(name);
  if (name && !kind) return spec;
  if (kind) kind->read(map, spec);
  map.finish();
  return spec;
}

Expectation read_expectation(const yaml::Value& value) {
  Expectation expectation;
  expectation.line = value.line();
  yaml::Map map = value.as_map();
  if (const yaml::Value path = map.require("path")) {
    expectation.path = path.as_string();
    if (Status s = check_result_path(expectation.path); !s) path.fail(s.error().message);
  }
  if (const yaml::Value v = map.get("min")) expectation.min = v.as_number();
  if (const yaml::Value v = map.get("max")) expectation.max = v.as_number();
  if (const yaml::Value v = map.get("equals")) expectation.equals = v.as_string();
  if (!expectation.min && !expectation.max && !expectation.equals) value.fail("expected min, max or equals");
  map.finish();
  return expectation;
}

}  // namespace

std::vector<Stimulus> read_stimuli(const yaml::Value& list) {
  std::vector<Stimulus> stimuli;
  if (list.is_map() && list.as_map().entries().empty()) return stimuli;  // an empty file
  for (const yaml::Value& item : list.as_list()) stimuli.push_back(read_stimulus(item));
  std::stable_sort(stimuli.begin(), stimuli.end(), [](const Stimulus& a, const Stimulus& b) { return a.at < b.at; });
  return stimuli;
}

Expected<Scenario> Scenario::load(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  auto text = read_file(file);
  return text ? parse(*text, file, overrides) : Expected<Scenario>(text.error());
}

Expected<Scenario> Scenario::parse(const std::string& text, const std::filesystem::path& file,
                                   const std::vector<std::string>& overrides) {
  auto document = yaml::Document::parse(text, file.string());
  if (!document) return document.error();
  for (const std::string& assignment : overrides)
    if (Status s = document->set(assignment); !s) return s.error();

  Scenario scenario;
  scenario.file = file;
  scenario.text = text;
  scenario.name = file.stem().string();
  scenario.overrides = overrides;
  yaml::Map map = document->root().as_map();
  if (const yaml::Value schema = map.require("schema"); schema && schema.as_integer() != 1)
    schema.fail("found " + schema.text() + ", expected 1");
  if (const yaml::Value world = map.get("world")) {
    yaml::Map world_map = world.as_map();
    std::string kind = "none";
    world_map.read_word("kind", kind, {"none", "rcll", "turtlesim"});
    if (kind == "rcll") {
      scenario.world_kind = WorldKind::kRcll;
      rcll::read_config(world_map, scenario.rcll);
      scenario.duration = from_seconds(scenario.rcll.setup_s + scenario.rcll.production_s);
    }
    if (kind == "turtlesim") {
      scenario.world_kind = WorldKind::kTurtlesim;
      turtlesim::read_config(world_map, scenario.turtlesim);
      scenario.tick = scenario.physics_step = sim::TurtleWorldOptions().step;
    }
    world_map.finish();
  }
  std::string tier = "physics";
  map.read_word("tier", tier, {"physics", "timed"});
  scenario.tier = tier == "timed" ? Tier::kTimed : Tier::kPhysics;
  if (scenario.tier == Tier::kTimed && scenario.world_kind == WorldKind::kTurtlesim)
    map.get("tier").fail("found 'timed', expected physics: turtlesim has no other tier");
  if (const yaml::Value timed = map.get("timed")) read_timed(timed, scenario.timed);
  map.read("seed", scenario.seed).read("epoch", scenario.epoch);
  map.read_seconds("duration_s", scenario.duration)
      .read_seconds("tick_s", scenario.tick)
      .read_seconds("physics_step_s", scenario.physics_step);
  if (const yaml::Value packages = map.get("packages"))
    read_packages(packages.as_map(), scenario.packages, scenario.package_lines);
  if (const yaml::Value agents = map.get("agents"))
    for (const yaml::Value& agent : agents.as_list()) scenario.agents.push_back(read_agent(agent));
  if (const yaml::Value servers = map.get("servers"))
    for (const yaml::Value& server : servers.as_list()) scenario.servers.push_back(read_server(server));
  if (const yaml::Value stimuli = map.get("stimuli")) scenario.stimuli = read_stimuli(stimuli);
  if (const yaml::Value faults = map.get("faults")) {
    scenario.faults = read_faults(faults);
    if (scenario.world_kind != WorldKind::kRcll)
      faults.fail("this world has neither robots nor machines: expected world.kind rcll");
  }
  if (const yaml::Value planner = map.get("planner")) pddl::read_cost(planner, scenario.planner);
  std::string on_rule_error = "stop";
  map.read_word("on_rule_error", on_rule_error, {"stop", "continue"});
  scenario.stop_on_rule_error = on_rule_error == "stop";
  map.read("max_firings_per_tick", scenario.max_firings_per_tick).read("trust_rules", scenario.trust_rules);
  if (const yaml::Value expect = map.get("expect"))
    for (const yaml::Value& item : expect.as_list()) scenario.expect.push_back(read_expectation(item));
  map.finish();

  if (scenario.tick <= SimTime::zero())
    map.get("tick_s").fail("must be more than 0");
  else if (scenario.physics_step <= SimTime::zero())
    map.get("physics_step_s").fail("must be more than 0");
  else if (scenario.world_kind != WorldKind::kTurtlesim &&
           scenario.tick % scenario.physics_step != SimTime::zero())  // a canvas steps at any tick
    map.get("physics_step_s").fail("tick_s must be a whole multiple of physics_step_s");
  if (scenario.max_firings_per_tick < 0) map.get("max_firings_per_tick").fail("must be 0 (no limit) or more");
  if (Status s = document->status(); !s) return s.error();
  return scenario;
}

std::filesystem::path Scenario::resolve(const std::string& relative) const {
  const std::filesystem::path path(relative);
  return path.is_absolute() ? path : (file.parent_path() / path).lexically_normal();
}

std::map<std::string, std::string> Scenario::shares(const AgentSpec& agent) const {
  std::map<std::string, std::string> out;
  for (const auto* list : {&packages, &agent.packages})
    for (const auto& [name, folder] : *list) {
      std::filesystem::path path = std::filesystem::absolute(resolve(folder)).lexically_normal();
      if (!path.has_filename()) path = path.parent_path();
      out[name] = path.string();
    }
  return out;
}

}  // namespace cxlab
