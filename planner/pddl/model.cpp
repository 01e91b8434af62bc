#include "planner/pddl/model.h"

#include <utility>

namespace cxlab::planner {

bool fits(const Domain& domain, const Object& object, const std::vector<TypeId>& types) {
  for (const TypeId own : object.types)
    for (const TypeId wanted : types)
      if (domain.is_a(own, wanted)) return true;
  return false;
}

std::vector<ObjectId> objects_of(const Domain& domain, const Problem& problem, const std::vector<TypeId>& types) {
  std::vector<ObjectId> found;
  for (std::size_t i = 0; i < problem.objects.size(); ++i)
    if (fits(domain, problem.objects[i], types)) found.push_back(static_cast<ObjectId>(i));
  return found;
}

int find(const NameTable& table, std::string_view name) {
  const auto entry = table.find(std::string(name));
  return entry == table.end() ? -1 : entry->second;
}

Symbols changing(const Domain& domain, const Problem& problem) {
  Symbols found{ById<char>(domain.predicates.size(), 0), ById<char>(domain.functions.size(), 0)};
  for (const Action& action : domain.actions)
    for (const Effect& effect : action.effects)
      (effect.is_numeric() ? found.functions[effect.function] : found.predicates[effect.predicate]) = 1;
  for (const TimedFact& timed : problem.timed_facts) found.predicates[timed.fact.predicate] = 1;
  for (const TimedAssignment& timed : problem.timed_values) found.functions[timed.assignment.function] = 1;
  return found;
}

ById<Symbols> bases_of_derived(const Domain& domain) {
  ById<Symbols> found;
  for (std::size_t derived = 0; derived < domain.predicates.size(); ++derived) {
    Symbols& bases =
        found.emplace_back(Symbols{ById<char>(domain.predicates.size(), 0), ById<char>(domain.functions.size(), 0)});
    std::vector<PredicateId> open = {static_cast<PredicateId>(derived)};
    ById<char> seen(domain.predicates.size(), 0);
    while (!open.empty()) {
      const PredicateId head = open.back();
      open.pop_back();
      for (const Derivation& rule : domain.derivations) {
        if (rule.predicate != head) continue;
        for_each_part(rule.condition, [&](const Condition& part, bool) {
          for (const Expression& side : part.sides)
            for_each_part(side, [&](const Expression& read) {
              if (read.kind == Expression::Kind::kFunction) bases.functions[read.function] = 1;
            });
          if (part.kind != Condition::Kind::kAtom) return;
          if (!domain.predicates[part.predicate].derived)
            bases.predicates[part.predicate] = 1;
          else if (std::exchange(seen[part.predicate], 1) == 0)
            open.push_back(part.predicate);
        });
      }
    }
  }
  return found;
}

}  // namespace cxlab::planner
