#pragma once
// Examines a rule base without running it: what is misspelt, unused, defined twice, unreachable, or loops.
//
//   auto base = check::RuleBase::read(sources, outside);
//   if (base) for (const check::Finding& finding : check::examine(*base)) ...

#include <compare>
#include <string>
#include <string_view>
#include <vector>

#include "cx/check/rule_base.h"

namespace cxlab::check {

struct Finding {
  std::string file;
  int line = 0;
  std::string code;     ///< one of `codes()`
  std::string message;  ///< what was found; what to do
  auto operator<=>(const Finding&) const = default;
  /// `file:line: [code] message`.
  std::string text() const;
};

/// What `cxlab check` looks for, in the order of docs/reference/check.md.
struct Code {
  std::string_view name, meaning;
};
const std::vector<Code>& codes();

/// By file and line, each once.
std::vector<Finding> examine(const RuleBase& base);

/// Removes what a comment `; check: allow CODE` allows, on the line of the finding or on the line above. A comment that
/// allows nothing is a finding itself. `findings`: of all environments that load these files.
std::vector<Finding> without_allowed(std::vector<Finding> findings, const std::vector<Source>& sources);

}  // namespace cxlab::check
