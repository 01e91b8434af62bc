#include "cx/explain/names.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "cx/base/number_text.h"
#include "cx/engine/template_names.h"

namespace cxlab::explain {

namespace {

/// The slots of a deftemplate, `(slot NAME ...)`; none for one that CLIPS has made for an ordered fact.
std::optional<std::vector<Term>> slots_of(const RuleEngine& engine, const std::string& name) {
  const ConstructInfo* info = engine.find_construct("deftemplate", name);
  if (info == nullptr) return std::nullopt;
  std::vector<Term> slots;
  for (Term& item : tree_of(Form{info->text, info->line, true, info->kind, info->name}).items)
    if (item.items.size() > 1 &&
        (item.head() == "slot" || item.head() == "multislot" || item.head() == "field" || item.head() == "multifield"))
      slots.push_back(std::move(item));
  return slots;
}

/// The words for what CLIPS calls the type of a constant; empty for other values.
std::vector<std::string_view> types_of(const Value& value) {
  switch (value.type()) {
    case ValueType::kFloat:
      if (value.as_number() != std::floor(value.as_number())) return {"FLOAT", "NUMBER"};
      [[fallthrough]];
    case ValueType::kInteger: return {"INTEGER", "FLOAT", "NUMBER"};
    case ValueType::kSymbol: return {"SYMBOL", "LEXEME"};
    case ValueType::kString: return {"STRING", "LEXEME"};
    default: return {};
  }
}

bool has_word(std::span<const std::string> words, std::span<const std::string_view> wanted) {
  return std::ranges::any_of(words, [&](const std::string& word) { return std::ranges::count(wanted, word) > 0; });
}

/// What the facets of a slot say against a value of it.
Status check_value(const std::string& name, const Term& slot, const Value& value) {
  const std::vector<std::string_view> types = types_of(value);
  const std::string found = "slot '" + slot.items[1].text + "' of template '" + name + "' cannot be " + value.print();
  for (const Term& facet : slot.items) {
    if (!facet.is_list() || facet.items.size() < 2 || facet.items[1].text.starts_with('?') || types.empty()) continue;
    std::vector<std::string> words;
    for (auto item = facet.items.begin() + 1; item != facet.items.end(); ++item) words.push_back(item->text);
    if (facet.head() == "type" && !has_word(words, types)) {
      const bool other = (value.is(ValueType::kSymbol) && has_word(words, std::array<std::string_view, 1>{"STRING"}));
      return input_error(found + "; its type is " + some_of(words) + (other ? ": write \"" + value.print() + '"' : ""));
    }
    if (facet.head() == "range" && words.size() == 2 && value.is_number()) {
      const auto low = read_number<double>(words[0]), high = read_number<double>(words[1]);
      if ((low && value.as_number() < *low) || (high && value.as_number() > *high))
        return input_error(found + "; its range is " + words[0] + " to " + words[1]);
    }
    const bool about_it =
        facet.head() == "allowed-values" || (value.is(ValueType::kSymbol) && facet.head() == "allowed-symbols") ||
        (value.is(ValueType::kString) && facet.head() == "allowed-strings") ||
        ((value.is(ValueType::kSymbol) || value.is(ValueType::kString)) && facet.head() == "allowed-lexemes");
    if (about_it && std::ranges::count(words, value.print()) == 0)
      return input_error(found + "; it holds " + some_of_and_nearest(value.print(), words, 12));
  }
  return {};
}

/// Whether the texts are the same but for the quotes of one of them.
bool differ_in_quotes(const std::string& a, const std::string& b) {
  return a != b && (a == '"' + b + '"' || b == '"' + a + '"');
}

}  // namespace

std::string with_module(const std::string& module, const std::string& name) {
  return module.empty() || module == "MAIN" ? name : module + "::" + name;
}

std::vector<std::string> names_of(const RuleEngine& engine, std::string_view kind) {
  std::vector<std::string> names;
  for (const ConstructInfo& info : engine.constructs())
    if (info.kind == kind) names.push_back(info.name);
  return names;
}

Status check_names(const Pattern& pattern, const RuleEngine& engine) {
  const std::string& name = pattern.template_name();
  if (pattern.is_object()) return {};
  const auto slots = slots_of(engine, name);
  if (!slots && !engine.has("deftemplate", name)) {
    std::vector<std::string> others = template_names(engine);
    std::erase(others, name);  // of a module that is not visible
    return input_error("there is no template '" + name + "'" + did_you_mean(name, others));
  }
  std::vector<std::string> known;
  if (slots)
    for (const Term& slot : *slots) known.push_back(slot.items[1].text);
  else
    known = engine.slot_names(name);  // also of one that a rule has built
  const bool ordered = !slots && known == std::vector<std::string>{"implied"};
  const std::vector<std::string> named = pattern.slot_names();
  if (!ordered && named.empty() && !pattern.constants().empty())
    return input_error("template '" + name + "' has slots; write (" + name + " (SLOT VALUE)), with one of " +
                       some_of(known));
  for (const std::string& slot : named) {
    if (std::ranges::count(named, slot) > 1) return input_error("slot '" + slot + "' is in the pattern twice");
    if (ordered) return input_error("template '" + name + "' has no slots: its facts are ordered");
    if (std::ranges::count(known, slot) == 0)
      return input_error("template '" + name + "' has no slot '" + slot + "'" + did_you_mean(slot, known));
    const std::size_t count = pattern.count_in(slot);
    const auto is_single = [&](const Term& one) {
      return one.items[1].is(slot) && (one.head() == "slot" || one.head() == "field");
    };
    if (count != 1 && slots && std::ranges::any_of(*slots, is_single))
      return input_error("slot '" + slot + "' of template '" + name + "' holds one value, found " +
                         (count == 0 ? "none" : std::to_string(count)));
  }
  return {};
}

Status check_values(const Pattern& pattern, const RuleEngine& engine, const std::vector<FactCopy>& facts) {
  if (const auto slots = slots_of(engine, pattern.template_name()))
    for (const auto& [name, value] : pattern.constants())
      for (const Term& slot : *slots)
        if (slot.items[1].is(name))
          if (Status s = check_value(pattern.template_name(), slot, value); !s) return s;
  for (const FactCopy& fact : facts) {
    if (fact.template_name != pattern.template_name()) continue;
    const std::vector<Mismatch> mismatches = pattern.mismatches(fact);
    const auto in_quotes = [](const Mismatch& m) { return differ_in_quotes(m.found, m.expected); };
    if (!mismatches.empty() && std::ranges::all_of(mismatches, in_quotes))
      return input_error("no fact matches: " + mismatches.front().slot + " holds " + mismatches.front().found +
                         ", which is not " + mismatches.front().expected +
                         " to CLIPS: one is a string, the other a symbol");
  }
  return {};
}

}  // namespace cxlab::explain
