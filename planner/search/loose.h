#pragma once
// Estimates how far the goal is from a state in which actions run. It uses the relaxed task, in which every action is
// two: its beginning and its end. It takes the better of two states: the present one, and the one after all running
// actions have ended.

#include <optional>
#include <span>
#include <vector>

#include "planner/search/relaxed.h"

namespace cxlab::planner {

class LooseEstimate {
 public:
  /// The rest refers to `task`, which must outlive it.
  explicit LooseEstimate(const GroundTask& task);
  LooseEstimate(const LooseEstimate&) = delete;
  LooseEstimate& operator=(const LooseEstimate&) = delete;

  struct Running {
    int action = -1;
    std::optional<Micros> left;  ///< until it ends; none: not known
    Micros length = 0;           ///< where `left` is known
  };
  /// `state` is of the task, its numbers are `numbers`. RelaxedHeuristic::kDeadEnd: the goal seems out of reach.
  int evaluate(RelaxedHeuristic& heuristic, const Word* state, const double* numbers, int next_event,
               std::span<const Running> running);
  /// By action of the task: whether its beginning or its end is a first step of a relaxed plan of the last evaluation.
  const ById<char>& preferred() const { return preferred_; }
  RelaxedHeuristic heuristic() const { return {simulator_, relaxed_}; }

 private:
  const GroundTask& task_;
  const GroundTask loose_;
  const Simulator simulator_;
  const RelaxedTask relaxed_;
  ById<int> origins_;     ///< by action of the relaxed task: the action
  ById<int> is_running_;  ///< by action: the fact that it has begun; -1: it has no duration
  PackedState state_;
  ById<char> preferred_;
};

}  // namespace cxlab::planner
