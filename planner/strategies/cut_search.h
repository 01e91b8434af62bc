#pragma once
// Strategy: search for plans in which actions must overlap, over the beginnings and ends of actions that are cut.

#include "planner/search/kept_search.h"
#include "planner/strategies/context.h"

namespace cxlab::planner {

class CutSearch {
 public:
  enum class Cut {
    kEnvelopes,   ///< actions that others can need to be under way
    kEverything,  ///< all that can be cut
  };

  CutSearch(PlanningContext& context, Cut cut) : context_(context), cut_(cut) {}

  /// Looks for a sequence of parts and offers it. True if it found one and a plan exists.
  bool run(const Turn& turn);
  /// Nothing is left that `run` could find: also where nothing is cut.
  bool exhausted() const { return exhausted_; }
  /// The cut task, made on the first call of this or of `run`; null where nothing is cut, or the time has run out.
  const SplitSpace* space();
  void forget() { first_.forget(); }

 private:
  std::vector<char> marked() const;

  PlanningContext& context_;
  const Cut cut_;
  bool made_ = false;
  std::unique_ptr<SplitSpace> space_;
  std::unique_ptr<SplitCheck> check_;
  KeptSearch first_;
  bool exhausted_ = false;
};

}  // namespace cxlab::planner
