#pragma once
// The context that all strategies of the planner share: the ground problem, the budget, the best plan so far and its
// bound.

#include "planner/search/lazy_search.h"
#include "planner/search/search_space.h"
#include "planner/strategies/best_possible.h"
#include "planner/strategies/incumbent.h"

namespace cxlab::planner {

/// One turn of a strategy.
struct Turn {
  std::uint64_t round = 0;  ///< seed of its random choices; 0: none
  std::int64_t units = 0;   ///< of work, at most
};

/// In every fourth round the search of round 0 continues; in the others a new search starts.
inline bool continues_first(const Turn& turn) { return turn.round % 4 == 0; }

class PlanningContext {
 public:
  /// Prepares the search over whole actions. Arguments passed by reference must outlive the context.
  PlanningContext(const Task& task, const PlanOptions& options, Budget& budget, GroundTask ground,
                  Incumbent::Clock::time_point began = Incumbent::Clock::now());
  PlanningContext(const PlanningContext&) = delete;
  PlanningContext& operator=(const PlanningContext&) = delete;

  const PlanOptions& options;
  Budget& budget;
  const GroundTask ground;
  const Touches touches{ground};
  const SplitSpace whole;  ///< nothing is cut
  const Objective objective{whole.space.simulator};
  const bool has_durations;
  Incumbent best;
  BestPossible bound{ground, objective, budget};

  bool has_events() const { return !ground.events.empty(); }
  bool is_over() const { return budget.over(); }

  /// Offers a plan as a list of whole actions, or of parts. True if it is the best now; improvement continues from it.
  bool offer(const SplitSpace& space, const Sequence& list);
  /// Offers a list of whole actions that a search found. Improvement begins with the first one, even if it is no plan
  /// as it stands.
  void offer_found(const Sequence& list);
  /// The list of whole actions from which improvement continues; empty: none was found.
  const Sequence& best_list() const { return best_list_; }
  /// The best plan as a list of parts of `cut`, if it was found so last; else `cut` is null.
  struct PartsList {
    const SplitSpace* cut = nullptr;
    Sequence list;
  };
  const PartsList& best_parts() const { return best_parts_; }

  LazyOptions search_options(std::uint64_t seed) const;

 private:
  Sequence best_list_;
  PartsList best_parts_;
};

}  // namespace cxlab::planner
