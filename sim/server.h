#pragma once
// A server: something on the bus that lives in the world (skills of a robot, the factory, a turtle). The episode calls
// it.

#include "cx/base/expected.h"
#include "cx/base/time.h"

namespace cxlab::sim {

class Server {
 public:
  virtual ~Server() = default;
  /// After the world has moved: looks at it and posts topics, feedback, results.
  virtual Status sense(SimTime now) = 0;
  /// At the end of the tick: takes what waits for it on the bus and acts on the world.
  virtual Status act(SimTime now) = 0;
  /// The next time at which it has something to do by itself (a period, a phase that ends); kNever if it only answers.
  /// Due at the first tick not before it. A server of a stepped world that must look each tick says its last `now`.
  virtual SimTime next_due() const = 0;
};

}  // namespace cxlab::sim
