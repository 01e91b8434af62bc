#pragma once
// Nested lists to conditions, effects and numbers: looks names up, checks arity and types.

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "planner/pddl/model.h"
#include "planner/pddl/syntax.h"

namespace cxlab::planner {

/// What names mean while one file is read. The functions return false after an error; `error()` then has it.
class Resolver {
 public:
  /// `objects` are the constants of the domain, or all objects of the problem. All arguments outlive this.
  Resolver(const Domain& domain, const ById<Object>& objects, const NameTable& object_names, const std::string& file,
           Source::File which);

  // Frames: the variables of one action, rule or goal.

  /// In the frame of a durative action ?duration may be read.
  void begin_frame(bool durative);
  /// Slots used since begin_frame.
  int slots() const { return slots_; }
  /// Parses `?a ?b - type` of a list and pushes the variables on the scope.
  bool declare_variables(const Node& list, std::vector<Variable>& out);

  // Parts of actions. Each appends to or fills `out`.

  bool condition(const Node& node, Condition& out);
  bool timed_condition(const Node& node, TimedCondition& out);
  bool duration(const Node& node, std::vector<DurationConstraint>& out);
  /// Effects of an instantaneous action.
  bool effects(const Node& node, std::vector<Effect>& out);
  bool timed_effects(const Node& node, std::vector<Effect>& out);
  bool metric(const Node& node, Expression& out);

  // Parts of problems.

  bool ground_fact(const Node& node, Fact& out);
  bool ground_function(const Node& node, Assignment& out);

  /// Typed names: `a b - t c - (either t u) d`. Each name with its types, object where none is given.
  struct TypedName {
    const Node* name;
    std::vector<TypeId> types;
  };
  bool typed_list(const std::vector<Node>& items, std::size_t first, const char* what, std::vector<TypedName>& out);

  /// Records an error and returns false.
  bool fail(const Node& at, std::string message);
  bool fail_unsupported(const Node& at, std::string message);
  const Error& error() const { return *error_; }

  Source source(const Node& node) const { return {which_, node.line}; }
  /// ` (declared at file:line)`, or empty.
  std::string declared(const Source& source) const;

 private:
  struct EffectContext {
    std::optional<Effect::Time> time;  ///< none: inside a durative action, before (at start ...) or (at end ...)
    bool durative = false;
    std::vector<Variable> variables;
    TimedCondition condition;
  };
  enum class Place { kCondition, kDuration, kEffect, kMetric };

  /// Words of the language that may stand in the place of a name, for "did you mean".
  using Words = std::span<const char* const>;

  bool atom(const Node& node, Words words, PredicateId& predicate, std::vector<Term>& terms);
  bool function_term(const Node& node, Words words, FunctionId& function, std::vector<Term>& terms);
  bool arguments(const Node& node, const std::string& name, const std::vector<Variable>& parameters,
                 const Source& declared_at, std::vector<Term>& terms);
  bool term(const Node& node, Term& out);
  bool expression(const Node& node, Place place, Expression& out);
  bool rate(const Node& node, Expression& out);
  bool equality_or_comparison(const Node& node, Condition& out);
  bool quantified(const Node& node, Condition& out);
  bool quantified_timed(const Node& node, TimedCondition& out);
  bool effect(const Node& node, const EffectContext& context, std::vector<Effect>& out);
  bool conditional_effect(const Node& node, const EffectContext& context, std::vector<Effect>& out);
  bool numeric_effect(const Node& node, const EffectContext& context, std::vector<Effect>& out);
  bool literal_effect(const Node& node, const EffectContext& context, std::vector<Effect>& out);
  bool ground(const std::vector<Term>& terms, const Node& node, std::vector<ObjectId>& out);
  bool looks_numeric(const Node& node) const;
  bool may_be(const std::vector<TypeId>& types, const std::vector<TypeId>& wanted) const;
  std::string type_names(const std::vector<TypeId>& types) const;

  const Domain& domain_;
  const ById<Object>& objects_;
  const NameTable& object_names_;
  const std::string& file_;
  Source::File which_;
  std::vector<Variable> scope_;
  int slots_ = 0;
  bool in_durative_ = false;
  std::optional<Error> error_;
};

/// Joins two conditions with `and`, without needless levels.
void conjoin(Condition& into, Condition&& more);

}  // namespace cxlab::planner
