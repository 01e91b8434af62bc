#pragma once
// Mistakes of a story that are told before it plays.

#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/testing/play.h"

namespace cxlab::testing {

struct Mistakes {
  std::vector<Error> errors;       ///< by line
  std::vector<std::string> notes;  ///< what may be meant as it is
};

/// All mistakes in types and fields of messages, in names of rules, actions, templates, slots and given facts, in
/// values of slots, and in patterns that no fact can match. Call it after activation. Values and patterns that were
/// checked before with the same templates need not be `checked` again, which takes the longest.
Mistakes mistakes_of(const Play& play, bool checked = false);

/// Whether rules assert facts of texts that they compute, so that they may have any name.
bool makes_facts_of_text(const Play& play);

}  // namespace cxlab::testing
