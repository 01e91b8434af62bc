#include "cx/executive/suspect_words.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "cx/engine/form_reader.h"

namespace cxlab::cx {

namespace {

using Words = std::set<std::string>;

bool is_symbol(const Term& term) {
  return term.kind == Token::Kind::kWord && !term.text.empty() &&
         std::isalpha(static_cast<unsigned char>(term.text.front())) != 0;
}

std::string without_digits(std::string text) {
  std::erase_if(text, [](unsigned char c) { return std::isdigit(c) != 0; });
  return text;
}

/// The word of `known` that this one may be meant to be; others of one family (C1, C2) are not.
std::string meant(const std::string& word, const Words& known) {
  constexpr std::size_t kShortest = 4;  // of shorter ones many are near
  if (word.size() < kShortest) return {};
  std::vector<std::string> others;
  for (const std::string& other : known)
    if (other.size() >= kShortest && without_digits(other) != without_digits(word)) others.push_back(other);
  return nearest_word(word, others);
}

struct Use {
  std::string file;
  int line = 0;
};

class WordReader {
 public:
  explicit WordReader(const RuleEngine& engine) : constructs_(engine.constructs()) {}

  std::vector<Error> read() {
    for (const ConstructInfo& info : constructs_)
      if (info.kind == "deftemplate") read_template(tree(info));
    for (const ConstructInfo& info : constructs_) {
      info_ = &info;
      const Term construct = tree(info);
      if (info.kind == "defrule")
        read_rule(construct);
      else if (info.kind == "deffacts")
        read_facts(construct, 2);
      else if (info.kind != "deftemplate")
        read_actions(construct, 2);
    }
    for (const auto& [slot, uses] : slot_patterns_)
      for (const auto& [word, use] : uses) judge_symbol(slot, word, use);
    for (const auto& [name, use] : asserted_) judge_fact(name, use);
    for (const auto& [name, use] : ordered_patterns_) judge_pattern(name, use);
    return std::move(found_);
  }

 private:
  using Slot = std::pair<std::string, std::string>;  // template, slot

  static Term tree(const ConstructInfo& info) {
    return tree_of(Form{info.text, info.line, true, info.kind, info.name});
  }
  Use here(const Term& term) const { return {info_->file, info_->file.empty() ? 0 : term.line}; }
  static std::string bare(std::string_view name) { return std::string(without_module(name)); }

  /// Symbols that a slot may have by its definition.
  void read_template(const Term& construct) {
    if (construct.items.size() < 2) return;
    const std::string name = bare(construct.items[1].text);
    templates_.insert(name);
    for (const Term& slot : construct.items) {
      if (slot.head() != "slot" && slot.head() != "multislot") continue;
      if (slot.items.size() < 2) continue;
      const Slot of{name, slot.items[1].text};
      for (const Term& facet : slot.items)
        if (facet.head().starts_with("allowed-") || facet.head() == "default")
          for (std::size_t i = 1; i < facet.items.size(); ++i) add_given(of, facet.items[i]);
    }
  }

  void add_given(const Slot& slot, const Term& value) {
    if (is_symbol(value)) {
      given_[slot].insert(value.text);
      anywhere_.insert(value.text);
    }
    for (std::size_t i = 1; i < value.items.size(); ++i) add_given(slot, value.items[i]);  // (if .. then A else B)
  }

  void read_rule(const Term& rule) {
    std::size_t i = 2;
    for (; i < rule.items.size() && !rule.items[i].is("=>"); ++i) read_condition(rule.items[i]);
    read_actions(rule, i);
  }

  void read_condition(const Term& condition) {
    static constexpr std::string_view kGroups[] = {"and", "or", "not", "exists", "forall", "logical"};
    const std::string_view head = condition.head();
    if (head.empty() || head == "declare" || head == "object") return;
    if (head == "test") return read_actions(condition, 0);
    if (std::ranges::find(kGroups, head) != std::end(kGroups)) {
      for (const Term& inner : condition.items) read_condition(inner);
      return;
    }
    const std::string name = bare(head);
    read_.insert(name);
    if (!templates_.contains(name)) ordered_patterns_.try_emplace(name, here(condition));
    for (std::size_t i = 1; i < condition.items.size(); ++i) {
      const Term& slot = condition.items[i];
      if (!slot.is_list()) continue;
      for (std::size_t k = 1; k < slot.items.size(); ++k) {
        const Term& value = slot.items[k];
        if (is_symbol(value))
          slot_patterns_[{name, std::string(slot.head())}].try_emplace(value.text, here(value));
        else
          read_actions(value, 0);  // a call in a constraint
      }
    }
  }

  /// Everything outside of patterns may give a symbol to something: all words count, those in texts, too.
  void read_actions(const Term& term, std::size_t from) {
    if (is_symbol(term)) anywhere_.insert(term.text);
    if (term.kind == Token::Kind::kString) add_words_of(term.text);
    if (!term.is_list()) return;
    const std::string_view head = term.head();
    if (head == "assert") return read_facts(term, 1);
    if (head == "modify" || head == "duplicate")
      for (std::size_t i = 2; i < term.items.size(); ++i) add_changed(term.items[i]);
    for (std::size_t i = from; i < term.items.size(); ++i) read_actions(term.items[i], 0);
  }

  void read_facts(const Term& list, std::size_t from) {
    for (std::size_t i = from; i < list.items.size(); ++i) {
      const Term& fact = list.items[i];
      read_fact(fact);
      for (std::size_t k = 1; k < fact.items.size(); ++k) read_actions(fact.items[k], 1);
    }
  }

  /// A slot that a modify changes, of a template that it does not name.
  void add_changed(const Term& slot) {
    Words& words = changed_[std::string(slot.head())];
    const auto collect = [&](const auto& self, const Term& value) -> void {
      if (is_symbol(value)) words.insert(value.text);
      for (std::size_t i = 1; i < value.items.size(); ++i) self(self, value.items[i]);
    };
    for (std::size_t i = 1; i < slot.items.size(); ++i) collect(collect, slot.items[i]);
  }

  void read_fact(const Term& fact) {
    if (fact.head().empty()) return;
    const std::string name = bare(fact.head());
    given_facts_.insert(name);
    if (!templates_.contains(name)) {
      asserted_.try_emplace(name, here(fact));
      return;
    }
    for (const Term& slot : fact.items)
      if (slot.is_list() && !slot.head().empty())
        for (std::size_t i = 1; i < slot.items.size(); ++i) add_given({name, std::string(slot.head())}, slot.items[i]);
  }

  void add_words_of(const std::string& text) {
    std::string word;
    for (const char c : text + ' ') {
      if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_') {
        word += c;
        continue;
      }
      if (!word.empty()) anywhere_.insert(std::exchange(word, {}));
    }
  }

  void judge_symbol(const Slot& slot, const std::string& word, const Use& use) {
    if (anywhere_.contains(word) || !templates_.contains(slot.first)) return;
    Words known = given_[slot];
    known.insert(changed_[slot.second].begin(), changed_[slot.second].end());
    const std::string near = meant(word, known);
    if (near.empty()) return;
    add(use, "nothing gives slot '" + slot.second + "' of '" + slot.first + "' the symbol " + word +
                 ", did you mean '" + near + "'?");
  }

  void judge_fact(const std::string& name, const Use& use) {
    if (read_.contains(name) || anywhere_.contains(name)) return;
    const std::string near = meant(name, read_);
    if (near.empty()) return;
    add(use, "no rule reads the facts '" + name + "' that are asserted here, did you mean '" + near + "'?");
  }

  void judge_pattern(const std::string& name, const Use& use) {
    if (given_facts_.contains(name) || anywhere_.contains(name)) return;
    const std::string near = meant(name, given_facts_);
    if (near.empty()) return;
    add(use, "nothing asserts the facts '" + name + "' that this pattern reads, did you mean '" + near + "'?");
  }

  void add(const Use& use, std::string what) { found_.push_back(input_error(std::move(what), use.file, use.line)); }

  const std::vector<ConstructInfo> constructs_;
  const ConstructInfo* info_ = nullptr;
  Words templates_;    // with slots
  Words read_;         // of facts in patterns
  Words given_facts_;  // of facts that are asserted
  Words anywhere_;     // outside of patterns
  std::map<Slot, Words> given_;
  std::map<std::string, Words> changed_;  // by modify and duplicate: slot, symbols
  std::map<Slot, std::map<std::string, Use>> slot_patterns_;
  std::map<std::string, Use> asserted_, ordered_patterns_;
  std::vector<Error> found_;
};

}  // namespace

std::vector<Error> suspect_words(const RuleEngine& engine) { return WordReader(engine).read(); }

}  // namespace cxlab::cx
