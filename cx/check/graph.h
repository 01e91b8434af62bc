#pragma once
// Which rules produce and consume which facts, as a picture.

#include <string>

#include "cx/check/rule_base.h"

namespace cxlab::check {

/// For Graphviz: rules are boxes, templates ellipses; an arrow from a rule to a template produces, the other consumes.
std::string graph_dot(const RuleBase& base, const std::string& title);
/// One block for each template of the files that are judged: its producers on the left, its consumers on the right.
std::string graph_svg(const RuleBase& base, const std::string& title);

}  // namespace cxlab::check
