#include "app/conditions.h"

#include <algorithm>
#include <string_view>

namespace cxlab::app {

namespace {

/// Terms as they were written: the body of a test or call stands close to its sign (?x&:(> ?x 3), =(+ 1 ?x)).
std::string joined(const std::vector<Term>& terms) {
  std::string out, before;
  for (const Term& term : terms) {
    const bool close = before.ends_with(':') || before == "=" || before.ends_with("&=") || before.ends_with("|=") ||
                       before.ends_with("~=");
    out += (out.empty() || (close && term.is_list) ? "" : " ") + term.text();
    before = term.word;
  }
  return out;
}

}  // namespace

std::string Term::text() const { return is_list ? '(' + joined(items) + ')' : word; }

namespace {

class Reader {
 public:
  explicit Reader(std::string_view text) : text_(text) {}

  std::optional<Term> next() {
    skip_blanks();
    if (at_ >= text_.size()) return std::nullopt;
    if (text_[at_] == ')') {
      ++at_;
      return std::nullopt;
    }
    Term term;
    if (text_[at_] == '(') {
      ++at_;
      term.is_list = true;
      while (auto item = next()) term.items.push_back(*std::move(item));
      return term;
    }
    const std::size_t begin = at_;
    if (text_[at_] == '"')
      skip_string();
    else
      while (at_ < text_.size() && std::string_view(" \t\r\n();\"").find(text_[at_]) == std::string_view::npos) ++at_;
    term.word = text_.substr(begin, at_ - begin);
    return term;
  }

 private:
  void skip_string() {
    for (++at_; at_ < text_.size() && text_[at_] != '"'; ++at_)
      if (text_[at_] == '\\') ++at_;
    at_ = std::min(at_ + 1, text_.size());
  }

  void skip_blanks() {
    while (at_ < text_.size()) {
      if (text_[at_] == ';')
        at_ = std::min(text_.find('\n', at_), text_.size());
      else if (std::string_view(" \t\r\n").find(text_[at_]) != std::string_view::npos)
        ++at_;
      else
        return;
    }
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

void collect(const Term& term, bool negated, std::vector<Condition>& out) {
  if (!term.is_list || term.items.empty()) return;
  const std::string& head = term.items.front().word;
  if (head == "test" || head == "declare") return;
  const bool logical =
      head == "and" || head == "or" || head == "exists" || head == "forall" || head == "logical" || head == "not";
  if (!logical) {
    out.push_back({term, negated});
    return;
  }
  for (std::size_t i = 1; i < term.items.size(); ++i) collect(term.items[i], negated != (head == "not"), out);
}

void collect_variables(const Term& term, std::vector<std::string>& out) {
  for (const Term& item : term.items) collect_variables(item, out);
  for (std::size_t at = term.word.find('?'); at != std::string::npos; at = term.word.find('?', at + 1)) {
    const std::string name = term.word.substr(at, term.word.find_first_of("&|~:", at) - at);
    if (name.size() > 1 && std::find(out.begin(), out.end(), name) == out.end()) out.push_back(name);
  }
}

bool is_open(const std::string& word) {
  return word.empty() || word[0] == '?' || word[0] == '$' || word[0] == ':' || word[0] == '=';
}

/// Whether a value may be what one field of a pattern allows, as far as constants tell.
bool may_be(const std::string& constraint, const std::string& value) {
  std::size_t begin = 0;
  while (begin <= constraint.size()) {
    const std::size_t end = std::min(constraint.find('&', begin), constraint.size());
    std::string part = constraint.substr(begin, end - begin);
    begin = end + 1;
    bool any = false;
    for (std::size_t from = 0; from <= part.size();) {
      const std::size_t to = std::min(part.find('|', from), part.size());
      const std::string word = part.substr(from, to - from);
      from = to + 1;
      const bool inverted = word.starts_with('~');
      const std::string constant = inverted ? word.substr(1) : word;
      any = any || is_open(constant) || (constant == value) != inverted;
    }
    if (!any) return false;
  }
  return true;
}

std::vector<std::string> fields_of(const Value& value) {
  std::vector<std::string> fields;
  if (value.type() != ValueType::kMultifield) return {value.print()};
  for (const Value& item : value.items()) fields.push_back(item.print());
  return fields;
}

/// The constraints of one slot against its value; a list (the body of a test or call) belongs to the word before.
bool may_match(const std::vector<Term>& constraints, const Value& value) {
  std::vector<std::string> words;
  for (const Term& term : constraints) {
    if (term.is_list) continue;
    if (term.word.starts_with("$?")) return true;
    words.push_back(term.word);
  }
  const std::vector<std::string> fields = fields_of(value);
  if (words.size() != fields.size()) return false;
  for (std::size_t i = 0; i < words.size(); ++i)
    if (!may_be(words[i], fields[i])) return false;
  return true;
}

}  // namespace

std::vector<std::string> Condition::variables() const {
  std::vector<std::string> out;
  collect_variables(pattern, out);
  return out;
}

std::vector<Condition> conditions_of(const std::string& defrule) {
  std::vector<Condition> out;
  const std::optional<Term> rule = Reader(defrule).next();
  if (!rule) return out;
  for (const Term& term : rule->items) {
    if (term.word == "=>") break;
    collect(term, false, out);
  }
  return out;
}

std::vector<Mismatch> mismatches(const Condition& condition, const FactCopy& fact) {
  std::vector<Mismatch> out;
  const auto compare = [&](const std::string& slot, const std::vector<Term>& constraints) {
    const Value* value = fact.slot(slot);
    if (value && !may_match(constraints, *value)) out.push_back({slot, value->print(), joined(constraints)});
  };
  const std::vector<Term>& items = condition.pattern.items;
  if (fact.slot("implied")) {
    compare("implied", {items.begin() + 1, items.end()});
    return out;
  }
  for (const Term& slot : items)
    if (slot.is_list && !slot.items.empty())
      compare(slot.items.front().word, {slot.items.begin() + 1, slot.items.end()});
  return out;
}

}  // namespace cxlab::app
