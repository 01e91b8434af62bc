#pragma once
// From a list of actions to a plan.
//
// Decoding runs through the list again and again, always taking the first action that can be applied, until the goal is
// reached, and schedules as it goes; what remains is dropped. So any order is a plan as long as the goal is reached,
// and moving one action drags along those that wait for it. Where more actions can make a plan better, decoding
// continues to the last step after which the goal holds. Where actions are cut, the list has their beginnings and ends,
// so that others can start or end in between.

#include <utility>
#include <vector>

#include "planner/improve/objective.h"
#include "planner/search/split.h"

namespace cxlab::planner {

/// What decoding gives.
struct DecodedPlan {
  static constexpr Micros kLatenessWeight = 10;
  Sequence order;             ///< as executed
  std::vector<Micros> times;  ///< by step: of a beginning, of an end, of the start of a whole action
  ById<int> causes;           ///< by step: the step that it waits for, or -1
  Micros makespan = 0;
  double value = 0;       ///< of the objective
  Micros lateness = 0;    ///< by how much things come too late for events
  std::vector<int> late;  ///< steps that do
  double cost = 0;        ///< what improvement brings down: the aim, and a little of all times

  double aim() const { return value + static_cast<double>(kLatenessWeight * lateness); }
};

class Decoder {
 public:
  /// `simulator` is of the split task, `touches` of the original; the split may cut nothing.
  Decoder(const SplitTask& split, const GroundTask& original, const Simulator& simulator, const Touches& touches,
          const Objective& objective)
      : split_(split),
        original_(original),
        simulator_(simulator),
        touches_(touches),
        objective_(objective),
        timeline_(touches, true),
        kept_states_(simulator.initial()) {}

  /// False if the list does not lead to the goal, or costs more than `most_cost`.
  bool decode(const Sequence& list, double most_cost, DecodedPlan& plan);
  /// Lists that begin as this plan does are decoded from where they differ, until another one is kept.
  void keep(const DecodedPlan& plan);
  /// The state of the kept plan before a step.
  const Word* kept_state(std::size_t step) const {
    return &kept_states_[step * static_cast<std::size_t>(simulator_.words())];
  }
  /// Goes as far as the list leads; the state then. Nothing has a time. False if something is still running.
  bool advance(const Sequence& list, Sequence& order, PackedState& state);
  /// Work since the last call: steps looked at.
  std::int64_t take_work() { return std::exchange(work_, 0); }

  const SplitTask& split() const { return split_; }
  const GroundTask& original() const { return original_; }
  const Simulator& simulator() const { return simulator_; }
  const Touches& touches() const { return touches_; }
  const Objective& objective() const { return objective_; }

 private:
  /// An action that has begun and not ended.
  struct Running {
    int action;  ///< of the original
    int begin;   ///< step
    Micros start, duration;
  };
  enum class Taken { kYes, kNo, kFailed };

  void set_out(const Sequence& list, std::size_t same);
  std::size_t take_kept(const Sequence& list, double most_cost, DecodedPlan& plan);
  Taken take_next(const Sequence& list, SequenceStep& step);
  bool schedule(DecodedPlan& plan, double most_cost);
  bool too_dear(double most_cost) const;
  bool is_part(const SequenceStep& step) const;
  Micros append(const SequenceStep& step, std::size_t index);
  void place(DecodedPlan& plan, std::size_t index);
  bool keeps_running(const Word* state, int except) const;

  const SplitTask& split_;
  const GroundTask& original_;
  const Simulator& simulator_;
  const Touches& touches_;
  const Objective& objective_;
  Timeline timeline_;
  Sequence scheduled_;  ///< what is on the timeline, up to the first part of an action that is cut
  DecodedPlan kept_;
  PackedState kept_states_;  ///< before each step of it, and at its end
  PackedState scratch_, trial_, end_;
  ById<int> next_;  ///< linked list of what is left; index 0 is the head
  ById<Running> running_;
  ById<std::pair<Micros, int>> releases_;  ///< by step: a beginning that must wait for its end, and the cause
  int next_event_ = 0;
  bool shifted_ = false;  ///< a release has grown since the schedule began
  std::int64_t work_ = 0;
};

}  // namespace cxlab::planner
