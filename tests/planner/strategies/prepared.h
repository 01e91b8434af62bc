#pragma once
// A small problem made ready for one strategy.

#include "../planner/answers.h"
#include "planner/ground/ground.h"
#include "planner/pddl/text.h"
#include "planner/strategies/context.h"

namespace cxlab::planner {

class Prepared {
 public:
  Prepared(const std::string& domain_body, const std::string& problem_body, PlanOptions options = {})
      : task_(parse(domain_body, problem_body)), options_(std::move(options)) {
    Expected<GroundTask> made = ground(task_);
    EXPECT_TRUE(made && !made->proved_unsolvable);
    budget_ = Budget(options_.budget, {});
    context_.emplace(task_, options_, budget_, std::move(*made));
  }

  PlanningContext& operator*() { return *context_; }
  PlanningContext* operator->() { return &*context_; }
  const Task& task() const { return task_; }

  /// The ground action of this name, as plans write it: "(move a b)".
  int action(const std::string& name) const {
    for (std::size_t a = 0; a < context_->ground.actions.size(); ++a)
      if (const GroundAction& action = context_->ground.actions[a];
          ground_text(task_.domain.actions[action.schema].name, action.arguments, task_.problem.objects) == name)
        return static_cast<int>(a);
    ADD_FAILURE() << "no action " << name;
    return -1;
  }
  /// A list of whole actions, with their shortest durations, and of events: "next event".
  Sequence list(const std::vector<std::string>& names) const {
    const Simulator& simulator = context_->whole.space.simulator;
    PackedState state = simulator.initial();
    Sequence list;
    int next_event = 0;
    for (const std::string& name : names) {
      if (name == "next event") {
        list.push_back({-2 - next_event, 0});
        simulator.apply_event(next_event++, state.data());
        continue;
      }
      Micros duration = 0;
      EXPECT_TRUE(simulator.apply(action(name), state.data(), duration)) << name;
      list.push_back({action(name), duration});
    }
    return list;
  }

 private:
  Task task_;
  PlanOptions options_;
  Budget budget_;
  std::optional<PlanningContext> context_;
};

/// Cups are washed at a sink (3 s) or by hand (5 s).
inline constexpr const char* kCups = R"((:predicates (dirty ?c) (clean ?c) (sink-free))
  (:durative-action sink :parameters (?c) :duration (= ?duration 3) :condition (and (at start (dirty ?c)) (at start (sink-free)))
   :effect (and (at start (not (sink-free))) (at end (sink-free)) (at start (not (dirty ?c))) (at end (clean ?c))))
  (:durative-action hand :parameters (?c) :duration (= ?duration 5) :condition (at start (dirty ?c))
   :effect (and (at start (not (dirty ?c))) (at end (clean ?c)))))";
inline constexpr const char* kTwoCups =
    "(:objects a b) (:init (dirty a) (dirty b) (sink-free)) (:goal (and (clean a) (clean b)))";

/// A fuse can only be repaired in the light of a match, which burns for 5 s.
inline constexpr const char* kMatch = R"((:predicates (unused) (light) (mended))
  (:durative-action strike :parameters () :duration (= ?duration 5) :condition (at start (unused))
   :effect (and (at start (not (unused))) (at start (light)) (at end (not (light)))))
  (:durative-action mend :parameters () :duration (= ?duration 2) :condition (over all (light)) :effect (at end (mended))))";
inline constexpr const char* kOneMatch = "(:init (unused)) (:goal (mended))";

/// A tank is filled by 2 a second.
inline constexpr const char* kTank = R"((:functions (level)) (:predicates (idle))
  (:durative-action fill :parameters () :duration (and (>= ?duration 1) (<= ?duration 10)) :condition (at start (idle))
   :effect (and (at start (not (idle))) (at end (idle)) (increase (level) (* #t 2)))))";
inline constexpr const char* kSeven = "(:init (idle) (= (level) 0)) (:goal (= (level) 7))";

}  // namespace cxlab::planner
