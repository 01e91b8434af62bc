#include "planner/ground/passes.h"

#include <algorithm>

#include "planner/ground/reachable.h"
#include "planner/ground/sorted.h"

namespace cxlab::planner {

namespace {

class IdleFinder {
 public:
  IdleFinder(const Task& task, GroundTask& ground, Budget& budget)
      : task_(task),
        ground_(ground),
        budget_(budget),
        changing_(changing(task.domain, task.problem)),
        first_number_(static_cast<int>(ground.facts.size())),
        first_other_(first_number_ + static_cast<int>(ground.numbers.size())) {
    for (const bool complements : {false, true})
      for (std::size_t f = 0; f < ground.facts.size(); ++f) {
        const GroundFact& fact = ground.facts[f];
        if (fact.predicate >= 0 && !fact.derived && fact.is_complement == complements)
          enter(fact.predicate, fact.objects, static_cast<int>(f));
      }
    for (std::size_t n = 0; n < ground.numbers.size(); ++n)
      enter(symbol(ground.numbers[n]), ground.numbers[n].objects, first_number_ + static_cast<int>(n));
  }

  void run() {
    for (GroundAction& action : ground_.actions) {
      budget_.spend(Work::kGround, 1);
      if (budget_.over()) return;
      look_at(action);
    }
    look_at_events();
    if (budget_.over()) return;
    drop_harmless();
  }

 private:
  /// How the whole task uses a fact or number that is not in it.
  struct Other {
    bool read = false, up = false, down = false;
    bool harmful() const { return (read && (up || down)) || (up && down); }
  };

  /// Functions are numbered behind the predicates.
  template <class OfFunction>
  int symbol(const OfFunction& item) const {
    return static_cast<int>(task_.domain.predicates.size()) + item.function;
  }

  void enter(int symbol, std::span<const ObjectId> objects, int key) {
    if (atoms_.insert(symbol, objects) == static_cast<int>(keys_.size())) keys_.push_back(key);
  }

  /// The key of a fact or number; one that is not in the task becomes another.
  int key_of(int symbol, std::span<const ObjectId> objects) {
    enter(symbol, objects, first_other_ + static_cast<int>(others_.size()));
    const int key = keys_[atoms_.find(symbol, objects)];
    if (key == first_other_ + static_cast<int>(others_.size())) others_.emplace_back();
    return key;
  }

  void look_at(GroundAction& action) {
    const Action& schema = task_.domain.actions[action.schema];
    frame_.assign(static_cast<std::size_t>(schema.slots), -1);
    std::ranges::copy(action.arguments, frame_.begin());
    out_ = &action.idle;
    at_end_ = conditional_ = false;
    read(schema.condition.start, action.start);
    at_end_ = true;
    read(schema.condition.end, action.end);
    for (const Effect& effect : schema.effects) {
      if (effect.time == Effect::Time::kContinuous) continue;
      at_end_ = effect.time == Effect::Time::kEnd;
      conditional_ = !effect.condition.is_true();
      for_each_assignment(task_, effect.variables, frame_, budget_, [&] {
        write(effect);
        if (effect.kind == Effect::Kind::kDelete) write_in_vain(effect, action);
      });
    }
  }

  void look_at_events() {
    at_end_ = conditional_ = false;
    const auto event_at = [this](double time) {
      return std::ranges::lower_bound(ground_.events, in_micros(time), {}, &TimedEvent::time);
    };
    for (const TimedFact& timed : task_.problem.timed_facts) {
      out_ = &event_at(timed.time)->idle;
      write(timed.fact.predicate, timed.fact.objects, timed.value, !timed.value);
    }
    for (const auto& [time, assignment, _] : task_.problem.timed_values) {
      out_ = &event_at(time)->idle;
      write(symbol(assignment), assignment.objects, true, true);
    }
    budget_.spend(Work::kGround,
                  static_cast<std::int64_t>(task_.problem.timed_facts.size() + task_.problem.timed_values.size()));
  }

  /// `needed` is what the ground action reads already.
  void read(const Condition& condition, const GroundCondition& needed) {
    if (condition.kind == Condition::Kind::kAtom) {
      if (changing_.predicates[condition.predicate] && !task_.domain.predicates[condition.predicate].derived)
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
    const int key = key_of(atom.predicate, Objects(atom.terms, frame_));
    if (key < first_number_)
      for (const int fact : {key, ground_.facts[key].complement})
        if (fact >= 0 && contains(needed.facts, fact)) return;
    note({key, at_end_, true, false, false, conditional_});
  }

  void read(const Expression& expression) {
    for_each_part(expression, [this](const Expression& part) {
      if (part.kind == Expression::Kind::kFunction && changing_.functions[part.function])
        note({key_of(symbol(part), Objects(part.terms, frame_)), at_end_, true, false, false, conditional_});
    });
  }

  /// A fact that the same happening adds stays true; validators count the deletion all the same.
  void write_in_vain(const Effect& effect, const GroundAction& action) {
    const int key = key_of(effect.predicate, Objects(effect.terms, frame_));
    if (key >= first_number_) return;
    bool added = false;
    for_each_share(action, [&](const ConditionalEffects& share) {
      const GroundEffects& effects = at_end_ ? share.at_end : share.at_start;
      const std::vector<int>& adds = ground_.facts[key].is_complement ? effects.remove : effects.add;
      added = added || std::ranges::find(adds, key) != adds.end();
    });
    if (added) note({key, at_end_, false, false, true, conditional_});
  }

  void write(const Effect& effect) {
    const Objects objects(effect.terms, frame_);
    if (!effect.is_numeric()) {
      write(effect.predicate, objects, effect.kind == Effect::Kind::kAdd, effect.kind == Effect::Kind::kDelete);
      return;
    }
    const bool by = effect.kind == Effect::Kind::kIncrease || effect.kind == Effect::Kind::kDecrease;
    write(symbol(effect), objects, true, !by);
    read(effect.value);
  }

  void write(int symbol, std::span<const ObjectId> objects, bool up, bool down) {
    if (const int key = key_of(symbol, objects); key >= first_other_)
      note({key, at_end_, false, up, down, conditional_});
  }

  void note(const IdleTouch& touch) {
    if (touch.key >= first_other_) {
      Other& other = others_[touch.key - first_other_];
      other.read |= touch.read;
      other.up |= touch.up;
      other.down |= touch.down;
    }
    out_->push_back(touch);
  }

  void drop_harmless() {
    ById<int> renamed(others_.size(), -1);
    for (std::size_t i = 0; i < others_.size(); ++i)
      if (others_[i].harmful()) renamed[i] = first_other_ + ground_.others++;
    const auto rename = [&](std::vector<IdleTouch>& touches) {
      for (IdleTouch& touch : touches)
        if (touch.key >= first_other_) touch.key = renamed[touch.key - first_other_];
      std::erase_if(touches, [](const IdleTouch& touch) { return touch.key < 0; });
      touches.shrink_to_fit();
    };
    for (GroundAction& action : ground_.actions) rename(action.idle);
    for (TimedEvent& event : ground_.events) rename(event.idle);
    std::erase_if(ground_.events, [](const TimedEvent& event) { return event.effects.empty() && event.idle.empty(); });
  }

  const Task& task_;
  GroundTask& ground_;
  Budget& budget_;
  const Symbols changing_;
  const int first_number_, first_other_;  ///< keys, as of IdleTouch
  AtomTable atoms_;                       ///< facts and numbers
  ById<int> keys_;                        ///< by entry of the table
  ById<Other> others_;
  ById<ObjectId> frame_;
  std::vector<IdleTouch>* out_ = nullptr;
  bool at_end_ = false, conditional_ = false;
};

}  // namespace

void find_idle(const Task& task, GroundTask& ground, Budget& budget) {
  if (!ground.proved_unsolvable) IdleFinder(task, ground, budget).run();
}

}  // namespace cxlab::planner
