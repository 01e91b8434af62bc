#pragma once
// Strategies that make a plan better: local search over lists of whole actions or of parts, rebuilding, and searches
// for other lists. Every better plan is offered.

#include "planner/improve/decoder.h"
#include "planner/strategies/context.h"

namespace cxlab::planner {

class Improvement {
 public:
  explicit Improvement(PlanningContext& context);

  /// Local search, then rebuilding for as long, each until `most_idle` tries in a row gave no better plan. False if
  /// `list` is no plan.
  bool of_list(const Sequence& list, std::uint64_t round, std::int64_t most_idle);
  /// Local search on a list of parts of a cut task.
  void of_parts(const SplitSpace& cut, const Sequence& list, std::uint64_t round, std::int64_t most_idle);

 private:
  PlanningContext& context_;
  const RelaxedTask priced_;  ///< actions cost what they add to the objective
  Decoder decoder_;
};

/// Searches for a list whose numbers leave room for a better metric than the best plan's.
class BetterMetricSearch {
 public:
  /// Lists of whole actions need not be in time for events.
  BetterMetricSearch(PlanningContext& context, const SplitSpace& space);

  std::optional<Sequence> run(const Turn& turn);
  /// No list leaves room.
  bool exhausted() const { return exhausted_; }

 private:
  PlanningContext& context_;
  const SplitSpace& space_;
  std::optional<SplitCheck> check_;  ///< of parts
  bool exhausted_ = false;
};

}  // namespace cxlab::planner
