#pragma once
// Greedy best-first search over whole actions, one after the other: lazy evaluation, the queues of the relaxed plan and
// of the landmarks in turn, actions of the relaxed plan preferred (LAMA, Richter and Westphal 2010).
//
// Sequences miss what needs actions to overlap; see concurrent_search.h. What they contain need not happen in their
// order: the timeline decides.

#include <vector>

#include "planner/schedule/timeline.h"
#include "planner/search/budget.h"
#include "planner/search/landmarks.h"
#include "planner/search/relaxed.h"

namespace cxlab::planner {

/// One step of a sequence: an action, or event k as action -2 - k.
struct SequenceStep {
  int action = -1;
  Micros duration = 0;
};
using Sequence = std::vector<SequenceStep>;

inline bool is_event(const SequenceStep& step) { return step.action <= -2; }

enum class SearchEnd : std::uint8_t {
  kFound,
  kExhausted,  ///< no state is left
  kBudget,
  kMemory,
};

struct LazyOptions {
  std::uint64_t seed = 0;        ///< 0: actions in their order; else shuffled
  double random_choice = 0;      ///< probability of taking any state of the queue instead of the first
  bool landmarks = true;
  std::size_t most_words = std::size_t{1} << 27;  ///< memory of states, in words of 8 bytes
};

class LazySearch {
 public:
  LazySearch(const Simulator& simulator, const Touches& touches, const RelaxedTask& relaxed, const Landmarks& landmarks)
      : simulator_(simulator), touches_(touches), relaxed_(relaxed), landmarks_(landmarks) {}

  /// Looks for a sequence from `start` (of which `reached` landmarks are marked by itself) to the goal.
  SearchEnd run(const PackedState& start, const LazyOptions& options, Budget& budget, Sequence& found);

 private:
  const Simulator& simulator_;
  const Touches& touches_;
  const RelaxedTask& relaxed_;
  const Landmarks& landmarks_;
};

}  // namespace cxlab::planner
