// Why a plan is wrong, and how to correct it.

#include <algorithm>
#include <ranges>

#include "planner/pddl/text.h"
#include "planner/validator/execution.h"

namespace cxlab::planner {
namespace {

std::string at_time(double seconds) { return " at " + time_text(seconds); }

/// The atom of a literal, and whether it is wanted true.
const Condition* literal_atom(const Condition& condition, bool& wanted) {
  wanted = condition.kind != Condition::Kind::kNot;
  const Condition& inner = wanted ? condition : condition.operands[0];
  return inner.kind == Condition::Kind::kAtom ? &inner : nullptr;
}

/// The names of the actions with such an effect.
template <class Wanted>
std::string actions_with(const Domain& domain, Wanted wanted) {
  std::string names;
  for (const Action& action : domain.actions)
    if (std::ranges::any_of(action.effects, wanted)) names += (names.empty() ? "" : ", ") + action.name;
  return names;
}

}  // namespace

bool Execution::fail(Violation violation) {
  verdict_.violation = std::move(violation);
  return false;
}

std::string Execution::describe_step(int step) const {
  std::string text = time_text(plan_[step].start) + ": " + step_text(plan_[step], domain_, problem_);
  if (plan_[step].line > 0) text += " (line " + std::to_string(plan_[step].line) + ")";
  return text;
}

std::string Execution::describe(const Happening& happening) const {
  switch (happening.kind) {
    case Happening::Kind::kOutside: return "the initial state's event at " + time_text(to_seconds(happening.time));
    case Happening::Kind::kStart: return "the start of " + describe_step(happening.step);
    case Happening::Kind::kEnd:
      return "the end" + at_time(to_seconds(happening.time)) + " of " + describe_step(happening.step);
    case Happening::Kind::kInstant: return describe_step(happening.step);
  }
  return {};
}

/// The smallest part of a condition that does not hold and explains why; `frame` is then bound to its objects.
const Condition& Execution::failing_part(const Condition& condition, Frame& frame, double duration) const {
  using Kind = Condition::Kind;
  if (condition.kind == Kind::kAnd)
    for (const Condition& operand : condition.operands)
      if (!evaluator_.holds(operand, frame, state_, duration)) return failing_part(operand, frame, duration);
  if (condition.kind == Kind::kImply) return failing_part(condition.operands[1], frame, duration);
  if (condition.kind != Kind::kForall) return condition;
  Frame broken;
  evaluator_.each_binding(condition.variables, frame, [&] {
    broken = frame;
    return evaluator_.holds(condition.operands[0], frame, state_, duration);
  });
  frame = broken;
  return failing_part(condition.operands[0], frame, duration);
}

bool Execution::fail_condition(int step, const Condition& condition, const char* when, double time) {
  Violation violation{Violation::Kind::kCondition, time, step};
  violation.when = when;
  Frame frame = running_[step].frame;
  const double duration = duration_of_step(step);
  const Condition& part = failing_part(condition, frame, duration);
  violation.message = describe_step(step) + ": a condition" + (*when == 0 ? "" : " " + violation.when) +
                      " does not hold" + at_time(time);
  explain(part, frame, violation, duration);
  state_.look_ahead(0);
  return fail(std::move(violation));
}

bool Execution::fail_effect(int step, const Effect& effect, double time) {
  Violation violation{Violation::Kind::kEffect, time, step};
  Printer printer(domain_, problem_.objects);
  printer.name_objects(plan_[step].arguments);
  printer.name_variables(effect.variables);
  violation.condition = printer.effect(effect);
  violation.message = describe_step(step) + ": the effect " + violation.condition + at_time(time) +
                      " has no value: it reads or changes a number that is undefined, or divides by 0";
  violation.advice = "give the number a value in :init of " + problem_.file;
  return fail(std::move(violation));
}

bool Execution::fail_interference(const Happening& earlier, const Happening& later, const std::string& what) {
  Violation violation{Violation::Kind::kInterference, to_seconds(later.time)};
  violation.step = later.step >= 0 ? later.step : earlier.step;
  violation.other_step = later.step >= 0 ? earlier.step : -1;
  violation.condition = what;
  const double gap = to_seconds(later.time - earlier.time);
  violation.message = describe(earlier) + " and " + describe(later) + " both use " + what +
                      " and one of them changes it; they are " +
                      (gap == 0 ? "at the same time" : time_text(gap) + " s apart") + ", expected at least " +
                      time_text(options_.epsilon) + " s";
  violation.advice =
      "move one of them by " + number_text(std::max(options_.epsilon - gap, options_.epsilon / 1000)) + " s";
  return fail(std::move(violation));
}

void Execution::explain(const Condition& part, const Frame& frame, Violation& violation, double duration) const {
  Printer printer(domain_, problem_.objects);
  printer.name_objects(frame);
  violation.condition = printer.condition(part);
  violation.message += ": " + violation.condition;
  bool wanted = true;
  if (const Condition* atom = literal_atom(part, wanted)) {
    explain_fact(*atom, frame, wanted, violation);
  } else if (part.kind == Condition::Kind::kCompare) {
    explain_numbers(part, frame, violation, duration);
  }
}

void Execution::explain_numbers(const Condition& part, const Frame& frame, Violation& violation,
                                double duration) const {
  std::string values;
  for (const Expression& side : part.sides) {
    const auto value = evaluator_.number(side, frame, state_, duration);
    values += (values.empty() ? "" : " and ") + (value ? number_text(*value) : std::string("without value"));
  }
  violation.message += "; its sides are " + values;
  std::string changers;
  std::vector<const Expression*> open = {&part.sides[0], &part.sides[1]};
  std::vector<FunctionId> seen;
  while (!open.empty()) {
    const Expression& next = *open.back();
    open.pop_back();
    for (const Expression& operand : next.operands) open.push_back(&operand);
    if (next.kind != Expression::Kind::kFunction || std::ranges::find(seen, next.function) != seen.end()) continue;
    seen.push_back(next.function);
    const std::string names = actions_with(
        domain_, [&](const Effect& effect) { return effect.is_numeric() && effect.function == next.function; });
    changers += (changers.empty() || names.empty() ? "" : ", ") + names;
  }
  violation.advice = changers.empty() ? "no action changes these numbers: see :init of " + problem_.file
                                      : "the numbers are changed by " + changers + ": move or add such a step";
}

/// The next happening that gives a fact this value.
std::optional<Happening> Execution::next_change(const Fact& fact, Effect::Kind makes) const {
  for (const Happening& happening : happenings_ | std::views::drop(current_)) {
    if (happening.kind == Happening::Kind::kOutside) continue;
    const auto time = happening.kind == Happening::Kind::kEnd ? Effect::Time::kEnd : Effect::Time::kStart;
    Frame frame = running_[happening.step].frame;
    for (const Effect& effect : action_of(happening.step).effects) {
      if (effect.time != time || effect.predicate != fact.predicate || effect.kind != makes) continue;
      const bool none = evaluator_.each_binding(
          effect.variables, frame, [&] { return !std::ranges::equal(Objects(effect.terms, frame), fact.objects); });
      if (!none) return happening;
    }
  }
  for (const TimedFact& later : problem_.timed_facts)
    if (later.value == (makes == Effect::Kind::kAdd) && later.fact == fact &&
        (current_ >= happenings_.size() || later.time >= to_seconds(happenings_[current_].time)))
      return Happening{to_nanos(later.time), Happening::Kind::kOutside};
  return std::nullopt;
}

void Execution::explain_fact(const Condition& atom, const Frame& frame, bool wanted, Violation& violation) const {
  const Objects objects(atom.terms, frame);
  const Fact fact{atom.predicate, {objects.begin(), objects.end()}};
  const Predicate& predicate = domain_.predicates[fact.predicate];
  if (predicate.derived) {
    violation.message += "; " + predicate.name + " is derived by a rule";
    return;
  }
  const Happening* spoiler = nullptr;
  for (const Record& record : records_)
    for (const Change& change : record.changes())
      if (change.kind == (wanted ? Effect::Kind::kDelete : Effect::Kind::kAdd) && change.id == fact.predicate &&
          change.objects == fact.objects)
        spoiler = &record.happening;
  const std::string text = ground_text(predicate.name, fact.objects, problem_.objects);
  const std::string other = wanted ? "false" : "true";
  violation.message += spoiler == nullptr ? "; " + text + " has been " + other + " from the beginning"
                                          : "; " + text + " was made " + other + " by " + describe(*spoiler);
  violation.advice =
      validator_.fluents().predicates[fact.predicate]
          ? advice_for_fact(fact, text, wanted, spoiler, violation)
          : "no action changes " + predicate.name + ": choose other arguments, or fix :init of " + problem_.file;
}

std::string Execution::advice_for_fact(const Fact& fact, const std::string& text, bool wanted, const Happening* spoiler,
                                       const Violation& violation) const {
  const bool over_all = violation.when == "over all", goal = violation.kind == Violation::Kind::kGoal;
  // Broken on the way by another: that one may wait.
  const bool on_the_way = over_all && spoiler != nullptr && spoiler->step != violation.step &&
                          to_seconds(spoiler->time) > plan_[violation.step].start;
  if (on_the_way && spoiler->kind == Happening::Kind::kOutside)
    return "let " + describe_step(violation.step) + " end at " + time_text(to_seconds(spoiler->time)) + " or before";
  if (on_the_way)
    return "let " + describe(*spoiler) + " wait until " + time_text(to_seconds(ends_[violation.step])) + ", when " +
           describe_step(violation.step) + " has ended";
  const Effect::Kind makes = wanted ? Effect::Kind::kAdd : Effect::Kind::kDelete;
  const std::string value = wanted ? "true" : "false";
  if (const auto later = next_change(fact, makes); later && later->step != violation.step) {
    const std::string cause = describe(*later) + " makes " + text + " " + value;
    if (goal) return "wait for it: " + cause;
    const char* verb = violation.when == "at end" ? " end at " : " begin at ";
    return "let " + describe_step(violation.step) + verb + time_text(to_seconds(later->time) + options_.epsilon) +
           " or later: " + cause;
  }
  const std::string names = actions_with(
      domain_, [&](const Effect& effect) { return effect.predicate == fact.predicate && effect.kind == makes; });
  if (names.empty()) return "no action makes it " + value;
  const bool undone = goal && spoiler != nullptr && spoiler->kind == Happening::Kind::kOutside;
  return "add a step " +
         (undone ? "after " + time_text(to_seconds(spoiler->time)) : "before " + time_text(violation.time)) +
         " that makes it " + value + ": " + names;
}

}  // namespace cxlab::planner
