#pragma once
// The effects of function calls on facts.

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cx/check/rule_base.h"

namespace cxlab::check {

class Effects {
 public:
  explicit Effects(const RuleBase& base);
  /// Adds the templates whose facts an expression of a rule may assert, change or retract; the empty name: any, or it
  /// may end the run.
  void add(const Term& expression, std::set<std::string>& templates);
  /// The parameters of a function whose facts each call retracts or modifies: index, and that action.
  std::vector<std::pair<std::size_t, const Term*>> takes(const std::string& function) const;

 private:
  const std::set<std::string>& of(const std::string& function);

  std::map<std::string, const Construct*> functions_;
  std::map<const Construct*, std::set<std::string>> touched_;
  std::map<std::string, std::set<std::string>> known_;
};

}  // namespace cxlab::check
