#pragma once
// Words in rules that look misspelt: CLIPS takes a pattern that no fact can match, and a fact that no pattern can
// match.

#include <vector>

#include "cx/engine/engine.h"

namespace cxlab::cx {

/// One for each symbol in a pattern that nothing in the rule base can give its slot, where another that it has is
/// spelt nearly so; and for each ordered fact that no pattern reads, or pattern that no rule gives, where another is.
/// Facts may come from outside: a word without such a neighbour is none of them.
std::vector<Error> suspect_words(const RuleEngine& engine);

}  // namespace cxlab::cx
