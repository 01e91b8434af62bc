// Domains and problems as PDDL files.

#include <span>
#include <utility>

#include "planner/pddl/text.h"

namespace cxlab::planner {
namespace {

std::string type_text(const Domain& domain, const std::vector<TypeId>& types) {
  if (types.size() == 1) return domain.types[types[0]].name;
  std::string text = "(either";
  for (const TypeId type : types) text += " " + domain.types[type].name;
  return text + ")";
}

std::string objects_text(const Domain& domain, const std::vector<Object>& objects, std::size_t from) {
  std::string text;
  for (std::size_t i = from; i < objects.size(); ++i) {
    // A single object of several types is declared once with each: it belongs to all of them.
    for (const TypeId type : objects[i].types) text += "\n    " + objects[i].name + " - " + domain.types[type].name;
  }
  return text;
}

/// What the problem adds to the types of the domain's constants.
std::string more_types_text(const Domain& domain, const std::vector<Object>& objects) {
  std::string text;
  for (std::size_t i = 0; i < domain.constants.size(); ++i)
    for (std::size_t k = domain.constants[i].types.size(); k < objects[i].types.size(); ++k)
      text += "\n    " + objects[i].name + " - " + domain.types[objects[i].types[k]].name;
  return text;
}

std::string signature(const Printer& printer, const std::string& name, const std::vector<Variable>& parameters) {
  return "(" + name + (parameters.empty() ? "" : " ") + printer.variables(parameters) + ")";
}

std::string timed_text(const Printer& printer, const TimedCondition& condition) {
  // One time in front of each part, which is what planners read best.
  std::string text = "(and";
  for (const auto& [time, whole] :
       {std::pair{"at start", &condition.start}, {"over all", &condition.over_all}, {"at end", &condition.end}}) {
    const std::span<const Condition> parts =
        whole->kind == Condition::Kind::kAnd ? std::span(whole->operands) : std::span(whole, 1);
    for (const Condition& part : parts) text += std::string(" (") + time + " " + printer.condition(part) + ")";
  }
  return text + ")";
}

std::string effect_text(const Printer& action_printer, const Effect& effect, bool durative) {
  Printer printer = action_printer;
  printer.name_variables(effect.variables);
  std::string text = printer.effect(effect);
  if (durative && effect.time == Effect::Time::kStart) text = "(at start " + text + ")";
  if (durative && effect.time == Effect::Time::kEnd) text = "(at end " + text + ")";
  if (!effect.condition.is_true())
    text = "(when " + (durative ? timed_text(printer, effect.condition) : printer.condition(effect.condition.start)) +
           " " + text + ")";
  if (!effect.variables.empty()) text = "(forall (" + printer.variables(effect.variables) + ") " + text + ")";
  return text;
}

std::string duration_text(const Printer& printer, const std::vector<DurationConstraint>& duration) {
  std::string text;
  for (const DurationConstraint& constraint : duration) {
    const char* verb = constraint.comparison == Comparison::kLessEqual      ? "<="
                       : constraint.comparison == Comparison::kGreaterEqual ? ">="
                                                                            : "=";
    std::string one = std::string("(") + verb + " ?duration " + printer.expression(constraint.bound) + ")";
    if (constraint.at_end) one = "(at end " + one + ")";
    text += (text.empty() ? "" : " ") + one;
  }
  return duration.size() == 1 ? text : "(and " + text + ")";
}

std::string action_text(const Domain& domain, const Action& action) {
  Printer printer(domain, domain.constants);
  printer.name_variables(action.parameters);
  std::string text = action.durative ? "  (:durative-action " : "  (:action ";
  text += action.name + "\n    :parameters (" + printer.variables(action.parameters) + ")\n";
  if (action.durative) {
    text += "    :duration " + duration_text(printer, action.duration) + "\n";
    text += "    :condition " + timed_text(printer, action.condition) + "\n";
  } else {
    text += "    :precondition " + printer.condition(action.condition.start) + "\n";
  }
  text += "    :effect (and";
  for (const Effect& effect : action.effects) text += "\n      " + effect_text(printer, effect, action.durative);
  return text + "))\n";
}

}  // namespace

std::string to_pddl(const Domain& domain) {
  const Printer printer(domain, domain.constants);
  std::string text = "(define (domain " + domain.name + ")\n";
  if (!domain.requirements.empty()) {
    text += "  (:requirements";
    for (const std::string& requirement : domain.requirements) text += " " + requirement;
    text += ")\n";
  }
  if (domain.types.size() > 1) {
    text += "  (:types";
    for (std::size_t i = 1; i < domain.types.size(); ++i) {
      const Type& type = domain.types[i];
      text += "\n    " + type.name + " - " + type_text(domain, type.parents);
    }
    text += ")\n";
  }
  if (!domain.constants.empty()) text += "  (:constants" + objects_text(domain, domain.constants, 0) + ")\n";
  text += "  (:predicates";
  for (const Predicate& predicate : domain.predicates)
    text += "\n    " + signature(printer, predicate.name, predicate.parameters);
  text += ")\n";
  if (!domain.functions.empty()) {
    text += "  (:functions";
    for (const Function& function : domain.functions)
      text += "\n    " + signature(printer, function.name, function.parameters) + " - number";
    text += ")\n";
  }
  for (const Derivation& rule : domain.derivations) {
    Printer names = printer;
    names.name_variables(rule.parameters);
    text += "  (:derived " + signature(names, domain.predicates[rule.predicate].name, rule.parameters) + "\n    " +
            names.condition(rule.condition) + ")\n";
  }
  for (const Action& action : domain.actions) text += action_text(domain, action);
  return text + ")\n";
}

std::string to_pddl(const Domain& domain, const Problem& problem) {
  const Printer printer(domain, problem.objects);
  std::string text = "(define (problem " + problem.name + ")\n  (:domain " + domain.name + ")\n  (:objects" +
                     more_types_text(domain, problem.objects) +
                     objects_text(domain, problem.objects, domain.constants.size()) + ")\n  (:init";
  for (const Fact& fact : problem.init) text += "\n    " + printer.fact(fact.predicate, fact.objects);
  const auto value_text = [&](const Assignment& value) {
    return "(= " + printer.function(value.function, value.objects) + " " + number_text(value.value) + ")";
  };
  for (const Assignment& value : problem.values) text += "\n    " + value_text(value);
  for (const TimedFact& later : problem.timed_facts) {
    const std::string fact = printer.fact(later.fact.predicate, later.fact.objects);
    text += "\n    (at " + number_text(later.time) + " " + (later.value ? fact : "(not " + fact + ")") + ")";
  }
  for (const TimedAssignment& later : problem.timed_values)
    text += "\n    (at " + number_text(later.time) + " " + value_text(later.assignment) + ")";
  text += ")\n  (:goal " + printer.condition(problem.goal) + ")\n";
  if (problem.metric)
    text += std::string("  (:metric ") + (problem.metric->maximize ? "maximize " : "minimize ") +
            printer.expression(problem.metric->value) + ")\n";
  return text + ")\n";
}

}  // namespace cxlab::planner
