#include "scenarios/scenario.h"

#include <algorithm>
#include <sstream>

#include "cx/base/file.h"
#include "cx/bus/names.h"
#include "scenarios/catalogue.h"
#include "scenarios/result.h"

namespace cxlab {

namespace {

void read_packages(const yaml::Value& value, std::map<std::string, PackageSpec>& out) {
  if (!value) return;
  for (const auto& [name, folder] : value.as_map().entries()) {
    out[name] = {folder.as_string(), folder.origin()};
    if (out[name].folder.empty()) folder.fail("expected a folder");
  }
}

/// Adds parameters by their whole names: `a: {b: {c: 1}}` is `a.b.c: 1`, so that an override can set one of them
/// alone. If two have the same name, the later one counts.
void read_params(const yaml::Value& value, const std::string& before, std::vector<cx::GivenParameter>& out) {
  for (const auto& [name, param] : value.as_map().entries()) {
    if (param.is_map()) {
      read_params(param, before + name + '.', out);
      continue;
    }
    std::erase_if(out, [&](const cx::GivenParameter& other) { return other.name == before + name; });
    out.push_back({before + name, param.dump(), param.origin()});
  }
}

AgentSpec read_agent(const yaml::Value& value) {
  AgentSpec agent;
  yaml::Map map = value.as_map();
  if (const yaml::Value config = map.require("config")) {
    agent.config = config.as_string();
    agent.config_origin = config.origin();
  }
  map.read("namespace", agent.name_space).read("remap", agent.remaps);
  read_packages(map.get("packages"), agent.packages);
  if (const yaml::Value params = map.get("params")) read_params(params, "", agent.params);
  map.read("activate", agent.activate);
  map.finish();
  if (const Status s = bus::check_node(agent.name_space, agent.remaps); !s) map.fail(s.error());
  return agent;
}

template <class Kind>
std::string names_of(const std::vector<const Kind*>& kinds) {
  std::string names;
  for (const Kind* kind : kinds) names += (names.empty() ? "" : ", ") + std::string(kind->name);
  return names;
}

template <class Kind>
void read_settings(yaml::Map& map, Chosen<Kind>& spec) {
  if (spec.kind->settings.read) spec.kind->settings.read(map, spec.config);
  map.finish();
}

void find_files(yaml::Map& world, Scenario& scenario) {
  for (const std::string_view key : scenario.world.kind->files) {
    const yaml::Value value = world.get(key);
    if (!value || value.text().empty()) continue;
    const Origin origin = value.origin();
    const bool from_option = origin.line == 0;
    scenario.world_files[std::string(key)] = {
        from_option ? std::filesystem::path(value.text()) : scenario.resolve(value.text()), origin};
  }
}

void read_world(const yaml::Value& value, const Catalogue& catalogue, Scenario& scenario) {
  WorldSpec spec{&kEmptyWorld, {}, value.origin()};
  yaml::Map map = value.as_map();
  if (const yaml::Value kind = map.get("kind")) {
    const std::string name = kind.as_string();
    spec.kind = catalogue.find_world(name);
    if (!spec.kind) return kind.fail(found_text(name, "one of: " + names_of(catalogue.worlds)));
  }
  read_settings(map, spec);
  scenario.set_world(std::move(spec));
  find_files(map, scenario);
}

/// A node by its name alone, or a map with its settings.
void read_server(const yaml::Value& value, const Catalogue& catalogue, Scenario& scenario) {
  ServerSpec spec{nullptr, {}, value.origin()};
  const auto find = [&](const yaml::Value& node) {
    const std::string name = node.as_string();
    spec.kind = catalogue.find_node(name);
    if (!spec.kind && !name.empty()) node.fail(found_text(name, "one of: " + names_of(catalogue.nodes)));
  };
  if (value.is_scalar()) {
    find(value);
  } else {
    yaml::Map map = value.as_map();
    const yaml::Value node = map.require("node");
    if (node) find(node);
    if (spec.kind)
      read_settings(map, spec);
    else if (!node)
      map.finish();
  }
  if (spec.kind) scenario.servers.push_back(std::move(spec));
}

void read_tier(yaml::Map& map, Scenario& scenario) {
  std::string tier(to_string(scenario.tier));
  map.read_word("tier", tier, {"physics", "timed"});
  scenario.tier = tier == "timed" ? Tier::kTimed : Tier::kPhysics;
  const WorldKind& world = *scenario.world.kind;
  if (world.tiers.empty() || std::ranges::find(world.tiers, scenario.tier) != world.tiers.end()) return;
  map.get("tier").fail(found_text(
      tier, std::string(to_string(world.tiers.front())) + ": " + std::string(world.name) + " has no other tier"));
}

/// A world makes all steps of a tick before anybody can look at it.
constexpr SimTime kLongestTick = std::chrono::hours(1);

void check_steps(yaml::Map& map, const Scenario& scenario) {
  const yaml::Value tick = map.get("tick_s"), step = map.get("physics_step_s");
  if (scenario.tick <= SimTime::zero()) return tick.fail("must be more than 0");
  if (scenario.tick > kLongestTick) return tick.fail(found_expected(tick.text(), "at most 3600 s"));
  if (scenario.physics_step <= SimTime::zero()) return step.fail("must be more than 0");
  if (scenario.world.kind->any_tick || scenario.tick % scenario.physics_step == SimTime::zero()) return;
  const auto shown = [](SimTime t) {
    std::ostringstream text;
    text << to_seconds(t);
    return text.str();
  };
  (step ? step : tick)
      .fail(found_expected("tick_s " + shown(scenario.tick) + " and physics_step_s " + shown(scenario.physics_step),
                           "a tick of whole steps"));
}

bool reads(const WorldKind& world, const SectionKind& section) {
  return std::ranges::find(world.reads, &section) != world.reads.end();
}

void read_sections(yaml::Map& map, const Catalogue& catalogue, Scenario& scenario) {
  for (const SectionKind* kind : catalogue.sections()) {
    const yaml::Value value = map.get(kind->key);
    if (!value) continue;
    scenario.sections.push_back({kind, {}, value.origin()});
    kind->read(value, scenario.sections.back().config);
    if (kind->elsewhere.empty() || reads(*scenario.world.kind, *kind)) continue;
    std::vector<const WorldKind*> worlds = catalogue.worlds;
    std::erase_if(worlds, [kind](const WorldKind* world) { return !reads(*world, *kind); });
    value.fail(std::string(kind->elsewhere) + ": expected world.kind " + names_of(worlds));
  }
}

void read_expectations(const yaml::Value& list, Scenario& scenario) {
  for (const yaml::Value& value : list.as_list()) {
    Expectation& e = scenario.expect.emplace_back();
    e.origin = value.origin();
    yaml::Map map = value.as_map();
    map.read(e);
    map.finish();
    if (const Status s = check_result_path(e.path, scenario); !s && map.has("path"))
      map.get("path").fail(s.error().message);
    if (!e.min && !e.max && !e.equals) value.fail("expected min, max or equals");
  }
}

}  // namespace

void read_bag(yaml::Map& scenario, bag::BagSpec& bag) {
  const yaml::Value value = scenario.get("bag");
  if (!value) return;
  scenario.read("bag", bag);
  const yaml::Value file = value.as_map().get("file");
  bag.origin = file ? file.origin() : value.origin();
  if (bag && bag.origin.line == 0) bag.file = std::filesystem::absolute(bag.file).lexically_normal().string();
}

std::string_view to_string(Tier tier) { return tier == Tier::kTimed ? "timed" : "physics"; }

Expected<Scenario> Scenario::load(const std::filesystem::path& file, const Catalogue& catalogue,
                                  const std::vector<Override>& overrides) {
  auto text = read_file(file);
  return text ? parse(*text, file, catalogue, overrides) : Expected<Scenario>(text.error());
}

Expected<Scenario> Scenario::parse(const std::string& text, const std::filesystem::path& file,
                                   const Catalogue& catalogue, const std::vector<Override>& overrides) {
  auto document = yaml::Document::parse(text, file.string());
  if (!document) return document.error();
  Scenario scenario;
  scenario.file = file;
  scenario.text = text;
  scenario.name = file.stem().string();
  for (const Override& change : overrides) {
    if (Status s = document->set(change.assignment, change.option); !s) return s.error();
    scenario.overrides.push_back(change.assignment);
  }
  yaml::Map map = document->root().as_map();
  for (const auto& [key, what] : {std::pair("scenarios", "a suite, and no scenario; cxlab bench plays it"),
                                  {"stories", "a file of stories, and no scenario; cxlab test plays them"}})
    if (document->root().as_map().has(key)) return input_error(std::string("this is ") + what, file.string(), 1);
  for (const auto& [node, value] : document->root().as_map().entries())
    if (value.is_map() && value.as_map().has("ros__parameters"))
      return input_error("this is a configuration of the CLIPS-Executive, and no scenario; cxlab env runs it",
                         file.string(), 1);
  if (const yaml::Value schema = map.require("schema"); schema && schema.as_integer() != 1)
    schema.fail(found_expected(schema.text(), "1"));
  if (const yaml::Value world = map.get("world")) read_world(world, catalogue, scenario);
  read_tier(map, scenario);
  map.read("seed", scenario.seed).read("epoch", scenario.epoch);
  map.read("duration_s", scenario.duration).read("tick_s", scenario.tick).read("physics_step_s", scenario.physics_step);
  read_packages(map.get("packages"), scenario.packages);
  if (const yaml::Value agents = map.get("agents"))
    for (const yaml::Value& agent : agents.as_list()) scenario.agents.push_back(read_agent(agent));
  if (const yaml::Value servers = map.get("servers"))
    for (const yaml::Value& server : servers.as_list()) read_server(server, catalogue, scenario);
  if (const yaml::Value stimuli = map.get("stimuli")) scenario.stimuli = read_stimuli(stimuli);
  read_bag(map, scenario.bag);
  read_sections(map, catalogue, scenario);
  std::string on_rule_error = "stop";
  map.read_word("on_rule_error", on_rule_error, {"stop", "continue"});
  scenario.stop_on_rule_error = on_rule_error == "stop";
  map.read("max_firings_per_tick", scenario.max_firings_per_tick).read("trust_rules", scenario.trust_rules);
  if (const yaml::Value expect = map.get("expect")) read_expectations(expect, scenario);
  map.finish();
  check_steps(map, scenario);
  if (scenario.max_firings_per_tick < 0) map.get("max_firings_per_tick").fail("must be 0 (no limit) or more");
  if (Status s = document->status(); !s) return s.error();
  return scenario;
}

}  // namespace cxlab
