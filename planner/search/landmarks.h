#pragma once
// Atoms that every plan makes true at some time: those that remain are a second estimate of what is left to do.
// All causal landmarks of the delete relaxation by propagation (Zhu and Givan 2003; Keyder, Richter and Helmert 2010),
// counted as LAMA does (Richter and Westphal 2010).

#include <vector>

#include "planner/ground/budget.h"
#include "planner/search/relaxed.h"

namespace cxlab::planner {

class Landmarks {
 public:
  /// Looks for them from the initial state; none if that would take more than `most_work` steps or the time runs out.
  Landmarks(const Simulator& simulator, const RelaxedTask& relaxed, std::int64_t most_work, Budget& budget);

  int count() const { return static_cast<int>(atoms_.size()); }
  int words() const { return (count() + 63) / 64; }
  std::int64_t work() const { return work_; }
  /// Atoms of the landmarks, ascending.
  const std::vector<int>& atoms() const { return atoms_; }

  /// Marks in `reached` (one bit a landmark) those that are true now.
  void mark(const Word* state, Word* reached) const;
  /// How many are still to be reached, or must be reached again.
  int remaining(const Word* state, const Word* reached) const;

 private:
  bool holds(int landmark, const Word* state) const;

  const Simulator& simulator_;
  int facts_ = 0;
  ById<int> atoms_;
  ById<char> goal_;                   ///< by landmark
  ById<std::vector<int>> needed_by_;  ///< by landmark: landmarks that it must directly precede
  std::int64_t work_ = 0;
};

}  // namespace cxlab::planner
