#include "planner/ground/idle.h"

#include <algorithm>
#include <cmath>

#include "planner/ground/reachable.h"
#include "planner/ground/sorted.h"

namespace cxlab::planner {

namespace {

using Of = IdleTouch::Of;

class IdleFinder {
 public:
  IdleFinder(const Task& task, GroundTask& ground, Budget& budget) : task_(task), ground_(ground), budget_(budget) {
    find_changing();
    for (const bool complements : {false, true})
      for (std::size_t f = 0; f < ground.facts.size(); ++f) {
        const GroundFact& fact = ground.facts[f];
        if (fact.predicate >= 0 && !fact.derived && fact.is_complement == complements)
          enter(facts_, fact_ids_, fact.predicate, fact.objects, static_cast<int>(f));
      }
    for (std::size_t n = 0; n < ground.numbers.size(); ++n)
      enter(numbers_, number_ids_, ground.numbers[n].function, ground.numbers[n].objects, static_cast<int>(n));
  }

  void run() {
    for (GroundAction& action : ground_.actions) {
      budget_.spend(Work::kGround, 1);
      if (budget_.over()) return;
      look_at(action);
    }
    for (TimedEvent& event : ground_.events) {
      budget_.spend(Work::kGround,
                    static_cast<std::int64_t>(task_.problem.timed_facts.size() + task_.problem.timed_values.size()));
      if (budget_.over()) return;
      look_at(event);
    }
    drop_harmless();
  }

 private:
  /// How the whole task uses a fact or number that is not in it.
  struct Other {
    bool read = false, up = false, down = false;
    bool harmful() const { return (read && (up || down)) || (up && down); }
  };

  static void enter(AtomTable& table, ById<int>& ids, int id, const std::vector<ObjectId>& objects, int index) {
    if (table.insert(id, objects) == static_cast<int>(ids.size())) ids.push_back(index);
  }

  void find_changing() {
    changing_predicates_.assign(task_.domain.predicates.size(), 0);
    changing_functions_.assign(task_.domain.functions.size(), 0);
    for (const Action& action : task_.domain.actions)
      for (const Effect& effect : action.effects)
        (effect.is_numeric() ? changing_functions_[effect.function] : changing_predicates_[effect.predicate]) = 1;
    for (const TimedFact& timed : task_.problem.timed_facts) changing_predicates_[timed.fact.predicate] = 1;
    for (const TimedAssignment& timed : task_.problem.timed_values) changing_functions_[timed.assignment.function] = 1;
  }

  void look_at(GroundAction& action) {
    const Action& schema = task_.domain.actions[action.schema];
    frame_.assign(static_cast<std::size_t>(schema.slots), -1);
    std::ranges::copy(action.arguments, frame_.begin());
    out_ = &action.idle;
    at_end_ = false;
    read(schema.condition.start, action.start);
    at_end_ = true;
    read(schema.condition.end, action.end);
    for (const Effect& effect : schema.effects) {
      if (effect.time == Effect::Time::kContinuous) continue;
      at_end_ = effect.time == Effect::Time::kEnd;
      for_each_assignment(task_, effect.variables, frame_, budget_, [&] { write(effect); });
    }
  }

  void look_at(TimedEvent& event) {
    out_ = &event.idle;
    at_end_ = false;
    const auto now = [&](double time) {
      return static_cast<Micros>(std::llround(time * kMicrosPerSecond)) == event.time;
    };
    for (const TimedFact& timed : task_.problem.timed_facts)
      if (now(timed.time)) write_fact(timed.fact.predicate, timed.fact.objects, timed.value);
    for (const TimedAssignment& timed : task_.problem.timed_values)
      if (now(timed.time)) write_number(timed.assignment.function, timed.assignment.objects, false);
  }

  const std::vector<ObjectId>& objects(const std::vector<Term>& terms) {
    objects_.clear();
    for (const Term& term : terms) objects_.push_back(term.is_variable ? frame_[term.index] : term.index);
    return objects_;
  }

  /// `needed` is what the ground action reads already.
  void read(const Condition& condition, const GroundCondition& needed) {
    if (condition.kind == Condition::Kind::kAtom) {
      if (changing_predicates_[condition.predicate] && !task_.domain.predicates[condition.predicate].derived)
        read_fact(condition, needed);
      return;
    }
    for (const Expression& side : condition.sides) read(side);
    if (!condition.operands.empty())
      for_each_assignment(task_, condition.variables, frame_, budget_, [&] {
        for (const Condition& operand : condition.operands) read(operand, needed);
      });
  }

  void read_fact(const Condition& atom, const GroundCondition& needed) {
    const std::vector<ObjectId>& arguments = objects(atom.terms);
    const int known = facts_.find(atom.predicate, arguments);
    if (known < 0) {
      note({Of::kOther, other(other_facts_, other_fact_ids_, atom.predicate, arguments), at_end_, true, false, false});
      return;
    }
    const int fact = fact_ids_[known], opposite = ground_.facts[fact].complement;
    const auto needs = [&](int f) { return f >= 0 && contains(needed.facts, f); };
    if (!needs(fact) && !needs(opposite)) note({Of::kFact, fact, at_end_, true, false, false});
  }

  void read(const Expression& expression) {
    if (expression.kind == Expression::Kind::kFunction && changing_functions_[expression.function]) {
      const std::vector<ObjectId>& arguments = objects(expression.terms);
      const int known = numbers_.find(expression.function, arguments);
      if (known >= 0)
        note({Of::kNumber, number_ids_[known], at_end_, true, false, false});
      else
        note({Of::kOther, other(other_numbers_, other_number_ids_, expression.function, arguments), at_end_, true,
              false, false});
    }
    for (const Expression& operand : expression.operands) read(operand);
  }

  void write(const Effect& effect) {
    if (!effect.is_numeric()) {
      write_fact(effect.predicate, objects(effect.terms), effect.kind == Effect::Kind::kAdd);
      return;
    }
    write_number(effect.function, objects(effect.terms),
                 effect.kind == Effect::Kind::kIncrease || effect.kind == Effect::Kind::kDecrease);
    read(effect.value);
  }

  void write_fact(PredicateId predicate, const std::vector<ObjectId>& arguments, bool add) {
    if (facts_.find(predicate, arguments) < 0)
      note({Of::kOther, other(other_facts_, other_fact_ids_, predicate, arguments), at_end_, false, add, !add});
  }

  void write_number(FunctionId function, const std::vector<ObjectId>& arguments, bool by) {
    if (numbers_.find(function, arguments) < 0)
      note({Of::kOther, other(other_numbers_, other_number_ids_, function, arguments), at_end_, false, true, !by});
  }

  int other(AtomTable& table, ById<int>& ids, int id, const std::vector<ObjectId>& arguments) {
    const int entry = table.insert(id, arguments);
    if (entry == static_cast<int>(ids.size())) {
      ids.push_back(static_cast<int>(others_.size()));
      others_.emplace_back();
    }
    return ids[entry];
  }

  void note(const IdleTouch& touch) {
    if (touch.of == Of::kOther) {
      Other& other = others_[touch.index];
      other.read |= touch.read;
      other.up |= touch.up;
      other.down |= touch.down;
    }
    out_->push_back(touch);
  }

  void drop_harmless() {
    ById<int> renamed(others_.size(), -1);
    for (std::size_t i = 0; i < others_.size(); ++i)
      if (others_[i].harmful()) renamed[i] = ground_.others++;
    const auto rename = [&](std::vector<IdleTouch>& touches) {
      for (IdleTouch& touch : touches)
        if (touch.of == Of::kOther) touch.index = renamed[touch.index];
      std::erase_if(touches, [](const IdleTouch& touch) { return touch.index < 0; });
      touches.shrink_to_fit();
    };
    for (GroundAction& action : ground_.actions) rename(action.idle);
    for (TimedEvent& event : ground_.events) rename(event.idle);
  }

  const Task& task_;
  GroundTask& ground_;
  Budget& budget_;
  ById<char> changing_predicates_, changing_functions_;
  AtomTable facts_, numbers_, other_facts_, other_numbers_;  ///< functions in place of predicates for numbers
  ById<int> fact_ids_, number_ids_, other_fact_ids_, other_number_ids_;  ///< by entry of the tables
  ById<Other> others_;
  ById<ObjectId> frame_, objects_;
  std::vector<IdleTouch>* out_ = nullptr;
  bool at_end_ = false;
};

}  // namespace

void find_idle(const Task& task, GroundTask& ground, Budget& budget) {
  if (!ground.proved_unsolvable) IdleFinder(task, ground, budget).run();
}

}  // namespace cxlab::planner
