#pragma once
// Greedy best-first search over whole actions, one after the other, as in LAMA (Richter and Westphal 2010). It
// evaluates states lazily, takes from the queues of the relaxed plan and of the landmarks in turn, and prefers actions
// of the relaxed plan.
//
// Sequences miss what needs actions to overlap; see split.h and clock.h. What they contain need not happen in their
// order: the timeline decides.

#include <memory>
#include <vector>

#include "planner/ground/budget.h"
#include "planner/schedule/timeline.h"
#include "planner/search/landmarks.h"
#include "planner/search/relaxed.h"

namespace cxlab::planner {

/// One step of a sequence: an action, or event k as action -2 - k.
struct SequenceStep {
  int action = -1;
  Micros duration = 0;
  bool operator==(const SequenceStep&) const = default;
};
using Sequence = ById<SequenceStep>;

inline bool is_event(const SequenceStep& step) { return step.action <= -2; }
inline int event_of(const SequenceStep& step) { return -2 - step.action; }

enum class SearchEnd : std::uint8_t {
  kFound,
  kExhausted,  ///< no state is left
  kBudget,
  kMemory,
};

struct LazyOptions {
  std::uint64_t seed = 0;                         ///< 0: actions in their order; else shuffled
  double random_choice = 0;                       ///< probability of taking any state of the queue instead of the first
  double cost_noise = 0;                          ///< actions cost up to this much more, as a share, each by chance
  std::size_t most_words = std::size_t{1} << 27;  ///< memory of states, in words of 8 bytes
};

/// Whether a sequence from the initial state can be given times.
class PathCheck {
 public:
  virtual ~PathCheck() = default;
  /// `path` has been accepted but for its last step; `state` is the state that it leads to.
  virtual bool accepts(const Sequence& path, const Word* state) = 0;
  /// The signature of the path accepted last. Equal states with different signatures are different, because their times
  /// matter.
  virtual Word signature() const = 0;
  /// `path` has been accepted and leads to the goal.
  virtual bool accepts_goal(const Sequence& path) = 0;
  /// What the answers since the last call have cost, in pieces of Work::kTimes.
  virtual std::int64_t take_work() { return 0; }
};

/// Accepts sequences of whole actions that keep clear of events.
class EventCheck : public PathCheck {
 public:
  explicit EventCheck(const Touches& touches) : timeline_(touches) {}
  bool accepts(const Sequence& path, const Word* state) override;
  /// Whether the path acts at all: a plan that only waits has no end.
  Word signature() const override { return acts_; }
  bool accepts_goal(const Sequence& path) override;

 private:
  Timeline timeline_;
  bool acts_ = false;
};

class LazySearch {
 public:
  /// Looks for a sequence from `start` to the goal. `check`: none, or asked for every step.
  LazySearch(const Simulator& simulator, const RelaxedTask& relaxed, const Landmarks& landmarks,
             const PackedState& start, const LazyOptions& options, PathCheck* check = nullptr);
  ~LazySearch();
  LazySearch(const LazySearch&) = delete;
  LazySearch& operator=(const LazySearch&) = delete;

  /// Searches until a slice of the budget ends; the next call continues there.
  SearchEnd run(Budget& budget, Sequence& found);

 private:
  struct Progress;
  const Simulator& simulator_;
  const Landmarks& landmarks_;
  PathCheck* check_;
  std::unique_ptr<Progress> progress_;
};

}  // namespace cxlab::planner
