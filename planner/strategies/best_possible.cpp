#include "planner/strategies/best_possible.h"

#include <algorithm>

#include "planner/bounds/lower_bound.h"

namespace cxlab::planner {

namespace {

constexpr std::int64_t kLeastSlice = 2'000;
constexpr std::int64_t kGrowth = 6;      ///< how much longer the next slice is,
constexpr std::int64_t kShareOfAll = 5;  ///< and how many times as much has then been spent in all

/// What happenings that may not coincide add to a makespan.
Micros separations(const Incumbent& best) { return kSeparation * static_cast<Micros>(2 * best.plan().steps.size()); }

}  // namespace

void BestPossible::keep_first_slice_short() { slice_ = std::min(kFirstSlice, std::max(kLeastSlice, budget_.units())); }

bool BestPossible::is_due() const { return budget_.units() > kShareOfAll * slice_; }

void BestPossible::raise() {
  if (budget_.late()) return;
  const LowerBound found = lower_bound(ground_, budget_, slice_);
  slice_ = found.complete ? Budget::kUnlimited / kShareOfAll : slice_ * kGrowth;
  if (found.makespan < makespan_) return;
  makespan_ = found.makespan;
  assumes_order_ = found.assumes_order;
  cost_ = objective_.bound(makespan_);
}

bool BestPossible::proves(const Incumbent& best) const {
  if (!best.exists()) return false;
  return best.by_metric() ? proves(best, cost_) : best.makespan() <= makespan_ + separations(best);
}

bool BestPossible::proves(const Incumbent& best, std::optional<double> cost) const {
  const double slack = objective_.time_weight() * in_seconds(separations(best));
  return cost && best.cost() <= *cost + slack + 1e-9;
}

void BestPossible::report(const Incumbent& best, PlanAnswer& answer) const {
  answer.lower_bound_s = in_seconds(makespan_);
  answer.bound_assumes_order = assumes_order_;
  if (cost_ && best.exists() && best.plan().metric) answer.metric_bound = best.signed_metric(*cost_);
}

}  // namespace cxlab::planner
