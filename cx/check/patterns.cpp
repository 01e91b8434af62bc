#include "cx/check/patterns.h"

#include <algorithm>
#include <utility>

#include "cx/base/number_text.h"

namespace cxlab::check {

namespace {

bool is_constant(const Term& term) {
  return term.kind == Token::Kind::kString ||
         (term.kind == Token::Kind::kWord && !is_variable(term) && !term.is(":") && !term.is("="));
}

std::string print(std::span<const Term> items) {
  std::string out;
  for (const Term& item : items) out += item.print() + ' ';
  return out;
}

SlotConstraint constraint_of(std::span<const Term> items) {
  SlotConstraint out;
  out.text = print(items);
  std::vector<std::set<std::string>> together(1);  // alternatives between two &
  bool negated = false, first = true, alternatives = false;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const Term& item = items[i];
    if (item.is("~") && item.kind == Token::Kind::kConnective) {
      negated = !negated;
      continue;
    }
    if (item.kind == Token::Kind::kConnective) {
      if (item.is("&")) together.emplace_back();
      alternatives = alternatives || item.is("|");
      continue;
    }
    if (i > 0 && items[i - 1].kind != Token::Kind::kConnective) out.plain = false;  // several fields
    const bool is_first = std::exchange(first, false), is_negated = std::exchange(negated, false);
    if (is_constant(item)) {
      if (is_negated)
        out.none_of.insert(item.print());
      else
        together.back().insert(item.print());
    } else if (is_variable(item)) {
      const std::string name = variable_name(item);
      if (item.text.starts_with("$?")) out.plain = false;
      if (is_negated && name == out.variable) out.impossible = true;
      if (is_first && !is_negated)
        out.variable = name;
      else
        out.plain = out.plain && name.empty();
    } else {
      out.plain = false;
    }
  }
  if (items.size() == 4 && !out.variable.empty() && items[1].is("&") && items[2].is(":") &&
      items[3].items.size() == 3 && variable_name(items[3].items[1]) == out.variable &&
      read_number<double>(items[3].items[2].text)) {
    const std::string_view op = items[3].head();
    out.unbounded = op == ">" || op == ">=" ? 1 : op == "<" || op == "<=" ? -1 : 0;
  }
  if (alternatives && (!out.none_of.empty() || (!out.variable.empty() && together.size() < 2))) out.plain = false;
  bool constrained = false;
  for (const std::set<std::string>& some : together) {
    if (some.empty()) continue;
    if (!constrained) {
      out.one_of = some;
    } else {
      std::erase_if(out.one_of, [&](const std::string& value) { return !some.contains(value); });
    }
    constrained = true;
  }
  if (constrained && out.plain) {
    const bool none = std::ranges::none_of(out.one_of, [&](const std::string& v) { return !out.none_of.contains(v); });
    out.impossible = out.impossible || none;
  }
  return out;
}

}  // namespace

bool SlotConstraint::wider_than(const SlotConstraint& other) const {
  if (any() || text == other.text) return true;
  if (!plain) return false;
  if (!other.one_of.empty())
    return std::ranges::all_of(other.one_of, [&](const std::string& value) { return admits(value); });
  return one_of.empty() && std::ranges::includes(other.none_of, none_of);
}

bool PatternSlots::wider_than(const PatternSlots& other) const {
  if (name != other.name) return false;
  return std::ranges::all_of(slots, [&](const auto& item) {
    const auto found = other.slots.find(item.first);
    return item.second.any() ? true : found != other.slots.end() && item.second.wider_than(found->second);
  });
}

std::optional<PatternSlots> slots_of(const Term& pattern) {
  const std::string_view head = pattern.head();
  if (head.empty() || is_group(head) || head == "test" || head == "object" || head == "declare") return std::nullopt;
  PatternSlots out{std::string(without_module(head)), {}};
  const std::span<const Term> items = std::span(pattern.items).subspan(1);
  if (!items.empty() && items.front().is_list()) {
    for (const Term& slot : items)
      if (!slot.head().empty()) out.slots[std::string(slot.head())] = constraint_of(std::span(slot.items).subspan(1));
    return out;
  }
  std::size_t begin = 0;
  int field = 1;
  while (begin < items.size()) {
    std::size_t end = begin + 1;
    const auto joins = [&](const Term& t) { return t.kind == Token::Kind::kConnective || t.is(":") || t.is("="); };
    while (end < items.size() && (items[end].kind == Token::Kind::kConnective || joins(items[end - 1]))) ++end;
    out.slots[std::to_string(field++)] = constraint_of(items.subspan(begin, end - begin));
    begin = end;
  }
  out.slots["#"] = SlotConstraint{std::to_string(items.size()), {}, {std::to_string(field)}, {}, false, true};
  return out;
}

std::map<std::string, std::span<const Term>> values_of(const Term& fact, std::size_t from) {
  std::map<std::string, std::span<const Term>> out;
  const std::span<const Term> items = std::span(fact.items).subspan(std::min(from, fact.items.size()));
  const bool slots = std::ranges::any_of(items, [](const Term& t) { return t.is_list(); });
  for (std::size_t i = 0; i < items.size(); ++i)
    if (slots && items[i].is_list() && items[i].items.size() > 1)
      out[std::string(items[i].head())] = std::span(items[i].items).subspan(1);
    else if (!items[i].is_list())
      out[std::to_string(i + 1)] = items.subspan(i, 1);
  return out;
}

std::set<std::string> variables_in(const Term& term) {
  std::set<std::string> out;
  if (std::string name = variable_name(term); !name.empty()) out.insert(std::move(name));
  for (const Term& item : term.items) out.merge(variables_in(item));
  return out;
}

std::size_t count_of(const Term& term, const std::string& variable) {
  std::size_t count = variable_name(term) == variable;
  for (const Term& item : term.items) count += count_of(item, variable);
  return count;
}

}  // namespace cxlab::check
