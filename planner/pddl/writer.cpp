// Domains and problems as PDDL files.

#include <span>
#include <utility>

#include "planner/pddl/text.h"

namespace cxlab::planner {
namespace {

/// Objects with the types that `known` does not give them. One of several types is declared with each.
std::string objects_text(const Domain& domain, const ById<Object>& objects, const ById<Object>& known) {
  std::string text;
  for (std::size_t i = 0; i < objects.size(); ++i)
    for (std::size_t k = i < known.size() ? known[i].types.size() : 0; k < objects[i].types.size(); ++k)
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
  const auto one = [&](const DurationConstraint& constraint) {
    const std::string text = "(" + text_of(kComparisonWords, constraint.comparison) + " ?duration " +
                             printer.expression(constraint.bound) + ")";
    return constraint.at_end ? "(at end " + text + ")" : text;
  };
  return duration.size() == 1 ? one(duration[0]) : list_text("and", duration, one);
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
  const auto effect = [&](const Effect& each) { return effect_text(printer, each, action.durative); };
  return text + "    :effect " + list_text("and", action.effects, effect, "\n      ") + ")\n";
}

}  // namespace

std::string to_pddl(const Domain& domain) {
  const Printer printer(domain, domain.constants);
  const auto name = [](const std::string& requirement) { return requirement; };
  const auto type = [&](const Type& each) { return each.name + " - " + types_text(domain, each.parents); };
  const auto predicate = [&](const Predicate& each) { return signature(printer, each.name, each.parameters); };
  const auto function = [&](const Function& each) {
    return signature(printer, each.name, each.parameters) + " - number";
  };
  std::string text = "(define (domain " + domain.name + ")\n";
  const auto add = [&](const char* head, const auto& items, auto text_of, const char* before = "\n    ") {
    if (!items.empty()) text += "  " + list_text(head, items, text_of, before) + "\n";
  };
  add(":requirements", domain.requirements, name, " ");
  add(":types", std::span(domain.types).subspan(1), type);
  if (!domain.constants.empty()) text += "  (:constants" + objects_text(domain, domain.constants, {}) + ")\n";
  text += "  " + list_text(":predicates", domain.predicates, predicate, "\n    ") + "\n";
  add(":functions", domain.functions, function);
  for (const Derivation& rule : domain.derivations) {
    Printer names = printer;
    names.name_variables(rule.parameters);
    text += "  (:derived " + signature(names, domain.predicates[rule.predicate].name, rule.parameters) + "\n    " +
            names.condition(rule.condition) + ")\n";
  }
  add(":timeless", domain.timeless, [&](const Fact& fact) {
    return ground_text(domain.predicates[fact.predicate].name, fact.objects, domain.constants);
  });
  for (const Action& action : domain.actions) text += action_text(domain, action);
  return text + ")\n";
}

std::string to_pddl(const Domain& domain, const Problem& problem) {
  const Printer printer(domain, problem.objects);
  std::string text = "(define (problem " + problem.name + ")\n  (:domain " + domain.name + ")\n  (:objects" +
                     objects_text(domain, problem.objects, domain.constants) + ")\n  (:init";
  const auto fact_text = [&](const Fact& fact) {
    return ground_text(domain.predicates[fact.predicate].name, fact.objects, problem.objects);
  };
  for (const Fact& fact : problem.init) text += "\n    " + fact_text(fact);
  const auto value_text = [&](const Assignment& value) {
    return "(= " + ground_text(domain.functions[value.function].name, value.objects, problem.objects) + " " +
           number_text(value.value) + ")";
  };
  for (const Assignment& value : problem.values) text += "\n    " + value_text(value);
  for (const TimedFact& later : problem.timed_facts) {
    const std::string fact = fact_text(later.fact);
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
