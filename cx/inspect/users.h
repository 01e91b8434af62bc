#pragma once
// Where a fact leads to: which rules wait for it and what they lack, or which rules could make it where it is missing.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/inspect/inspector.h"
#include "cx/inspect/makers.h"

namespace cxlab::inspect {

/// A rule that has a condition about a fact.
struct FactUser {
  std::string rule, file;
  int line = 0;
  std::string condition;        ///< as written
  std::string differs;          ///< what of the fact does not match it; empty: the fact matches
  std::int64_t fired = 0;       ///< for this fact since its last change
  std::optional<SimTime> last;  ///< of these firings
  /// Its first condition that does not hold together with this fact; none: all do.
  std::optional<explain::UnmetCondition> lacks = {};
};

/// The answer to a question about a fact.
struct FactFuture {
  std::optional<FactHistory> fact;  ///< the one that was asked about, or that matched last; none: it is missing
  std::vector<FactUser> waiting;    ///< rules that need such a fact
  std::vector<FactUser> forbidden;  ///< rules that must not have such a fact
  std::vector<FactUser> nearly;     ///< rules that would need another value in one of its slots

  std::string nearest;           ///< where the fact is missing: the nearest one, and what differs in it
  std::optional<Makers> makers;  ///< and the rules that could make it

  /// Lines for people.
  std::string text() const;
};

/// `what`: a fact such as `f-12`, or a pattern. If several facts match, it is the one that changed last.
Expected<FactFuture> future_of(const Inspector& inspector, const std::string& what);

}  // namespace cxlab::inspect
