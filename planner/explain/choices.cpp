#include "planner/explain/choices.h"

#include <algorithm>
#include <limits>

namespace cxlab::planner {

std::vector<ObjectId> chosen(const Term& term, const Choices& choices) {
  if (term.is_variable) return choices[term.index];
  return {term.index};
}

std::vector<std::vector<ObjectId>> chosen(const std::vector<Term>& terms, const Choices& choices) {
  std::vector<std::vector<ObjectId>> out;
  for (const Term& term : terms) out.push_back(chosen(term, choices));
  return out;
}

namespace {

/// Slots of the choices that a condition or a number reads.
template <class Part>
void note_terms(const Part& part, const Choices& choices, std::set<int>& slots) {
  for (const Term& term : part.terms)
    if (term.is_variable && !choices[term.index].empty()) slots.insert(term.index);
}

}  // namespace

void note_slots(const Expression& expression, const Choices& choices, std::set<int>& slots) {
  for_each_part(expression, [&](const Expression& part) { note_terms(part, choices, slots); });
}

std::set<int> slots_of(const Condition& condition, const Choices& choices) {
  std::set<int> slots;
  for_each_part(condition, [&](const Condition& part, bool) {
    note_terms(part, choices, slots);
    for (const Expression& side : part.sides) note_slots(side, choices, slots);
  });
  return slots;
}

std::set<int> slots_of(const Demand& demand, const Choices& choices) {
  if (demand.condition) return slots_of(*demand.condition, choices);
  std::set<int> slots;
  note_slots(demand.value, choices, slots);
  return slots;
}

Frame frame_of(const Choices& choices) {
  Frame frame(choices.size(), -1);
  for (std::size_t slot = 0; slot < choices.size(); ++slot)
    if (!choices[slot].empty()) frame[slot] = choices[slot][0];
  return frame;
}

bool ChoiceJudge::is_impossible(const Condition& condition, bool wanted, const Choices& choices) {
  if (condition.kind == Condition::Kind::kAtom && wanted) {
    const auto objects = chosen(condition.terms, choices);
    const std::set<int> slots = slots_of(condition, choices);
    if (std::ssize(slots) == std::ranges::count_if(condition.terms, &Term::is_variable)) {  // no variable stands twice
      budget_.spend(Work::kGround, 1 + std::ssize(reach_.atoms_of(condition.predicate)) / 8);
      return std::ranges::none_of(reach_.atoms_of(condition.predicate), [&](int atom) {
        const auto found = reach_.atoms().objects(atom);
        for (std::size_t i = 0; i < objects.size(); ++i)
          if (std::ranges::find(objects[i], found[i]) == objects[i].end()) return false;
        return reach_.can_be(condition.predicate, found, true);
      });
    }
  }
  return !any(slots_of(condition, choices), choices,
              [&](Frame& frame) { return reach_.can_hold(condition, frame, wanted); });
}

bool ChoiceJudge::is_met(const Demand& demand, Frame& frame) const {
  return demand.condition ? reach_.can_hold(*demand.condition, frame, demand.wanted)
                          : reach_.range(demand.value, frame).has_value();
}

bool ChoiceJudge::is_impossible(const Demand& demand, const Choices& choices) {
  if (demand.condition) return is_impossible(*demand.condition, demand.wanted, choices);
  return !any(slots_of(demand, choices), choices, [&](Frame& frame) { return is_met(demand, frame); });
}

bool ChoiceJudge::is_fixed_relation(const Demand& demand) const {
  if (!demand.condition) return false;
  if (demand.condition->kind == Condition::Kind::kSame) return true;
  return demand.condition->kind == Condition::Kind::kAtom && reach_.is_static(demand.condition->predicate) &&
         !reach_.atoms_of(demand.condition->predicate).empty();
}

std::pair<Choices, std::pair<int, int>> ChoiceJudge::nearest_choice(const std::vector<Demand>& demands,
                                                                    const Choices& choices) {
  std::vector<int> slots;
  for (std::size_t slot = 0; slot < choices.size(); ++slot)
    if (!choices[slot].empty()) slots.push_back(static_cast<int>(slot));
  std::vector<std::vector<const Demand*>> decided(slots.size() + 1);  // by the number of slots that are bound
  for (const Demand& demand : demands) {
    const std::set<int> used = slots_of(demand, choices);
    const auto last = used.empty() ? slots.begin() : std::ranges::find(slots, *used.rbegin()) + 1;
    decided[static_cast<std::size_t>(last - slots.begin())].push_back(&demand);
  }
  constexpr int kMany = std::numeric_limits<int>::max();
  std::pair<int, int> least{kMany, kMany};
  Frame frame(choices.size(), -1), nearest = frame_of(choices);
  const auto visit = [&](const auto& self, std::size_t bound, std::pair<int, int> open) -> void {
    budget_.spend(Work::kGround, 1 + std::ssize(decided[bound]));
    for (const Demand* demand : decided[bound])
      if (!is_met(*demand, frame)) {
        open.first += is_fixed_relation(*demand);
        ++open.second;
      }
    if (open >= least || budget_.over()) return;
    if (bound == slots.size()) {
      least = open;
      nearest = frame;
      return;
    }
    for (const ObjectId object : choices[slots[bound]]) {
      frame[slots[bound]] = object;
      self(self, bound + 1, open);
    }
  };
  visit(visit, 0, {0, 0});
  Choices out(choices.size());
  for (const int slot : slots) out[slot] = {nearest[slot]};
  return {std::move(out), least};
}

}  // namespace cxlab::planner
