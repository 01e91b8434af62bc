#pragma once
// The parts of `examine`, each for some codes.

#include <string>
#include <vector>

#include "cx/check/check.h"

namespace cxlab::check {

using Findings = std::vector<Finding>;

inline void add(Findings& findings, const Place& place, std::string code, std::string message) {
  if (place.source && place.source->judged)
    findings.push_back({place.source->file, place.line, std::move(code), std::move(message)});
}

/// unknown-symbol, never-asserted, never-read, unused-template, never-set (facts.cpp)
void judge_facts(const RuleBase& base, Findings& findings);
/// unknown-slot (slots.cpp)
void judge_unknown_slots(const RuleBase& base, Findings& findings);
/// unreachable (reach.cpp)
void judge_reach(const RuleBase& base, Findings& findings);
/// loop (loops.cpp)
void judge_loops(const RuleBase& base, Findings& findings);
/// salience (salience.cpp)
void judge_salience(const RuleBase& base, Findings& findings);
/// defined-twice, used-once, unused-function, unused-global (check.cpp)
void judge_constructs(const RuleBase& base, Findings& findings);

/// The symbols of `known` that a misspelt `word` may stand for, else empty. Members of one family (C1, C2) are not.
std::string meant(const std::string& word, const std::vector<std::string>& known);

/// A rule's parts.
struct RuleParts {
  struct Condition {
    const Term* term = nullptr;
    std::string fact;  ///< of `?f <- (...)`
  };
  std::vector<Condition> conditions;  ///< `logical` and `and` taken apart
  std::vector<const Term*> actions;
  const Term* salience = nullptr;  ///< its value
};
RuleParts parts_of(const Construct& rule);

}  // namespace cxlab::check
