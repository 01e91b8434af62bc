#pragma once

namespace cxlab {

/// Of what is refused to rules that are not trusted.
inline constexpr const char* kTrustRemedy =
    "trust_rules: true in the scenario lifts this, or --trust-rules of cxlab env";

/// Code of the error where something would run that nobody has said is trusted.
inline constexpr const char* kUntrusted = "untrusted";

}  // namespace cxlab
