#pragma once
// Shorter plans from a plan: local search over the order and the choice of its actions.
//
// A plan is a list of actions. Decoding runs through the list again and again, always taking the first action that can
// be applied, until the goal is reached, and schedules as it goes; what remains is dropped. So any order is a plan as
// long as the goal is reached, and moving one action drags along those that wait for it. Where actions are cut, the list
// has their beginnings and ends, so that others can start or end in between.

#include <functional>
#include <vector>

#include "cx/base/random.h"
#include "planner/search/split.h"

namespace cxlab::planner {

class LocalSearch {
 public:
  using OnBetter = std::function<void(const Sequence&, Micros makespan)>;

  /// `simulator` is of the split task, `touches` of the original; the split may cut nothing.
  LocalSearch(const SplitTask& split, const GroundTask& original, const Simulator& simulator, const Touches& touches, std::uint64_t seed);

  /// Takes a plan to go on from, as a sequence of parts; false if it is none. It may come too late for events: the
  /// search then brings that down first.
  bool start(const Sequence& plan);
  /// Tries moves until the slice of the budget is over, or `most_idle` moves in a row gave no new best plan. Plans that
  /// keep clear of events are told.
  void run(Budget& budget, std::int64_t most_idle, const OnBetter& on_better);

  bool in_time() const { return best_.lateness == 0; }

 private:
  static constexpr Micros kLatenessWeight = 10;
  struct Plan {
    Sequence order;               ///< as executed
    std::vector<Micros> times;    ///< by step: of a beginning, of an end, of the start of a whole action
    std::vector<int> causes;      ///< by step: the step that it waits for
    Micros makespan = 0, lateness = 0;
    double cost = 0;
    Micros aim() const { return makespan + kLatenessWeight * lateness; }
  };

  /// An action that has begun and not ended.
  struct Running {
    int action;      ///< of the original
    int begin;       ///< step
    Micros start, duration;
  };

  bool decode(const Sequence& list, double most_cost, Plan& plan);
  bool schedule(Plan& plan, double most_cost);
  bool place(Plan& plan, std::size_t step);
  bool keeps_running(const Word* state) const;
  void set_current(Plan plan);
  void make_move(Sequence& list);
  void pull(Sequence& list, int step, int to) const;
  void exchange(Sequence& list);
  int critical_step();
  std::vector<int> alternatives(int original) const;

  const SplitTask& split_;
  const GroundTask& original_;
  const Simulator& simulator_;
  Simulator whole_;                 ///< of the original
  const Touches& touches_;
  RandomStream random_;
  Timeline timeline_;
  Plan current_, best_;
  std::vector<Word> states_;        ///< before each step of the current plan
  std::vector<int> critical_;       ///< steps that determine the makespan, the last one first
  std::vector<std::vector<int>> achievers_;  ///< by fact, then number: original actions that add it or change it
  std::vector<Running> running_;
  std::vector<std::pair<Micros, int>> releases_;  ///< by step: a beginning that must wait for its end, and the cause
  bool shifted_ = false;            ///< a release has grown since the schedule began
  std::vector<double> history_;     ///< costs accepted some moves ago (late acceptance, Burke and Bykov 2017)
  std::int64_t moves_ = 0;
  PackedState scratch_, trial_;
  std::int64_t work_ = 0;
};

}  // namespace cxlab::planner
