#pragma once
// The loop: which tick comes next, and what happens in it. Episodes, stories and tests play their ticks with it.
//
//   Loop loop(bus, tick, {.worlds = {&world}, .servers = {&skills}, .referee = &referee, .agents = {&manager}});
//   loop.set_end(duration);
//   while (loop.now() < duration) if (Status s = loop.tick(); !s) ...

#include <cstdint>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/time.h"
#include "cx/run/parts.h"

namespace cxlab {

namespace bus {
class Bus;
}

/// What takes part in a tick, each called in the order of its list. All outlive the loop.
struct Parts {
  std::vector<Simulation*> worlds = {};
  std::vector<Server*> servers = {};
  Referee* referee = nullptr;  ///< may be none
  std::vector<Agent*> agents = {};
};

class Loop {
 public:
  Loop(bus::Bus& bus, SimTime tick, Parts parts) : bus_(bus), tick_(tick), parts_(std::move(parts)) {}

  /// A tick is played at this time even if nothing is due then (kNever: none).
  void set_end(SimTime end) { end_ = end; }

  /// The first tick is at this time, and no time passes before it.
  void set_begin(SimTime begin) { begin_ = begin; }

  /// One more agent, after the others. It outlives the loop.
  void add(Agent& agent) { parts_.agents.push_back(&agent); }

  /// The first tick is at 0, or where the loop begins. After that the first at which something is due, wherever
  /// messages wait the following one.
  SimTime next_tick() const;
  /// Plays the next tick.
  Status tick() { return tick_at(next_tick()); }
  /// Plays a tick at a time of the caller's choice, after the last one.
  Status tick_at(SimTime next);

  SimTime now() const { return now_; }           ///< time of the last tick; before the first: less than 0
  std::int64_t ticks() const { return ticks_; }  ///< how many have been played

 private:
  bus::Bus& bus_;
  SimTime tick_;
  Parts parts_;
  SimTime begin_{}, end_ = kNever;
  SimTime now_{-1};
  std::int64_t ticks_ = 0;
};

}  // namespace cxlab
