#pragma once
// Strategy: search for a sequence of whole actions, or of the beginnings and ends of actions that are cut.

#include "planner/strategies/context.h"

namespace cxlab::planner {

/// Which actions are cut, so that others can happen between their beginning and their end.
enum class Cut {
  kNothing,     ///< the timeline decides afterwards which actions overlap
  kEnvelopes,   ///< actions that others can need to run
  kEverything,  ///< all that can be cut
};

class SequenceSearch {
 public:
  SequenceSearch(PlanningContext& context, Cut cut) : context_(context), cut_(cut) {}

  /// Looks for a sequence that comes in time for all events and offers it. True if it found one and a plan exists.
  bool run(const Turn& turn);
  /// Nothing is left that `run` could find: also where an action should be cut and none can be.
  bool exhausted() const { return exhausted_; }
  /// Looks for a sequence of whole actions, whether it comes in time or not. Offers nothing.
  std::optional<Sequence> find(const Turn& turn);
  /// The task that is searched, made on the first call of this or of `run`; null where an action should be cut and none
  /// can be, or the time has run out.
  const SplitSpace* space();
  /// Frees the memory of the search that would continue.
  void forget() { first_.reset(); }

 private:
  std::vector<char> marked() const;

  PlanningContext& context_;
  const Cut cut_;
  bool made_ = false, exhausted_ = false;
  std::unique_ptr<SplitSpace> cut_space_;
  std::unique_ptr<PathCheck> check_;   ///< none where every sequence has times
  std::unique_ptr<LazySearch> first_;  ///< continues as long as it looks for the same
};

}  // namespace cxlab::planner
