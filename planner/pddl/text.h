#pragma once
// Model back to PDDL text: for messages, for files, and for plans.

#include <span>
#include <string>
#include <vector>

#include "planner/pddl/model.h"

namespace cxlab::planner {

/// Writes parts of actions and problems. Slots are written as in `names`: variables, or the objects bound to them.
class Printer {
 public:
  Printer(const Domain& domain, const ById<Object>& objects) : domain_(&domain), objects_(&objects) {}

  /// Writes parameters as variables: `?x`.
  void name_variables(const std::vector<Variable>& parameters);
  /// Writes slots 0, 1, ... as these objects.
  void name_objects(std::span<const ObjectId> objects);

  std::string condition(const Condition& condition) const;
  std::string expression(const Expression& expression) const;
  /// Without its variables, time and condition: `(not (p ?x))`. Name its variables first.
  std::string effect(const Effect& effect) const;
  /// `?x ?y - type ?z - (either a b)`
  std::string variables(const std::vector<Variable>& variables) const;

  std::string fact(PredicateId predicate, std::span<const ObjectId> objects) const;
  std::string function(FunctionId function, std::span<const ObjectId> objects) const;

 private:
  std::string term(const Term& term) const;
  std::string terms(const std::string& name, const std::vector<Term>& terms) const;
  Printer inside(const std::vector<Variable>& variables) const;

  const Domain* domain_;
  const ById<Object>* objects_;
  ById<std::string> names_;
};

/// `block`, `(either a b)`
std::string types_text(const Domain& domain, const std::vector<TypeId>& types);
/// A number as short as it can be read back without loss: 5, 0.1.
std::string number_text(double number);
/// A time in seconds with three decimals, or up to nine where three lose something: 5.000, 33.333333333.
std::string time_text(double seconds);

/// The whole domain or problem as PDDL that parses to the same model.
std::string to_pddl(const Domain& domain);
std::string to_pddl(const Domain& domain, const Problem& problem);

}  // namespace cxlab::planner
