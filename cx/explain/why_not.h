#pragma once
// Why a rule has not fired: what holds of its left-hand side now, what is missing first, and what has fired so far.

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/time.h"
#include "cx/engine/engine.h"
#include "cx/explain/agenda_watch.h"
#include "cx/explain/evaluator.h"
#include "cx/explain/history.h"

namespace cxlab::explain {

/// Names of variables with their values, in the order in which they are bound.
using Values = std::vector<std::pair<std::string, std::string>>;

/// The first condition that no combination of facts gets past.
struct UnmetCondition {
  int number = 0;                   ///< of the rule's conditions, from 1
  std::string text;                 ///< as written; of an `or` the alternative that got furthest
  std::string because;              ///< one sentence
  std::optional<std::string> fact;  ///< the nearest one, the one that forbids, or the one without a partner
  std::uint64_t fact_number = 0;    ///< of it, as in the journal; 0: it is none, or several
  std::string slot;                 ///< the first that differs in it; "implied" for an ordered fact, may be empty
  bool none_there = false;          ///< there is no fact of its template at all
  std::optional<std::size_t> matches_alone;  ///< of a pattern: facts that match it without the conditions before
  Values values;                             ///< in the combination that got furthest
  std::string module = "MAIN";               ///< of the rule

  /// Text, reason and fact in one line.
  std::string print() const;
};

enum class Verdict {
  kWaiting,    ///< on the agenda
  kFocus,      ///< on the agenda of a module that is not in focus
  kFired,      ///< all conditions hold, and it has fired for what holds
  kTaken,      ///< all conditions hold, but it is not on the agenda and has not fired for what holds
  kCondition,  ///< a condition does not hold
};
/// "waiting", "focus", "fired", "taken", "condition".
std::string_view to_string(Verdict verdict);

struct WhyNot {
  std::string rule, module, file;  ///< `file` as the engine knows it
  int line = 0;
  Verdict verdict{};
  std::optional<UnmetCondition> unmet;  ///< with kCondition
  std::size_t alternatives = 1;         ///< that its `or` conditions make; of these, `unmet` is about one

  // Where all conditions hold
  std::size_t combinations = 0;    ///< of facts that satisfy them
  std::vector<std::string> facts;  ///< of the one that fires first, or fired last
  Values values;                   ///< in it
  std::optional<SimTime> fired_for_it;

  // With kWaiting and kFocus
  int salience = 0;
  std::size_t above = 0;                                 ///< activations that fire before it
  std::vector<std::pair<std::string, int>> first_above;  ///< the first of them, with their salience
  std::vector<std::string> focus;                        ///< the stack of modules, the first on top

  // What has happened
  std::size_t fired = 0;
  SimTime last_fired{};
  std::vector<std::string> last_facts;
  std::optional<LostActivation> lost;  ///< since the last firing; set by who watched the agenda
};

/// About the present state of the engine. `history`: of its environment from the start, with the firings of the rule.
/// `wanted` asks about combinations with these values only; it is an error if the conditions do not bind them.
/// Defines functions of its own in the engine for a while, but changes no fact; `rule` is a copy for that reason.
Expected<WhyNot> why_not(RuleEngine& engine, ConstructInfo rule, const History& history, const Wanted& wanted = {});
/// The same without the history, for a rule that has not fired: what it lacks. None if it lacks nothing, or binds
/// nothing that is wanted.
std::optional<UnmetCondition> unmet_condition(RuleEngine& engine, ConstructInfo rule, const Wanted& wanted = {});

/// A condition of a rule as it is now.
struct ConditionNow {
  int number = 0;  ///< from 1
  std::string text;
  int line = 0, end_line = 0;  ///< of the rule's file
  /// Whether the conditions up to it hold together; of an `or` whether an alternative does. None: one before it fails,
  /// or there are too many combinations to tell.
  std::optional<bool> holds;
  std::optional<std::size_t> matches_alone;  ///< of a pattern: facts that match it without the conditions before
};
/// All conditions of a rule, in their order. Its first one that does not hold is the one of `unmet_condition`.
Expected<std::vector<ConditionNow>> conditions_now(RuleEngine& engine, ConstructInfo rule);

}  // namespace cxlab::explain
