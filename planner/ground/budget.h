#pragma once
// How much the planner may still do. Work is counted by kind, each with a fixed weight, so that the same budget always
// gives the same answer; a wall clock only cuts a run short when a timeout was asked for.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <limits>
#include <optional>

#include "planner/pddl/failure.h"

namespace cxlab::planner {

enum class Work : std::uint8_t {
  kGround,    ///< what is looked at while a problem is written out: atoms, parts of conditions, actions in each pass
  kReach,     ///< operators looked at by heuristics and landmarks
  kNode,      ///< states made
  kSchedule,  ///< actions scheduled or executed by the improvement
  kBound,     ///< operators looked at for lower bounds
  kTimes,     ///< distances in temporal networks, pairs of points in zones, cells of linear programs
};
inline constexpr std::size_t kWorkKinds = 6;
/// Units of one piece of work, in thousandths. A unit is about a microsecond of a core of 2020.
inline constexpr std::array<std::int64_t, kWorkKinds> kWorkWeights = {100, 20, 2000, 150, 20, 4};

/// Looks at whether a comparison or an axiom is known already, in one piece of Work::kGround.
inline constexpr std::size_t kLooksOfWork = 32;

/// Units of so many pieces of work.
constexpr std::int64_t units_of(Work kind, std::int64_t pieces) {
  return pieces * kWorkWeights[static_cast<std::size_t>(kind)] / 1000;
}

class Budget {
 public:
  static constexpr std::int64_t kUnlimited = std::numeric_limits<std::int64_t>::max();

  Budget() = default;
  /// `units` to spend, and seconds of wall time from now; after `improved` no more than `patience` units.
  Budget(std::int64_t units, std::optional<double> timeout_s, std::optional<std::int64_t> patience = {})
      : units_(units), patience_(patience), limit_(units) {
    if (timeout_s)
      deadline_ =
          std::chrono::steady_clock::now() + std::chrono::microseconds(static_cast<std::int64_t>(*timeout_s * 1e6));
  }

  void spend(Work kind, std::int64_t pieces) { counts_[static_cast<std::size_t>(kind)] += pieces; }

  /// A better plan was found.
  void improved() {
    if (patience_) limit_ = *patience_ < units_ - units() ? units() + *patience_ : units_;
  }

  std::int64_t units() const {
    std::int64_t thousandths = 0;
    for (std::size_t k = 0; k < kWorkKinds; ++k) thousandths += counts_[k] * kWorkWeights[k];
    return thousandths / 1000;
  }

  bool slice_over() { return units() >= slice_ || over(); }
  bool over() {
    if (over_) return true;
    const std::int64_t now = units();
    if (now >= limit_)
      over_ = true;
    else if (deadline_ && now >= next_look_) {
      next_look_ = now + 200;
      late();
    }
    return over_;
  }
  /// Whether the time has run out, by a look at the clock: for long steps between which little is spent.
  bool late() {
    if (!late_ && deadline_) late_ = std::chrono::steady_clock::now() >= *deadline_;
    over_ |= late_;
    return late_;
  }

 private:
  friend class BudgetSlice;

  std::array<std::int64_t, kWorkKinds> counts_{};
  std::int64_t units_ = kUnlimited;
  std::optional<std::int64_t> patience_;
  std::int64_t limit_ = kUnlimited, slice_ = kUnlimited, next_look_ = 0;
  std::optional<std::chrono::steady_clock::time_point> deadline_;
  bool over_ = false, late_ = false;
};

/// While it lives, a slice of the budget ends after `units` more, or with the slice that it is a part of.
class BudgetSlice {
 public:
  BudgetSlice(Budget& budget, std::int64_t units) : budget_(budget), outer_(budget.slice_) {
    budget.slice_ = std::min(outer_, budget.units() + units);
  }
  ~BudgetSlice() { budget_.slice_ = outer_; }
  BudgetSlice(const BudgetSlice&) = delete;
  BudgetSlice& operator=(const BudgetSlice&) = delete;
  /// Ends the slice now.
  void end() { budget_.slice_ = budget_.units(); }

 private:
  Budget& budget_;
  const std::int64_t outer_;
};

}  // namespace cxlab::planner
