#pragma once
// Which values slots are known to have: a mutant has another one of them (lab/mutants.h).

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "cx/engine/form_reader.h"
#include "lab/mutants.h"
#include "lab/rule_words.h"

namespace cxlab::lab {

/// The values that slots are known to have, from definitions, conditions and actions.
class KnownValues {
 public:
  explicit KnownValues(const std::vector<RuleText>& files);

  bool has_slots(std::string_view name) const { return templates_.contains(name); }

  /// Another one than these of the slot (`TEMPLATE.SLOT`, or empty); else of one that has the symbol; else an invented
  /// one.
  std::string other(const std::string& symbol, const std::string& slot, const WordSet& not_these) const;

 private:
  void read_template(const Term& tree);
  void read_construct(const Term& tree);
  void read_condition(const Term& condition);
  void read_fact(const Term& fact);
  void read_actions(const Term& call, const std::map<std::string, std::string>& templates_of);
  void add(const std::string& slot, const Term& values, std::size_t from);

  WordSet templates_;
  std::map<std::string, WordSet> values_;  // by `TEMPLATE.SLOT`
};

}  // namespace cxlab::lab
