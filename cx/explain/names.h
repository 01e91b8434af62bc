#pragma once
// Names that people write: of constructs, and in patterns.

#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "cx/explain/pattern.h"

namespace cxlab::explain {

/// The name of a construct as people write it: with a module other than MAIN.
std::string with_module(const std::string& module, const std::string& name);

/// Names of constructs of that kind, bare.
std::vector<std::string> names_of(const RuleEngine& engine, std::string_view kind);

/// Of templates, with those of ordered facts that are there.
std::vector<std::string> template_names(const RuleEngine& engine);

/// What a pattern that a person wrote names and the engine does not have, with the nearest name: its template or a
/// slot.
Status check_names(const Pattern& pattern, const RuleEngine& engine);

/// Why no fact is like a pattern: it has a value against the type or the allowed values of its slot, or a symbol where
/// `facts` have that string, or the other way round. To be asked where nothing matches: CLIPS does not keep rules from
/// asserting such a value.
Status check_values(const Pattern& pattern, const RuleEngine& engine, const std::vector<FactCopy>& facts);

}  // namespace cxlab::explain
