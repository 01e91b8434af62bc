#pragma once
// What the environments of an episode may take from the machine together, and who may stop rules in the middle.

#include <atomic>
#include <cstdint>
#include <optional>

#include "cx/base/expected.h"

namespace cxlab {

/// The code of an error that says that rules were stopped from outside.
inline constexpr const char* kStoppedCode = "stopped";

/// Shared by the engines of one episode; looked at when a rule fires, a fact is asserted and a loop turns. From the
/// moment a limit is exceeded no rule of any of them acts any more.
struct Limits {
  std::int64_t memory = 2'000'000'000;      ///< bytes that CLIPS holds in all of them; 0 = no limit
  const std::atomic<bool>* stop = nullptr;  ///< once set, what rules do now ends; may be none

  std::int64_t held = 0;          ///< bytes, as last counted
  std::optional<Error> exceeded;  ///< kResource: the memory, with the rule; kRun with `kStoppedCode`: `stop` was set
};

}  // namespace cxlab
