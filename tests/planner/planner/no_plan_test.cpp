// The answers that are not plans: proofs, and what ends a search before.

#include <gtest/gtest.h>

#include "answers.h"
#include "lamp.h"

namespace cxlab::planner {
namespace {

TEST(FindPlan, ProvesThatNothingAddsTheGoal) {
  const PlanAnswer found = answer(parse(
      "(:predicates (a) (b)) (:action make :parameters () :precondition (b) :effect (a))", "(:init) (:goal (a))"));
  EXPECT_EQ(found.status, PlanStatus::kUnsolvable);
}

TEST(FindPlan, ANumberThatNeverGetsAValueIsNamed) {
  const char* refuel = R"((:predicates (full ?c) (ready)) (:functions (fuel ?c) (spare ?c) (weight ?c))
    (:action fill :parameters (?c) :precondition (ready) :effect (and (increase (fuel ?c) 1) (full ?c)))
    (:action spill :parameters (?c) :precondition (ready) :effect (scale-down (spare ?c) 2)))";
  const auto reason = [&](const std::string& more, const std::string& init, const std::string& goal) {
    const PlanAnswer found = answer(
        parse(refuel + more, "(:objects a b) (:init (ready) " + init + ") (:goal " + goal + ")"), {.budget = 200'000});
    return found.status == PlanStatus::kUnsolvable ? found.reason
           : found.plan                            ? "a plan"
                                                   : "another answer: " + found.reason;
  };
  const std::string missing =
      "the goal is out of reach, judged by facts one by one and in pairs; without a value in :init, and nothing "
      "assigns one: ";
  EXPECT_EQ(reason("", "(= (fuel b) 0)", "(full a)"), missing + "(fuel a)");
  EXPECT_EQ(reason("", "", "(and (full a) (>= (spare b) 1))"), missing + "(fuel a), (spare b)");
  EXPECT_EQ(reason("", "(= (fuel a) 0)", "(full a)"), "a plan");
  EXPECT_EQ(
      reason("(:action weigh :parameters (?c) :precondition (and (not (ready)) (<= (weight ?c) 3)) :effect (full ?c))",
             "", "(full a)"),
      missing + "(fuel a)")
      << "weigh can never begin, whatever (weight a) is";
  EXPECT_EQ(reason("", "", "(>= (fuel a) 3)"), missing + "(fuel a)");
  EXPECT_EQ(reason("(:durative-action measure :parameters (?c) :duration (= ?duration (+ 1 (spare ?c))) :condition () "
                   ":effect (at end (full ?c)))",
                   "", "(full b)"),
            missing + "(fuel b), (spare b)");
  EXPECT_EQ(reason("(:action weigh :parameters (?c) :precondition (<= (weight ?c) 3) :effect (full ?c))",
                   "(= (weight b) 9)", "(full a)"),
            missing + "(fuel a), (weight a)");
  EXPECT_EQ(reason("(:action calibrate :parameters (?c) :effect (assign (fuel ?c) 2))", "", "(>= (fuel a) 4)"),
            "a plan");
  EXPECT_EQ(reason("(:action pour :parameters (?c ?d) :precondition (not (= ?c ?d)) :effect (and (full ?c) (assign "
                   "(fuel ?c) (fuel ?d))))",
                   "", "(full a)"),
            missing + "(fuel a), (fuel b)");
  EXPECT_EQ(reason("(:action calibrate :parameters (?c) :effect (assign (fuel ?c) 2))", "", "(full a)"), "a plan");
  EXPECT_EQ(reason("(:action copy :parameters (?c) :effect (and (full ?c) (assign (fuel ?c) (spare ?c)))) (:action "
                   "repair :parameters (?c) :effect (assign (spare ?c) 2))",
                   "", "(full a)"),
            "a plan");
  EXPECT_EQ(reason("", "(at 5 (= (fuel a) 1))", "(>= (fuel a) 3)"), "a plan");
  EXPECT_EQ(reason("", "", "(and (full a) (not (ready)))"),
            "the goal is out of reach, judged by facts one by one and in pairs");
}

TEST(FindPlan, NumbersOfActionsThatCanNeverBeginAreNotNamed) {
  const PlanAnswer found = answer(parse(R"((:predicates (full)) (:functions (fuel) (weight) (limit))
    (:action fill :parameters () :precondition (>= (fuel) 1) :effect (full))
    (:action weigh :parameters () :precondition (and (>= (limit) 5) (<= (weight) 3)) :effect (full))
    (:action lower :parameters () :effect (decrease (limit) 1)))",
                                        "(:init (= (limit) 1)) (:goal (full))"));
  EXPECT_EQ(found.status, PlanStatus::kUnsolvable);
  EXPECT_EQ(found.reason,
            "the goal is out of reach, judged by facts one by one and in pairs; without a value in :init, and nothing "
            "assigns one: (fuel)");
}

TEST(FindPlan, ProvesThatNoOrderWorks) {
  const PlanAnswer found = answer(parse(R"((:predicates (key) (a) (b))
    (:action open-a :parameters () :precondition (key) :effect (and (a) (not (key))))
    (:action open-b :parameters () :precondition (key) :effect (and (b) (not (key)))))",
                                        "(:init (key)) (:goal (and (a) (b)))"));
  EXPECT_EQ(found.status, PlanStatus::kUnsolvable);
}

TEST(FindPlan, ProvesThatTwoFactsOfTheGoalAreNeverTrueTogetherWithoutTryingAllStates) {
  std::string objects = "(:objects", off;
  for (int i = 0; i < 40; ++i) {
    objects += " s" + std::to_string(i);
    off += " (off s" + std::to_string(i) + ")";
  }
  const PlanAnswer found =
      answer(parse(R"((:predicates (key) (left) (right) (on ?s) (off ?s))
    (:durative-action open-left :parameters () :duration (= ?duration 2) :condition (at start (key))
     :effect (and (at start (not (key))) (at end (left))))
    (:durative-action open-right :parameters () :duration (= ?duration 2) :condition (at start (key))
     :effect (and (at start (not (key))) (at end (right))))
    (:action switch-on :parameters (?s) :precondition (off ?s) :effect (and (on ?s) (not (off ?s))))
    (:action switch-off :parameters (?s) :precondition (on ?s) :effect (and (off ?s) (not (on ?s)))))",
                   objects + ") (:init (key)" + off + ") (:goal (and (left) (right) (forall (?s) (on ?s))))"),
             {.budget = 20'000});
  EXPECT_EQ(found.status, PlanStatus::kUnsolvable);
  EXPECT_LT(found.units, 5'000);
}

TEST(FindPlan, ProvesUsingThatAnActionEndsOnce) {
  // If one lifting could end often, a block would be in the hand and on another one.
  const PlanAnswer found =
      answer(parse(R"((:predicates (on ?x ?y) (table ?x) (clear ?x) (free) (held ?x))
    (:durative-action lift :parameters (?x) :duration (= ?duration 2)
     :condition (and (at start (clear ?x)) (at start (table ?x)) (at start (free)))
     :effect (and (at start (not (free))) (at start (not (clear ?x))) (at end (not (table ?x))) (at end (held ?x))))
    (:durative-action stack :parameters (?x ?y) :duration (= ?duration 3)
     :condition (and (at start (held ?x)) (at start (clear ?y)))
     :effect (and (at start (not (held ?x))) (at start (not (clear ?y))) (at end (clear ?x)) (at end (on ?x ?y)) (at end (free))))
    (:durative-action unstack :parameters (?x ?y) :duration (= ?duration 3)
     :condition (and (at start (on ?x ?y)) (at start (clear ?x)) (at start (free)))
     :effect (and (at start (not (free))) (at start (not (clear ?x))) (at end (not (on ?x ?y))) (at end (held ?x)) (at end (clear ?y)))))",
                   R"((:objects a b c) (:init (table a) (table b) (table c) (clear a) (clear b) (clear c) (free))
    (:goal (and (on a b) (on b a))))"));
  EXPECT_EQ(found.status, PlanStatus::kUnsolvable);
}

/// Robots that bring parcels from place to place; the effects of putting one down.
std::string parcels(const std::string& drop) {
  return R"((:types robot place) (:predicates (at ?r - robot ?p - place) (in ?p - place) (has ?r - robot) (free ?r - robot))
    (:durative-action go :parameters (?r - robot ?a ?b - place) :duration (= ?duration 5)
     :condition (at start (at ?r ?a)) :effect (and (at start (not (at ?r ?a))) (at end (at ?r ?b))))
    (:durative-action pick :parameters (?r - robot ?a - place) :duration (= ?duration 2)
     :condition (and (over all (at ?r ?a)) (at start (in ?a)) (at start (free ?r)))
     :effect (and (at start (not (in ?a))) (at start (not (free ?r))) (at end (has ?r))))
    (:durative-action drop :parameters (?r - robot ?a - place) :duration (= ?duration 2)
     :condition (and (over all (at ?r ?a)) (at start (has ?r)))
     :effect )" +
         drop + ")";
}

TEST(FindPlan, ProvesWhileOverlapsCouldStillBeTriedForEver) {
  // Two robots, three places, one parcel wanted at two of them.
  const PlanAnswer found =
      answer(parse(parcels("(and (at start (not (has ?r))) (at end (in ?a)) (at end (free ?r)))"),
                   R"((:objects r1 r2 - robot a b c - place) (:init (at r1 a) (at r2 b) (in a) (free r1) (free r2))
    (:goal (and (in b) (in c))))"),
             {.budget = 1'000'000});
  EXPECT_EQ(found.status, PlanStatus::kUnsolvable);
}

TEST(FindPlan, NeverDeniesAPlanInWhichAnActionOverlapsItself) {
  // A robot that has its parcel until the end of a drop begins the drop twice, and takes the parcel between the two
  // ends. The planner does not try this, the validator accepts it.
  const PlanAnswer found = answer(
      parse(parcels("(and (at end (in ?a)) (at end (not (has ?r))) (at end (free ?r)))"),
            R"((:objects r1 - robot a b c - place) (:init (at r1 a) (in a) (free r1)) (:goal (and (in b) (in c))))"),
      {.budget = 200'000});
  EXPECT_NE(found.status, PlanStatus::kUnsolvable);
}

TEST(FindPlan, StatesThatDifferOnlyInUnreadCostsAreOne) {
  // Three tiles on a ring of four places only go round: two of them never change their order.
  const PlanAnswer found =
      answer(parse(R"((:predicates (at ?t ?p) (empty ?p) (next ?p ?q)) (:functions (total-cost))
    (:action slide :parameters (?t ?p ?q) :precondition (and (at ?t ?p) (empty ?q) (next ?p ?q))
     :effect (and (at ?t ?q) (empty ?p) (not (at ?t ?p)) (not (empty ?q)) (increase (total-cost) 1))))",
                   R"((:objects a b c n e s w) (:init (at a n) (at b e) (at c s) (empty w) (= (total-cost) 0)
     (next n e) (next e s) (next s w) (next w n) (next e n) (next s e) (next w s) (next n w))
    (:goal (and (at b n) (at a e) (at c s))) (:metric minimize (total-cost)))"),
             {.budget = 100'000});
  EXPECT_EQ(found.status, PlanStatus::kUnsolvable);
  EXPECT_GT(found.units, 20);  // not by facts in pairs
}

TEST(FindPlan, WithoutDurationsOneSearchThroughAllOrdersIsTheProof) {
  // Five tiles on a board of two by three: half of the 720 states can be reached.
  const PlanAnswer found = answer(parse(R"((:predicates (at ?t ?p) (empty ?p) (next ?p ?q))
    (:action slide :parameters (?t ?p ?q) :precondition (and (at ?t ?p) (empty ?q) (next ?p ?q))
     :effect (and (at ?t ?q) (empty ?p) (not (at ?t ?p)) (not (empty ?q)))))",
                                        R"((:objects a b c d e p1 p2 p3 p4 p5 p6)
    (:init (at a p1) (at b p2) (at c p3) (at d p4) (at e p5) (empty p6)
     (next p1 p2) (next p2 p1) (next p2 p3) (next p3 p2) (next p4 p5) (next p5 p4) (next p5 p6) (next p6 p5)
     (next p1 p4) (next p4 p1) (next p2 p5) (next p5 p2) (next p3 p6) (next p6 p3))
    (:goal (and (at b p1) (at a p2) (at c p3) (at d p4) (at e p5))))"));
  EXPECT_EQ(found.status, PlanStatus::kUnsolvable);
  EXPECT_EQ(found.reason, "no order of actions reaches the goal");
}

TEST(FindPlan, ProvesThatTimesRuleOutAllPlans) {
  const std::string domain = R"((:predicates (lit) (done))
    (:durative-action flash :parameters () :duration (= ?duration 1) :condition () :effect (and (at start (lit)) (at end (not (lit)))))
    (:durative-action work :parameters () :duration (= ?duration 2) :condition (over all (lit)) :effect (at end (done))))";
  EXPECT_EQ(answer(parse(domain, "(:init) (:goal (done))")).status, PlanStatus::kUnsolvable);
}

TEST(FindPlan, ReportsThatTheBudgetEnded) {
  std::string objects = "(:objects";
  std::string init;
  for (int i = 0; i < 14; ++i) {
    objects += " o" + std::to_string(i);
    init += " (item o" + std::to_string(i) + ")";
  }
  const PlanAnswer found = answer(
      parse(kLamp, objects + ") (:init (dark) (free)" + init + ") (:goal (forall (?i) (done ?i)))"), {.budget = 300});
  EXPECT_EQ(found.status, PlanStatus::kBudget);
  EXPECT_GE(found.units, 300);
}

/// Objects o0 ... of which fact (p o) holds.
std::string numbered(int count) {
  std::string objects = "(:objects", init;
  for (int i = 0; i < count; ++i) {
    objects += " o" + std::to_string(i);
    init += " (p o" + std::to_string(i) + ")";
  }
  return objects + ") (:init (next o0 o1)" + init + ")";
}

TEST(FindPlan, TheBudgetCanEndDuringGrounding) {
  std::string different;  // twelve of eleven objects are never all different
  for (char a = 'a'; a <= 'l'; ++a)
    for (char b = 'a'; b < a; ++b) different += std::string(" (not (= ?") + a + " ?" + b + "))";
  const std::string five = "(?a ?b ?c ?d ?e)", all = "(p ?a) (p ?b) (p ?c) (p ?d) (p ?e)";
  const std::pair<std::string, int> actions[] = {
      {"(:action a :parameters " + five + " :precondition (and " + all + ") :effect (and (g) (made ?a ?b ?c ?d ?e)))",
       60},
      {"(:action a :parameters (?a ?b ?c ?d ?e ?f ?g ?h ?i ?j ?k ?l) :precondition (and " + all + different +
           ") :effect (g)) (:action b :parameters () :effect (g))",
       11},
      {"(:action a :parameters () :effect (and (g) (forall " + five + " (made ?a ?b ?c ?d ?e))))", 60},
      {"(:action a :parameters (?x) :precondition (forall " + five +
           " (or (p ?a) (made ?a ?b ?c ?d ?e))) :effect (and (g) (made ?x ?x ?x ?x ?x) (not (p ?x))))",
       60}};
  for (const auto& [action, objects] : actions) {
    const Task task = parse("(:predicates (p ?x) (next ?x ?y) (g) (made ?a ?b ?c ?d ?e))" + action,
                            numbered(objects) + "(:goal (or (g) (made o1 o2 o3 o4 o5)))");
    const PlanAnswer found = answer(task, {.budget = 5'000}), again = answer(task, {.budget = 5'000});
    EXPECT_EQ(found.status, PlanStatus::kBudget) << action;
    EXPECT_EQ(found.reason, "the budget ended while the problem was written out") << action;
    EXPECT_LE(found.units, 5'100) << action;
    EXPECT_EQ(found.units, again.units) << action;
  }
}

TEST(FindPlan, GroundingCountsAsWork) {
  const auto units = [](int objects) {
    return answer(parse("(:predicates (p ?x) (next ?x ?y) (g)) (:action a :parameters (?a ?b) :precondition (and (p "
                        "?a) (p ?b)) :effect (and (next ?a ?b) (g)))",
                        numbered(objects) + "(:goal (g))"))
        .units;
  };
  EXPECT_GT(units(60), 3 * units(30));
}

TEST(FindPlan, ATimeoutOfZeroEndsAtOnce) {
  const PlanAnswer found = answer(
      parse("(:predicates (g)) (:action a :parameters () :effect (g))", "(:init) (:goal (g))"), {.timeout_s = 0.0});
  EXPECT_EQ(found.status, PlanStatus::kBudget);
  EXPECT_FALSE(found.plan);
}

}  // namespace
}  // namespace cxlab::planner
