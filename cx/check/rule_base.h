#pragma once
// The rule files of one environment as constructs: who asserts, changes and reads which facts, and which symbols can
// reach which slot.

#include <algorithm>
#include <deque>
#include <initializer_list>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/engine/form_reader.h"

namespace cxlab::check {

using Words = std::set<std::string, std::less<>>;

struct Source {
  std::string file, text;
  bool judged = true;  ///< findings in it are wanted; else it only shows what the others are for
  bool loaded = true;  ///< else another configuration of the same package may load it
};

/// What does not come from rule files.
struct Outside {
  Words templates;                     ///< that plugins define; they may assert and read them as they like
  std::map<std::string, Words> slots;  ///< of those templates whose slots are known
  Words facts;                         ///< ordered facts that plugins assert
  Words functions;                     ///< deffunctions that plugins define
  Words words;        ///< of configurations and PDDL: modules that get the focus, symbols that come back
  bool open = false;  ///< more may be asserted and read: a name is doubted only where a known one is spelt nearly so
};

struct Place {
  const Source* source = nullptr;
  int line = 0;
  std::string text() const { return source->file + ':' + std::to_string(line); }
};

struct Construct {
  std::string kind, module, name;
  Place place;
  Term tree;
  bool is_rule() const { return kind == "defrule"; }
  bool judged() const { return place.source->judged; }
};

enum class How { kAssert, kModify, kRetract, kRead, kReadNot };

/// What a construct does with the facts of a template.
struct Touch {
  const Construct* by = nullptr;
  How how{};
  std::string template_name;   ///< empty: of a retract whose fact is not known
  const Term* term = nullptr;  ///< the pattern or fact; null where there is none
  Place place;
  bool required = false;  ///< of a pattern: its rule cannot fire without it
};

/// A symbol or text that a value is compared with.
struct Test {
  std::string value;   ///< key of what is compared, see `RuleBase::possible`
  std::string symbol;  ///< a text has its quotes
  std::string what;    ///< for people: "slot 'state' of 'robot'"
  const Construct* by = nullptr;
  Place place;
};

struct Slot {
  int line = 0;
  bool has_default = false;
  std::vector<std::pair<std::string, int>> allowed;  ///< symbols and their lines
};

struct Template {
  const Construct* defined = nullptr;
  std::map<std::string, Slot> slots;
};

struct Global {
  const Construct* defined = nullptr;
  int line = 0;
};

/// What a value may be.
struct Values {
  std::map<std::string, std::set<const Construct*>> symbols;  ///< and what produces each; null: a default
  bool open = false;                                          ///< anything else
  bool open_text = false;                                     ///< any text
};

class RuleBase {
 public:
  /// The error has file and line. Everything borrows from `sources`, which move in.
  static Expected<RuleBase> read(std::vector<Source> sources, Outside outside);
  RuleBase(RuleBase&&) = default;
  RuleBase(const RuleBase&) = delete;

  const std::deque<Source>& sources() const { return sources_; }
  const Outside& outside() const { return outside_; }
  const std::deque<Construct>& constructs() const { return constructs_; }
  const std::map<std::string, Template>& templates() const { return templates_; }
  const std::vector<Touch>& touches() const { return touches_; }
  const std::vector<Test>& tests() const { return tests_; }
  const std::map<std::string, Global>& globals() const { return globals_; }

  /// `s:TEMPLATE.SLOT`, `v:CONSTRUCT#VARIABLE`, `r:FUNCTION`: the symbols and texts that can get there.
  const Values& possible(const std::string& key) const;
  /// The slot whose value a variable has, if it has no other.
  std::string origin_of(std::string key) const;
  /// Whether the slots of a template of rule files or plugins are known, and that is none of them.
  bool lacks_slot(const std::string& template_name, const std::string& slot) const;
  /// Those that are known.
  std::vector<std::string> slots_of(const std::string& template_name) const;
  bool is_set(const std::string& template_name, const std::string& slot) const;
  bool is_read(const std::string& template_name, const std::string& slot) const;
  /// Whether actions or functions have the word other than as the name of a fact, or a text that may be evaluated has
  /// it.
  bool is_mentioned(std::string_view word) const { return words_.contains(word) || (evaluates_ && has_in_text(word)); }
  bool has_in_text(std::string_view word) const { return in_texts_.contains(word); }
  /// Who calls or names a function or global.
  const std::set<const Construct*>& users(const std::string& name) const;
  bool is_file_template(const std::string& name) const { return templates_.contains(name); }
  /// Rules assert facts by texts or files that are only known when they run.
  bool asserts_unknown() const { return asserts_unknown_; }

 private:
  friend class Reader;
  RuleBase() = default;
  struct Flow {
    Values values;
    std::set<std::string> from;  ///< keys
  };

  std::deque<Source> sources_;
  Outside outside_;
  std::deque<Construct> constructs_;
  std::map<std::string, Template> templates_;
  std::vector<Touch> touches_;
  std::vector<Test> tests_;
  std::map<std::string, Global> globals_;
  std::map<std::string, Flow> flows_;
  mutable std::map<std::string, Values> possible_;
  std::set<std::pair<std::string, std::string>> sets_, reads_;  ///< template ("" = any), slot
  std::map<std::string, std::set<const Construct*>, std::less<>> users_;
  Words words_, in_texts_;
  bool evaluates_ = false;  ///< texts as rules, facts or calls
  bool asserts_unknown_ = false;
};

inline bool is_any(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::ranges::find(words, word) != words.end();
}
bool is_symbol(const Term& term);
bool is_variable(const Term& term);
/// `x` of `?x` and `$?x`, also of `?x:slot`; empty for `?`, for `?*global*` and for what is no variable.
std::string variable_name(const Term& term);
/// The conditions of a rule, and the index of its first action in `tree.items`.
std::size_t first_action(const Term& rule);
bool is_group(std::string_view head);  ///< and, or, not, exists, forall, logical
bool is_query(std::string_view head);  ///< of facts: do-for-fact, any-factp, find-fact, ...

}  // namespace cxlab::check
