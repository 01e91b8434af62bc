#pragma once
// By how much steps of a plan may begin early or late before something breaks.

#include <optional>

#include "planner/validator/validator.h"

namespace cxlab::planner {

/// The result of moving steps. `holds` and `breaks` bracket the plan's tolerance to a thousandth of itself.
struct Robustness {
  double holds = 0;                    ///< s: every sample with shifts up to this was valid
  double breaks = 0;                   ///< s: a sample with shifts up to this was not; 0 = none up to the limit
  std::optional<Violation> violation;  ///< of that sample; its times are the shifted ones
  int samples = 0;                     ///< plans that were checked
};

/// Moves the starts of steps by up to +-shift, durations stay: each step alone, all odd against all even ones, and
/// `draws` random ways of the stream (seed, "robustness"); searches the largest shift up to `limit` (s) that nothing
/// breaks. No step is moved before 0. The plan itself must be valid.
Expected<Robustness> robustness(const Validator& validator, const Plan& plan, const ValidateOptions& options,
                                double limit, std::uint64_t seed = 1, int draws = 50);

}  // namespace cxlab::planner
