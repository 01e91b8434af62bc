#include "planner/strategies/happening_strategy.h"

#include <algorithm>

namespace cxlab::planner {

namespace {

constexpr std::size_t kMostActions = 200, kMostEvents = 60;
constexpr std::size_t kMostActionsToImprove = 40;
/// Between happenings that interfere, in proofs: less than validators ask for, by what times are rounded to.
constexpr Micros kProofSeparation = 999;
constexpr int kMostCopies = 3;  ///< of an action at once, that are followed one by one

}  // namespace

bool HappeningStrategy::is_needed() const {
  const GroundTask& task = context_.ground;
  const bool times_matter = context_.has_durations || context_.has_events() || (better_ && context_.best.by_metric());
  return times_matter && task.actions.size() <= (better_ ? kMostActionsToImprove : kMostActions) &&
         task.events.size() <= kMostEvents;
}

/// Whether effects that may not come about keep happenings apart.
bool HappeningStrategy::may_be_apart_in_vain() const {
  return std::ranges::any_of(context_.ground.actions, [](const GroundAction& action) {
    return std::ranges::any_of(action.idle, &IdleTouch::conditional);
  });
}

std::unique_ptr<HappeningSearch> HappeningStrategy::make(bool relaxed, int copies) const {
  HappeningSearch::Options how;
  how.most_words = context_.search_options(0).most_words;
  how.moments.keep_origin = better_;
  how.all_numbers = better_ && context_.best.by_metric();
  how.moments.relaxed = relaxed;
  how.moments.certain = certain_;
  how.moments.copies = copies;
  if (relaxed) how.moments.separation = kProofSeparation;
  return std::make_unique<HappeningSearch>(context_.ground, context_.whole.space.simulator, context_.budget, how);
}

bool HappeningStrategy::run(const Turn& turn) {
  if (exhausted_ || context_.budget.late()) return false;
  if (!search_ && !is_needed()) {
    exhausted_ = true;
    return false;
  }
  if (!search_) search_ = make(false, kMostCopies);
  const bool bounded = better_ && !context_.best.by_metric();
  const BudgetSlice slice(context_.budget, turn.units);
  const SearchEnd end =
      search_->run(bounded ? context_.best.makespan() : DurationRange::kForever, [this](const HappeningPlan& plan) {
        return (plan.partial && context_.best.offer(*plan.partial)) || context_.best.offer(plan.steps);
      });
  if (end == SearchEnd::kExhausted && !better_ && !certain_ && may_be_apart_in_vain()) {
    certain_ = true;
    search_.reset();
    return false;
  }
  exhausted_ = end == SearchEnd::kExhausted || end == SearchEnd::kMemory;
  seen_all_ = end == SearchEnd::kExhausted && search_->complete() && (!better_ || !search_->capped());
  if (exhausted_) search_.reset();
  return end == SearchEnd::kFound;
}

bool HappeningStrategy::prove(const Turn& turn) {
  if (proof_ended_ || context_.budget.late()) return false;
  if (!proof_ && !is_needed()) {
    proof_ended_ = true;
    return false;
  }
  const BudgetSlice slice(context_.budget, turn.units);
  for (;;) {
    if (!proof_) proof_ = make(true, copies_of_proof_);
    const SearchEnd end = proof_->run(DurationRange::kForever, [](const HappeningPlan&) { return true; });
    if (end == SearchEnd::kBudget) return false;
    const bool proved = end == SearchEnd::kExhausted && proof_->complete();
    proof_.reset();
    // If a plan seems possible, the durations of more copies may still rule it out.
    proof_ended_ = proved || end != SearchEnd::kFound || copies_of_proof_ == kMostCopies;
    if (proof_ended_) return proved;
    copies_of_proof_ = kMostCopies;
  }
}

void HappeningStrategy::forget() {
  search_.reset();
  proof_.reset();
}

}  // namespace cxlab::planner
