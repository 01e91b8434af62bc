#pragma once
// Small random temporal problems: facts without arguments, one counter, actions with whole durations, events.

#include <string>
#include <vector>

#include "cx/base/random.h"

namespace cxlab::planner {

struct Literal {
  int fact = 0;
  bool value = true;
};

struct RandomAction {
  int duration = 1;                           ///< s
  std::vector<Literal> start, over_all, end;  ///< conditions
  std::vector<Literal> start_effects, end_effects;
  int least_count = -1;  ///< the counter at the start; -1: not read
  int change = 0;        ///< of the counter at the end
};

struct RandomEvent {
  int time = 1;  ///< s
  Literal effect;
};

struct RandomProblem {
  int facts = 4;
  std::vector<char> initial;
  int count = 0;
  std::vector<RandomAction> actions;
  std::vector<RandomEvent> events;
  std::vector<Literal> goal;
  /// The metric to be minimized: time_weight * total-time + count_weight * counter; none if both are 0.
  int time_weight = 0, count_weight = 0;

  static RandomProblem draw(RandomStream& random);
  /// With a counter that most actions change, and a metric.
  static RandomProblem draw_with_metric(RandomStream& random);
  /// Jobs that take turns: places that are kept from the start of an action to its end, or filled at its end and freed
  /// by another action.
  static RandomProblem draw_shop(RandomStream& random);
  std::string domain() const;
  std::string problem() const;
};

}  // namespace cxlab::planner
