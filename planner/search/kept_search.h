#pragma once
// A search that goes on where it was when its last slice of the budget ended, as long as it looks for the same.

#include <memory>

#include "planner/search/lazy_search.h"

namespace cxlab::planner {

class KeptSearch {
 public:
  /// Begins with `options` unless one that looks for the same is under way; all else is the same in every call.
  SearchEnd go_on(const Simulator& simulator, const RelaxedTask& relaxed, const Landmarks& landmarks, PathCheck* check,
                  const LazyOptions& options, Budget& budget, Sequence& found) {
    SearchEnd end;
    if (search_ && late_goal_ == options.late_goal) {
      end = search_->go_on(budget, found);
    } else {
      search_ = std::make_unique<LazySearch>(simulator, relaxed, landmarks, check);
      late_goal_ = options.late_goal;
      end = search_->run(simulator.initial(), options, budget, found);
    }
    if (end != SearchEnd::kBudget) search_.reset();
    return end;
  }
  void forget() { search_.reset(); }

 private:
  std::unique_ptr<LazySearch> search_;
  bool late_goal_ = false;
};

}  // namespace cxlab::planner
