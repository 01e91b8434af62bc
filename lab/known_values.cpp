#include "lab/known_values.h"

#include <optional>

namespace cxlab::lab {

KnownValues::KnownValues(const std::vector<RuleText>& files) {
  for (const bool templates : {true, false})  // what facts with slots are called is known before facts are read
    for (const RuleText& file : files)
      for (const Form& form : read_forms(file.text, file.name).forms) {
        if (!form.list || (form.head == "deftemplate") != templates) continue;
        const Term tree = tree_of(form);
        if (templates)
          read_template(tree);
        else
          read_construct(tree);
      }
}

std::string KnownValues::other(const std::string& symbol, const std::string& slot, const WordSet& not_these) const {
  if (symbol == "TRUE") return "FALSE";
  if (symbol == "FALSE") return "TRUE";
  const bool quoted = symbol.starts_with('"');
  const auto next_of = [&](const WordSet& values) -> std::optional<std::string> {
    const auto after = values.upper_bound(symbol);
    for (auto it = after; it != values.end(); ++it)
      if (it->starts_with('"') == quoted && !not_these.contains(*it)) return *it;
    for (auto it = values.begin(); it != after; ++it)
      if (*it != symbol && it->starts_with('"') == quoted && !not_these.contains(*it)) return *it;
    return std::nullopt;
  };
  const auto known = values_.find(slot);
  if (known != values_.end())
    if (auto found = next_of(known->second)) return *found;
  if (known == values_.end() && !quoted)
    for (const auto& [name, values] : values_)
      if (values.contains(symbol))
        if (auto found = next_of(values)) return *found;
  if (quoted) return symbol == "\"\"" ? "\"other\"" : "\"\"";
  return "not-" + symbol;
}

void KnownValues::read_template(const Term& tree) {
  if (tree.items.size() < 2) return;
  const std::string name(without_module(tree.items[1].text));
  templates_.insert(name);
  for (const Term& slot : tree.items) {
    if (!is_one_of(slot.head(), {"slot", "field", "multislot", "multifield"}) || slot.items.size() < 2) continue;
    for (const Term& facet : slot.items)
      if (is_one_of(facet.head(),
                    {"allowed-symbols", "allowed-values", "allowed-strings", "allowed-lexemes", "default"}))
        add(name + '.' + slot.items[1].text, facet, 1);
  }
}

void KnownValues::read_construct(const Term& tree) {
  std::map<std::string, std::string> templates_of;  // facts that variables stand for
  bool conditions = tree.head() == "defrule";
  for (std::size_t i = 2; i < tree.items.size(); ++i) {
    const Term& item = tree.items[i];
    if (item.is("=>")) conditions = false;
    if (!item.is_list()) continue;
    if (conditions && i > 1 && tree.items[i - 1].is("<-")) templates_of[tree.items[i - 2].text] = item.head();
    if (conditions)
      read_condition(item);
    else if (tree.head() == "deffacts")
      read_fact(item);
    else
      read_actions(item, templates_of);
  }
}

void KnownValues::read_condition(const Term& condition) {
  if (is_one_of(condition.head(), {"and", "or", "not", "exists", "forall", "logical"})) {
    for (const Term& item : condition.items)
      if (item.is_list()) read_condition(item);
  } else if (!is_one_of(condition.head(), {"test", "declare"})) {
    for (std::size_t i = 1; i < condition.items.size(); ++i)
      if (condition.items[i].is_list() && !condition.items[i - 1].is(":") && !condition.items[i - 1].is("="))
        templates_.insert(std::string(condition.head()));
    read_fact(condition);
  }
}

void KnownValues::read_fact(const Term& fact) {
  const std::string name(fact.head());
  if (!has_slots(name)) return;
  for (const Term& slot : fact.items)
    if (slot.is_list() && !slot.items.empty()) add(name + '.' + std::string(slot.head()), slot, 1);
}

void KnownValues::read_actions(const Term& call, const std::map<std::string, std::string>& templates_of) {
  if (call.head() == "assert") {
    for (const Term& fact : call.items) read_fact(fact);
  } else if (is_one_of(call.head(), {"modify", "duplicate"}) && call.items.size() > 1) {
    const auto known = templates_of.find(call.items[1].text);
    for (const Term& slot : call.items)
      if (slot.is_list() && known != templates_of.end()) add(known->second + '.' + std::string(slot.head()), slot, 1);
  }
  for (const Term& item : call.items)
    if (item.is_list()) read_actions(item, templates_of);
}

void KnownValues::add(const std::string& slot, const Term& values, std::size_t from) {
  for (std::size_t i = from; i < values.items.size(); ++i) {
    const Term& value = values.items[i];
    if (is_constant(value) && !is_number_word(value.text) && !is_one_of(value.text, {":", "=", "nil"}))
      values_[slot].insert(value.text);
  }
}

}  // namespace cxlab::lab
