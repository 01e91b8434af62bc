#include "scenarios/floor/sections.h"

#include <algorithm>
#include <string>

#include "sim/skills/skill.h"

namespace cxlab {
namespace {

using sim::Fault;
using sim::FaultWord;

/// Whether the kind takes that key, and whether it must be there ("seconds*").
bool takes(const FaultWord& word, const std::string& key) {
  return (", " + std::string(word.arguments)).find(", " + key) != std::string::npos;
}
bool needs(const FaultWord& word, const std::string& key) { return takes(word, key + '*'); }

void read_when(yaml::Map& map, const FaultWord& word, Fault& fault) {
  const char* chance = word.by_occasion ? "probability" : "mean_s";
  const bool at = map.has("at"), by_chance = map.has(chance);
  if (at == by_chance) return map.fail(std::string("expected either at or ") + chance);
  if (at) {
    fault.at.emplace();
    map.read_seconds("at", *fault.at);
    return;
  }
  if (word.by_occasion) {
    map.read("probability", fault.probability);
    if (!(fault.probability >= 0 && fault.probability <= 1))
      map.get("probability").fail(found_expected(map.get("probability").text(), "a probability, 0 .. 1"));
  } else {
    map.read_seconds("mean_s", fault.mean);
    if (fault.mean < from_seconds(0.001))
      map.get("mean_s").fail(found_expected(map.get("mean_s").text(), "at least 0.001 s"));
  }
  map.read_seconds("from", fault.from).read_seconds("until", fault.until).read("times", fault.times);
  if (fault.until <= fault.from) map.get("until").fail(found_expected(map.get("until").text(), "a time after from"));
  if (fault.times < 0) map.get("times").fail("must be 0 (no limit) or more");
}

void read_error(yaml::Map& map, Fault& fault) {
  map.read("error", fault.error);
  constexpr int kCodes[]{103, 201, 202, 203, 204, 206, 207, 208, 209, 220, 300};
  if (!map.has("error") || std::ranges::find(kCodes, fault.error) != std::end(kCodes)) return;
  std::string list;
  for (const int code : kCodes) list += (list.empty() ? "" : ", ") + std::to_string(code);
  map.get("error").fail(found_expected(std::to_string(fault.error), "one of: " + list));
}

void read_factor(yaml::Map& map, Fault& fault) {
  map.read("factor", fault.factor);
  if (!(fault.factor >= 0.05 && fault.factor <= 1))
    map.get("factor").fail(found_expected(map.get("factor").text(), "a share of the speed, 0.05 .. 1"));
}

void read_sigma(yaml::Map& map, const char* key, double most, double& sigma) {
  map.read(key, sigma);
  if (!(sigma >= 0 && sigma <= most))
    map.get(key).fail(found_expected(map.get(key).text(), "0 to " + std::to_string(static_cast<int>(most))));
}

Fault read_fault(const yaml::Value& value) {
  Fault fault;
  fault.origin = value.origin();
  yaml::Map map = value.as_map();
  std::vector<std::string> kinds;
  for (const FaultWord& word : sim::fault_words()) kinds.emplace_back(word.name);
  std::string kind;
  if (!map.require("kind")) {
    map.finish();
    return fault;
  }
  map.read_word("kind", kind, kinds);
  const auto word = std::ranges::find(sim::fault_words(), kind, &FaultWord::name);
  if (word == sim::fault_words().end()) return fault;
  fault.kind = word->kind;
  read_when(map, *word, fault);
  for (const char* key : {"machine", "factor", "seconds", "sigma_m", "sigma_deg"})
    if (needs(*word, key)) map.require(key);
  if (takes(*word, "robot")) map.read("robot", fault.robot);
  if (takes(*word, "machine")) map.read("machine", fault.machine);
  if (takes(*word, "skill")) {
    std::vector<std::string> skills;
    for (const sim::SkillWord& skill : sim::skill_words()) skills.emplace_back(skill.name);
    map.read_word("skill", fault.skill, skills);
  }
  if (takes(*word, "error")) read_error(map, fault);
  if (takes(*word, "after_s")) map.read_seconds("after_s", fault.after);
  if (takes(*word, "seconds")) map.read_seconds("seconds", fault.duration);
  if (takes(*word, "factor")) read_factor(map, fault);
  if (takes(*word, "sigma_m")) read_sigma(map, "sigma_m", 2, fault.sigma_m);
  if (takes(*word, "sigma_deg")) read_sigma(map, "sigma_deg", 90, fault.sigma_deg);
  map.finish();
  return fault;
}

yaml::Writer write_fault(const Fault& fault) {
  const FaultWord& word = *std::ranges::find(sim::fault_words(), fault.kind, &FaultWord::kind);
  yaml::Writer out;
  out("kind", std::string(word.name));
  if (fault.at) {
    out("at", *fault.at);
  } else {
    if (word.by_occasion)
      out("probability", fault.probability);
    else
      out("mean_s", fault.mean);
    out("from", fault.from);
    if (fault.until != kNever) out("until", fault.until);
    out("times", fault.times);
  }
  if (!fault.robot.empty()) out("robot", fault.robot);
  if (!fault.machine.empty()) out("machine", fault.machine);
  if (!fault.skill.empty()) out("skill", fault.skill);
  if (fault.error != 0) out("error", fault.error);
  if (takes(word, "after_s")) out("after_s", fault.after);
  if (takes(word, "seconds")) out("seconds", fault.duration);
  if (takes(word, "factor")) out("factor", fault.factor);
  if (takes(word, "sigma_m")) out("sigma_m", fault.sigma_m);
  if (takes(word, "sigma_deg")) out("sigma_deg", fault.sigma_deg);
  return out;
}

using Faults = std::vector<Fault>;

void read_faults(const yaml::Value& list, std::any& config) {
  Faults& faults = config.emplace<Faults>();
  for (const yaml::Value& item : list.as_list()) faults.push_back(read_fault(item));
}

yaml::Writer write_faults(std::string_view key, const std::any& config) {
  yaml::Writer out;
  for (const Fault& fault : std::any_cast<const Faults&>(config)) out.append(key, write_fault(fault));
  return out;
}

}  // namespace

constinit const SectionKind kTimedSection = section_of<sim::TimedSkillsConfig>("timed");
constinit const SectionKind kFaultsSection{.key = "faults",
                                           .read = read_faults,
                                           .write = write_faults,
                                           .elsewhere = "this world has neither robots nor machines"};

const sim::TimedSkillsConfig& timed_of(const Scenario& scenario) {
  return scenario.section<sim::TimedSkillsConfig>(kTimedSection);
}

std::vector<Fault> faults_of(const Scenario& scenario) {
  Faults faults = scenario.section<Faults>(kFaultsSection);
  for (std::size_t i = 0; i < faults.size(); ++i) faults[i].number = i;
  return faults;
}

}  // namespace cxlab
