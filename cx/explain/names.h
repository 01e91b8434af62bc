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

/// Fails if a pattern that a person wrote names a template or slot that the engine does not have. The error suggests
/// the nearest name.
Status check_names(const Pattern& pattern, const RuleEngine& engine);

/// Fails if a value of the pattern is not of its slot's type or allowed values. Fails too if it is a symbol where
/// `facts` have that string, or the other way round. Call it only where nothing matches: CLIPS lets rules assert such
/// values.
Status check_values(const Pattern& pattern, const RuleEngine& engine, const std::vector<FactCopy>& facts);

}  // namespace cxlab::explain
