#pragma once
// Why a rule has not fired: what holds of its left-hand side now, what is missing first, and what has fired so far.

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/time.h"
#include "cx/engine/engine.h"
#include "cx/explain/history.h"

namespace cxlab::explain {

/// The first condition that no combination of facts gets past.
struct UnmetCondition {
  int number = 0;                   ///< of the rule's conditions, from 1
  std::string text;                 ///< as written; of an `or` the alternative that got furthest
  std::string because;              ///< one sentence
  std::optional<std::string> fact;  ///< the nearest one, the one that forbids, or the one without a partner
  std::string slot;                 ///< the first that differs in it; "implied" for an ordered fact, may be empty
  std::optional<std::size_t> matches_alone;  ///< of a pattern: facts that match it without the conditions before
  std::vector<std::pair<std::string, std::string>> values;  ///< of variables, in the combination that got furthest

  /// Text, reason and fact in one line.
  std::string print() const;
};

enum class Verdict {
  kWaiting,    ///< on the agenda
  kFired,      ///< all conditions hold, and it has fired for what holds
  kTaken,      ///< all conditions hold, but it is not on the agenda and has not fired
  kCondition,  ///< a condition does not hold
};
/// "waiting", "fired", "taken", "condition".
std::string_view to_string(Verdict verdict);

struct WhyNot {
  std::string rule, module, file;  ///< `file` as the engine knows it
  int line = 0;
  Verdict verdict{};
  std::optional<UnmetCondition> unmet;  ///< with kCondition

  // With kWaiting
  int salience = 0;
  std::size_t above = 0;                                 ///< activations that fire before it
  std::vector<std::pair<std::string, int>> first_above;  ///< the first of them, with their salience

  // What has happened
  std::size_t fired = 0;
  SimTime last_fired{};
  std::vector<std::string> last_facts;
};

/// About the present state of the engine. `rule` may have a module. `history`: of its environment from the start.
/// Defines functions of its own in the engine for a while, but changes no fact.
Expected<WhyNot> why_not(RuleEngine& engine, const std::string& rule, const History& history);
/// The same without the history, for a rule that has not fired: what it lacks. None if it lacks nothing.
std::optional<UnmetCondition> unmet_condition(RuleEngine& engine, const ConstructInfo& rule);

}  // namespace cxlab::explain
