#pragma once
// Makes shorter plans from a plan, by local search over the order and the choice of its actions. It accepts a plan that
// is no worse than the one some moves ago (late acceptance, Burke and Bykov 2017).

#include <functional>
#include <vector>

#include "cx/base/random.h"
#include "planner/improve/decoder.h"

namespace cxlab::planner {

class LocalSearch {
 public:
  using OnBetter = std::function<void(const DecodedPlan&)>;

  /// `whole` is of the task that the decoder's cuts.
  LocalSearch(Decoder& decoder, const Simulator& whole, std::uint64_t seed);

  /// Takes a plan to begin with, as a sequence of parts; false if it is none. It may come too late for events: the
  /// search then brings that down first.
  bool start(const Sequence& plan);
  /// Many moves will exchange steps that come too late for events, until none does.
  void exchange_late_steps() { exchanges_late_ = true; }
  /// Tries moves until the slice of the budget is over, or `most_idle` moves in a row gave no new best plan. Plans that
  /// keep clear of events are reported.
  void run(Budget& budget, std::int64_t most_idle, const OnBetter& on_better);

  const DecodedPlan& best() const { return best_; }

 private:
  void set_current(DecodedPlan plan);
  void make_move(Sequence& list);
  void pull(Sequence& list, int step, int to) const;
  void exchange(Sequence& list);
  void exchange_late(Sequence& list);
  void insert(Sequence& list, std::size_t begin, std::size_t end, int original) const;
  int critical_step();
  std::vector<int> alternatives(int original) const;

  Decoder& decoder_;
  const SplitTask& split_;
  const GroundTask& original_;
  const Simulator& simulator_;
  const Simulator& whole_;  ///< of the original
  RandomStream random_;
  DecodedPlan current_, best_;
  std::vector<int> critical_;         ///< steps that determine the makespan, the last one first
  ById<std::vector<int>> achievers_;  ///< by fact, then number: original actions that add it or change it
  std::vector<int> earners_;          ///< original actions that make the objective better by themselves
  std::vector<double> history_;       ///< costs accepted some moves ago
  std::int64_t moves_ = 0;
  bool exchanges_late_ = false;
};

}  // namespace cxlab::planner
