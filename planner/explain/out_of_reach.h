#pragma once
// Why the goal of a problem is out of reach: one chain of causes, from a condition of the goal to something that no
// action brings about.
//
//   the goal (delivered o1) is out of reach: only deliver (domain.pddl:9) makes it true, and needs (at-gate p1); no
//   action makes it true, and :init lacks it

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "planner/ground/budget.h"
#include "planner/pddl/model.h"

namespace cxlab::planner {

/// Facts that are true, or false, with some objects: one of `objects[i]` stands at argument i.
struct FactPattern {
  PredicateId predicate = -1;
  std::vector<std::vector<ObjectId>> objects;
  bool value = true;
};

/// A condition that never holds, whatever is done, and why.
struct Cause {
  std::string condition;  ///< as PDDL; a variable in it may be any of the objects that fit
  std::string when{};     ///< of the action before that asks for it: "at start", "over all", "at end"; empty: no time

  // What is claimed.
  std::vector<FactPattern> facts{};  ///< none of them ever comes about; two of one object each: not both at once
  bool together = false;             ///< `facts` are two that are never so together

  // Why: actions (or rules) that would bring it about, of which one is followed to the next cause; or the end.
  std::vector<std::string> makers{};
  std::string verb{};            ///< what they would do: "makes it true", "raises (fuel r1)"
  std::string followed{}, at{};  ///< one of `makers`, and its file and line
  std::string end{};             ///< "no action makes it true, and :init lacks it"; only of the last cause
  bool again = false;            ///< the last cause is one of those before: they need each other
};

struct OutOfReach {
  std::vector<Cause> causes;  ///< the first is a condition of the goal

  /// One sentence; a long chain is cut in the middle.
  std::string text() const;
};

/// Nothing where no single condition, and no two of them, prove it, or the budget ends. `initial` names the initial
/// state in the text.
std::optional<OutOfReach> explain_out_of_reach(const Task& task, Budget& budget, std::string_view initial = ":init");

}  // namespace cxlab::planner
