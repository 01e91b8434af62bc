#include "cx/explain/agenda_watch.h"

#include <algorithm>
#include <utility>

namespace cxlab::explain {

void AgendaWatch::look(const RuleEngine& engine, SimTime t, const std::string& module, const std::string& firing) {
  std::vector<ActivationInfo> agenda = engine.agenda();
  std::erase_if(agenda, [&](const ActivationInfo& activation) { return activation.rule != rule_; });
  for (Waiting& before : waiting_) {
    const bool waits = std::ranges::any_of(agenda, [&](const ActivationInfo& activation) {
      return activation.module == before.activation.module && activation.facts == before.activation.facts;
    });
    if (!waits) lost_[before.activation.module] = {since_, std::move(before.facts), at_work_};
  }
  // The one that fires stands at the head of its module's agenda until its actions begin.
  if (firing == rule_) {
    const auto first = std::ranges::find(agenda, module, &ActivationInfo::module);
    if (first != agenda.end()) agenda.erase(first);
  }
  waiting_.clear();
  for (ActivationInfo& activation : agenda) {
    Waiting& now = waiting_.emplace_back(Waiting{std::move(activation), {}});
    for (const std::int64_t index : now.activation.facts)
      if (index >= 0)
        if (const auto fact = engine.fact(index)) now.facts.push_back(fact->print());
  }
  at_work_ = firing.empty() || module == "MAIN" ? firing : module + "::" + firing;
  since_ = t;
}

const LostActivation* AgendaWatch::last(const std::string& module) const {
  const auto found = lost_.find(module);
  return found == lost_.end() ? nullptr : &found->second;
}

}  // namespace cxlab::explain
