#include "scenarios/scenario.h"

#include "cx/base/file.h"
#include "scenarios/catalogue.h"
#include "scenarios/share.h"

namespace cxlab {

void Scenario::set_world(WorldSpec spec) {
  world = std::move(spec);
  const WorldKind& kind = *world.kind;
  duration = kind.duration;
  tick = kind.tick;
  physics_step = kind.physics_step;
  tier = kind.tiers.empty() ? Tier::kPhysics : kind.tiers.front();
  if (kind.set_defaults) kind.set_defaults(*this);
}

std::string_view Scenario::tier_name() const { return world.kind->tiers.empty() ? "none" : to_string(tier); }

std::filesystem::path Scenario::resolve(const std::string& relative) const {
  const std::filesystem::path path(relative);
  return path.is_absolute() ? path : (file.parent_path() / path).lexically_normal();
}

std::map<std::string, std::string> Scenario::shares(const AgentSpec& agent) const {
  std::map<std::string, std::string> out;
  for (const auto* list : {&packages, &agent.packages})
    for (const auto& [package_name, package] : *list) {
      std::filesystem::path path = std::filesystem::absolute(resolve(package.folder)).lexically_normal();
      if (!path.has_filename()) path = path.parent_path();
      out[package_name] = path.string();
    }
  return out;
}

std::string Scenario::strange_config(const AgentSpec& agent) const {
  const std::filesystem::path config = std::filesystem::absolute(resolve(agent.config)).lexically_normal();
  const auto folder = nearest_package(config.parent_path());
  const auto known = shares(agent);
  const auto package = folder ? known.find(package_name(*folder)) : known.end();
  std::error_code ignored;
  if (package == known.end() || std::filesystem::equivalent(package->second, *folder, ignored)) return {};
  return "agents: config is " + agent.config + ", but packages has " + package->first + " in " + package->second +
         ": files that only the configuration there loads are not loaded; set config, too";
}

namespace {

using Texts = std::vector<std::pair<std::string, std::string>>;

Texts folders_of(const std::map<std::string, PackageSpec>& packages) {
  Texts out;
  for (const auto& [name, package] : packages) out.emplace_back(name, package.folder);
  return out;
}

template <class Kind>
yaml::Writer write(const char* key, const Chosen<Kind>& spec) {
  yaml::Writer out;
  out(key, std::string(spec.kind->name));
  if (spec.kind->settings.write) out.add(spec.kind->settings.write(spec.config));
  return out;
}

yaml::Writer write(const AgentSpec& agent) {
  yaml::Writer out, params;
  out("config", agent.config);
  out("namespace", agent.name_space);
  if (!agent.remaps.empty()) out("remap", agent.remaps);
  if (!agent.packages.empty()) out("packages", folders_of(agent.packages));
  for (const cx::GivenParameter& param : agent.params) params.put_yaml(param.name, param.value);
  if (!params.empty()) out.put("params", params);
  out("activate", agent.activate);
  return out;
}

}  // namespace

std::string Scenario::to_yaml() const {
  yaml::Writer out;
  out("schema", 1);
  out.put("world", write("kind", world));
  if (!world.kind->tiers.empty()) out("tier", std::string(to_string(tier)));
  out("seed", seed);
  out("epoch", epoch);
  out("duration_s", duration);
  out("tick_s", tick);
  out("physics_step_s", physics_step);
  if (!packages.empty()) out("packages", folders_of(packages));
  for (const AgentSpec& agent : agents) out.append("agents", write(agent));
  for (const ServerSpec& server : servers) out.append("servers", write("node", server));
  for (const Stimulus& stimulus : stimuli) out.append("stimuli", write_stimulus(stimulus));
  if (bag) out.put("bag", yaml::Writer::changed(bag));
  for (const SectionSpec& section : sections) out.add(section.kind->write(section.kind->key, section.config));
  out("on_rule_error", stop_on_rule_error ? "stop" : "continue");
  out("max_firings_per_tick", max_firings_per_tick);
  out("trust_rules", trust_rules);
  for (const Expectation& e : expect) out.append("expect", yaml::Writer::of(e));
  return out.text();
}

}  // namespace cxlab
