#pragma once

namespace cxlab {

/// How to allow what untrusted rules may not do.
inline constexpr const char* kTrustRemedy =
    "trust_rules: true in the scenario lifts this, or --trust-rules of cxlab env";

/// Code of the error where something would run that nobody has said is trusted.
inline constexpr const char* kUntrusted = "untrusted";

}  // namespace cxlab
