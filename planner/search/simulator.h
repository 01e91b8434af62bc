#pragma once
// States of a ground task and what actions do to them when one follows the other.
//
// A state is an array of words: the bits of the facts, then the numbers as bits of doubles.

#include <optional>
#include <vector>

#include "planner/ground/task.h"

namespace cxlab::planner {

using PackedState = std::vector<Word>;

/// Values that conditional effects read when their action began.
using Remembered = std::vector<char>;

/// Does to a number what an effect with this right-hand side does.
void change(double& number, NumericEffect::Kind kind, double value);

class Simulator {
 public:
  explicit Simulator(const GroundTask& task);

  const GroundTask& task() const { return task_; }
  int words() const { return words_; }  ///< of a whole state
  int significant_words() const {
    return significant_words_;
  }  ///< the first ones, by which states differ: without what only the metric reads
  PackedState initial() const;
  const double* numbers(const Word* state) const { return reinterpret_cast<const double*>(state + fact_words_); }

  bool holds(const GroundCondition& condition, const Word* state, double duration_s = 0) const;
  bool is_goal(const Word* state) const { return holds(task_.goal, state); }
  /// Whether the goal holds after all events from `next_event` on: a plan ends with its last step, and what validators
  /// judge is what the events leave.
  bool is_lasting_goal(const Word* state, int next_event) const;

  /// What must be true for an action to run from beginning to end with nothing beside it; `impossible` if it cannot.
  const GroundCondition& whole_condition(int action) const { return whole_[action].condition; }
  const GroundEffects& whole_effects(int action) const {
    return whole_[action].effects;
  }  ///< facts only; conditional ones are not in it
  bool whole_impossible(int action) const { return whole_[action].impossible; }

  /// Durations that the constraints allow in this state; none if there is no duration.
  std::optional<DurationRange> durations(int action, const Word* state) const;
  /// The same for copies of an action that choose: the one that they choose.
  std::optional<DurationRange> durations_of_copy(int action, const Word* state) const;

  /// Runs the whole action; `duration` is the shortest one allowed, or longer by its stretch. False if it cannot run:
  /// the state is then not to be used.
  bool apply(int action, Word* state, Micros& duration) const;
  /// The same with a duration given.
  bool apply_with(int action, Word* state, Micros duration) const;

  /// Begins an action: conditions at the start, effects. Conditions over all are not looked at.
  bool begin(int action, Word* state, Micros duration, Remembered& remembered) const;
  /// Ends an action that began `duration` ago.
  bool end(int action, Word* state, Micros duration, const Remembered& remembered) const;
  /// The same where the numbers that change all along have changed already.
  bool finish(int action, Word* state, Micros duration, const Remembered& remembered) const;
  bool over_all_holds(int action, const Word* state, Micros duration) const;
  void apply_event(int event, Word* state) const;

  /// Sets the derived facts.
  void derive(Word* state) const;
  /// The same where `is_true` judges the conditions of axioms.
  template <class IsTrue>
  void derive(Word* state, const IsTrue& is_true) const;

 private:
  struct Whole {
    GroundCondition condition;
    GroundEffects effects;
    bool impossible = false;
    std::vector<NumericEffect> numbers;  ///< in the order of time
    bool plain = false;                  ///< condition, effects and constant changes of numbers are all there is
    bool fixed = false;                  ///< the duration is a constant
    Micros duration = 0;
  };

  std::optional<Micros> chosen(int action, const DurationRange& range, const Word* state) const;
  std::optional<Micros> aimed(const GroundAction& action, const DurationRange& range, const Word* state) const;
  double value_after(const GroundAction& action, const Word* state, double duration_s) const;
  double* mutable_numbers(Word* state) const { return reinterpret_cast<double*>(state + fact_words_); }
  void apply_effects(const GroundEffects& effects, Word* state, double duration_s) const;
  Whole make_whole(const GroundAction& action) const;

  const GroundTask& task_;
  int fact_words_ = 0;
  int words_ = 0, significant_words_ = 0;
  ById<Whole> whole_;
};

template <class IsTrue>
void Simulator::derive(Word* state, const IsTrue& is_true) const {
  if (task_.axioms.empty()) return;
  for (const Axiom& axiom : task_.axioms) {
    reset(state, axiom.head);
    if (const int opposite = task_.facts[axiom.head].complement; opposite >= 0) set(state, opposite);
  }
  for (std::size_t f = 0; f < task_.facts.size(); ++f)  // derived, and no axiom is left
    if (task_.facts[f].derived && task_.facts[f].is_complement && !is_set(state, task_.facts[f].complement))
      set(state, static_cast<int>(f));
  for (std::size_t begin = 0, stop = 0; begin < task_.axioms.size(); begin = stop) {
    while (stop < task_.axioms.size() && task_.axioms[stop].stratum == task_.axioms[begin].stratum) ++stop;
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t i = begin; i < stop; ++i) {
        const Axiom& axiom = task_.axioms[i];
        if (is_set(state, axiom.head) || !is_true(axiom.body)) continue;
        set(state, axiom.head);
        if (const int opposite = task_.facts[axiom.head].complement; opposite >= 0) reset(state, opposite);
        changed = true;
      }
    }
  }
}

}  // namespace cxlab::planner
