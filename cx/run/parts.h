#pragma once
// The parts that the loop of an episode calls: worlds, servers, a referee, agents. Simulators, scenarios, the executive
// and tests implement these; cx/run/loop.h calls them.

#include "cx/base/expected.h"
#include "cx/base/time.h"

namespace cxlab {

/// What moves by itself from tick to tick: a physics world, a ledger, a canvas of turtles.
class Simulation {
 public:
  virtual ~Simulation() = default;
  /// Moves on by one tick, or in a world that does not step by any time up to `next_event`. Fails when it diverges.
  virtual Status advance(SimTime duration) = 0;
  /// The next time at which something happens by itself (a belt arrives); kNever if nothing moves; a world that steps
  /// always returns its own time.
  virtual SimTime next_event() const = 0;
};

/// Something on the bus that lives in the world: the skills of a robot, the factory, a turtle.
class Server {
 public:
  virtual ~Server() = default;
  /// After the world has moved: looks at it and posts topics, feedback, results.
  virtual Status sense(SimTime now) = 0;
  /// At the end of the tick: takes what waits for it on the bus and acts on the world.
  virtual Status act(SimTime now) = 0;
  /// The next time at which it has something to do by itself (a period, a phase that ends); kNever if it only answers.
  /// Due at the first tick not before it. A server of a stepped world that must look each tick returns its last `now`.
  virtual SimTime next_due() const = 0;
};

/// Looks at the world after the servers and gives points.
class Referee {
 public:
  virtual ~Referee() = default;
  virtual Status judge(SimTime now) = 0;
  virtual SimTime next_due() const = 0;
  /// Whether the game has ended before the scenario's duration.
  virtual bool over() const = 0;
};

/// Decides: an environment manager with its environments.
class Agent {
 public:
  virtual ~Agent() = default;
  /// Takes what waits for its environments.
  virtual Status perceive() = 0;
  /// Lets those decide that are due.
  virtual Status decide(SimTime now) = 0;
  /// Takes what waits for its node: transitions, parameters. Fails if that must end the run.
  virtual Status act() = 0;
  /// The earliest time at which it has something to decide.
  virtual SimTime next_due() const = 0;
};

}  // namespace cxlab
