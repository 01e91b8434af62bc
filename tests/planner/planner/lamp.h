#pragma once
// Items are repaired while a lamp gives light.

namespace cxlab::planner {

inline constexpr const char* kLamp = R"((:predicates (dark) (light) (done ?i) (item ?i) (free))
  (:durative-action strike :parameters () :duration (= ?duration 5) :condition (at start (dark))
   :effect (and (at start (not (dark))) (at start (light)) (at end (not (light))) (at end (dark))))
  (:durative-action mend :parameters (?i) :duration (= ?duration 2)
   :condition (and (at start (item ?i)) (at start (free)) (over all (light)))
   :effect (and (at start (not (free))) (at end (free)) (at end (done ?i)))))";

}  // namespace cxlab::planner
