#include "planner/strategies/sequence_search.h"

#include <algorithm>
#include <utility>

#include "planner/search/lasting.h"

namespace cxlab::planner {

namespace {

constexpr std::int64_t kCutWork = 16;  ///< of a cut task, by action, in pieces of Work::kGround

}  // namespace

/// By action: whether it is cut.
std::vector<char> SequenceSearch::marked() const {
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

const SplitSpace* SequenceSearch::space() {
  const bool made = std::exchange(made_, true);
  if (cut_ == Cut::kNothing) {
    if (!made && context_.has_events()) check_ = std::make_unique<EventCheck>(context_.touches);
    return &context_.whole;
  }
  if (made) return cut_space_.get();
  exhausted_ = true;
  const std::vector<char> cut = marked();
  Budget& budget = context_.budget;
  if (budget.late() || std::ranges::find(cut, 1) == cut.end()) return nullptr;
  cut_space_ = std::make_unique<SplitSpace>(split(with_lasting_facts(context_.ground), cut), budget);
  check_ =
      std::make_unique<SplitCheck>(cut_space_->split, context_.ground, cut_space_->space.simulator, context_.touches);
  budget.spend(Work::kGround, kCutWork * static_cast<std::int64_t>(context_.ground.actions.size()));
  exhausted_ = false;
  return cut_space_.get();
}

bool SequenceSearch::run(const Turn& turn) {
  const SplitSpace* in = space();
  if (exhausted_) return false;
  const auto& [simulator, relaxed, landmarks] = in->space;
  const LazyOptions how = context_.search_options(turn.round);
  const bool continues = continues_first(turn) && !context_.best.exists();
  std::unique_ptr<LazySearch> once;
  std::unique_ptr<LazySearch>& search = continues ? first_ : once;
  if (!search)
    search = std::make_unique<LazySearch>(simulator, relaxed, landmarks, simulator.initial(), how, check_.get());
  Sequence found;
  SearchEnd end = SearchEnd::kBudget;
  {
    const BudgetSlice slice(context_.budget, turn.units);
    end = search->run(context_.budget, found);
  }
  if (end != SearchEnd::kBudget) search.reset();
  exhausted_ = end == SearchEnd::kExhausted;
  if (end != SearchEnd::kFound) return false;
  if (cut_ == Cut::kNothing)
    context_.offer_found(found);
  else
    context_.offer(*in, found);
  return context_.best.exists();
}

std::optional<Sequence> SequenceSearch::find(const Turn& turn) {
  const BudgetSlice slice(context_.budget, turn.units);
  const auto& [simulator, relaxed, landmarks] = context_.whole.space;
  LazySearch search(simulator, relaxed, landmarks, simulator.initial(), context_.search_options(turn.round));
  Sequence found;
  return search.run(context_.budget, found) == SearchEnd::kFound ? std::optional(std::move(found)) : std::nullopt;
}

}  // namespace cxlab::planner
