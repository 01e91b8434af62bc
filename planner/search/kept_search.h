#pragma once
// A search that continues where its last slice of the budget ended, as long as it looks for the same.

#include <memory>

#include "planner/search/lazy_search.h"
#include "planner/search/search_space.h"

namespace cxlab::planner {

class KeptSearch {
 public:
  /// Begins with `options` unless a search for the same goal is under way; all else is the same in every call.
  SearchEnd go_on(const SearchSpace& space, PathCheck* check, const LazyOptions& options, Budget& budget,
                  Sequence& found) {
    SearchEnd end;
    if (search_ && late_goal_ == options.late_goal) {
      end = search_->go_on(budget, found);
    } else {
      search_ = std::make_unique<LazySearch>(space.simulator, space.relaxed, space.landmarks, check);
      late_goal_ = options.late_goal;
      end = search_->run(space.simulator.initial(), options, budget, found);
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
