#pragma once
// Limits on what the environments of an episode may take from the machine together. A stop may end rules in the middle.

#include <atomic>
#include <cstdint>
#include <optional>

#include "cx/base/expected.h"

namespace cxlab {

/// The code of an error that says that rules were stopped from outside.
inline constexpr const char* kStoppedCode = "stopped";

/// Limits for all engines of one episode together.
struct Limits {
  std::int64_t memory = 2'000'000'000;      ///< bytes that CLIPS holds in all of them, and that are charged to them
                                            ///< (cx/base/charge.h); 0 = no limit
  std::int64_t disk = 5'000'000'000;        ///< bytes that are written for them; 0 = no limit
  std::int64_t steps = 500'000'000;         ///< of one of them in a tick (docs/reference/limits.md); 0 = no limit
  const std::atomic<bool>* stop = nullptr;  ///< once set, what rules do now ends; may be none
};

/// The limits with what has been taken of them. Shared by the engines of one episode; looked at when a rule fires, a
/// fact is asserted and a loop turns. From the moment a limit is exceeded no rule of any of them acts any more.
struct LimitsInUse : Limits {
  explicit LimitsInUse(const Limits& limits = {}) : Limits(limits) {}

  std::int64_t held = 0;  ///< bytes of CLIPS, as last counted
  struct Charged {
    std::int64_t memory = 0, disk = 0;
  };
  std::optional<Charged> before;  ///< what was charged when the first of them came
  /// With the rule. kResource: memory or disk; kRun: the steps, or with `kStoppedCode` that `stop` was set.
  std::optional<Error> exceeded;
};

}  // namespace cxlab
