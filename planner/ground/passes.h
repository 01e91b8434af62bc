#pragma once
// The passes of `ground`, besides the join (reachable.h) and the removal of needless parts (renumber.h).

#include <cstddef>
#include <vector>

#include "planner/ground/budget.h"
#include "planner/ground/task.h"

namespace cxlab::planner {

/// Which actions can help towards the goal at all, judged by predicates alone. By action: whether it adds a predicate
/// that is needed, deletes one whose absence is needed, or changes a number that is read or must have a value first.
/// The goal and the relevant actions determine what is needed.
std::vector<char> relevant_actions(const Task& task);

/// What conditions read through derived predicates, by action of the domain; empty without derived predicates.
ById<SchemaReads> find_derived_reads(const Domain& domain);

/// Which facts can be true, and which two of them at once. Empty: nothing is known.
struct Together {
  std::size_t words = 0;     ///< of a row
  std::vector<Word> rows{};  ///< by fact: bits of the facts that can be true with it

  bool can_be(int a, int b) const { return words == 0 || is_set(&rows[static_cast<std::size_t>(a) * words], b); }
};

/// What can happen, judged by pairs of facts.
struct Possible {
  ById<char> actions;  ///< by action: its start and its end
  bool goal = true;    ///< the goal can hold
  Together together{};
};
/// Finds facts that are never true together, and actions that therefore cannot happen (h2, Haslum and Geffner 2000).
/// Beginnings and ends count one by one, so that overlapping plans are covered; numbers are assumed to allow
/// everything. All is possible if there are derived facts or more than 1,500 facts, or the budget ends.
Possible possible_by_pairs(const GroundTask& task, Budget& budget);

/// Whether the bound of a duration is above 0 wherever the condition holds.
bool is_surely_positive(const GroundTask& task, const GroundExpression& bound, const GroundCondition& condition);

/// Turns the actions that last no longer than 0 into instantaneous ones, and drops those whose beginning and end
/// always interfere. Nothing is asked over all: the open interval between is empty. Actions that may last longer, and
/// whose beginning and end always interfere, last at least `kValidSeparation`.
void merge_instants(GroundTask& task);

/// Copies each action whose effects depend on a duration that may be chosen, once for each of several durations.
/// Incomplete if the budget ends.
void offer_durations(GroundTask& task, Budget& budget);

/// Finds what validators keep apart although no plan depends on it: fills in GroundAction::idle and TimedEvent::idle of
/// a pruned task. Incomplete if the budget ends.
void find_idle(const Task& task, GroundTask& ground, Budget& budget);

}  // namespace cxlab::planner
