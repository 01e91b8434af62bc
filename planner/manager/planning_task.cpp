// The problem that a planner receives: the present state, reduced by the filters of a goal.

#include <algorithm>
#include <functional>

#include "planner/manager/instance.h"

namespace cxlab::planner {
namespace {

bool listed(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

void keep_actions(Domain& domain, const std::vector<std::string>& names) {
  if (names.empty()) return;
  std::erase_if(domain.actions, [&](const Action& action) { return !listed(names, action.name); });
  domain.action_names.clear();
  for (std::size_t i = 0; i < domain.actions.size(); ++i)
    domain.action_names[domain.actions[i].name] = static_cast<int>(i);
}

Condition goal_condition(const std::vector<Fact>& facts, const std::vector<Assignment>& values) {
  const auto terms = [](const std::vector<ObjectId>& objects) {
    std::vector<Term> out;
    for (const ObjectId object : objects) out.push_back(Term::object(object));
    return out;
  };
  Condition all;
  for (const Fact& fact : facts) {
    Condition& atom = all.operands.emplace_back();
    atom.kind = Condition::Kind::kAtom;
    atom.predicate = fact.predicate;
    atom.terms = terms(fact.objects);
  }
  for (const Assignment& value : values) {
    Condition& equal = all.operands.emplace_back();
    equal.kind = Condition::Kind::kCompare;
    equal.sides = {{Expression::Kind::kFunction, 0, value.function, terms(value.objects), {}},
                   Expression::constant(value.value)};
  }
  return all;
}

/// The metric may read numbers of objects that the planner does not see.
bool renumber(Expression& expression, const ById<ObjectId>& to) {
  for (Term& term : expression.terms) {
    if (!term.is_variable) term.index = to[term.index];
    if (term.index < 0) return false;
  }
  return std::ranges::all_of(expression.operands, [&](Expression& part) { return renumber(part, to); });
}

}  // namespace

Problem without_objects(const Problem& problem, const std::vector<char>& keep) {
  Problem out;
  out.name = problem.name;
  out.file = problem.file;
  ById<ObjectId> to(problem.objects.size(), -1);
  for (std::size_t i = 0; i < problem.objects.size(); ++i) {
    if (!keep[i]) continue;
    to[i] = static_cast<ObjectId>(out.objects.size());
    out.objects.push_back(problem.objects[i]);
  }
  for (const auto& [name, id] : problem.object_names)
    if (to[id] >= 0) out.object_names[name] = to[id];
  const auto copy = [&](const auto& from, auto& into, auto objects_of) {
    for (auto item : from) {
      std::vector<ObjectId>& objects = std::invoke(objects_of, item);
      for (ObjectId& object : objects) object = to[object];
      if (std::ranges::find(objects, -1) == objects.end()) into.push_back(std::move(item));
    }
  };
  copy(problem.init, out.init, &Fact::objects);
  copy(problem.values, out.values, &Assignment::objects);
  copy(problem.timed_facts, out.timed_facts, [](TimedFact& f) -> auto& { return f.fact.objects; });
  copy(problem.timed_values, out.timed_values, [](TimedAssignment& v) -> auto& { return v.assignment.objects; });
  out.metric = problem.metric;
  if (out.metric && !renumber(out.metric->value, to)) out.metric.reset();
  return out;
}

std::pair<std::vector<Fact>, std::vector<Assignment>> goals_without(const Problem& problem, const GoalInstance& goal,
                                                                    const std::vector<char>& keep) {
  Problem carrier;  // its numbers of objects move as those of the problem do
  carrier.objects = problem.objects;
  carrier.init = goal.facts;
  carrier.values = goal.values;
  carrier = without_objects(carrier, keep);
  return {std::move(carrier.init), std::move(carrier.values)};
}

Expected<Task> Instance::planning_task(const GoalInstance& goal, double seconds) const {
  Task task{domain(), problem()};
  keep_actions(task.domain, goal.actions);
  Problem& p = task.problem;
  const auto seen = [&](const std::string& name) { return goal.fluents.empty() || listed(goal.fluents, name); };
  p.init.clear();
  for (Fact& fact : state_.facts()) {
    const Predicate& predicate = domain().predicates[fact.predicate];
    if (!predicate.derived && seen(predicate.name)) p.init.push_back(std::move(fact));
  }
  p.values.clear();
  for (Assignment& value : state_.values())
    if (seen(domain().functions[value.function].name)) p.values.push_back(std::move(value));
  // Events are counted from now on; those that came are part of the state.
  std::erase_if(p.timed_facts, [&](const TimedFact& f) { return f.time <= seconds; });
  std::erase_if(p.timed_values, [&](const TimedAssignment& v) { return v.time <= seconds; });
  for (TimedFact& f : p.timed_facts) f.time -= seconds;
  for (TimedAssignment& v : p.timed_values) v.time -= seconds;

  if (!goal.objects.empty()) {
    std::vector<char> keep(p.objects.size(), 1);
    for (std::size_t i = domain().constants.size(); i < keep.size(); ++i)
      keep[i] = listed(goal.objects, p.objects[i].name);
    const auto [facts, values] = goals_without(p, goal, keep);
    if (facts.size() + values.size() != goal.facts.size() + goal.values.size())
      return input_error("the goal names an object that the object filter leaves out");
    p = without_objects(p, keep);
    p.goal = goal_condition(facts, values);
  } else {
    p.goal = goal_condition(goal.facts, goal.values);
  }
  return task;
}

}  // namespace cxlab::planner
