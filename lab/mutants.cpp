#include "lab/mutants.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <set>
#include <string_view>

#include "cx/base/number_text.h"
#include "cx/engine/form_reader.h"
#include "cx/journal/file_store.h"

namespace cxlab::lab {

namespace {

using Names = std::set<std::string, std::less<>>;

constexpr const char* kChanges[] = {"condition", "constraint", "negation", "connective", "comparison", "arithmetic",
                                    "number",    "symbol",     "action",   "slot",       "salience"};

bool is_one_of(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::ranges::find(words, word) != words.end();
}
bool is_variable_word(std::string_view word) { return word.starts_with('?') || word.starts_with("$?"); }

/// `1`, `-3`, `2.5`, `1e3`.
bool is_number_word(std::string_view word) {
  return word.find_first_of("0123456789") != word.npos && read_number<double>(std::string(word)).has_value();
}

/// A symbol, number or text that stands for itself.
bool is_constant(const Term& term) {
  return term.kind == Token::Kind::kString || (term.kind == Token::Kind::kWord && !is_variable_word(term.text));
}

std::string other_number(const std::string& word) {
  constexpr double kSmall = 10;
  const double value = *read_number<double>(word);
  const bool whole = word.find_first_of(".eE") == word.npos;
  if (whole && std::abs(value) < kSmall) return std::to_string(static_cast<long long>(value) + 1);
  if (whole) return std::to_string(2 * static_cast<long long>(value));
  std::string text = value == 0 ? "1.0" : general_text(2 * value, 15);
  if (text.find_first_of(".e") == text.npos) text += ".0";
  return text;
}

/// What only prints or is for people; of `format` where it prints.
bool prints(const Term& call) {
  const std::string_view head = call.head();
  if (is_one_of(head, {"printout", "print", "println"})) return true;
  return head == "format" && call.items.size() > 1 && !call.items[1].is("nil");
}

/// `; mutate: skip` of a file: lines at which nothing is changed.
std::set<int> skipped_lines(const std::string& text) {
  constexpr std::string_view kMark = "; mutate: skip";
  std::set<int> lines;
  bool pending = false;
  int number = 1;
  for (std::size_t at = 0; at < text.size(); ++number) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view line(text.data() + at, end - at);
    const std::size_t mark = line.find(kMark);
    const std::size_t first = line.find_first_not_of(" \t\r");
    const bool alone = first != line.npos && line[first] == ';';
    if (pending && first != line.npos && !alone) {
      lines.insert(number);
      pending = false;
    }
    if (mark != line.npos && std::ranges::count(line.substr(0, mark), '"') % 2 == 0) {
      lines.insert(number);
      pending |= alone;
    }
    at = end + 1;
  }
  return lines;
}

/// In one line, without comments.
std::string squeezed(std::string_view text) {
  std::string out;
  bool quoted = false, blank = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (!quoted && text[i] == ';') {
      i = std::min(text.find('\n', i), text.size());
      blank = true;
      continue;
    }
    if (!quoted && std::isspace(static_cast<unsigned char>(text[i])) != 0) {
      blank = true;
      continue;
    }
    if (blank && !out.empty() && out.back() != '(' && text[i] != ')') out += ' ';
    blank = false;
    out += text[i] == '\n' ? ' ' : text[i];
    if (quoted && text[i] == '\\' && i + 1 < text.size())
      out += text[++i];
    else if (text[i] == '"')
      quoted = !quoted;
  }
  return out;
}

/// The values that slots are known to have, from definitions, conditions and actions.
class KnownValues {
 public:
  explicit KnownValues(const std::vector<RuleText>& files) {
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

  bool has_slots(std::string_view name) const { return templates_.contains(name); }

  /// Another one than these of the slot (`TEMPLATE.SLOT`, or empty); else of one that has the symbol; else an invented
  /// one.
  std::string other(const std::string& symbol, const std::string& slot, const Names& not_these) const {
    if (symbol == "TRUE") return "FALSE";
    if (symbol == "FALSE") return "TRUE";
    const bool quoted = symbol.starts_with('"');
    const auto next_of = [&](const Names& values) -> std::optional<std::string> {
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

 private:
  void read_template(const Term& tree) {
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

  void read_construct(const Term& tree) {
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

  void read_condition(const Term& condition) {
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

  void read_fact(const Term& fact) {
    const std::string name(fact.head());
    if (!has_slots(name)) return;
    for (const Term& slot : fact.items)
      if (slot.is_list() && !slot.items.empty()) add(name + '.' + std::string(slot.head()), slot, 1);
  }

  void read_actions(const Term& call, const std::map<std::string, std::string>& templates_of) {
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

  void add(const std::string& slot, const Term& values, std::size_t from) {
    for (std::size_t i = from; i < values.items.size(); ++i) {
      const Term& value = values.items[i];
      if (is_constant(value) && !is_number_word(value.text) && !is_one_of(value.text, {":", "=", "nil"}))
        values_[slot].insert(value.text);
    }
  }

  Names templates_;
  std::map<std::string, Names> values_;  // by `TEMPLATE.SLOT`
};

/// Makes the mutants of one construct after the other.
class Mutator {
 public:
  explicit Mutator(const std::vector<RuleText>& files) : files_(files), known_(files) {
    // Functions whose definition is spared are only for people, and so are their calls.
    for (const RuleText& file : files) {
      const std::set<int> skipped = skipped_lines(file.text);
      for (const Form& form : read_forms(file.text, file.name).forms)
        if (form.head == "deffunction" && skipped.contains(form.line)) spared_.insert(form.name);
    }
  }

  std::vector<Mutant> make() {
    for (file_ = 0; file_ < files_.size(); ++file_) {
      if (!files_[file_].changed) continue;
      skipped_ = skipped_lines(files_[file_].text);
      for (const Form& form : read_forms(files_[file_].text, files_[file_].name).forms)
        if (form.list && !skipped_.contains(form.line)) read(form);
    }
    return std::move(out_);
  }

 private:
  /// Where a value stands: what may be there is known of the slot.
  struct Spot {
    std::string slot;
    Names not_these;
  };

  void read(const Form& form) {
    form_ = &form;
    tree_ = tree_of(form);
    acts_ = false;
    templates_of_.clear();
    occurrences_.clear();
    count_words(tree_);
    construct_ = form.name;
    if (form.head == "defrule")
      read_rule();
    else if (form.head == "deffunction")
      read_function();
    else if (form.head == "defglobal")
      read_globals();
  }

  void count_words(const Term& term) {
    if (term.kind == Token::Kind::kWord) ++occurrences_[without_dollar(term.text)];
    for (const Term& item : term.items) count_words(item);
  }
  static std::string without_dollar(const std::string& word) {
    std::string name = word.starts_with("$?") ? word.substr(1) : word;
    return name.substr(0, name.find(':'));  // ?fact:slot
  }

  // --- Rules

  void read_rule() {
    const std::vector<Term>& items = tree_.items;
    std::size_t i = 2;
    if (i < items.size() && items[i].kind == Token::Kind::kString) ++i;
    if (i < items.size() && items[i].head() == "declare") read_declaration(items[i++]);
    const std::size_t first = i;
    while (i < items.size() && !items[i].is("=>")) ++i;
    read_conditions(items, first, i, true);
    acts_ = true;
    if (i < items.size()) read_statements(tree_, i + 1, items.size(), 1);
  }

  void read_declaration(const Term& declaration) {
    for (const Term& item : declaration.items) {
      if (item.head() != "salience" || item.items.size() != 2) continue;
      const Term& value = item.items[1];
      std::string other = "(- 0 " + value_text(value) + ')';
      if (is_number_word(value.text)) other = value.text.starts_with('-') ? value.text.substr(1) : '-' + value.text;
      if (value.text != "0") replace(Change::kSalience, value, other, item);
    }
  }

  /// Conditions of a rule or of a group. `may_drop`: each may be left out, even if it is the only one.
  void read_conditions(const std::vector<Term>& items, std::size_t from, std::size_t to, bool may_drop) {
    for (std::size_t i = from; i < to; ++i) {
      std::size_t begin = i;
      if (i + 2 < to && items[i + 1].is("<-")) {
        templates_of_[items[i].text] = items[i + 2].head();
        i += 2;
      }
      const Term& condition = items[i];
      if (!condition.is_list()) continue;
      if (may_drop) drop(Change::kCondition, items[begin].begin, condition.end, items[begin].line);
      read_condition(condition, begin != i);
    }
  }

  void read_condition(const Term& condition, bool bound) {
    const std::string_view head = condition.head();
    const std::vector<Term>& items = condition.items;
    const std::size_t parts = items.size() - 1;
    if (is_one_of(head, {"and", "or"})) {
      if (parts > 1) replace(Change::kConnective, items[0], head == "and" ? "or" : "and", condition);
      read_conditions(items, 1, items.size(), parts > 1);
    } else if (head == "not") {
      if (parts == 1) replace(Change::kNegation, condition, value_text(items[1]), condition);
      read_conditions(items, 1, items.size(), false);
    } else if (head == "exists") {
      replace(Change::kNegation, items[0], "not", condition);
      read_conditions(items, 1, items.size(), parts > 1);
    } else if (head == "logical") {
      read_conditions(items, 1, items.size(), parts > 1);
    } else if (head == "forall") {
      read_conditions(items, 1, items.size(), false);
    } else if (head == "test") {
      for (std::size_t i = 1; i < items.size(); ++i) read_value(items[i], {}, true);
    } else {
      if (!bound) replace(Change::kNegation, condition, "(not " + value_text(condition) + ')', condition);
      read_pattern(condition);
    }
  }

  void read_pattern(const Term& pattern) {
    const std::string name(pattern.head());
    bool slots = false;
    for (std::size_t i = 1; i < pattern.items.size(); ++i)
      slots |= pattern.items[i].is_list() && !pattern.items[i - 1].is(":") && !pattern.items[i - 1].is("=");
    if (!slots) return read_fields(pattern, name + ".", true);
    for (const Term& slot : pattern.items) {
      if (!slot.is_list() || slot.items.size() < 2) continue;
      const std::vector<Field> fields = fields_of(slot);
      const bool simple = std::ranges::all_of(fields, [](const Field& f) { return f.parts.size() == 1; });
      const bool free = fields.size() == 1 && simple && is_free(*fields[0].parts[0].atom);
      if (simple && !free) replace_by_nothing(Change::kConstraint, slot, pattern);
      read_fields(slot, name + '.' + std::string(slot.head()), false);
    }
  }

  /// A variable that stands nowhere else: it demands nothing.
  bool is_free(const Term& atom) const {
    if (!is_variable_word(atom.text)) return false;
    const auto known = occurrences_.find(without_dollar(atom.text));
    return is_one_of(atom.text, {"?", "$?"}) || known == occurrences_.end() || known->second < 2;
  }

  struct Part {
    const Term* sign = nullptr;  ///< ~
    const Term* atom = nullptr;  ///< a word or text; `:` or `=`
    const Term* call = nullptr;  ///< after `:` and `=`
    std::size_t begin() const { return sign ? sign->begin : atom->begin; }
    std::size_t end() const { return call ? call->end : atom->end; }
  };
  /// Parts of one field with `&` and `|` between them.
  struct Field {
    std::vector<Part> parts;
    std::vector<const Term*> connectives;
  };

  static std::vector<Field> fields_of(const Term& list) {
    std::vector<Field> fields;
    const std::vector<Term>& items = list.items;
    for (std::size_t i = 1; i < items.size();) {
      Field field;
      while (i < items.size()) {
        Part part;
        if (items[i].is("~") && i + 1 < items.size()) part.sign = &items[i++];
        part.atom = &items[i++];
        if ((part.atom->is(":") || part.atom->is("=")) && i < items.size() && items[i].is_list())
          part.call = &items[i++];
        field.parts.push_back(part);
        if (i >= items.size() || !(items[i].is("&") || items[i].is("|"))) break;
        field.connectives.push_back(&items[i++]);
      }
      if (field.connectives.size() < field.parts.size()) fields.push_back(std::move(field));
    }
    return fields;
  }

  void read_fields(const Term& list, const std::string& slot, bool ordered) {
    for (const Field& field : fields_of(list)) {
      const bool simple = field.parts.size() == 1;
      Spot spot{slot, {}};
      for (const Part& part : field.parts) spot.not_these.insert(part.atom->text);
      for (std::size_t i = 0; i < field.parts.size(); ++i) {
        const Part& part = field.parts[i];
        if (!simple && (part.sign || part.call || is_constant(*part.atom))) drop_part(field, i, list);
        if (part.sign)
          change(Change::kNegation, part.sign->begin, part.sign->end, "", list, part.sign->line);
        else if (simple && !part.call && is_constant(*part.atom))
          change(Change::kNegation, part.begin(), part.begin(), "~", list, part.atom->line);
        if (ordered && simple && (part.sign || part.call || !is_free(*part.atom)))
          change(Change::kConstraint, part.begin(), part.end(), part.atom->text.starts_with('$') ? "$?" : "?", list,
                 part.atom->line);
        if (part.call)
          read_value(*part.call, {}, part.atom->is(":"));
        else
          read_value(*part.atom, spot, false, &list);
      }
    }
  }

  /// With the connective after it if that is `|`, so that what stands before still holds for the others.
  void drop_part(const Field& field, std::size_t i, const Term& list) {
    const Part& part = field.parts[i];
    std::size_t begin = part.begin(), end = part.end();
    if (i < field.connectives.size() && (i == 0 || field.connectives[i]->is("|")))
      end = field.parts[i + 1].begin();
    else
      begin = field.parts[i - 1].end();
    change(Change::kConstraint, begin, end, "", list, part.atom->line);
  }

  // --- Functions and globals

  void read_function() {
    const std::vector<Term>& items = tree_.items;
    std::size_t i = 2;
    if (i < items.size() && items[i].kind == Token::Kind::kString) ++i;
    ++i;  // parameters
    if (i + 1 < items.size() && items[i].kind == Token::Kind::kString) ++i;
    read_statements(tree_, i, items.size(), 2);
  }

  void read_globals() {
    for (std::size_t i = 3; i < tree_.items.size(); ++i) {
      if (!tree_.items[i - 1].is("=") || !tree_.items[i - 2].text.starts_with("?*")) continue;
      construct_ = tree_.items[i - 2].text;
      Term whole = tree_.items[i];
      whole.begin = tree_.items[i - 2].begin;
      read_value(tree_.items[i], {}, false, &whole);
    }
  }

  // --- Calls

  /// Actions that follow each other. Each call may be left out where there are at least so many.
  void read_statements(const Term& parent, std::size_t from, std::size_t to, std::size_t least) {
    const std::vector<Term>& items = parent.items;
    for (std::size_t i = from; i < to; ++i) {
      if (!items[i].is_list() || is_spared(items[i])) {
        if (!items[i].is_list()) read_value(items[i], {}, false, &parent);
        continue;
      }
      if (to - from >= least) drop(Change::kAction, items[i].begin, items[i].end, items[i].line);
      read_call(items[i], false, true);
    }
  }

  bool is_spared(const Term& call) const { return prints(call) || spared_.contains(call.head()); }

  /// `context`: what is shown around a word that is changed.
  void read_value(const Term& value, const Spot& spot, bool boolean, const Term* context = nullptr) {
    if (value.is_list()) return read_call(value, boolean, false);
    const Term& around = context ? *context : value;
    if (!is_constant(value)) return;
    if (value.kind != Token::Kind::kString && is_number_word(value.text))
      replace(Change::kNumber, value, other_number(value.text), around);
    else if (!is_one_of(value.text, {"crlf", "tab", "nil", ":", "="}))
      replace(Change::kSymbol, value, known_.other(value.text, spot.slot, spot.not_these), around);
  }

  void read_values(const Term& list, std::size_t from, const Spot& spot, bool boolean = false) {
    for (std::size_t i = from; i < list.items.size(); ++i) read_value(list.items[i], spot, boolean, &list);
  }

  void read_call(const Term& call, bool boolean, bool statement) {
    if (call.items.empty() || is_spared(call)) return;
    const std::vector<Term>& items = call.items;
    const std::string_view head = call.head();
    const std::size_t arguments = items.size() - 1;
    const bool compares = swap_operator(call, arguments);
    const bool connects = is_one_of(head, {"and", "or"});
    if (head == "not" && arguments == 1) replace(Change::kNegation, call, value_text(items[1]), call);
    if (boolean && !compares && !connects && head != "not")
      replace(Change::kNegation, call, "(not " + value_text(call) + ')', call);

    if (connects || head == "not") {
      // `not` is dropped already: a second one around what it holds for would be the same.
      read_values(call, 1, {}, connects);
    } else if (is_one_of(head, {"any-factp", "find-fact", "find-all-facts", "do-for-fact", "do-for-all-facts",
                                "delayed-do-for-all-facts", "any-instancep", "find-instance", "find-all-instances",
                                "do-for-instance", "do-for-all-instances", "delayed-do-for-all-instances"})) {
      if (arguments > 1) read_value(items[2], {}, true);
      read_statements(call, std::min<std::size_t>(3, items.size()), items.size(), statement ? 1 : 2);
    } else if (head == "if") {
      read_if(call, statement);
    } else if (head == "while") {
      read_value(items[std::min<std::size_t>(1, arguments)], {}, true);
      read_statements(call, arguments > 1 && items[2].is("do") ? 3 : 2, items.size(), 1);
    } else if (is_one_of(head, {"foreach", "progn$", "loop-for-count"})) {
      const std::size_t values = head == "foreach" ? 3 : 2;
      if (head == "foreach" && arguments > 1) read_value(items[2], {}, false, &call);
      if (head != "foreach" && arguments > 0 && items[1].is_list()) read_values(items[1], 1, {});
      std::size_t first = std::min(values, items.size());
      if (first < items.size() && items[first].is("do")) ++first;
      read_statements(call, first, items.size(), 1);
    } else if (head == "switch") {
      for (std::size_t i = 2; i < items.size(); ++i) read_case(items[i], statement);
      if (arguments > 0 && items[1].is_list()) read_call(items[1], false, false);
    } else if (head == "progn") {
      read_statements(call, 1, items.size(), 2);
    } else if (head == "assert") {
      for (std::size_t i = 1; i < items.size(); ++i) {
        if (arguments > 1) drop(Change::kAction, items[i].begin, items[i].end, items[i].line);
        read_fact(items[i]);
      }
    } else if (is_one_of(head, {"modify", "duplicate"})) {
      const auto known = arguments > 0 ? templates_of_.find(items[1].text) : templates_of_.end();
      read_slots(call, 2, known == templates_of_.end() ? "" : known->second);
    } else if (head == "retract") {
      for (std::size_t i = 1; i < items.size(); ++i) {
        if (arguments > 1) replace_by_nothing(Change::kAction, items[i], call);
        if (items[i].is_list()) read_call(items[i], false, false);
      }
    } else if (is_one_of(head, {"bind", "funcall", "apply", "deffunction"})) {
      read_values(call, 2, {});
    } else if (is_one_of(head, {"fact-slot-value", "slot-value"})) {
      if (arguments > 0) read_value(items[1], {}, false, &call);
    } else if (head == "format") {
      read_values(call, 3, {});
    } else {
      read_values(call, 1, {});
    }
  }

  /// Whether it is a comparison.
  bool swap_operator(const Term& call, std::size_t arguments) {
    struct Swap {
      std::string_view from, to;
      Change change;
      std::string_view bound = {};  // the same with the bound, or without it
    };
    static constexpr Swap kSwaps[] = {{"<", ">=", Change::kComparison, "<="}, {">", "<=", Change::kComparison, ">="},
                                      {"<=", ">", Change::kComparison, "<"},  {">=", "<", Change::kComparison, ">"},
                                      {"=", "<>", Change::kComparison},       {"<>", "=", Change::kComparison},
                                      {"!=", "=", Change::kComparison},       {"eq", "neq", Change::kComparison},
                                      {"neq", "eq", Change::kComparison},     {"and", "or", Change::kConnective},
                                      {"or", "and", Change::kConnective},     {"+", "-", Change::kArithmetic},
                                      {"-", "+", Change::kArithmetic},        {"*", "/", Change::kArithmetic},
                                      {"/", "*", Change::kArithmetic},        {"min", "max", Change::kArithmetic},
                                      {"max", "min", Change::kArithmetic}};
    const auto* swap = std::ranges::find(kSwaps, call.head(), &Swap::from);
    if (swap == std::end(kSwaps)) return false;
    if (arguments < 2) return swap->change == Change::kComparison;
    replace(swap->change, call.items[0], std::string(swap->to), call);
    if (!swap->bound.empty()) replace(swap->change, call.items[0], std::string(swap->bound), call);
    return swap->change == Change::kComparison;
  }

  void read_if(const Term& call, bool statement) {
    const std::vector<Term>& items = call.items;
    if (items.size() < 3) return;
    read_value(items[1], {}, true);
    std::size_t other = 3;
    while (other < items.size() && !items[other].is("else")) ++other;
    for (const auto& [from, to] : {std::pair(std::size_t{3}, other), std::pair(other + 1, items.size())})
      if (from < to) read_statements(call, from, to, statement ? 1 : 2);
  }

  void read_case(const Term& branch, bool statement) {
    if (!branch.is_list()) return;
    const bool is_default = branch.head() == "default";
    if (!is_default && branch.items.size() > 1) read_value(branch.items[1], {}, false, &branch);
    read_statements(branch, std::min<std::size_t>(is_default ? 1 : 3, branch.items.size()), branch.items.size(),
                    statement ? 1 : 2);
  }

  void read_fact(const Term& fact) {
    if (!fact.is_list()) return;
    const std::string name(fact.head());
    if (known_.has_slots(name))
      read_slots(fact, 1, name);
    else
      read_values(fact, 1, {name + '.', {}});
  }

  void read_slots(const Term& fact, std::size_t from, const std::string& name) {
    for (std::size_t i = from; i < fact.items.size(); ++i) {
      const Term& slot = fact.items[i];
      if (!slot.is_list() || slot.items.empty()) continue;
      if (fact.items.size() > from + 1) replace_by_nothing(Change::kSlot, slot, slot);
      read_values(slot, 1, {name.empty() ? "" : name + '.' + std::string(slot.head()), {}});
    }
  }

  // --- Writing

  std::string value_text(const Term& term) const { return form_->text.substr(term.begin, term.end - term.begin); }

  void drop(Change change_of, std::size_t begin, std::size_t end, int line) {
    add(change_of, begin, end, "", begin, end, line);
  }
  void replace_by_nothing(Change change_of, const Term& term, const Term& around) {
    change(change_of, term.begin, term.end, "", around, term.line);
  }
  void replace(Change change_of, const Term& term, const std::string& by, const Term& around) {
    change(change_of, term.begin, term.end, by, around, term.line);
  }
  void change(Change change_of, std::size_t begin, std::size_t end, const std::string& by, const Term& around,
              int line) {
    add(change_of, begin, end, by, around.begin, around.end, line);
  }

  /// `from`, `to`: what is shown.
  void add(Change change_of, std::size_t begin, std::size_t end, const std::string& by, std::size_t from,
           std::size_t to, int line) {
    if (skipped_.contains(line)) return;
    Mutant mutant;
    mutant.change = change_of;
    mutant.file = file_;
    mutant.kind = form_->head;
    mutant.construct = construct_;
    mutant.line = line;
    mutant.defined = form_->line;
    mutant.begin = form_->at + begin;
    mutant.end = form_->at + end;
    mutant.text = by;
    mutant.acts = acts_;
    constexpr std::size_t kAround = 60;  // characters on each side, of what is longer
    const std::string& text = form_->text;
    const bool cut_left = begin - from > kAround, cut_right = to - end > kAround;
    const std::string left =
        (cut_left ? "..." : "") + text.substr(cut_left ? begin - kAround : from, cut_left ? kAround : begin - from);
    const std::string right = text.substr(end, cut_right ? kAround : to - end) + (cut_right ? "..." : "");
    mutant.before = squeezed(left + text.substr(begin, end - begin) + right);
    mutant.after = squeezed(left + by + right);
    const std::string key = files_[file_].name + '\n' + mutant.kind + ' ' + construct_ + '\n' +
                            kChanges[static_cast<int>(change_of)] + '\n' + mutant.before + '\n' + mutant.after + '\n';
    constexpr std::size_t kDigits = 8;
    mutant.id = content_hash(key + std::to_string(seen_[key]++)).substr(0, kDigits);
    out_.push_back(std::move(mutant));
  }

  const std::vector<RuleText>& files_;
  const KnownValues known_;
  Names spared_;
  std::vector<Mutant> out_;
  std::map<std::string, int> seen_;
  // Of the construct at hand:
  std::size_t file_ = 0;
  std::set<int> skipped_;
  const Form* form_ = nullptr;
  Term tree_;
  std::string construct_;
  bool acts_ = false;
  std::map<std::string, std::string> templates_of_;
  std::map<std::string, int> occurrences_;
};

/// From the first byte of the line in which `at` lies.
std::size_t line_begin(const std::string& text, std::size_t at) {
  const std::size_t before = at == 0 ? text.npos : text.rfind('\n', at - 1);
  return before == text.npos ? 0 : before + 1;
}
std::size_t line_end(const std::string& text, std::size_t at) { return std::min(text.find('\n', at), text.size()); }

std::vector<std::string> lines_in(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t at = 0;;) {
    const std::size_t end = text.find('\n', at);
    lines.push_back(text.substr(at, end == text.npos ? end : end - at));
    if (end == text.npos) return lines;
    at = end + 1;
  }
}

}  // namespace

const char* to_string(Change change) { return kChanges[static_cast<int>(change)]; }

std::string Mutant::what() const { return after.empty() ? "without " + before : before + " -> " + after; }

std::vector<Mutant> mutants_of(const std::vector<RuleText>& files) {
  std::vector<Mutant> out = Mutator(files).make();
  std::ranges::stable_sort(
      out, [](const Mutant& a, const Mutant& b) { return std::pair(a.file, a.begin) < std::pair(b.file, b.begin); });
  return out;
}

std::string mutated(const std::string& text, const Mutant& mutant) {
  return text.substr(0, mutant.begin) + mutant.text + text.substr(mutant.end);
}

std::string diff_of(const RuleText& file, const Mutant& mutant) {
  constexpr std::size_t kContext = 2;  // lines
  const std::string& text = file.text;
  const std::size_t first = line_begin(text, mutant.begin), last = line_end(text, mutant.end);
  const std::vector<std::string> lines = lines_in(text), was = lines_in(text.substr(first, last - first));
  const std::vector<std::string> now =
      lines_in(text.substr(first, mutant.begin - first) + mutant.text + text.substr(mutant.end, last - mutant.end));
  const auto at =
      static_cast<std::size_t>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(first), '\n'));
  const std::size_t end = at + was.size(), begin = at - std::min(at, kContext);
  const std::size_t stop =
      std::min(end + kContext, lines.size() - (lines.back().empty() && lines.size() > end ? 1 : 0));
  std::string out = "--- " + file.name + "\n+++ " + file.name + "\n@@ -" + std::to_string(begin + 1) + ',' +
                    std::to_string(stop - begin) + " +" + std::to_string(begin + 1) + ',' +
                    std::to_string(stop - begin - was.size() + now.size()) + " @@ " + mutant.kind + ' ' +
                    mutant.construct + '\n';
  for (std::size_t i = begin; i < at; ++i) out += ' ' + lines[i] + '\n';
  for (const std::string& line : was) out += '-' + line + '\n';
  for (const std::string& line : now) out += '+' + line + '\n';
  for (std::size_t i = end; i < stop; ++i) out += ' ' + lines[i] + '\n';
  return out;
}

std::vector<std::string> rules_that_use(const std::vector<RuleText>& files, const Mutant& mutant) {
  if (mutant.kind == "defrule") return {mutant.construct};
  Names used{mutant.construct}, rules;
  std::vector<Form> forms;
  for (const RuleText& file : files)
    for (Form& form : read_forms(file.text, file.name).forms)
      if (is_one_of(form.head, {"defrule", "deffunction"})) forms.push_back(std::move(form));
  for (bool more = true; more;) {
    more = false;
    for (const Form& form : forms) {
      if (used.contains(form.name) || rules.contains(form.name)) continue;
      if (std::ranges::none_of(tokens_of(form), [&](const Token& token) {
            return token.kind == Token::Kind::kWord && used.contains(token.text);
          }))
        continue;
      (form.head == "defrule" ? rules : used).insert(form.name);
      more |= form.head != "defrule";
    }
  }
  return {rules.begin(), rules.end()};
}

}  // namespace cxlab::lab
