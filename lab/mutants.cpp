#include "lab/mutants.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string_view>

#include "cx/base/number_text.h"
#include "cx/engine/form_reader.h"
#include "cx/journal/file_store.h"
#include "lab/known_values.h"
#include "lab/rule_text.h"
#include "lab/rule_words.h"

namespace cxlab::lab {

namespace {

constexpr const char* kChanges[] = {"condition", "constraint", "negation", "connective", "comparison", "arithmetic",
                                    "number",    "symbol",     "action",   "slot",       "salience"};

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
    WordSet not_these;
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
  WordSet spared_;
  std::vector<Mutant> out_;
  std::map<std::string, int> seen_;
  // The current construct:
  std::size_t file_ = 0;
  std::set<int> skipped_;
  const Form* form_ = nullptr;
  Term tree_;
  std::string construct_;
  bool acts_ = false;
  std::map<std::string, std::string> templates_of_;
  std::map<std::string, int> occurrences_;
};

}  // namespace

const char* to_string(Change change) { return kChanges[static_cast<int>(change)]; }

std::string Mutant::what() const { return after.empty() ? "without " + before : before + " -> " + after; }

std::vector<Mutant> mutants_of(const std::vector<RuleText>& files) {
  std::vector<Mutant> out = Mutator(files).make();
  std::ranges::stable_sort(
      out, [](const Mutant& a, const Mutant& b) { return std::pair(a.file, a.begin) < std::pair(b.file, b.begin); });
  return out;
}

std::vector<std::string> rules_that_use(const std::vector<RuleText>& files, const Mutant& mutant) {
  if (mutant.kind == "defrule") return {mutant.construct};
  WordSet used{mutant.construct}, rules;
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