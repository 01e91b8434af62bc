#include <algorithm>
#include <array>

#include "scenarios/scenario.h"

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
  stimulus.origin = value.origin();
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
    value.fail(found_expected(std::to_string(verbs) + " verbs", "exactly one of: " + list));
  }
  return stimulus;
}

}  // namespace

std::vector<Stimulus> read_stimuli(const yaml::Value& list) {
  std::vector<Stimulus> stimuli;
  if (list.is_map() && list.as_map().entries().empty()) return stimuli;  // an empty file
  for (const yaml::Value& item : list.as_list()) stimuli.push_back(read_stimulus(item));
  sort_stimuli(stimuli);
  return stimuli;
}

void sort_stimuli(std::vector<Stimulus>& stimuli) { std::ranges::stable_sort(stimuli, {}, &Stimulus::at); }

yaml::Writer write_stimulus(const Stimulus& stimulus) {
  const VerbWord& word = *std::ranges::find(kVerbs, stimulus.verb, &VerbWord::verb);
  yaml::Writer out;
  out("at", stimulus.at);
  if (stimulus.plugin.empty())
    out(word.key, stimulus.target);
  else
    out.below(word.key, [&](yaml::Writer& keys) {
      keys("env", stimulus.target);
      keys("plugin", stimulus.plugin);
    });
  if (!stimulus.manager.empty()) out("manager", stimulus.manager);
  if (word.typed) out("type", stimulus.type);
  if (word.content && !stimulus.content.empty()) out.put_yaml(word.content, stimulus.content);
  return out;
}

}  // namespace cxlab
