#pragma once
// What could bring about a condition that does not hold: the way from why-not to where the fault is.

#include <optional>
#include <string>
#include <vector>

#include "cx/explain/why_not.h"
#include "cx/inspect/inspector.h"

namespace cxlab::inspect {

struct Makers {
  std::string pattern;   ///< of facts, as written: one is missing, or forbids the rule
  bool forbids = false;  ///< facts must go; else one must come

  /// A rule that could do it, as its text says.
  struct Maker {
    std::string rule, file;
    int line = 0;
    std::string how;      ///< "asserts", "changes" or "retracts" such facts
    std::string through;  ///< the deffunction that does so for it; may be empty
    std::int64_t fired = 0;
    std::optional<SimTime> last;
    /// Its first condition that does not hold now; none: all do, or it cannot be looked at.
    std::optional<explain::UnmetCondition> lacks;
  };
  std::vector<Maker> makers;  ///< those that fired last come first

  /// The last fact that matched the pattern by itself: made then, and gone since, if it has.
  std::optional<FactChange> made, gone;
  std::optional<FactCopy> matched;  ///< that fact as it was last while it matched
  /// The last change of the nearest fact, or of the one that forbids.
  std::optional<FactChange> changed;

  /// Lines for people.
  std::string text() const;
};

/// What could bring about a condition about facts; none for a test, or where the rules cannot be read.
std::optional<Makers> makers_of(const Inspector& inspector, const explain::UnmetCondition& unmet);

}  // namespace cxlab::inspect
