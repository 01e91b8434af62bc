#include "planner/validator/robustness.h"

#include <algorithm>
#include <cmath>

#include "cx/base/random.h"

namespace cxlab::planner {
namespace {

class Shaker {
 public:
  Shaker(const Validator& validator, const Plan& plan, const ValidateOptions& options, std::uint64_t seed, int draws)
      : validator_(validator), plan_(plan), options_(options) {
    const std::size_t steps = plan.size();
    for (std::size_t step = 0; step < steps; ++step)
      for (const double direction : {1.0, -1.0}) {
        ways_.emplace_back(steps, 0.0);
        ways_.back()[step] = direction;
      }
    ways_.emplace_back(steps, 0.0);
    for (std::size_t step = 0; step < steps; ++step) ways_.back()[step] = step % 2 == 0 ? 1 : -1;
    RandomStream random(seed, "robustness");
    for (int draw = 0; draw < draws; ++draw) {
      ways_.emplace_back(steps, 0.0);
      for (double& direction : ways_.back()) direction = random.uniform(-1, 1);
    }
  }

  int samples() const { return samples_; }

  /// The first violation among all ways with shifts up to `shift`; none if all are valid.
  Expected<std::optional<Violation>> shake(double shift) {
    for (const auto& way : ways_) {
      Plan moved = plan_;
      for (std::size_t step = 0; step < moved.size(); ++step)
        moved[step].start = std::max(0.0, moved[step].start + shift * way[step]);
      ++samples_;
      auto verdict = validator_.check(moved, options_);
      if (!verdict) return verdict.error();
      if (!verdict->valid) return std::move(verdict->violation);
    }
    return std::optional<Violation>{};
  }

 private:
  const Validator& validator_;
  const Plan& plan_;
  const ValidateOptions& options_;
  std::vector<std::vector<double>> ways_;  ///< shift of each step, -1 .. 1
  int samples_ = 0;
};

}  // namespace

Expected<Robustness> robustness(const Validator& validator, const Plan& plan, const ValidateOptions& options,
                                double limit, std::uint64_t seed, int draws) {
  Shaker shaker(validator, plan, options, seed, draws);
  Robustness found;
  double shift = limit;
  while (true) {
    auto violation = shaker.shake(shift);
    if (!violation) return violation.error();
    if (*violation) {
      found.breaks = shift;
      found.violation = std::move(**violation);
    } else {
      found.holds = shift;
    }
    found.samples = shaker.samples();
    constexpr double kFinest = 1e-6;  // s
    if (found.breaks == 0 || found.breaks <= kFinest ||
        found.breaks - found.holds <= std::max(kFinest, found.breaks * 1e-3))
      return found;
    shift = std::round((found.holds + found.breaks) / 2 * 1e7) / 1e7;  // seven decimals, to be read
  }
}

}  // namespace cxlab::planner
