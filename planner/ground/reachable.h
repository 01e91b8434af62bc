#pragma once
// Which ground atoms can become true, and under which arguments each action can be applied, if nothing were ever
// deleted and conditions that are not plain atoms always held. A join over the atoms found so far, driven by each new
// one.

#include <cstdint>
#include <span>
#include <vector>

#include "cx/base/expected.h"
#include "planner/ground/budget.h"
#include "planner/pddl/model.h"
#include "planner/state/atom_table.h"

namespace cxlab::planner {

struct Binding {
  ActionId action = -1;
  std::vector<ObjectId> arguments;
};

struct Reachable {
  AtomTable atoms;      ///< derived predicates are not in it
  ById<char> fluent;    ///< by predicate: something changes it
  ById<char> changing;  ///< by function: something changes it
  std::vector<Binding> bindings;
};

/// Fails (kResource) beyond `most_bindings` (Failure::kOutOfMemory) or the budget (kOutOfBudget).
Expected<Reachable> find_reachable(const Task& task, std::size_t most_bindings, Budget& budget);

/// Calls `visit()` for every assignment of objects to `variables`, written to their slots of `frame`, until the budget
/// ends.
template <class Visit>
void for_each_assignment(const Task& task, std::span<const Variable> variables, ById<ObjectId>& frame, Budget& budget,
                         const Visit& visit) {
  if (variables.empty()) {
    budget.spend(Work::kGround, 1);
    visit();
    return;
  }
  for (const ObjectId object : objects_of(task.domain, task.problem, variables[0].types)) {
    if (budget.over()) return;
    frame[variables[0].slot] = object;
    for_each_assignment(task, variables.subspan(1), frame, budget, visit);
  }
}

}  // namespace cxlab::planner
