#include "planner/strategies/cut_search.h"

#include <algorithm>

#include "planner/search/lasting.h"

namespace cxlab::planner {

namespace {

constexpr std::int64_t kCutWork = 16;  ///< of a cut task, by action, in pieces of Work::kGround

}  // namespace

/// By action: whether it is cut.
std::vector<char> CutSearch::marked() const {
  const GroundTask& task = context_.ground;
  const Simulator& simulator = context_.whole.space.simulator;
  const PackedState initial = simulator.initial();
  std::vector<char> marked;
  for (const GroundAction& action : task.actions) {
    const auto range = simulator.durations(static_cast<int>(marked.size()), initial.data());
    const bool lasts = !range || range->most >= kSeparation;
    marked.push_back(lasts && can_be_cut(task, action) && (cut_ == Cut::kEverything || is_envelope(task, action)));
  }
  return marked;
}

const SplitSpace* CutSearch::space() {
  if (made_) return space_.get();
  made_ = exhausted_ = true;
  const std::vector<char> cut = marked();
  Budget& budget = context_.budget;
  if (budget.late() || std::ranges::find(cut, 1) == cut.end()) return nullptr;
  space_ = std::make_unique<SplitSpace>(split(with_lasting_facts(context_.ground), cut), budget);
  check_ = std::make_unique<SplitCheck>(space_->split, context_.ground, space_->space.simulator, context_.touches);
  budget.spend(Work::kGround, kCutWork * static_cast<std::int64_t>(context_.ground.actions.size()));
  exhausted_ = false;
  return space_.get();
}

bool CutSearch::run(const Turn& turn) {
  space();
  if (exhausted_) return false;
  KeptSearch once;
  Sequence found;
  SearchEnd end = SearchEnd::kBudget;
  {
    const BudgetSlice slice(context_.budget, turn.units);
    end = (continues_first(turn) && !context_.best.exists() ? first_ : once)
              .go_on(space_->space, check_.get(), context_.search_options(turn.round), context_.budget, found);
  }
  exhausted_ = context_.is_exhausted(end);
  if (end != SearchEnd::kFound) return false;
  context_.offer(*space_, found);
  return context_.best.exists();
}

}  // namespace cxlab::planner
