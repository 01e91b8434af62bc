#pragma once
// Nested lists to conditions, effects and numbers: looks names up, checks arity and types.

#include <ranges>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planner/pddl/failure.h"
#include "planner/pddl/model.h"
#include "planner/pddl/syntax.h"

namespace cxlab::planner {

/// What a file holds: `(define (KIND NAME) SECTION...)`.
struct FileShape {
  std::string_view kind, other_kind;
  std::vector<std::string_view> many, single, unsupported;  ///< heads of sections
  std::string_view expected;                                ///< the sections in words
};

/// The sections of a file with this head.
inline auto sections(const Node& root, std::string_view head) {
  return root.items | std::views::filter([head](const Node& section) { return section.head() == head; });
}

/// What names mean while one file is read. All functions throw Rejected.
class Resolver {
 public:
  /// `objects` are the constants of the domain, or all objects of the problem. All arguments outlive this.
  Resolver(const Domain& domain, ById<Object>& objects, NameTable& object_names, const std::string& file,
           Source::File which)
      : domain_(domain), objects_(objects), object_names_(object_names), file_(file), which_(which) {}

  /// Checks the sections of a file and returns its name.
  std::string define(const Node& root, const FileShape& shape) const;

  /// Typed names: `a b - t c - (either t u) d`. Each name with its types, object where none is given.
  struct TypedName {
    const Node* name;
    std::vector<TypeId> types;
  };
  std::vector<TypedName> typed_list(std::span<const Node> items, std::string_view what) const;
  /// Adds the objects of a section. One that is declared twice belongs to the types of both.
  void declare_objects(const Node& section, std::string_view what);
  /// `(:private a b - t)` within a section, also `(:private ?owner - t (p ?x))`: what stands behind the owner.
  static std::vector<Node> without_owners(const Node& section);

  // Frames: the variables of one action, rule or goal.

  /// In the frame of a durative action conditions and effects have times, and ?duration may be read.
  void begin_frame(bool durative);
  /// Slots used since begin_frame.
  int slots() const { return slots_; }
  /// Parses `?a ?b - type` and pushes the variables on the scope.
  std::vector<Variable> variables(std::span<const Node> items);
  std::vector<Variable> variables(const Node& list);
  /// Gives variables slots and pushes them on the scope.
  void declare(std::vector<Variable>& variables);
  /// The parameters of a declaration, where names mean nothing and may stand twice.
  std::vector<Variable> signature(std::span<const Node> items);

  Condition condition(const Node& node);
  /// Conditions and effects of an action.
  TimedCondition conditions(const Node& node);
  std::vector<Effect> effects(const Node& node);
  std::vector<DurationConstraint> duration(const Node& node);
  Expression metric(const Node& node) { return expression(node, Place::kMetric); }

  /// Refuses a whole number that a double does not hold: 9007199254740993.
  void expect_exact(const Node& number, double value) const;

  // Parts of problems.

  Fact ground_fact(const Node& node);
  /// A numeric fluent, with the FunctionId as `predicate`.
  Fact ground_function(const Node& node);

  template <class... Parts>
  [[noreturn]] void fail(const Node& at, const Parts&... parts) const {
    throw Rejected{input_error(message(parts...), file_, at.line)};
  }
  template <class... Parts>
  [[noreturn]] void fail_unsupported(const Node& at, const Parts&... parts) const {
    throw Rejected{input_error(message(parts...), file_, at.line).with_code(word_of(Failure::kUnsupported))};
  }

  Source source(const Node& node) const { return {which_, node.line}; }
  /// `; declared at file:line`, with a name `; 'NAME' is declared at file:line`; empty for what no line declares.
  std::string declared(const Source& source, std::string_view name = {}) const;

 private:
  enum class Place { kCondition, kDuration, kEffect, kMetric };
  /// Words of the language that may stand in the place of a name, for "did you mean".
  using Words = std::span<const std::string_view>;
  /// A predicate or function with its arguments.
  using Call = std::pair<int, std::vector<Term>>;

  Call atom(const Node& node, Words words);
  Call function_term(const Node& node, Words words);
  template <class Declaration>
  std::vector<Term> arguments(const Node& node, const Declaration& declaration);
  Term term(const Node& node);
  Expression expression(const Node& node, Place place);
  Expression rate(const Node& node);
  bool looks_numeric(const Node& node) const;
  void timed_condition(const Node& node, TimedCondition& out);
  /// `pattern` has the time, variables and condition of what surrounds the effect; it is not `timed` inside a durative
  /// action before (at start ...) or (at end ...).
  void effect(const Node& node, Effect pattern, bool timed, std::vector<Effect>& out);
  void conditional_effect(const Node& node, Effect pattern, bool timed, std::vector<Effect>& out);
  Effect numeric_effect(const Node& node, Effect effect);
  Effect literal_effect(const Node& node, Effect effect);
  bool may_be(const std::vector<TypeId>& types, const std::vector<TypeId>& wanted) const;
  std::string type_names(const std::vector<TypeId>& types) const;

  const Domain& domain_;
  ById<Object>& objects_;
  NameTable& object_names_;
  const std::string& file_;
  Source::File which_;
  std::vector<Variable> scope_;
  int slots_ = 0;
  bool in_durative_ = false;
};

/// Joins two conditions with `and`, without needless levels.
void conjoin(Condition& into, Condition&& more);

}  // namespace cxlab::planner
