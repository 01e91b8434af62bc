// The problem that a planner gets: what is so now, as far as the filters of a goal let it through.

#include <algorithm>

#include "planner/manager/instance.h"

namespace cxlab::planner {
namespace {

bool listed(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

void keep_actions(Domain& domain, const std::vector<std::string>& names) {
  if (names.empty()) return;
  std::erase_if(domain.actions, [&](const Action& action) { return !listed(names, action.name); });
  domain.action_names.clear();
  for (std::size_t i = 0; i < domain.actions.size(); ++i)
    domain.action_names[domain.actions[i].name] = static_cast<int>(i);
}

Condition goal_condition(const GoalInstance& goal) {
  const auto terms = [](const std::vector<ObjectId>& objects) {
    std::vector<Term> out;
    for (const ObjectId object : objects) out.push_back(Term::object(object));
    return out;
  };
  Condition all;
  for (const Fact& fact : goal.facts) {
    Condition atom;
    atom.kind = Condition::Kind::kAtom;
    atom.predicate = fact.predicate;
    atom.terms = terms(fact.objects);
    all.operands.push_back(std::move(atom));
  }
  for (const Assignment& value : goal.values) {
    Expression number;
    number.kind = Expression::Kind::kFunction;
    number.function = value.function;
    number.terms = terms(value.objects);
    Condition equal;
    equal.kind = Condition::Kind::kCompare;
    equal.sides = {std::move(number), Expression::constant(value.value)};
    all.operands.push_back(std::move(equal));
  }
  return all;
}

/// The metric may read numbers of objects that the planner does not see.
bool renumber(Expression& expression, const std::vector<ObjectId>& to) {
  for (Term& term : expression.terms) {
    if (!term.is_variable) term.index = to[static_cast<std::size_t>(term.index)];
    if (term.index < 0) return false;
  }
  return std::all_of(expression.operands.begin(), expression.operands.end(),
                     [&](Expression& part) { return renumber(part, to); });
}

}  // namespace

Problem without_objects(const Problem& problem, const std::vector<char>& keep) {
  Problem out;
  out.name = problem.name;
  out.file = problem.file;
  std::vector<ObjectId> to(problem.objects.size(), -1);
  for (std::size_t i = 0; i < problem.objects.size(); ++i) {
    if (!keep[i]) continue;
    to[i] = static_cast<ObjectId>(out.objects.size());
    out.objects.push_back(problem.objects[i]);
  }
  for (const auto& [name, id] : problem.object_names)
    if (keep[static_cast<std::size_t>(id)]) out.object_names[name] = to[static_cast<std::size_t>(id)];
  const auto moved = [&](std::vector<ObjectId> objects, auto add) {
    for (ObjectId& object : objects)
      if ((object = to[static_cast<std::size_t>(object)]) < 0) return;
    add(std::move(objects));
  };
  for (const Fact& f : problem.init) moved(f.objects, [&](auto o) { out.init.push_back({f.predicate, std::move(o)}); });
  for (const Assignment& v : problem.values)
    moved(v.objects, [&](auto o) { out.values.push_back({v.function, std::move(o), v.value}); });
  for (const TimedFact& f : problem.timed_facts)
    moved(f.fact.objects,
          [&](auto o) { out.timed_facts.push_back({f.time, {f.fact.predicate, std::move(o)}, f.value, f.source}); });
  for (const TimedAssignment& v : problem.timed_values)
    moved(v.assignment.objects, [&](auto o) {
      out.timed_values.push_back({v.time, {v.assignment.function, std::move(o), v.assignment.value}, v.source});
    });
  out.metric = problem.metric;
  if (out.metric && !renumber(out.metric->value, to)) out.metric.reset();
  return out;
}

Expected<Task> Instance::planning_task(const GoalInstance& goal, double seconds) const {
  Task task{domain(), problem()};
  keep_actions(task.domain, goal.actions);
  Problem& p = task.problem;
  const auto seen = [&](const std::string& name) { return goal.fluents.empty() || listed(goal.fluents, name); };
  p.init.clear();
  for (Fact& fact : state_.facts()) {
    const Predicate& predicate = domain().predicates[static_cast<std::size_t>(fact.predicate)];
    if (!predicate.derived && seen(predicate.name)) p.init.push_back(std::move(fact));
  }
  p.values.clear();
  for (Assignment& value : state_.values())
    if (seen(domain().functions[static_cast<std::size_t>(value.function)].name)) p.values.push_back(std::move(value));
  // Events are counted from now on; those that came are part of the state.
  std::erase_if(p.timed_facts, [&](const TimedFact& f) { return f.time <= seconds; });
  std::erase_if(p.timed_values, [&](const TimedAssignment& v) { return v.time <= seconds; });
  for (TimedFact& f : p.timed_facts) f.time -= seconds;
  for (TimedAssignment& v : p.timed_values) v.time -= seconds;

  if (!goal.objects.empty()) {
    std::vector<char> keep(p.objects.size(), 1);
    for (std::size_t i = domain().constants.size(); i < keep.size(); ++i)
      keep[i] = listed(goal.objects, p.objects[i].name);
    Problem carrier;  // the goal's numbers of objects move as those of the problem do
    carrier.objects = p.objects;
    carrier.init = goal.facts;
    carrier.values = goal.values;
    carrier = without_objects(carrier, keep);
    if (carrier.init.size() + carrier.values.size() != goal.facts.size() + goal.values.size())
      return input_error("the goal names an object that the object filter leaves out");
    p = without_objects(p, keep);
    GoalInstance moved;
    moved.facts = std::move(carrier.init);
    moved.values = std::move(carrier.values);
    p.goal = goal_condition(moved);
  } else {
    p.goal = goal_condition(goal);
  }
  return task;
}

}  // namespace cxlab::planner
