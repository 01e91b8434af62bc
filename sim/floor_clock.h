#pragma once
// The clock of a floor: simulated time without the time for which the floor was halted. Drives, machines at work and
// the game go by it, so that a halt moves all of them. Messages and records have simulated time.

#include <algorithm>
#include <vector>

#include "cx/base/time.h"

namespace cxlab::sim {

class FloorClock {
 public:
  bool halted() const { return !halts_.empty() && halts_.back().end == kNever; }
  /// It stands from `now` on, until it goes on. Times of calls never decrease.
  void halt(SimTime now) { halts_.push_back({now, kNever}); }
  void go_on(SimTime now) { halts_.back().end = now; }

  /// What it shows at that simulated time, which may be in the past.
  SimTime at(SimTime simulated) const {
    SimTime stood{};
    for (const Halt& halt : halts_)
      if (halt.begin < simulated) stood += std::min(halt.end, simulated) - halt.begin;
    return simulated - stood;
  }
  /// The simulated time at which it shows `time` and goes on; kNever while it stands there or before.
  SimTime when(SimTime time) const {
    SimTime stood{};
    for (const Halt& halt : halts_) {
      if (time < halt.begin - stood) break;
      if (halt.end == kNever) return kNever;
      stood += halt.end - halt.begin;
    }
    return time > kNever - stood ? kNever : time + stood;
  }

 private:
  struct Halt {
    SimTime begin{}, end = kNever;
  };
  std::vector<Halt> halts_;  ///< in order
};

}  // namespace cxlab::sim
