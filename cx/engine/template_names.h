#pragma once

#include <string>
#include <vector>

namespace cxlab {

class RuleEngine;

/// Names of all templates in all modules, in order and each once. CLIPS makes a template for an ordered fact when it
/// reads a condition or action that names it, or when the fact is asserted.
std::vector<std::string> template_names(const RuleEngine& engine);

}  // namespace cxlab
