#pragma once
// The simple temporal network of a plan whose actions may overlap: happenings in an order in which they are right, and
// the distances that keep them so. Earliest times by relaxation (Bellman and Ford; Dechter, Meiri and Pearl 1991).

#include <utility>
#include <vector>

#include "planner/schedule/timeline.h"

namespace cxlab::planner {

/// `to` happens at least `least` and at most `most` after `from`. Point 2 k is the start of step k, 2 k + 1 its end;
/// kOrigin is the start of the plan.
struct Ordering {
  static constexpr int kOrigin = -1;
  int from = kOrigin, to = 0;
  Micros least = 0;
  Micros most = DurationRange::kForever;
};

class Stn {
 public:
  explicit Stn(const Touches& touches)
      : touches_(touches), keys_(static_cast<std::size_t>(touches.keys())), is_used_(keys_.size(), 0) {}

  void clear();
  /// The next happening is the start of an action; the index of its step.
  int begin(int action, DurationRange range);
  /// The next happening is the end of a step.
  void finish(int step);
  /// The next happening is the next event.
  void event();

  /// Happenings so far.
  int points() const { return static_cast<int>(point_step_.size()); }
  /// Distances that were looked at since the last call, in pieces of Work::kTimes.
  std::int64_t take_work() { return std::exchange(work_, 0); }
  /// Forgets all happenings but the first ones.
  void truncate(int points);

  /// Earliest times. Actions that have not ended must still be able to end after all that happened so far.
  /// `hold_separation`: between a condition over all and what changes it at its ends; 0 is what PDDL asks.
  /// False if there are none.
  bool solve(Micros hold_separation);
  /// The same for a complete plan: its last step ends after all events that happened, and no other event breaks the
  /// goal before that.
  bool solve_complete(Micros hold_separation);

  /// Least distances between happenings that the network keeps; those that follow from others are mostly left out.
  std::size_t distances() const { return edges_.size(); }
  int steps() const { return static_cast<int>(steps_.size()); }
  Micros start(int step) const { return times_[steps_[step].start]; }
  Micros end(int step) const { return times_[steps_[step].end]; }
  Micros makespan() const;
  /// The latest of all happenings, without ends to come.
  Micros last_happening() const { return last_happening_; }
  /// Constraints between points, without those that follow from others. After `solve`, when all steps have ended.
  std::vector<Ordering> orderings() const;

 private:
  struct Step {
    int action;
    DurationRange range;
    int start = -1, end = -1;  ///< points
    Micros release = 0;        ///< not before
  };
  struct Edge {
    int from, to;
    bool hold;  ///< over a condition over all only
  };
  struct Use {
    int point;
    std::uint8_t does;
  };

  int add_point(int step, int event);
  void connect(int point, std::span<const Touch> touches, bool at_end);
  bool relax(Micros hold_separation);
  bool has_cycle();
  bool keeps_clear_of_events() const;
  template <class Visit>
  void for_each_limit(int step, bool at_end, const Visit& visit) const;
  /// The least distance of two happenings that conflict.
  Micros separation(std::uint8_t a, std::uint8_t b) const {
    return Touches::conflict_at_instant(a, b) ? kSeparation : hold_separation_;
  }

  const Touches& touches_;
  ById<Step> steps_;
  ById<int> point_step_, point_event_;  ///< by point; -1: none
  ById<Edge> edges_;
  ById<std::vector<Use>> keys_;
  std::vector<int> used_keys_;
  ById<char> is_used_;  ///< by key: in used_keys_
  ById<Micros> times_;
  ById<int> causes_, marks_;  ///< by point: what it waits for; scratch
  int next_event_ = 0;
  Micros last_happening_ = 0;
  Micros hold_separation_ = 0;
  std::int64_t work_ = 0;
};

}  // namespace cxlab::planner
