#pragma once
// The task without deletions: how far the goal seems, and which actions seem to help. Additive costs choose the
// cheapest achiever of each atom, the relaxed plan is read off them (hFF with hadd, Keyder and Geffner 2008; numeric
// conditions as in subgoaling, Scala et al. 2016: a gap takes as many steps as it needs).

#include <cstdint>
#include <span>
#include <vector>

#include "cx/base/random.h"
#include "planner/search/simulator.h"

namespace cxlab::planner {

/// A way to reach atoms: a whole action (with one of its conditional effects), an axiom, an event.
struct RelaxedOperator {
  int action = -1;   ///< -1: axiom; -2 - k: event k
  bool base = true;  ///< has exactly the condition of the action
  int cost = 1;
  std::vector<int> conditions;  ///< atoms
  std::vector<int> adds;        ///< facts
  struct Gain {
    int atom;       ///< of a comparison
    double change;  ///< of its value, towards the goal; infinite: one application does it
  };
  std::vector<Gain> gains;
};

/// Atoms are facts, then comparisons.
class RelaxedTask {
 public:
  /// `unit_costs`: every action costs 1; else its duration in tenths of the mean one, and 1.
  RelaxedTask(const Simulator& simulator, bool unit_costs);
  /// `costs`: by action.
  RelaxedTask(const Simulator& simulator, const std::vector<int>& costs);

  int atoms() const { return atoms_; }
  int facts() const { return facts_; }
  const ById<RelaxedOperator>& operators() const { return operators_; }
  const std::vector<int>& goal() const { return goal_; }
  std::span<const int> readers(int atom) const { return readers_.of(atom); }
  std::span<const int> adds(int op) const { return adds_.of(op); }
  /// By operator: how many conditions; the action of one that has exactly the condition of the action, else -1.
  const ById<int>& conditions() const { return conditions_; }
  const ById<int>& base_actions() const { return base_actions_; }
  /// Operators without conditions, and whether an operator has gains.
  const std::vector<int>& unconditional() const { return unconditional_; }
  bool has_gains(int op) const { return has_gains_[op] != 0; }
  /// What it took to make: comparisons looked at.
  std::int64_t work() const { return work_; }

 private:
  void add_operators(const Simulator& simulator, int action, int cost);
  void add_effects(const GroundTask& task, RelaxedOperator& made, const GroundEffects& effects, int action);

  int facts_ = 0, atoms_ = 0;
  std::int64_t work_ = 0;
  ById<RelaxedOperator> operators_;
  std::vector<int> goal_;
  /// Lists in one array: what is read all the time lies together.
  class Lists {
   public:
    void add(std::span<const int> list) {
      items_.insert(items_.end(), list.begin(), list.end());
      begin_.push_back(items_.size());
    }
    std::span<const int> of(int list) const { return {items_.data() + begin_[list], items_.data() + begin_[list + 1]}; }

   private:
    ById<std::size_t> begin_ = {0};
    std::vector<int> items_;
  };
  Lists readers_;  ///< by atom: operators that have it as a condition
  Lists adds_;     ///< by operator
  ById<int> conditions_, base_actions_, unconditional_;
  ById<char> has_gains_;
};

class RelaxedHeuristic {
 public:
  static constexpr int kDeadEnd = std::numeric_limits<int>::max();

  RelaxedHeuristic(const Simulator& simulator, const RelaxedTask& relaxed);

  /// Makes every operator with a cost dearer by chance, by up to `share` of it.
  void scatter_costs(RandomStream& random, double share);
  /// Cost of a relaxed plan from `state`, in which `next_event` is the first event to come.
  int evaluate(const Word* state, int next_event = 0);
  /// Actions whose conditions hold in the last state; ascending.
  const std::vector<int>& applicable() const { return applicable_; }
  /// The applicable actions that the relaxed plan contains.
  const std::vector<int>& preferred() const { return preferred_; }
  /// Actions of the relaxed plan, and events as -2 - k.
  const std::vector<int>& relaxed_plan() const { return plan_; }
  /// Work done by all evaluations: operators looked at.
  std::int64_t work() const { return work_; }

 private:
  void reach(int atom, int cost, int achiever);
  void explore(int next_event);
  void extract(int atom);

  const Simulator& simulator_;
  const RelaxedTask& relaxed_;
  ById<int> prices_;  ///< by operator
  ById<int> cost_, achiever_, missing_, sum_;
  std::vector<double> gap_;  ///< by comparison
  ById<char> marked_, in_plan_;
  std::vector<std::vector<int>> buckets_;
  std::vector<int> used_;  ///< operators of the relaxed plan
  ById<int> applicable_, preferred_, plan_;
  const Word* state_ = nullptr;
  int unreached_goals_ = 0;
  ById<char> is_goal_;
  std::int64_t work_ = 0;
};

}  // namespace cxlab::planner
