#include "cx/explain/history.h"

#include <algorithm>

#include "cx/engine/form_reader.h"
#include "cx/explain/fact_record.h"

namespace cxlab::explain {

bool Firing::is_of(std::string_view name) const {
  const std::string_view bare = without_module(name);
  return rule == bare && (bare.size() == name.size() || module == name.substr(0, name.size() - bare.size() - 2));
}

std::string module_of(const JournalRecord& firing) {
  return std::string(firing.data.find("module") ? firing.data.text("module") : "MAIN");
}

const std::vector<FactCopy>& History::last_facts(const std::string& module) const {
  static const std::vector<FactCopy> kNone;
  const auto known = last_facts_.find(module);
  return known == last_facts_.end() ? kNone : known->second;
}

const Firing* History::fired_for(const std::string& module, const std::vector<std::int64_t>& facts) const {
  std::uint64_t changed = 0;
  for (const std::int64_t number : facts)
    if (const auto known = present_.find(number); known != present_.end()) changed = std::max(changed, known->second.n);
  const auto fired = std::find_if(firings_.rbegin(), firings_.rend(), [&](const Firing& firing) {
    return firing.rule == options_.rule && firing.module == module && firing.facts == facts;
  });
  return fired != firings_.rend() && fired->n >= changed ? &*fired : nullptr;
}

void History::end_version(const Present& present, SimTime t) {
  if (options_.past_facts) facts_[present.version].until = t;
}

void History::add(const JournalRecord& record) {
  if (record.kind == RecordKind::kFire) {
    const std::string module = module_of(record);
    Firing& firing = firings_.emplace_back(Firing{record.t, std::string(record.data.text("rule")), module});
    if (firing.rule != options_.rule) return;
    firing.n = record.n;
    std::vector<FactCopy>& last_facts = last_facts_[module];
    last_facts.clear();
    for (const std::int64_t fact : facts_of_firing(record.data)) {
      if (!present_.contains(fact)) continue;
      firing.facts.push_back(fact);
      last_facts.push_back(present_[fact].fact);
    }
    return;
  }
  const std::int64_t number = record.data.integer("fact");
  const auto known = present_.find(number);
  if (known != present_.end()) end_version(known->second, record.t);
  if (record.kind == RecordKind::kRetract) {
    present_.erase(number);
    return;
  }
  Present& present = present_[number];
  apply(record, present.fact);
  present.version = facts_.size();
  present.n = record.n;
  templates_.insert(present.fact.template_name);
  if (options_.past_facts) facts_.push_back({present.fact, record.t});
}

bool Histories::wants(std::string_view stream, RecordKind kind) const {
  return (kind == RecordKind::kAssert || kind == RecordKind::kModify || kind == RecordKind::kRetract ||
          kind == RecordKind::kFire || kind == RecordKind::kDecision) &&  // of an environment: a fact, too
         stream.starts_with("env/");
}

void Histories::heard(const JournalRecord& record) {
  by_stream_.try_emplace(record.stream, options_).first->second.add(record);
}

const History& Histories::of(const std::string& stream) {
  return by_stream_.try_emplace(stream, options_).first->second;
}

}  // namespace cxlab::explain
