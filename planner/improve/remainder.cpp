#include "planner/improve/remainder.h"

#include <algorithm>
#include <map>
#include <utility>

namespace cxlab::planner {

Remainder::Done Remainder::of(const Plan& plan) {
  const std::vector<OneOf> steps = ways_of(plan);
  const PackedState now = simulator_.initial();
  Done best = do_in_order({}, now);
  for (std::size_t count = 0; count <= steps.size() && !is_goal(best); ++count) {
    Done done = do_in_order(std::span(steps).last(count), now);
    if (is_goal(done) || done.score() > best.score()) best = std::move(done);
  }
  return best;
}

std::vector<Remainder::OneOf> Remainder::ways_of(const Plan& plan) {
  const std::vector<GroundAction>& actions = simulator_.task().actions;
  std::map<std::pair<ActionId, std::vector<ObjectId>>, OneOf> by_step;
  for (std::size_t a = 0; a < actions.size(); ++a)
    by_step[{actions[a].schema, actions[a].arguments}].push_back(static_cast<int>(a));
  budget_.spend(Work::kReach, static_cast<std::int64_t>(actions.size()));
  std::vector<OneOf> steps;
  for (const PlanStep& step : plan) {
    const auto known = by_step.find({step.action, step.arguments});
    steps.push_back(known == by_step.end() ? OneOf{} : known->second);
  }
  return steps;
}

Sequence Remainder::without_needless(Sequence steps) {
  PackedState state = simulator_.initial();
  for (std::size_t i = 0; i < steps.size();) {
    std::vector<OneOf> later;
    for (std::size_t k = i + 1; k < steps.size(); ++k) later.push_back({steps[k].action});
    const Done less = do_in_order(later, state);
    if (is_goal(less)) {
      steps.resize(i);
      steps.insert(steps.end(), less.steps.begin(), less.steps.end());
    } else {
      Micros duration = 0;
      simulator_.apply(steps[i++].action, state.data(), duration);
    }
  }
  return steps;
}

Remainder::Done Remainder::do_in_order(std::span<const OneOf> steps, PackedState from) {
  Done done{{}, std::move(from)};
  for (const OneOf& ways : steps) {
    const auto way = std::find_if(ways.begin(), ways.end(), [&](int action) {
      PackedState next = done.state;
      Micros duration = 0;
      if (!simulator_.apply(action, next.data(), duration)) return false;
      done.steps.push_back({action, duration});
      done.state = std::move(next);
      return true;
    });
    if (way == ways.end()) ++done.left_out;
  }
  budget_.spend(Work::kSchedule, static_cast<std::int64_t>(steps.size()));
  return done;
}

}  // namespace cxlab::planner
