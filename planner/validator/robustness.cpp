#include "planner/validator/robustness.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cx/base/random.h"

namespace cxlab::planner {
Expected<Robustness> robustness(const Validator& validator, const Plan& plan, const ValidateOptions& options,
                                double limit, std::uint64_t seed, int draws) {
  std::vector<std::vector<double>> ways;  // shift of each step, -1 .. 1
  const auto add_way = [&]() -> std::vector<double>& { return ways.emplace_back(plan.size(), 0.0); };
  for (std::size_t step = 0; step < plan.size(); ++step)
    for (const double direction : {1.0, -1.0}) add_way()[step] = direction;
  for (double next = 1; double& direction : add_way()) direction = std::exchange(next, -next);
  RandomStream random(seed, "robustness");
  for (int draw = 0; draw < draws; ++draw)
    for (double& direction : add_way()) direction = random.uniform(-1, 1);

  Robustness found;
  // The first violation among all ways with shifts up to `shift`; none if all are valid.
  const auto shake = [&](double shift) -> Expected<std::optional<Violation>> {
    for (const auto& way : ways) {
      Plan moved = plan;
      for (std::size_t step = 0; step < moved.size(); ++step)
        moved[step].start = std::max(0.0, moved[step].start + shift * way[step]);
      ++found.samples;
      auto verdict = validator.check(moved, options);
      if (!verdict) return verdict.error();
      if (!verdict->valid) return std::move(verdict->violation);
    }
    return std::optional<Violation>{};
  };
  double shift = limit;
  while (true) {
    auto violation = shake(shift);
    if (!violation) return violation.error();
    if (*violation) {
      found.breaks = shift;
      found.violation = std::move(**violation);
    } else {
      found.holds = shift;
    }
    constexpr double kFinest = 1e-6;  // s
    if (found.breaks == 0 || found.breaks <= kFinest ||
        found.breaks - found.holds <= std::max(kFinest, found.breaks * 1e-3))
      return found;
    shift = std::round((found.holds + found.breaks) / 2 * 1e7) / 1e7;  // seven decimals, to be read
  }
}

}  // namespace cxlab::planner
