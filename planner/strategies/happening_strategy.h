#pragma once
// Strategy: search over orders of happenings, which small problems end with a plan or a proof.

#include <memory>

#include "planner/happenings/happening_search.h"
#include "planner/strategies/context.h"
#include "planner/strategies/unsolvable.h"

namespace cxlab::planner {

class HappeningStrategy {
 public:
  /// `better`: looks for plans that are better than the one that exists, so that it must know how long each takes.
  HappeningStrategy(PlanningContext& context, bool better) : context_(context), better_(better) {}

  /// Whether the problem is small enough, and times matter in it.
  bool is_needed() const;
  /// Goes on looking for a plan that is better than the best one, and offers it. True if it found one.
  bool run(const Turn& turn);
  /// Nothing is left that `run` could find.
  bool exhausted() const { return exhausted_; }
  /// Everything was looked at, so that no other search could find anything either; except for plans in which more than
  /// a few copies of an action run at once, where any plan is looked for.
  bool has_seen_all() const { return seen_all_; }
  /// Continues the search for a proof that the problem has no plan. True: proved. `has_ended_proof` becomes true when
  /// the search has ended.
  bool prove(const Turn& turn);
  bool has_ended_proof() const { return proof_ended_; }
  /// Frees the memory of both searches.
  void forget();

 private:
  std::unique_ptr<HappeningSearch> make(bool relaxed, int copies) const;
  bool may_be_apart_in_vain() const;

  PlanningContext& context_;
  const bool better_;
  std::unique_ptr<HappeningSearch> search_, proof_;
  int copies_of_proof_ = 1;
  bool exhausted_ = false, seen_all_ = false, proof_ended_ = false;
  bool certain_ = false;  ///< the second search: only what is certain is kept apart
};

}  // namespace cxlab::planner
