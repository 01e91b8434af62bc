#pragma once
// What can happen in a ground task at most.

#include <vector>

#include "planner/ground/budget.h"
#include "planner/ground/task.h"

namespace cxlab::planner {

/// What can happen if nothing is ever deleted and numbers go as far as they like in each direction in which they move.
/// The beginning of an action asks for its start condition only: others may bring about the rest while it runs.
/// A number without a value has none until one is assigned; before that what reads it or changes it cannot happen.
/// Not to be used if the budget ends.
class Relaxation {
 public:
  /// `any_value`: as if every number without a value had the right one.
  Relaxation(const GroundTask& task, Budget& budget, bool any_value = false);

  bool reaches(const GroundCondition& condition) const;
  bool reaches(const ConditionalEffects& effects) const {
    return reaches(effects.start) && reaches(effects.over_all) && reaches(effects.end);
  }
  bool applicable(std::size_t action) const { return ended_[action] != 0; }
  bool has_value(int number) const { return defined_[number] != 0; }

 private:
  bool has_value(const GroundExpression& expression) const;
  bool has_values(const GroundEffects& effects) const;
  bool has_duration(const GroundAction& action, bool ends) const;
  void spread();
  bool round();
  bool apply(const GroundEffects& effects);
  bool move(const GroundEffects& effects);
  bool move_number(int number, const GroundExpression& change);
  void refresh();
  void look(std::size_t count);

  const GroundTask& task_;
  Budget& budget_;
  std::size_t looks_ = 0;
  bool any_value_;
  std::vector<char> useless_;  ///< by action
  ById<char> fact_, comparison_, begun_, ended_, up_, down_, defined_;
};

}  // namespace cxlab::planner
