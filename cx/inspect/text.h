#pragma once
// Answers as people read them: for commands and for `cxlab attach`.

#include <optional>
#include <string>
#include <vector>

#include "cx/inspect/inspector.h"

namespace cxlab::inspect {

/// "312.400 s".
std::string seconds_text(SimTime t);
/// The s in a time as people write it, "312.4", "5:12" or "5:12.4", in decimal digits: "5:12.4" and "312.4" are the
/// same number. Nothing where it is no time.
std::optional<std::string> seconds_in(const std::string& time);
/// "?id = 3 ?robot = robot1"; empty without values.
std::string values_text(const Values& values);

/// A line for each fact and one for who made and changed it; with `changes` a line for each change.
std::string text_of(const std::vector<FactHistory>& facts, bool changes);
/// "10  order-begin: f-3 f-7" in the order of firing.
std::string text_of(const std::vector<ActivationInfo>& agenda, const std::vector<std::string>& focus);
/// "?*speed* = 0.5".
std::string text_of(const std::vector<std::pair<std::string, Value>>& globals);
std::string text_of(const std::vector<FiringCopy>& firings);
/// A table of those that fired; then those that were on the agenda in vain; then those that never were, and why.
std::string text_of(const std::vector<RuleUse>& rules);

/// "asserted", "changed" or "retracted".
const char* done_by(RecordKind kind);
/// "rule order-begin (orders.clp:58) at 302.000 s  ?id = 4".
std::string line_of(const Derivation::Step& step);

/// The condition that a rule lacks, in lines that begin with `indent`: "lacks condition 2: (order (id 3)): there is no
/// fact of order". A text that is too long becomes several lines: the condition, why it does not hold, and the fact
/// concerned. `begin` comes before the condition.
std::string text_of(const explain::UnmetCondition& unmet, const std::string& begin, const std::string& indent);

/// All that a derivation has, as a numbered list of firings, the latest first: each once, with the numbers of those
/// that made what it matched. Where a rule fires again and again for what it left itself, that is one line.
std::string whole_text(const Derivation& derivation);

/// A derivation as a tree of lines.
struct Tree {
  std::string text;
  std::vector<Tree> branches;
};
/// The latest cause of each step is followed to its end, but not through a rule that stands above; of the others only
/// the last change is shown. With `whole` all are followed, each once.
Tree tree_of(const Derivation& derivation, bool whole);
std::string text_of(const Tree& tree);
/// The same tree as a picture.
std::string svg_of(const Tree& tree);

}  // namespace cxlab::inspect
