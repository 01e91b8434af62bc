#include "planner/search/search_space.h"

namespace cxlab::planner {

namespace {

constexpr std::int64_t kSpaceWork = 4;               ///< of making a space, by action, in pieces of Work::kGround
constexpr std::int64_t kLandmarkWork = 300'000'000;  ///< word operations
constexpr std::int64_t kWordsOfWork = 16;            ///< word operations in one piece of Work::kReach

}  // namespace

SearchSpace::SearchSpace(const GroundTask& task, Budget& budget)
    : simulator(task), relaxed(simulator, true), landmarks(simulator, relaxed, kLandmarkWork, budget) {
  budget.spend(Work::kGround, kSpaceWork * static_cast<std::int64_t>(task.actions.size()));
  budget.spend(Work::kReach, relaxed.work() + landmarks.work() / kWordsOfWork);
}

}  // namespace cxlab::planner
