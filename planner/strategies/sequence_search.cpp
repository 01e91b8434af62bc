#include "planner/strategies/sequence_search.h"

namespace cxlab::planner {

bool SequenceSearch::run(const Turn& turn) {
  if (exhausted_) return false;
  KeptSearch once;
  Sequence found;
  SearchEnd end = SearchEnd::kBudget;
  {
    const BudgetSlice slice(context_.budget, turn.units);
    end = (continues_first(turn) ? first_ : once)
              .go_on(context_.whole.space, context_.has_events() ? &in_time_ : nullptr,
                     context_.search_options(turn.round), context_.budget, found);
  }
  if (end == SearchEnd::kFound) context_.offer_found(found);
  exhausted_ = context_.is_exhausted(end);
  return context_.best.exists();
}

std::optional<Sequence> SequenceSearch::find(const Turn& turn) {
  const BudgetSlice slice(context_.budget, turn.units);
  KeptSearch once;
  Sequence found;
  const SearchEnd end =
      once.go_on(context_.whole.space, nullptr, context_.search_options(turn.round), context_.budget, found);
  return end == SearchEnd::kFound ? std::optional(std::move(found)) : std::nullopt;
}

}  // namespace cxlab::planner
