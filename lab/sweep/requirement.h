#pragma once
// Thresholds of a suite (docs/reference/sweeps.md); lab/sweep/judge.h answers them.
//
//   require:
//     - mean(points) >= 250          # each strategy, in each scenario
//     - fast: mean(late_s) <= 30     # only the strategy `fast`
//     - not worse than main          # in the same games; `main`: a strategy of the suite, or a sweep of `earlier:`
//     - not worse than main by 10    # by more than 10 points
//     - not worse than main in late_s

#include <filesystem>
#include <string>

#include "cx/base/expected.h"
#include "cx/base/origin.h"

namespace cxlab::lab {

struct Requirement {
  enum class Kind { kAtLeast, kAtMost, kNotWorse };

  std::string text;  ///< as in the suite
  Origin origin{};
  std::string strategy{};  ///< of which it is asked; empty: of each
  Kind kind = Kind::kNotWorse;
  std::string metric{};  ///< empty: the one that the world compares
  double bound = 0;      ///< of a mean; of kNotWorse how much worse it may be
  std::string than{};    ///< strategy or earlier sweep

  static Expected<Requirement> parse(const std::string& text);
};

/// A sweep that was played before, by the name that a suite gives it.
struct EarlierSweep {
  std::string name;
  std::filesystem::path path;
  Origin origin{};
};

}  // namespace cxlab::lab
