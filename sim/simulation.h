#pragma once
// What moves by itself from tick to tick: a physics world, a ledger, a canvas of turtles.

#include "cx/base/expected.h"
#include "cx/base/time.h"

namespace cxlab::sim {

class Simulation {
 public:
  virtual ~Simulation() = default;
  /// Moves on by one tick, or in a world that does not step by any time up to `next_event`. Fails when it diverges.
  virtual Status advance(SimTime duration) = 0;
  /// The next time at which something happens by itself (a belt arrives); kNever if nothing moves; a world that steps
  /// always says its own time.
  virtual SimTime next_event() const = 0;
};

}  // namespace cxlab::sim
