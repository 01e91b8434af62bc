#include "planner/ground/passes.h"

#include <tuple>

namespace cxlab::planner {

namespace {

void add(const ById<char>& more, ById<char>& to) {
  to.resize(more.size(), 0);
  for (std::size_t i = 0; i < more.size(); ++i) to[i] |= more[i];
}

}  // namespace

ById<SchemaReads> find_derived_reads(const Domain& domain) {
  ById<SchemaReads> found;
  if (domain.derivations.empty()) return found;
  const ById<Symbols> bases = bases_of_derived(domain);
  for (const Action& action : domain.actions) {
    SchemaReads& reads = found.emplace_back();
    const auto look_at = [&](const TimedCondition& condition) {
      for (const auto& [part, to] : {std::pair{&condition.start, &reads.start},
                                     {&condition.over_all, &reads.over_all},
                                     {&condition.end, &reads.end}})
        for_each_part(*part, [&, &into = *to](const Condition& each, bool) {
          if (each.kind != Condition::Kind::kAtom || !domain.predicates[each.predicate].derived) return;
          add(bases[each.predicate].predicates, into.predicates);
          add(bases[each.predicate].functions, into.functions);
        });
    };
    look_at(action.condition);
    for (const Effect& effect : action.effects) look_at(effect.condition);
  }
  return found;
}

}  // namespace cxlab::planner
