#include "cx/check/rule_base.h"

#include <algorithm>
#include <cctype>

namespace cxlab::check {

bool is_symbol(const Term& term) {
  if (term.kind != Token::Kind::kWord || term.text.empty() || term.text == "=>" || term.text == "<-") return false;
  const auto first = static_cast<unsigned char>(term.text.front());
  return std::isalpha(first) != 0 || first == '_';
}

bool is_variable(const Term& term) {
  return term.kind == Token::Kind::kWord && (term.text.starts_with('?') || term.text.starts_with("$?"));
}

std::string variable_name(const Term& term) {
  if (!is_variable(term)) return {};
  std::string name = term.text.substr(term.text.starts_with('$') ? 2 : 1);
  if (name.starts_with('*') && name.size() > 1) return {};
  return name.substr(0, name.find(':'));
}

bool is_group(std::string_view head) { return is_any(head, {"and", "or", "not", "exists", "forall", "logical"}); }

bool is_query(std::string_view head) {
  return is_any(head, {"do-for-fact", "do-for-all-facts", "delayed-do-for-all-facts", "any-factp", "find-fact",
                       "find-all-facts"});
}

std::size_t first_action(const Term& rule) {
  std::size_t i = 0;
  while (i < rule.items.size() && !rule.items[i].is("=>")) ++i;
  return std::min(i + 1, rule.items.size());
}

const Values& RuleBase::possible(const std::string& key) const {
  const auto [known, fresh] = possible_.try_emplace(key);
  if (!fresh) return known->second;
  Values& values = known->second;
  std::set<std::string> seen{key};
  std::vector<std::string> open{key};
  while (!open.empty()) {
    const std::string at = std::move(open.back());
    open.pop_back();
    if (at.starts_with("s:")) {
      const std::string name = at.substr(2, at.rfind('.') - 2);
      if (outside_.templates.contains(name) || outside_.facts.contains(name) || is_mentioned(name)) values.open = true;
    }
    const auto found = flows_.find(at);
    if (found == flows_.end()) {
      values.open = values.open || !at.starts_with("s:");
      continue;
    }
    for (const auto& [symbol, by] : found->second.values.symbols) values.symbols[symbol].insert(by.begin(), by.end());
    values.open = values.open || found->second.values.open;
    values.open_text = values.open_text || found->second.values.open_text;
    for (const std::string& next : found->second.from)
      if (seen.insert(next).second) open.push_back(next);
  }
  return values;
}

std::string RuleBase::origin_of(std::string key) const {
  for (int step = 0; step < 20 && !key.starts_with("s:"); ++step) {
    const auto found = flows_.find(key);
    if (found == flows_.end() || found->second.from.size() != 1 || !found->second.values.symbols.empty()) break;
    key = *found->second.from.begin();
  }
  return key;
}

bool RuleBase::lacks_slot(const std::string& template_name, const std::string& slot) const {
  if (const auto defined = templates_.find(template_name); defined != templates_.end())
    return !defined->second.slots.empty() && !defined->second.slots.contains(slot);
  const auto known = outside_.slots.find(template_name);
  return known != outside_.slots.end() && !known->second.contains(slot);
}

std::vector<std::string> RuleBase::slots_of(const std::string& template_name) const {
  std::vector<std::string> names;
  if (const auto defined = templates_.find(template_name); defined != templates_.end())
    for (const auto& [name, slot] : defined->second.slots) names.push_back(name);
  else if (const auto known = outside_.slots.find(template_name); known != outside_.slots.end())
    names.assign(known->second.begin(), known->second.end());
  return names;
}

bool RuleBase::is_set(const std::string& template_name, const std::string& slot) const {
  return sets_.contains({template_name, slot});
}

bool RuleBase::is_read(const std::string& template_name, const std::string& slot) const {
  return reads_.contains({template_name, slot}) || reads_.contains({"", slot});
}

const std::set<const Construct*>& RuleBase::users(const std::string& name) const {
  static const std::set<const Construct*> kNobody;
  const auto found = users_.find(name);
  return found == users_.end() ? kNobody : found->second;
}

}  // namespace cxlab::check
