#pragma once
// Choices of objects for the variables of a condition, an action or a rule: whether something can be so with any of
// them, and which of them come nearest.

#include <cstddef>
#include <set>
#include <utility>
#include <vector>

#include "planner/explain/reach.h"

namespace cxlab::planner {

/// By slot: the objects that it may be. Empty: not in use.
using Choices = ById<std::vector<ObjectId>>;

/// Something that an action or a rule asks for: a condition, or that a number has a value.
struct Demand {
  const Condition* condition = nullptr;
  bool wanted = true;
  const char* when = "";
  Expression value{};  ///< without a condition
};

std::vector<ObjectId> chosen(const Term& term, const Choices& choices);
std::vector<std::vector<ObjectId>> chosen(const std::vector<Term>& terms, const Choices& choices);
/// Slots of the choices that a number, a condition or a demand reads.
void note_slots(const Expression& expression, const Choices& choices, std::set<int>& slots);
std::set<int> slots_of(const Condition& condition, const Choices& choices);
std::set<int> slots_of(const Demand& demand, const Choices& choices);
/// The first object of each.
Frame frame_of(const Choices& choices);

class ChoiceJudge {
 public:
  /// Meaningless when the budget is over. Both outlive it.
  ChoiceJudge(const Reach& reach, Budget& budget) : reach_(reach), budget_(budget) {}

  /// Whether `holds()` is true for some choice of the slots from `next` on.
  template <class Holds>
  bool any_choice(const std::vector<int>& slots, std::size_t next, const Choices& choices, Frame& frame,
                  const Holds& holds) {
    budget_.spend(Work::kGround, 1);
    if (budget_.over()) return true;
    if (next == slots.size()) return holds();
    for (const ObjectId object : choices[slots[next]]) {
      frame[slots[next]] = object;
      if (any_choice(slots, next + 1, choices, frame, holds)) return true;
    }
    return false;
  }
  template <class Holds>
  bool any(const std::set<int>& slots, const Choices& choices, const Holds& holds) {
    Frame frame(choices.size(), -1);
    return any_choice({slots.begin(), slots.end()}, 0, choices, frame, [&] { return holds(frame); });
  }

  /// Whether it is `wanted` with none of the choices.
  bool is_impossible(const Condition& condition, bool wanted, const Choices& choices);
  bool is_impossible(const Demand& demand, const Choices& choices);
  bool is_met(const Demand& demand, Frame& frame) const;
  /// Whether no action can change it, but it is so for others: such a demand says which arguments are meant.
  bool is_fixed_relation(const Demand& demand) const;
  /// The choice that leaves the fewest demands open: first of those that nothing can change, then of all.
  std::pair<Choices, std::pair<int, int>> nearest_choice(const std::vector<Demand>& demands, const Choices& choices);

 private:
  const Reach& reach_;
  Budget& budget_;
};

}  // namespace cxlab::planner
