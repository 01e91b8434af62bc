// Reads the constructs of rule files into a `RuleBase`: who does what with which facts, and which values flow where.

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

#include "cx/check/rule_base.h"

namespace cxlab::check {

namespace {

/// Their value is a number, a fact or nothing: no symbol of a slot but TRUE and FALSE.
bool gives_no_symbol(std::string_view head) {
  return is_any(head, {"+",        "-",         "*",           "/",       "div",        "mod",     "abs",        "min",
                       "max",      "integer",   "float",       "round",   "sqrt",       "**",      "length$",    "=",
                       "<>",       "<",         ">",           "<=",      ">=",         "eq",      "neq",        "and",
                       "or",       "not",       "random",      "time",    "fact-index", "subsetp", "str-length", "now",
                       "integerp", "numberp",   "symbolp",     "stringp", "any-factp",  "floatp",  "evenp",      "oddp",
                       "printout", "str-index", "str-compare", "println", "assert",     "modify",  "duplicate"});
}
bool gives_a_text(std::string_view head) {
  return is_any(head, {"str-cat", "format", "implode$", "sub-string", "upcase", "lowcase", "readline"});
}

/// Their value is one of their arguments, or made of these.
bool passes_on(std::string_view head) {
  return is_any(head,
                {"create$", "nth$", "first$", "rest$", "insert$", "insert", "replace$", "delete$", "subseq$", "expand$",
                 "delete-member$", "replace-member$", "intersection$", "union$", "difference$", "sort"});
}

/// The expressions whose value an expression may have, where these are the last ones of its branches.
std::vector<const Term*> last_ones(const Term& term) {
  std::vector<const Term*> out;
  const std::vector<Term>& items = term.items;
  if (term.head() == "switch") {
    for (const Term& branch : items)
      if ((branch.head() == "case" || branch.head() == "default") && branch.items.size() > 1)
        out.push_back(&branch.items.back());
    return out;
  }
  for (std::size_t i = 1; term.head() == "if" && i + 1 < items.size(); ++i)
    if (items[i + 1].is("else")) out.push_back(&items[i]);
  if (items.size() > 1) out.push_back(&items.back());
  return out;
}

std::string slot_key(const std::string& name, const std::string& slot) { return "s:" + name + '.' + slot; }

}  // namespace

class Reader {
 public:
  explicit Reader(RuleBase& base) : base_(base) {}

  Status read() {
    for (const Source& source : base_.sources_) {
      FormReading reading = read_forms(source.text, source.file);
      if (!reading.errors.empty()) return reading.errors.front();
      std::string module = "MAIN";
      for (const Form& form : reading.forms) {
        if (!form.list) continue;
        Construct& construct = base_.constructs_.emplace_back();
        construct.kind = form.head;
        construct.name = form.name;
        construct.place = {&source, form.line};
        construct.tree = tree_of(form);
        if (form.head == "defmodule") module = form.name;
        construct.module = module;
        if (construct.tree.items.size() > 1)
          if (const auto colons = construct.tree.items[1].text.find("::"); colons != std::string::npos)
            construct.module = construct.tree.items[1].text.substr(0, colons);
      }
    }
    // Which facts functions get and give is known when all calls are: the next pass reads with what this one has found.
    constexpr int kPasses = 4;
    for (int pass = 0; pass < kPasses; ++pass) {
      const Facts before = std::exchange(fact_flows_, {});
      known_facts_ = &before;
      read_all();
      if (before == fact_flows_) break;
    }
    known_facts_ = nullptr;
    finish();
    return {};
  }

 private:
  using Items = std::span<const Term>;
  /// Templates of the facts that a parameter ("f#0") or the result ("f") of a function may stand for.
  struct FactFlow {
    std::set<std::string> names;
    bool unknown = false;
    bool operator==(const FactFlow&) const = default;
  };
  using Facts = std::map<std::string, FactFlow>;

  void read_all() {
    base_.templates_.clear();
    base_.globals_.clear();
    base_.touches_.clear();
    base_.tests_.clear();
    base_.flows_.clear();
    base_.sets_.clear();
    base_.reads_.clear();
    number_ = 0;
    for (const Construct& construct : base_.constructs_) define(construct);
    for (const Construct& construct : base_.constructs_) {
      by_ = &construct;
      ++number_;
      fact_templates_.clear();
      singles_.clear();
      manifold_.clear();
      read_construct(construct);
    }
  }

  static Items after(const Term& list, std::size_t from) {
    return Items(list.items).subspan(std::min(from, list.items.size()));
  }
  static std::string bare(std::string_view name) { return std::string(without_module(name)); }
  Place here(const Term& term) const { return {by_->place.source, term.line}; }
  RuleBase::Flow& flow(const std::string& key) { return base_.flows_[key]; }
  std::string variable_key(const std::string& name) const { return "v:" + std::to_string(number_) + '#' + name; }
  static std::string parameter_key(const std::string& function, std::size_t i) {
    return "p:" + function + '#' + std::to_string(i);
  }
  void use(const std::string& name) { base_.users_[name].insert(by_); }

  // --- Definitions

  void define(const Construct& construct) {
    by_ = &construct;
    if (construct.kind == "deftemplate") define_template(construct);
    if (construct.kind == "deffunction") functions_[construct.name] = &construct;
    if (construct.kind == "defglobal")
      for (const Term& item : construct.tree.items)
        if (item.kind == Token::Kind::kWord && item.text.starts_with("?*"))
          base_.globals_.try_emplace(item.text.substr(1), Global{&construct, item.line});
  }

  void define_template(const Construct& construct) {
    Template& defined = base_.templates_[construct.name];
    if (!defined.defined || construct.judged()) defined.defined = &construct;
    for (const Term& item : construct.tree.items) {
      if (!is_any(item.head(), {"slot", "multislot", "field", "multifield"}) || item.items.size() < 2) continue;
      const std::string& name = item.items[1].text;
      Slot& slot = defined.slots[name];
      slot.line = item.line;
      RuleBase::Flow& values = flow(slot_key(construct.name, name));
      bool default_known = false, is_text = false;
      for (const Term& facet : after(item, 2)) {
        const std::string_view head = facet.head();
        is_text = is_text || (head == "type" && facet.items.size() == 2 && facet.items[1].is("STRING"));
        if (head.starts_with("allowed-"))
          for (const Term& value : after(facet, 1))
            if (is_symbol(value)) slot.allowed.emplace_back(value.text, value.line);
        if (head != "default" && head != "default-dynamic") continue;
        default_known = true;
        slot.has_default = !(facet.items.size() > 1 && facet.items[1].is_list() == false &&
                             is_any(facet.items[1].text, {"?NONE", "?DERIVE"}));
        for (const Term& value : after(facet, 1)) {
          if (value.is("?DERIVE")) default_known = false;
          add_values(value, values);
        }
      }
      if (default_known || item.head().starts_with("multi")) continue;
      values.values.symbols[is_text                ? "\"\""
                            : slot.allowed.empty() ? "nil"
                                                   : slot.allowed.front().first]
          .insert(nullptr);
    }
  }

  void read_construct(const Construct& construct) {
    const Term& tree = construct.tree;
    if (construct.kind == "defrule") {
      const std::size_t action = first_action(tree);
      read_conditions(Items(tree.items).subspan(0, action).subspan(std::min<std::size_t>(2, action)), true, true);
      for (const Term& item : Items(tree.items).subspan(action)) read_action(item);
    } else if (construct.kind == "deffacts") {
      for (const Term& fact : after(tree, 2))
        if (fact.is_list()) read_fact(fact);
    } else if (construct.kind == "deffunction") {
      read_function(construct);
    } else if (construct.kind == "defglobal") {
      for (std::size_t i = 0; i + 2 < tree.items.size(); ++i)
        if (tree.items[i].text.starts_with("?*") && tree.items[i + 1].is("=")) {
          read_action(tree.items[i + 2]);
          add_values(tree.items[i + 2], flow("g:" + tree.items[i].text.substr(1)));
        }
    } else if (construct.kind == "deftemplate") {
      for (const Term& slot : after(tree, 2))
        for (const Term& facet : slot.items)
          if (facet.head().starts_with("default"))
            for (const Term& value : after(facet, 1))
              if (value.is_list()) read_action(value);
    } else if (construct.kind == "defmodule") {
      return;
    } else if (construct.kind.starts_with("def")) {
      for (const Term& item : after(tree, 1)) read_action(item);
    } else {
      read_action(tree);  // a call of a batch file
    }
  }

  void read_function(const Construct& construct) {
    const Term& tree = construct.tree;
    std::size_t body = 2;
    while (body < tree.items.size() && !tree.items[body].is_list()) ++body;
    if (body >= tree.items.size()) return;
    const std::vector<Term>& parameters = tree.items[body].items;
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      const std::string name = variable_name(parameters[i]);
      flow(variable_key(name)).from.insert(parameter_key(construct.name, i));
      fact_templates_[name] = known_facts("p:" + construct.name + '#' + std::to_string(i));
    }
    const bool comment = tree.items.size() > body + 2 && tree.items[body + 1].kind == Token::Kind::kString;
    for (const Term& item : after(tree, body + (comment ? 2 : 1))) read_action(item);
    if (tree.items.size() > body + 1) {
      add_values(tree.items.back(), flow("r:" + construct.name));
      give_facts("r:" + construct.name, tree.items.back());
    }
  }

  // --- Conditions

  void read_conditions(Items items, bool positive, bool required) {
    std::string fact;
    for (std::size_t i = 0; i < items.size(); ++i) {
      const Term& item = items[i];
      if (i + 1 < items.size() && items[i + 1].is("<-")) fact = variable_name(item);
      if (!item.is_list()) continue;
      read_condition(item, std::exchange(fact, {}), positive, required);
    }
  }

  void read_condition(const Term& item, const std::string& fact, bool positive, bool required) {
    const std::string_view head = item.head();
    if (head.empty()) return;
    if (head == "declare") {
      for (const Term& property : after(item, 1))
        for (const Term& value : after(property, 1)) read_action(value);
    } else if (head == "test") {
      for (const Term& expression : after(item, 1)) read_action(expression);
    } else if (head == "not") {
      read_conditions(after(item, 1), !positive, false);
    } else if (head == "or" || head == "forall") {
      read_conditions(after(item, 1), positive, false);
    } else if (is_group(head)) {
      read_conditions(after(item, 1), positive, required);
    } else if (head == "object") {
      for (const Term& inner : after(item, 1)) read_action(inner);
    } else {
      read_pattern(item, fact, positive, required);
    }
  }

  void read_pattern(const Term& pattern, const std::string& fact, bool positive, bool required) {
    const std::string name = bare(pattern.head());
    if (!fact.empty()) fact_templates_[fact].insert(name);
    base_.touches_.push_back(
        {by_, positive ? How::kRead : How::kReadNot, name, &pattern, here(pattern), positive && required});
    if (pattern.items.size() > 1 && pattern.items[1].is_list()) {
      for (const Term& slot : after(pattern, 1)) {
        if (slot.head().empty()) continue;
        const std::string slot_name(slot.head());
        base_.reads_.insert({name, slot_name});
        read_constraints(after(slot, 1), slot_key(name, slot_name), "slot '" + slot_name + "' of '" + name + '\'');
      }
      return;
    }
    // Fields of an ordered fact: where each stands is known up to the first that may be several.
    std::size_t begin = 1, field = 1;
    bool several = false;
    while (begin < pattern.items.size()) {
      std::size_t end = begin + 1;
      const auto joins = [](const Term& term) { return term.kind == Token::Kind::kConnective; };
      while (end < pattern.items.size() && (joins(pattern.items[end]) || joins(pattern.items[end - 1]) ||
                                            pattern.items[end - 1].is(":") || pattern.items[end - 1].is("=")))
        ++end;
      const Items items = Items(pattern.items).subspan(begin, end - begin);
      several = several || std::ranges::any_of(items, [](const Term& t) { return t.text.starts_with("$?"); });
      const std::string slot = several ? "*" : std::to_string(field++);
      read_constraints(items, slot_key(name, slot), "field " + slot + " of the facts '" + name + '\'');
      begin = end;
    }
  }

  void read_constraints(Items items, const std::string& key, const std::string& what) {
    for (std::size_t i = 0; i < items.size(); ++i) {
      const Term& item = items[i];
      if (const std::string name = variable_name(item); !name.empty()) {
        flow(variable_key(name)).from.insert(key);
        (item.text.starts_with('$') ? manifold_ : singles_).insert(name);
      } else if (is_symbol(item) || item.kind == Token::Kind::kString) {
        base_.tests_.push_back({key, item.text, what, by_, here(item)});
      } else if (item.is_list()) {
        read_action(item);
      } else if (item.text.starts_with("?*")) {
        read_word(item);
      }
    }
  }

  // --- Actions

  void read_action(const Term& term) {
    if (term.kind == Token::Kind::kString) return read_text(term.text);
    if (term.kind == Token::Kind::kWord) return read_word(term);
    if (!term.is_list()) return;
    const std::string head(term.head());
    if (head.empty()) {
      for (const Term& item : term.items) read_action(item);
      return;
    }
    use(head);
    if (head == "assert") {
      for (const Term& fact : after(term, 1))
        if (fact.is_list()) read_fact(fact);
    } else if (head == "modify" || head == "duplicate") {
      read_modify(term, head == "duplicate");
    } else if (head == "retract") {
      for (const Term& item : after(term, 1)) {
        std::set<std::string> names = templates_of(item);
        if (names.empty() && is_variable(item)) names.insert("");
        for (const std::string& name : names) base_.touches_.push_back({by_, How::kRetract, name, nullptr, here(item)});
        read_action(item);
      }
      note_value_used(term);
    } else if (is_query(head)) {
      read_query(term);
    } else if (head == "bind") {
      read_bind(term);
    } else if (head == "foreach" || head == "progn$" || head == "loop-for-count") {
      read_loop(term);
    } else {
      read_call(term, head);
    }
  }

  void read_word(const Term& term) {
    if (term.text.starts_with("?*")) return use(term.text.substr(1));
    if (const auto colon = term.text.find(':'); is_variable(term) && colon != std::string::npos)
      return read_of_slot(term, term.text.substr(colon + 1));
    if (is_variable(term)) return;
    base_.words_.insert(bare(term.text));
    use(bare(term.text));
  }

  void read_of_slot(const Term& fact, const std::string& slot) {
    const std::set<std::string> names = templates_of(fact);
    if (names.empty()) base_.reads_.insert({"", slot});
    for (const std::string& name : names) base_.reads_.insert({name, slot});
  }

  void read_text(const std::string& text) {
    std::string word;
    for (const char c : text + ' ') {
      if (std::isalnum(static_cast<unsigned char>(c)) != 0 || is_any(std::string(1, c), {"-", "_", "*", "$", "/"})) {
        word += c;
        continue;
      }
      if (word.empty()) continue;
      use(word);
      base_.in_texts_.insert(std::exchange(word, {}));
    }
  }

  /// Templates of the facts that a term may stand for; empty: it is not known.
  std::set<std::string> templates_of(const Term& term) const {
    if (const std::string name = variable_name(term); !name.empty()) {
      const auto found = fact_templates_.find(name);
      return found == fact_templates_.end() ? std::set<std::string>() : found->second;
    }
    if (!term.is_list() || term.items.size() < 2) return {};
    const std::string head(term.head());
    if (head == "assert") return {bare(term.items.back().head())};
    if (head == "modify" || head == "duplicate") return templates_of(term.items[1]);
    if (functions_.contains(head)) return known_facts("r:" + head);
    std::set<std::string> names;
    if (head == "find-fact" || head == "find-all-facts") {
      for (const Term& member : term.items[1].items)
        for (const Term& name : after(member, 1))
          if (is_symbol(name)) names.insert(bare(name.text));
    } else if (is_any(head, {"if", "switch", "progn"})) {
      for (const Term* item : last_ones(term)) names.merge(templates_of(*item));
    } else if (passes_on(head)) {
      for (const Term& item : after(term, 1)) names.merge(templates_of(item));
    }
    return names;
  }

  /// Templates of what a function gets or gives; empty: it is not known.
  std::set<std::string> known_facts(const std::string& key) const {
    const auto found = known_facts_->find(key);
    return found == known_facts_->end() || found->second.unknown ? std::set<std::string>() : found->second.names;
  }
  void give_facts(const std::string& key, const Term& value) {
    if (!value.is_list() && !is_variable(value)) return;
    std::set<std::string> names = templates_of(value);
    FactFlow& flow = fact_flows_[key];
    flow.unknown = flow.unknown || names.empty();
    flow.names.merge(names);
  }

  void read_fact(const Term& fact) {
    const std::string name = bare(fact.head());
    base_.touches_.push_back({by_, How::kAssert, name, &fact, here(fact)});
    const auto known = base_.templates_.find(name);
    const bool slots = known != base_.templates_.end()
                           ? !known->second.slots.empty()
                           : fact.items.size() > 1 && base_.outside_.templates.contains(name);
    std::size_t field = 1;
    bool several = false;
    for (const Term& item : after(fact, 1)) {
      if (slots && item.is_list()) {
        set_slot(name, item, true);
        continue;
      }
      read_action(item);
      // A variable or call may stand for several fields.
      several = several || item.is_list() || (is_variable(item) && !is_single(item));
      const std::string slot = several ? "*" : std::to_string(field++);
      add_values(item, flow(slot_key(name, slot)));
      if (several) flow(slot_key(name, "*")).values.open = true;
    }
  }

  /// A variable that conditions bind to one field.
  bool is_single(const Term& variable) const {
    const std::string name = variable_name(variable);
    return variable.text.starts_with('?') && variable.text.find(':') == std::string::npos && singles_.contains(name) &&
           !manifold_.contains(name);
  }

  void set_slot(const std::string& name, const Term& slot, bool walk) {
    if (slot.head().empty()) return;
    const std::string slot_name(slot.head());
    base_.sets_.insert({name, slot_name});
    for (const Term& value : after(slot, 1)) {
      if (walk) read_action(value);
      if (!name.empty()) add_values(value, flow(slot_key(name, slot_name)));
    }
  }

  void read_modify(const Term& term, bool duplicates) {
    if (term.items.size() < 2) return;
    read_action(term.items[1]);
    std::set<std::string> names = templates_of(term.items[1]);
    const bool known = !names.empty();
    if (!known)
      for (const auto& [name, defined] : base_.templates_)
        if (may_know(*defined.defined) && std::ranges::all_of(after(term, 2), [&](const Term& slot) {
              return defined.slots.contains(std::string(slot.head()));
            }))
          names.insert(name);
    for (const Term& slot : after(term, 2))
      for (const Term& value : after(slot, 1)) read_action(value);
    for (const std::string& name : names) {
      base_.touches_.push_back({by_, duplicates && known ? How::kAssert : How::kModify, name, nullptr, here(term)});
      for (const Term& slot : after(term, 2)) set_slot(name, slot, false);
    }
  }

  /// Files that are not loaded do nothing to facts of those that are judged, where these are not named.
  bool may_know(const Construct& defined) const { return by_->place.source->loaded || !defined.judged(); }

  void read_query(const Term& term) {
    if (term.items.size() < 2) return;
    for (const Term& member : term.items[1].items) {
      if (member.items.size() < 2) continue;
      std::set<std::string>& names = fact_templates_[variable_name(member.items[0])];
      names.clear();
      for (const Term& name : after(member, 1)) {
        if (!is_symbol(name)) continue;  // an expression says which
        names.insert(bare(name.text));
        base_.touches_.push_back({by_, How::kRead, bare(name.text), nullptr, here(name)});
      }
    }
    for (const Term& item : after(term, 2)) read_action(item);
  }

  void read_bind(const Term& term) {
    if (term.items.size() < 2) return;
    for (const Term& value : after(term, 2)) read_action(value);
    const Term& variable = term.items[1];
    if (variable.text.starts_with("?*")) {
      for (const Term& value : after(term, 2)) add_values(value, flow("g:" + variable.text.substr(1)));
      return;
    }
    const std::string name = variable_name(variable);
    manifold_.insert(name);
    for (const Term& value : after(term, 2)) add_values(value, flow(variable_key(name)));
    if (term.items.size() == 3)
      for (const std::string& found : templates_of(term.items[2])) fact_templates_[name].insert(found);
    note_value_used(term);
  }

  /// The value of an assert that something takes: a fact that is retracted at once, or looked at by its address.
  void note_value_used(const Term& term) {
    for (const Term& item : after(term, 1))
      if (item.head() == "assert")
        for (const Term& fact : after(item, 1)) base_.words_.insert(bare(fact.head()));
  }

  void read_loop(const Term& term) {
    const bool listed = term.items.size() > 1 && term.items[1].is_list();
    const Term* variable = listed && !term.items[1].items.empty() ? &term.items[1].items[0]
                           : term.items.size() > 1                ? &term.items[1]
                                                                  : nullptr;
    if (variable && term.head() != "loop-for-count") {
      const Term* from = listed                  ? (term.items[1].items.size() > 1 ? &term.items[1].items[1] : nullptr)
                         : term.items.size() > 2 ? &term.items[2]
                                                 : nullptr;
      if (from) {
        add_values(*from, flow(variable_key(variable_name(*variable))));
        fact_templates_[variable_name(*variable)] = templates_of(*from);
      }
    }
    for (const Term& item : after(term, 1)) read_action(item);
  }

  void read_call(const Term& term, const std::string& head) {
    if (is_any(head, {"load-facts", "bload-facts", "load-instances"}) ||
        (is_any(head, {"assert-string", "eval", "build"}) && !has_text(term)))
      base_.asserts_unknown_ = base_.asserts_unknown_ || by_->place.source->loaded;
    if (is_any(head, {"assert-string", "eval", "build", "load-facts"})) base_.evaluates_ = true;
    if ((head == "eq" || head == "neq") && term.items.size() > 2)
      for (const Term& other : after(term, 2)) {
        compare(term.items[1], other);
        compare(other, term.items[1]);
      }
    if (head == "member$" && term.items.size() == 3 && term.items[2].head() == "create$")
      for (const Term& other : after(term.items[2], 1)) compare(term.items[1], other);
    if (head == "switch" && term.items.size() > 2) {
      for (const Term& branch : after(term, 2)) {
        if (branch.head() == "case" && branch.items.size() > 1) compare(term.items[1], branch.items[1]);
        for (const Term& item : after(branch, branch.head() == "case" ? 2 : 1))
          if (!item.is("then")) read_action(item);
      }
      read_action(term.items[1]);
      return;
    }
    const bool names_slot = head == "fact-slot-value" && term.items.size() == 3 && is_symbol(term.items[2]);
    if (names_slot) read_of_slot(term.items[1], term.items[2].text);
    if (head == "return")
      for (const Term& value : after(term, 1)) {
        add_values(value, flow("r:" + by_->name));
        give_facts("r:" + by_->name, value);
      }
    pass_arguments(term, head);
    if (!is_any(head, {"if", "while", "progn", "switch"})) note_value_used(term);
    const bool compares = head == "eq" || head == "neq";
    const bool prints = is_any(head, {"printout", "println", "print"});
    for (const Term& item : after(term, 1))
      if (!(prints && item.kind == Token::Kind::kString) && !(compares && is_symbol(item)) &&
          !(head == "if" && (item.is("then") || item.is("else"))) && !(names_slot && &item == &term.items[2]))
        read_action(item);
  }

  static bool has_text(const Term& term) {
    return term.kind == Token::Kind::kString || std::ranges::any_of(term.items, has_text);
  }

  void pass_arguments(const Term& term, const std::string& head) {
    const auto function = functions_.find(head);
    if (function == functions_.end()) return;
    const bool expands = std::ranges::any_of(term.items, [](const Term& t) { return t.head() == "expand$"; });
    const Term& tree = function->second->tree;
    std::size_t list = 2;
    while (list < tree.items.size() && !tree.items[list].is_list()) ++list;
    const std::size_t count = list < tree.items.size() ? tree.items[list].items.size() : 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (expands) flow(parameter_key(head, i)).values.open = true;
      const bool rest = tree.items[list].items[i].text.starts_with("$?");
      for (std::size_t k = i + 1; k < term.items.size() && (rest || k == i + 1); ++k) {
        add_values(term.items[k], flow(parameter_key(head, i)));
        give_facts(parameter_key(head, i), term.items[k]);
      }
    }
  }

  /// `value` is compared with `other`, where that is a symbol.
  void compare(const Term& value, const Term& other) {
    const bool constant = is_symbol(other) || other.kind == Token::Kind::kString;
    if (!constant || other.is("TRUE") || other.is("FALSE") || other.is("nil")) return;
    std::string key, what = value.print();
    const auto colon = value.text.find(':');
    if (is_variable(value) && colon != std::string::npos) {
      const std::set<std::string> names = templates_of(value);
      if (names.size() != 1) return;
      key = slot_key(*names.begin(), value.text.substr(colon + 1));
      what = "slot '" + value.text.substr(colon + 1) + "' of '" + *names.begin() + '\'';
    } else if (const std::string name = variable_name(value); !name.empty()) {
      key = variable_key(name);
    } else if (value.text.starts_with("?*")) {
      key = "g:" + value.text.substr(1);
    }
    if (!key.empty()) base_.tests_.push_back({key, other.text, what, by_, here(other)});
  }

  /// What an expression may give.
  void add_values(const Term& term, RuleBase::Flow& to) {
    if (term.kind == Token::Kind::kConnective) return;
    if (is_symbol(term) || term.kind == Token::Kind::kString) {
      to.values.symbols[term.text].insert(by_->kind == "deftemplate" ? nullptr : by_);
      return;
    }
    if (!term.is_list()) {
      if (term.text.starts_with("?*")) {
        to.from.insert("g:" + term.text.substr(1));
      } else if (const auto colon = term.text.find(':'); is_variable(term) && colon != std::string::npos) {
        add_slot(term, term.text.substr(colon + 1), to);
      } else if (const std::string name = variable_name(term); !name.empty()) {
        to.from.insert(variable_key(name));
      }
      return;
    }
    const std::string head(term.head());
    if (head == "eq" || head == "not" || head == "and" || head == "or" || head == "neq") {
      to.values.symbols["TRUE"].insert(by_);
      to.values.symbols["FALSE"].insert(by_);
    }
    if (head.empty() || gives_no_symbol(head)) return;
    if (gives_a_text(head)) {
      to.values.open_text = true;
    } else if (head == "fact-slot-value" && term.items.size() == 3 && is_symbol(term.items[2])) {
      add_slot(term.items[1], term.items[2].text, to);
    } else if (functions_.contains(head)) {
      to.from.insert("r:" + head);
    } else if (is_any(head, {"if", "switch", "progn", "bind"})) {
      if (head == "if" || head == "switch") to.values.symbols["FALSE"].insert(by_);
      for (const Term* item : last_ones(term)) add_values(*item, to);
    } else if (head == "member$") {
      to.values.symbols["FALSE"].insert(by_);
    } else if (passes_on(head)) {
      for (const Term& item : after(term, 1)) add_values(item, to);
    } else {
      to.values.open = true;
    }
  }

  void add_slot(const Term& fact, const std::string& slot, RuleBase::Flow& to) {
    const std::set<std::string> names = templates_of(fact);
    if (names.empty()) {
      bool found = false;
      for (const auto& [name, defined] : base_.templates_)
        if (defined.slots.contains(slot)) {
          to.from.insert(slot_key(name, slot));
          found = true;
        }
      to.values.open = to.values.open || !found;
    }
    for (const std::string& name : names) to.from.insert(slot_key(name, slot));
  }

  // --- What is known when all is read

  void finish() {
    // CLIPS takes slots only of templates that are defined: elsewhere, where none of these files does.
    for (const Touch& touch : base_.touches_)
      if ((touch.how == How::kRead || touch.how == How::kReadNot) && touch.term && touch.term->items.size() > 1 &&
          touch.term->items[1].is_list() && !base_.templates_.contains(touch.template_name))
        base_.outside_.templates.insert(touch.template_name);
    // What another package defines as well, its rules and plugins use.
    for (const Construct& construct : base_.constructs_)
      if (construct.kind == "deftemplate" && !construct.judged() &&
          base_.templates_.at(construct.name).defined->judged())
        base_.outside_.templates.insert(construct.name);
    for (const Touch& touch : base_.touches_)
      if (touch.how == How::kAssert && !base_.templates_.contains(touch.template_name))
        for (const auto& [key, flow] : base_.flows_)
          if (key.starts_with("s:" + touch.template_name + '.')) any_of_.insert(key);
    for (const std::string& key : any_of_) {
      const std::string all = key.substr(0, key.rfind('.')) + ".*";
      if (key != all) base_.flows_[key].from.insert(all);
    }
    for (const auto& [name, construct] : functions_) {
      const bool called_from_outside = name.ends_with("-callback") || base_.words_.contains(name) ||
                                       base_.in_texts_.contains(name) || !base_.users_.contains(name) ||
                                       base_.outside_.functions.contains(name);
      for (std::size_t i = 0; called_from_outside && i < construct->tree.items.size(); ++i)
        base_.flows_[parameter_key(name, i)].values.open = true;
    }
  }

  RuleBase& base_;
  const Construct* by_ = nullptr;
  int number_ = 0;                                               // of the construct
  std::map<std::string, std::set<std::string>> fact_templates_;  // by variable, of the construct
  std::set<std::string> singles_, manifold_;                     // variables of one field, and of others
  std::map<std::string, const Construct*> functions_;
  std::set<std::string> any_of_;
  const Facts* known_facts_ = nullptr;  // of the pass before
  Facts fact_flows_;
};

Expected<RuleBase> RuleBase::read(std::vector<Source> sources, Outside outside) {
  RuleBase base;
  for (Source& source : sources) base.sources_.push_back(std::move(source));
  base.outside_ = std::move(outside);
  if (Status s = Reader(base).read(); !s) return s.error();
  return base;
}

}  // namespace cxlab::check
