#pragma once
// A ground task with what a search on it needs.

#include "planner/ground/budget.h"
#include "planner/search/landmarks.h"
#include "planner/search/split.h"

namespace cxlab::planner {

struct SearchSpace {
  /// Spends the work of making it. `task` must outlive it.
  SearchSpace(const GroundTask& task, Budget& budget);
  SearchSpace(const SearchSpace&) = delete;
  SearchSpace& operator=(const SearchSpace&) = delete;

  Simulator simulator;
  RelaxedTask relaxed;
  Landmarks landmarks;
};

/// The same for a task in which some actions are cut in two, or none.
struct SplitSpace {
  SplitSpace(SplitTask task, Budget& budget) : split(std::move(task)), space(split.task, budget) {}

  const SplitTask split;
  const SearchSpace space;
};

}  // namespace cxlab::planner
