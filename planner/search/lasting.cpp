#include "planner/search/lasting.h"

#include <algorithm>
#include <map>

#include "planner/ground/sorted.h"

namespace cxlab::planner {

GroundTask with_lasting_facts(const GroundTask& task) {
  std::vector<DurationRange> durations;
  for (const GroundAction& action : task.actions) durations.push_back(constant_durations(action));
  ById<std::vector<Micros>> held(task.facts.size());  // by fact: durations of those that hold it for as long, ascending
  for (std::size_t a = 0; a < task.actions.size(); ++a)
    for (const int f : task.actions[a].at_start.add)
      if (contains(task.actions[a].at_end.remove, f)) held[f].push_back(durations[a].most);
  for (auto& lengths : held) std::ranges::sort(lengths);
  const auto too_short = [&held](int f, Micros length) {
    return static_cast<std::size_t>(std::ranges::lower_bound(held[f], length) - held[f].begin());
  };
  std::map<std::pair<int, std::size_t>, int> lasting;  // by fact and how many hold it too shortly
  GroundTask out = task;
  for (std::size_t a = 0; a < task.actions.size(); ++a) {
    std::vector<int> needed;
    for (const int f : task.actions[a].over_all.facts) {
      const std::size_t useless = too_short(f, durations[a].least);
      if (useless == 0 || task.facts[f].derived || contains(task.actions[a].at_start.add, f)) continue;
      const auto [known, fresh] = lasting.try_emplace({f, useless}, static_cast<int>(out.facts.size()));
      if (fresh) {
        out.facts.push_back({-1, {}, -1, false, false});
        out.initial_facts.push_back(task.initial_facts[f]);
      }
      needed.push_back(known->second);
    }
    std::vector<int>& facts = out.actions[a].over_all.facts;
    facts.insert(facts.end(), needed.begin(), needed.end());
    std::ranges::sort(facts);
  }
  if (lasting.empty()) return out;
  const auto follow = [&](GroundEffects& effects, const GroundAction* holder, Micros length) {
    const GroundEffects before = effects;
    for (const auto& [key, fact] : lasting) {
      const auto [f, useless] = key;
      const bool lasts = !holder || !contains(holder->at_end.remove, f) || too_short(f, length) >= useless;
      if (contains(before.add, f) && lasts) effects.add.push_back(fact);
      if (contains(before.remove, f)) effects.remove.push_back(fact);
    }
    std::ranges::sort(effects.add);
    std::ranges::sort(effects.remove);
  };
  for (std::size_t a = 0; a < task.actions.size(); ++a) {
    GroundAction& action = out.actions[a];
    follow(action.at_start, &task.actions[a], durations[a].most);
    follow(action.at_end, nullptr, 0);
    for (ConditionalEffects& conditional : action.conditional) {
      follow(conditional.at_start, nullptr, 0);
      follow(conditional.at_end, nullptr, 0);
    }
  }
  for (TimedEvent& event : out.events) follow(event.effects, nullptr, 0);
  return out;
}

}  // namespace cxlab::planner
