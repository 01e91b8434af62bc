#pragma once
// Strategy: search for a sequence of whole actions. Which of them overlap is decided afterwards, by the timeline.

#include "planner/search/kept_search.h"
#include "planner/strategies/context.h"

namespace cxlab::planner {

class SequenceSearch {
 public:
  explicit SequenceSearch(PlanningContext& context) : context_(context), in_time_(context.touches) {}

  /// Looks for a sequence that comes in time for all events and offers it. True if a plan exists afterwards.
  bool run(const Turn& turn);
  /// No sequence is left that `run` could find.
  bool exhausted() const { return exhausted_; }
  /// Looks for any sequence, whether it comes in time or not. Offers nothing.
  std::optional<Sequence> find(const Turn& turn);
  /// Frees the memory of the search that would continue.
  void forget() { first_.forget(); }

 private:
  PlanningContext& context_;
  EventCheck in_time_;
  KeptSearch first_;
  bool exhausted_ = false;
};

}  // namespace cxlab::planner
