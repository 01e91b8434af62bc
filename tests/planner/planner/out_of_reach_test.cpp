// The explanation of a goal that is out of reach.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "answers.h"

namespace cxlab::planner {
namespace {

/// The explanation, or "none: " and the answer.
std::string why(const std::string& domain, const std::string& problem,
                const PlanOptions& options = {.budget = 200'000}) {
  const PlanAnswer found = answer(parse(domain, problem), options);
  EXPECT_TRUE(!found.out_of_reach || found.status == PlanStatus::kUnsolvable);
  return found.out_of_reach ? found.out_of_reach->text() : "none: " + (found.plan ? "a plan" : found.reason);
}

const std::string kDelivery = R"((:types robot place order)
  (:predicates (at ?r - robot ?p - place) (at-gate ?p - place) (road ?a ?b - place) (has ?r - robot ?o - order)
               (delivered ?o - order) (closed ?p - place))
  (:action go :parameters (?r - robot ?a ?b - place) :precondition (and (at ?r ?a) (road ?a ?b))
   :effect (and (at ?r ?b) (not (at ?r ?a))))
  (:action take :parameters (?r - robot ?o - order) :effect (has ?r ?o))
  (:action deliver :parameters (?r - robot ?o - order ?p - place)
   :precondition (and (at ?r ?p) (at-gate ?p) (has ?r ?o) (not (closed ?p))) :effect (delivered ?o)))";
const std::string kObjects = "(:objects r1 - robot p1 p2 p3 - place o1 - order) ";
const std::string kRoads = "(road p1 p2) (road p2 p3) ";

TEST(OutOfReach, NamesWhatTheInitialStateLacks) {
  EXPECT_EQ(why(kDelivery, kObjects + "(:init (at r1 p1) " + kRoads + ") (:goal (delivered o1))"),
            "the goal (delivered o1) is out of reach: only deliver (domain.pddl:8) makes it true, and needs (at-gate "
            "?p); no action makes it true, and :init has none");
  EXPECT_EQ(
      why(kDelivery, kObjects + "(:init (at r1 p1) (road p1 p2) (at-gate p3)) (:goal (delivered o1))"),
      "the goal (delivered o1) is out of reach: only deliver (domain.pddl:8) makes it true, and needs (at r1 p3); "
      "only go (domain.pddl:5) makes it true, and needs (road ?a p3); no action makes it true, and :init has none; "
      "nearest is (road p1 p2)");
  EXPECT_EQ(why(kDelivery, kObjects + "(:init (at r1 p1) (at-gate p3) (road p1 p2) (road p3 p2)) (:goal (at r1 p3))"),
            "the goal (at r1 p3) is out of reach: only go (domain.pddl:5) makes it true, and needs (road ?a p3); no "
            "action makes it true, and :init has none; nearest is (road p1 p2)");
}

TEST(OutOfReach, FactsThatNeedEachOther) {
  EXPECT_EQ(
      why(kDelivery, kObjects + "(:init (at-gate p1) " + kRoads + ") (:goal (delivered o1))"),
      "the goal (delivered o1) is out of reach: only deliver (domain.pddl:8) makes it true, and needs (at r1 ?p); "
      "only go (domain.pddl:5) makes it true, and needs (at r1 ?a); only go (domain.pddl:5) makes it true, and "
      "needs (at r1 ?a), which is needed for itself, and :init has none");
}

TEST(OutOfReach, NegatedConditions) {
  EXPECT_EQ(why(kDelivery, kObjects + "(:init (at r1 p1) (at-gate p1) (closed p1)) (:goal (delivered o1))"),
            "the goal (delivered o1) is out of reach: only deliver (domain.pddl:8) makes it true, and needs (not "
            "(closed p1)); no action makes it false, and :init has it");
  EXPECT_EQ(why(kDelivery, kObjects + "(:init (closed p1)) (:goal (not (closed p1)))"),
            "the goal (not (closed p1)) is out of reach: no action makes it false, and :init has it");
}

TEST(OutOfReach, ObjectsAndTypes) {
  EXPECT_EQ(
      why(kDelivery, "(:objects p1 - place o1 - order) (:init (at-gate p1)) (:goal (delivered o1))"),
      "the goal (delivered o1) is out of reach: only deliver (domain.pddl:8) makes it true, and needs an object of "
      "type robot; there is none");
  EXPECT_EQ(
      why("(:types a) (:predicates (p ?x - a) (q)) (:constants k - a) (:action make :parameters () :effect (p k))",
          "(:objects l - a) (:init) (:goal (p l))"),
      "the goal (p l) is out of reach: no action makes it true (make makes others of p true), and :init lacks it");
}

TEST(OutOfReach, OnlyRulesOfItsTypeMakeAFact) {
  EXPECT_EQ(
      why(R"((:types cup plate) (:predicates (clean ?x) (washed ?c - cup) (wiped ?p - plate))
  (:derived (clean ?x - cup) (washed ?x))
  (:derived (clean ?x - plate) (wiped ?x))
  (:action wipe :parameters (?p - plate) :precondition (not (wiped ?p)) :effect (wiped ?p)))",
          "(:objects c - cup p - plate) (:init) (:goal (clean c))"),
      "the goal (clean c) is out of reach: only the rule of clean (domain.pddl:3) makes it true, and needs (washed c); "
      "no action makes it true, and :init lacks it");
}

TEST(OutOfReach, TheNumberOfOneObjectIsNotThatOfAnother) {
  const std::string burn = "(:functions (fuel ?r)) (:action burn :parameters (?r) :effect (decrease (fuel ?r) 1))";
  const std::string init = "(:objects a b) (:init (= (fuel a) 1) (= (fuel b) 2)) ";
  EXPECT_EQ(why(burn, init + "(:goal (exists (?r) (>= (fuel ?r) 3)))"),
            "the goal (>= (fuel ?r) 3) is out of reach: no action raises (fuel ?r)");
  EXPECT_EQ(why(burn, init + "(:goal (>= (fuel b) 3))"),
            "the goal (>= (fuel b) 3) is out of reach: no action raises (fuel b), and in :init (fuel b) is 2");
}

TEST(OutOfReach, WhatChangesWhileAnActionLastsIsInReach) {
  EXPECT_EQ(why(R"((:predicates (key) (done)) (:functions (level))
  (:durative-action fill :parameters () :duration (= ?duration 5) :condition () :effect (increase (level) (* #t 1)))
  (:action use :parameters () :precondition (and (>= (level) 3) (key)) :effect (done)))",
                "(:init (= (level) 0)) (:goal (done))"),
            "the goal (done) is out of reach: only use (domain.pddl:4) makes it true, and needs (key); no action makes "
            "it true, and :init lacks it");
}

TEST(OutOfReach, QuantifiedGoals) {
  const std::string made =
      "(:predicates (p ?x) (q ?x)) (:action make :parameters (?x) :precondition (q ?x) :effect (p ?x))";
  EXPECT_EQ(why(made, "(:objects a b c) (:init (q a) (q c)) (:goal (forall (?x) (p ?x)))"),
            "the goal (p b) is out of reach: only make (domain.pddl:2) makes it true, and needs (q b); no action makes "
            "it true, and :init lacks it; nearest is (q a)");
  EXPECT_EQ(
      why(made, "(:objects a b) (:init) (:goal (exists (?x) (p ?x)))"),
      "the goal (p ?x) is out of reach: only make (domain.pddl:2) makes it true, and needs (q ?x); no action makes "
      "it true, and :init has none");
  EXPECT_EQ(why(made, "(:objects a b) (:init (q a)) (:goal (or (q b) (p b)))"),
            "the goal (p b), one way to (or (q b) (p b)), is out of reach: only make (domain.pddl:2) makes it true, "
            "and needs "
            "(q b); no action makes it true, and :init lacks it; nearest is (q a)");
}

TEST(OutOfReach, OfObjectsThatLackAsMuchTheFirstIsNamed) {
  EXPECT_EQ(why("(:predicates (p) (q ?x) (s ?x)) (:action make :parameters (?x) :precondition (and (q ?x) (s ?x)) "
                ":effect (p))",
                "(:objects a b c) (:init (s a) (q b)) (:goal (p))"),
            "the goal (p) is out of reach: only make (domain.pddl:2) makes it true, and needs (q a); no action makes "
            "it true, and :init lacks it; nearest is (q b)");
}

TEST(OutOfReach, Numbers) {
  const std::string tank = R"((:predicates (station) (there)) (:functions (fuel) (need))
    (:action use :precondition (> (fuel) 0) :effect (decrease (fuel) 1))
    (:action fill :precondition (station) :effect (increase (fuel) 5))
    (:action drive :precondition (>= (fuel) (need)) :effect (there)))";
  EXPECT_EQ(
      why(tank, "(:init (= (fuel) 1) (= (need) 3)) (:goal (there))"),
      "the goal (there) is out of reach: only drive (domain.pddl:5) makes it true, and needs (>= (fuel) (need)); "
      "only fill (domain.pddl:4) raises (fuel) or lowers (need), and needs (station); no action makes it true, and "
      ":init lacks it");
  EXPECT_EQ(
      why("(:predicates (x)) (:functions (fuel ?r)) (:action use :parameters (?r) :effect (decrease (fuel ?r) 1))",
          "(:objects r) (:init (= (fuel r) 1)) (:goal (>= (fuel r) 3))"),
      "the goal (>= (fuel r) 3) is out of reach: no action raises (fuel r), and in :init (fuel r) is 1");
  EXPECT_EQ(
      why(tank, "(:init (= (need) 3)) (:goal (there))"),
      "the goal (there) is out of reach: only drive (domain.pddl:5) makes it true, and needs a value of (fuel); no "
      "action gives a value to (fuel), and in :init (fuel) has no value");
}

TEST(OutOfReach, WhatChangesByItselfIsNoObstacle) {
  for (const auto& [gate, init] : {std::pair{"(> (n) 3)", "(= (n) 1) (at 5 (= (n) 9))"},
                                   {"(< (n) 0)", "(= (n) 1) (at 5 (= (n) -9))"},
                                   {"(closed)", "(= (n) 1) (at 5 (closed))"},
                                   {"(not (closed))", "(= (n) 1) (closed) (at 5 (not (closed)))"}})
    EXPECT_EQ(
        why(std::string("(:predicates (done) (tidy) (closed)) (:functions (n)) (:action work :precondition (and ") +
                gate + " (tidy)) :effect (done))",
            std::string("(:init ") + init + ") (:goal (done))"),
        "the goal (done) is out of reach: only work (domain.pddl:2) makes it true, and needs (tidy); no action "
        "makes it true, and :init lacks it");
}

TEST(OutOfReach, WhatCanBeginButNeverEndHelpsNobody) {
  const std::string chain = R"((:predicates (p) (q) (never) (done))
    (:durative-action first :parameters () :duration (= ?duration 1) :condition (at end (never)) :effect (at start (p)))
    (:durative-action second :parameters () :duration (= ?duration 1) :condition (at end (p)) :effect (at start (q)))
    (:action last :precondition (q) :effect (done)))";
  EXPECT_EQ(why(chain, "(:init) (:goal (done))"),
            "the goal (done) is out of reach: only last (domain.pddl:5) makes it true, and needs (q); only second "
            "(domain.pddl:4) makes it true, and needs (p) at end; only first (domain.pddl:3) makes it true, and needs "
            "(never) at end; no action makes it true, and :init lacks it");
}

TEST(OutOfReach, AComparisonSaysWhichWayItsNumberWouldHaveToMove) {
  for (const auto& [move, goals] :
       {std::pair{"raises", std::vector{"(> (n) 3)", "(>= (n) 3)", "(not (< (n) 3))", "(not (<= (n) 3))"}},
        {"lowers", {"(< (n) 0)", "(<= (n) 0)", "(not (> (n) 0))", "(not (>= (n) 0))"}}})
    for (const std::string goal : goals)
      EXPECT_EQ(why(std::string("(:predicates (x)) (:functions (n)) (:action other :effect (") +
                        (std::string(move) == "raises" ? "decrease" : "increase") + " (n) 1))",
                    "(:init (= (n) 1)) (:goal " + goal + ")"),
                "the goal " + goal + " is out of reach: no action " + move + " (n), and in :init (n) is 1");
}

TEST(OutOfReach, NumbersThatMoveButNotFarEnough) {
  EXPECT_EQ(
      why("(:predicates (x)) (:functions (n) (k)) (:action less :effect (decrease (k) 1))",
          "(:init (= (n) 1) (= (k) 2)) (:goal (> (+ (n) (* 2 (k))) 9))"),
      "the goal (> (+ (n) (* 2 (k))) 9) is out of reach: no action raises (n) or raises (k), and in :init (n) is 1 "
      "and (k) is 2");
  EXPECT_EQ(why("(:predicates (x)) (:functions (n) (k)) (:action less :effect (decrease (k) 1))",
                "(:init (= (n) 1) (= (k) 2)) (:goal (> (- (n) (* -2 (k))) 9))"),
            "the goal (> (- (n) (* -2 (k))) 9) is out of reach: what less can do to it is not enough");
}

TEST(OutOfReach, GoalsThatNothingCouldMeet) {
  const std::string made = "(:types a) (:predicates (p ?x) (q ?x - a)) (:action make :parameters (?x) :effect (p ?x))";
  EXPECT_EQ(why(made, "(:objects b) (:init) (:goal (exists (?x - a) (q ?x)))"),
            "the goal is out of reach: it needs an object of type a; there is none");
  EXPECT_EQ(why(made, "(:objects b c) (:init) (:goal (and (p b) (= b c)))"),
            "the goal (= b c) is out of reach: no objects that fit are the same");
  EXPECT_EQ(why(made, "(:objects b c) (:init) (:goal (and (p b) (or)))"),
            "the goal (or) is out of reach: nothing is asked for that could be so");
  EXPECT_EQ(
      why("(:predicates (ok ?x) (p ?x) (q)) (:action make :parameters (?x) :precondition (q) :effect (p ?x))",
          "(:objects b) (:init (ok b)) (:goal (imply (ok b) (p b)))"),
      "the goal (p b), one way to (imply (ok b) (p b)), is out of reach: only make (domain.pddl:2) makes it true, "
      "and needs (q); no action makes it true, and :init lacks it");
}

TEST(OutOfReach, ConditionsOverTime) {
  const std::string work = R"((:predicates (light) (power) (done) (tidy))
    (:durative-action work :parameters () :duration (= ?duration 2)
     :condition (and (at start (power)) (over all (light)) (at end (tidy)))
     :effect (at end (done))))";
  EXPECT_EQ(why(work, "(:init (power) (tidy)) (:goal (done))"),
            "the goal (done) is out of reach: only work (domain.pddl:3) makes it true, and needs (light) over all; no "
            "action makes it true, and :init lacks it");
  EXPECT_EQ(why(work, "(:init (light) (tidy)) (:goal (done))"),
            "the goal (done) is out of reach: only work (domain.pddl:3) makes it true, and needs (power) at start; no "
            "action makes it true, and :init lacks it");
  EXPECT_EQ(why(work, "(:init (power) (at 5 (light))) (:goal (done))"),
            "the goal (done) is out of reach: only work (domain.pddl:3) makes it true, and needs (tidy) at end; no "
            "action makes it true, and :init lacks it");
  EXPECT_EQ(why(work, "(:init (power) (tidy) (at 5 (light))) (:goal (done))"), "none: a plan");
}

TEST(OutOfReach, RulesAndEffectsWithConditions) {
  EXPECT_EQ(
      why("(:predicates (a) (b) (c)) (:derived (c) (and (a) (b))) (:action make :effect (a))", "(:init) (:goal (c))"),
      "the goal (c) is out of reach: only the rule of c (domain.pddl:2) makes it true, and needs (b); no action "
      "makes it true, and :init lacks it");
  EXPECT_EQ(why("(:predicates (a) (b)) (:action make :effect (when (b) (a)))", "(:init) (:goal (a))"),
            "the goal (a) is out of reach: only make (domain.pddl:2) makes it true, and needs (b) for this effect; no "
            "action makes it true, and :init lacks it");
  EXPECT_EQ(why("(:predicates (a) (b ?lid)) (:action shake :effect (forall (?lid) (when (b ?lid) (a))))",
                "(:objects x y) (:init) (:goal (a))"),
            "the goal (a) is out of reach: only shake (domain.pddl:2) makes it true, and needs (b ?lid) for this "
            "effect; no action makes it true, and :init has none");
}

TEST(OutOfReach, SeveralActionsAndLongChains) {
  std::string steps = "(:predicates";
  for (int i = 0; i < 9; ++i) steps += " (s" + std::to_string(i) + ")";
  steps += ")";
  for (int i = 1; i < 9; ++i)
    steps += "\n(:action do" + std::to_string(i) + " :precondition (s" + std::to_string(i - 1) + ") :effect (s" +
             std::to_string(i) + "))";
  EXPECT_EQ(
      why(steps, "(:init) (:goal (s8))"),
      "the goal (s8) is out of reach: only do8 (domain.pddl:10) makes it true, and needs (s7); only do7 "
      "(domain.pddl:9) makes it true, and needs (s6); ... and so on to (s2); only do2 (domain.pddl:4) makes it "
      "true, and needs (s1); only do1 (domain.pddl:3) makes it true, and needs (s0); no action makes it true, and "
      ":init lacks it");
  EXPECT_EQ(
      why("(:predicates (a) (b) (c) (d)) (:action one :precondition (and (b) (c)) :effect (a)) (:action two "
          ":precondition (and (d) (not (b))) :effect (a))",
          "(:init) (:goal (a))"),
      "the goal (a) is out of reach: each of two, one makes it true; two (domain.pddl:2) comes closest, and needs "
      "(d); no action makes it true, and :init lacks it");
}

TEST(OutOfReach, TwoFactsThatAreNeverSoAtOnce) {
  const std::string key = R"((:predicates (key) (left) (right) (both))
    (:action open-left :precondition (key) :effect (and (not (key)) (left)))
    (:action open-right :precondition (key) :effect (and (not (key)) (right)))
    (:action pass :precondition (and (left) (right)) :effect (both)))";
  EXPECT_EQ(why(key, "(:init (key)) (:goal (and (left) (right)))"),
            "the goal is out of reach: it asks for (left) and (right); each alone can be, but never both at once");
  EXPECT_EQ(why(key, "(:init (key)) (:goal (both))"),
            "the goal (both) is out of reach: only pass (domain.pddl:5) makes it true, and needs (left) and (right); "
            "each alone can be, but never both at once");
}

TEST(OutOfReach, WhatOnlyTryingAllProvesHasNoName) {
  const std::string three = R"((:predicates (k1) (k2) (a) (b) (c))
    (:action one :precondition (k1) :effect (and (not (k1)) (a))) (:action two :precondition (k1) :effect (and (not (k1)) (b)))
    (:action three :precondition (k2) :effect (and (not (k2)) (a))) (:action four :precondition (k2) :effect (and (not (k2)) (b)))
    (:action five :precondition (k1) :effect (and (not (k1)) (c))) (:action six :precondition (k2) :effect (and (not (k2)) (c))))";
  EXPECT_EQ(why(three, "(:init (k1) (k2)) (:goal (and (a) (b) (c)))"), "none: no order of actions reaches the goal");
}

TEST(OutOfReach, CostsNoUnitsAndEndsWithTheBudget) {
  const std::string goal = kObjects + "(:init (at r1 p1) (road p1 p2) (at-gate p3)) (:goal (delivered o1))";
  const std::int64_t units = answer(parse(kDelivery, goal)).units;
  const PlanAnswer tight = answer(parse(kDelivery, goal), {.budget = units + 1});
  EXPECT_EQ(tight.status, PlanStatus::kUnsolvable);
  EXPECT_EQ(tight.units, units);
  EXPECT_FALSE(tight.out_of_reach);
}

TEST(OutOfReach, TheInitialStateMayHaveAnotherName) {
  EXPECT_THAT(why(kDelivery, kObjects + "(:init (closed p1)) (:goal (not (closed p1)))",
                  {.budget = 200'000, .initial_state = "the instance"}),
              ::testing::EndsWith("and the instance has it"));
}

}  // namespace
}  // namespace cxlab::planner
