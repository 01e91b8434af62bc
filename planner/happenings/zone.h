#pragma once
// A zone holds what is known about the distances of some points in time, as in timed automata (Dill 1989; Bengtsson and
// Yi 2004). It is always closed: every distance is as narrow as all of them together make it.

#include <span>
#include <vector>

#include "planner/ground/task.h"

namespace cxlab::planner {

class Zone {
 public:
  static constexpr Micros kAny = DurationRange::kForever;

  int points() const { return points_; }
  /// A new point, any distance from the others; its index.
  int add_point();
  /// `to` is at least `least` after `from`. False if nothing is left; the zone is then not to be used.
  bool require(int from, int to, Micros least);
  /// The most that `to` can be after `from`; kAny: no bound. The least is -most(to, from).
  Micros most(int from, int to) const { return most_[at(from, to)]; }
  /// The least that `to` can be after `from`; -kAny: no bound.
  Micros least(int from, int to) const { return -most_[at(to, from)]; }
  bool is_fixed(int from, int to) const { return most(from, to) < kAny && most(from, to) == least(from, to); }
  /// Forgets all other points; point k is then the one that was `points[k]`.
  void keep(std::span<const int> points);
  /// Whether all times that `other` allows are allowed here. Both have the same points.
  bool contains(const Zone& other) const;

 private:
  std::size_t at(int from, int to) const {
    return static_cast<std::size_t>(from) * static_cast<std::size_t>(points_) + static_cast<std::size_t>(to);
  }

  int points_ = 0;
  std::vector<Micros> most_;  ///< by pair of points
};

}  // namespace cxlab::planner
