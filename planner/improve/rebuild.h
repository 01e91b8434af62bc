#pragma once
// Makes shorter plans from a plan (large neighbourhood search). It takes out steps that belong together and lets a
// search fill the gap in another way. It keeps the result if it is no worse.

#include "cx/base/random.h"
#include "planner/improve/local_search.h"

namespace cxlab::planner {

class Rebuild {
 public:
  /// `relaxed` is of whole actions, with their durations as costs; the decoder cuts nothing.
  Rebuild(Decoder& decoder, const RelaxedTask& relaxed, std::uint64_t seed);

  /// Takes a plan to begin with; false if it is none.
  bool start(const Sequence& plan);
  /// Continues until the slice of the budget is over, or `most_idle` tries in a row gave no new best plan.
  void run(Budget& budget, std::int64_t most_idle, const LocalSearch::OnBetter& on_better);

  const DecodedPlan& best() const { return best_; }

 private:
  Sequence without_some();
  std::vector<char> belongs_to_goal(int goal_fact) const;

  Decoder& decoder_;
  const RelaxedTask& relaxed_;
  RandomStream random_;
  DecodedPlan current_, best_;
  std::vector<double> history_;
  std::int64_t tries_ = 0;
};

}  // namespace cxlab::planner
