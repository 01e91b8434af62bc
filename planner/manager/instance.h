#pragma once
// A problem that changes while plans for it are made and carried out: objects, facts and numbers of now, and goals.
//
//   auto instance = Instance::make(*load_task("domain.pddl", "problem.pddl"));
//   (*instance)->set(*(*instance)->fact("on", {"a", "b"}), true);
//   auto step = (*instance)->step("pick-up", {"a"});
//   std::vector<std::string> missing = (*instance)->unsatisfied(*step, Instance::When::kStart);
//
// Names are accepted in any case and reported as they were written: names from files in lower case, names of added
// objects unchanged. Errors name what was found and the nearest known name, or those known.

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "planner/pddl/model.h"
#include "planner/state/state.h"

namespace cxlab::planner {

/// What a plan is made for: a goal, and what of the instance the planner sees. Empty lists do not filter.
struct GoalInstance {
  std::vector<Fact> facts;
  std::vector<Assignment> values;
  std::vector<std::string> actions;
  std::vector<std::string> fluents;  ///< predicates and functions whose present facts and values the planner gets
  std::vector<std::string> objects;  ///< beside the constants of the domain
};

/// An object as agents name it; one that is to be removed needs no type.
struct ObjectName {
  std::string name, type;
};

/// An action with its arguments.
struct ActionCall {
  ActionId action = -1;
  std::vector<ObjectId> arguments;
};

/// One effect as it is reported to agents.
struct ReportedEffect {
  std::string name;
  std::vector<std::string> arguments;
  bool at_end = false;
  bool numeric = false;
  bool value = false;    ///< of a fact: it becomes true
  char operation = '=';  ///< of a number: = + -
  double number = 0;
};

class Instance {
 public:
  using Names = std::vector<std::string>;

  /// The goals of the problem are dropped; the goal instance `base` is there.
  /// `meter`, which may be none, outlives this and limits what answers try; when it is over, an answer is meaningless.
  explicit Instance(Task task, Meter* meter = nullptr);
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  const Domain& domain() const { return task_.domain; }
  const Problem& problem() const { return task_.problem; }

  // --- Names to ids
  Expected<Fact> fact(const std::string& predicate, const Names& arguments) const;
  Expected<Fact> number(const std::string& function, const Names& arguments) const;  ///< `predicate` is the FunctionId
  Expected<ActionCall> step(const std::string& action, const Names& arguments) const;
  Expected<TypeId> type(const std::string& name) const;

  // --- The state of now
  /// First those of the problem's :init, in its order; then in the order in which they became true; derived ones are
  /// last.
  std::vector<Fact> facts() const;
  std::vector<Assignment> values() const { return state_.values(); }
  /// kInput where the predicate is derived.
  Status set(const Fact& fact, bool value);
  void set_value(const Fact& number, double value);
  /// The objects of `wanted` that do not exist yet; an error if one of them cannot be made.
  Expected<std::vector<Object>> new_objects(const std::vector<ObjectName>& wanted) const;
  void add_objects(const std::vector<Object>& objects);
  /// By object of the problem, 1 if it stays when `gone` are removed; an error if one of them cannot be removed.
  Expected<std::vector<char>> others_than(const std::vector<ObjectName>& gone) const;
  /// Removes the other objects, and the facts, numbers and goals that name them.
  void keep_objects(const std::vector<char>& keep);
  /// Applies the events that are due `seconds` after the problem was loaded. Returns whether there were any.
  bool advance(double seconds);

  // --- Goals, by name
  Status create_goal(const std::string& name);  ///< replaces an existing one
  GoalInstance* goal(const std::string& name);
  /// The names for a filter as they were written first; an error if one is not known.
  Expected<Names> known_names(Names GoalInstance::* filter, const Names& names) const;

  // --- Actions in the state of now
  enum class When {
    kStart,    ///< conditions at the start, and those over all right after the effects at the start
    kAtStart,  ///< conditions at the start alone
    kOverAll,
    kEnd,
  };
  /// The conditions that do not hold, as `p(a)`, `(not p(a))`, `Forall (t y) p(y)`; none: the action can be done.
  Names unsatisfied(const ActionCall& call, When when) const;
  /// The action may begin now: what its effects at the end ask of the state at the start is remembered until the
  /// next call.
  void remember_start(const ActionCall& call);
  /// Conditional effects whose condition holds, universal ones with every object, numbers computed in the state of now.
  /// Conditions at the start of effects at the end are those that were remembered, or of now where none were. Changes
  /// all along the action are reported at its end.
  Expected<std::vector<ReportedEffect>> effects(const ActionCall& call) const;
  /// As the original PDDL manager reports them: conditions are left out, universal effects come once, with the
  /// names of their variables, right-hand sides are constants or single functions.
  Expected<std::vector<ReportedEffect>> original_effects(const ActionCall& call) const;

  // --- Planning
  /// The problem of now for that goal, `seconds` after it was loaded.
  Expected<Task> planning_task(const GoalInstance& goal, double seconds) const;

 private:
  template <class Found, class Item>
  Expected<Found> look_up(const char* what, const ById<Item>& items, const NameTable& table, const std::string& name,
                          const Names& arguments) const;
  Frame frame(const ActionCall& call) const;
  double duration(const ActionCall& call, const Frame& frame) const;
  std::vector<Fact> in_order(State state) const;
  void renew_evaluator();
  const State& state() const;
  void touch() { derived_ = false; }

  using Binding = std::vector<ObjectId>;
  /// Effects of an action, by index and binding of their variables.
  using EffectSet = std::set<std::pair<std::size_t, Binding>>;

  Task task_;
  mutable State state_;  // derived facts are made on demand
  mutable bool derived_ = false;
  Meter* meter_;
  std::optional<Evaluator> evaluator_;
  std::map<std::string, GoalInstance> goals_;
  std::map<std::pair<ActionId, Binding>, EffectSet> started_;  // effects at the end whose condition at the start held
  std::size_t next_fact_ = 0, next_value_ = 0;                 // events of the problem that have not come yet
};

/// A copy of the problem without the objects for which `keep` is false, and without what names them.
Problem without_objects(const Problem& problem, const std::vector<char>& keep);
/// The facts and numbers of a goal that are left then.
std::pair<std::vector<Fact>, std::vector<Assignment>> goals_without(const Problem& problem, const GoalInstance& goal,
                                                                    const std::vector<char>& keep);

/// A condition in the notation of the Unified Planning Framework: `p(a, b)`, `(not p)`, `(x(a) <= 3)`,
/// `Forall (block y) p(y)`. Slots below the size of `bound` are those objects.
std::string framework_text(const Condition& condition, const Domain& domain, const ById<Object>& objects,
                           std::span<const ObjectId> bound);

/// Names what was found, and the nearest of the known names or, where none is near, some of them.
Error unknown_name(const std::string& what, const std::string& found, const std::vector<std::string>& known);

}  // namespace cxlab::planner
