#include "cx/run/loop.h"

#include <algorithm>

#include "cx/base/number_text.h"
#include "cx/bus/bus.h"

namespace cxlab {

namespace {

/// Calls a function of every part, up to the first that fails.
template <class Part, class... Args>
Status each(const std::vector<Part*>& parts, Status (Part::*call)(Args...), Args... args) {
  for (Part* part : parts)
    if (Status s = (part->*call)(args...); !s) return s;
  return {};
}

}  // namespace

Status Loop::tick_at(SimTime next) {
  const CLocale numbers;  // CLIPS and worlds print them
  const SimTime passed = next - (ticks_ == 0 ? begin_ : now_);
  if (passed > SimTime::zero())
    if (Status s = each(parts_.worlds, &Simulation::advance, passed); !s) return s;
  bus_.begin_tick(next);
  now_ = next;
  ++ticks_;
  if (Status s = each(parts_.servers, &Server::sense, now_); !s) return s;
  if (parts_.referee)
    if (Status s = parts_.referee->judge(now_); !s) return s;
  if (Status s = each(parts_.agents, &Agent::perceive); !s) return s;
  if (Status s = each(parts_.agents, &Agent::decide, now_); !s) return s;
  if (Status s = each(parts_.agents, &Agent::act); !s) return s;
  return each(parts_.servers, &Server::act, now_);
}

SimTime Loop::next_tick() const {
  if (ticks_ == 0) return begin_;
  const SimTime following = tick_not_before(now_ + SimTime{1}, tick_);
  if (bus_.any_waiting()) return following;
  SimTime due = end_;
  for (const Simulation* world : parts_.worlds) due = std::min(due, world->next_event());
  for (const Server* server : parts_.servers) due = std::min(due, server->next_due());
  if (parts_.referee) due = std::min(due, parts_.referee->next_due());
  for (const Agent* agent : parts_.agents) due = std::min(due, agent->next_due());
  return due > kNever - tick_ ? kNever : std::max(following, tick_not_before(due, tick_));
}

}  // namespace cxlab
