#include "planner/strategies/context.h"

#include <algorithm>

namespace cxlab::planner {

namespace {

constexpr std::int64_t kCopyWork = 8;   ///< of a task with other actions, by action, in pieces of Work::kGround
constexpr double kRandomChoice = 0.05;  ///< in every round but the first
constexpr double kCostNoise = 3;        ///< in every other round: what one prefers in vain is dear in another

}  // namespace

PlanningContext::PlanningContext(const Task& task, const PlanOptions& how, Budget& units, GroundTask made,
                                 Incumbent::Clock::time_point began)
    : options(how),
      budget(units),
      ground(std::move(made)),
      whole(split(ground, std::vector<char>(ground.actions.size(), 0)), units),
      has_durations(std::ranges::any_of(ground.actions, &GroundAction::durative)),
      best(task, ground, touches, objective, units, how.on_plan, began) {
  budget.spend(Work::kGround, kCopyWork * static_cast<std::int64_t>(ground.actions.size()));
}

bool PlanningContext::offer(const SplitSpace& space, const Sequence& list) {
  if (!best.offer(to_plan(space.split, ground, space.space.simulator, list))) return false;
  if (&space == &whole) {
    best_list_ = list;
    best_parts_ = {};
  } else {
    best_parts_ = {&space, list};
  }
  return true;
}

void PlanningContext::offer_found(const Sequence& list) {
  if (best_list_.empty()) best_list_ = list;
  best.offer(to_plan(whole.split, ground, whole.space.simulator, list));
}

LazyOptions PlanningContext::search_options(std::uint64_t seed) const {
  LazyOptions how;
  how.seed = seed;
  how.random_choice = seed == 0 ? 0 : kRandomChoice;
  if (seed % 2 == 1) how.cost_noise = kCostNoise;
  const std::size_t searches = has_durations ? 4 : 2;  // that exist at the same time
  how.most_words = options.most_memory_mb * 1024 * 1024 / sizeof(Word) / searches;
  return how;
}

}  // namespace cxlab::planner
