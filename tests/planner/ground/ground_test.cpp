// Grounding: which actions, facts and numbers a ground task has, and which are left out.

#include "planner/ground/ground.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "planner/ground/reachable.h"
#include "planner/ground/relaxation.h"
#include "planner/pddl/parser.h"
#include "planner/pddl/text.h"

namespace cxlab::planner {
namespace {

class Grounded {
 public:
  Grounded(const std::string& domain_body, const std::string& problem_body) {
    Expected<Domain> domain = parse_domain(
        "(define (domain d) (:requirements :adl :durative-actions :fluents :timed-initial-literals :derived-predicates "
        ":continuous-effects :duration-inequalities)\n" +
            domain_body + ")",
        "domain.pddl");
    EXPECT_TRUE(domain) << domain.error().text();
    Expected<Problem> problem =
        parse_problem("(define (problem p) (:domain d)\n" + problem_body + ")", "problem.pddl", *domain);
    EXPECT_TRUE(problem) << problem.error().text();
    task_ = {std::move(*domain), std::move(*problem)};
    Expected<GroundTask> made = ground(task_);
    EXPECT_TRUE(made);
    ground_ = std::move(*made);
  }

  /// Actions with arguments that are looked at when the problem is written out.
  std::size_t bindings() const {
    Budget unlimited;
    return find_reachable(task_, 1000, unlimited)->bindings.size();
  }

  const GroundTask& operator*() const { return ground_; }
  const GroundTask* operator->() const { return &ground_; }

  std::vector<std::string> actions() const {
    std::vector<std::string> names;
    for (const GroundAction& action : ground_.actions)
      names.push_back(text(task_.domain.actions[action.schema].name, action.arguments));
    std::ranges::sort(names);
    return names;
  }
  std::vector<std::string> facts() const {
    std::vector<std::string> names;
    for (const GroundFact& fact : ground_.facts) {
      const std::string name = text(task_.domain.predicates[fact.predicate].name, fact.objects);
      names.push_back(fact.is_complement ? "(not " + name + ")" : name);
    }
    std::ranges::sort(names);
    return names;
  }

 private:
  std::string text(const std::string& name, const std::vector<ObjectId>& arguments) const {
    return ground_text(name, arguments, task_.problem.objects);
  }

  Task task_;
  GroundTask ground_;
};

using Names = std::vector<std::string>;

TEST(Ground, KeepsActionsThatCanHappenAndHelp) {
  const Grounded task(R"((:predicates (at ?p) (road ?p ?q) (tired))
    (:action go :parameters (?p ?q) :precondition (and (at ?p) (road ?p ?q)) :effect (and (at ?q) (not (at ?p))))
    (:action yawn :parameters () :precondition () :effect (tired)))",
                      "(:objects a b c x) (:init (at a) (road a b) (road b c) (road x a)) (:goal (at c))");
  EXPECT_EQ(task.actions(), (Names{"(go a b)", "(go b c)"})) << "x cannot be reached, yawning helps nothing";
  EXPECT_EQ(task.facts(), (Names{"(at a)", "(at b)", "(at c)"})) << "roads never change";
}

TEST(Ground, AParameterThatNothingReadsIsNotEnumerated) {
  const Grounded task(R"((:predicates (done))
    (:action work :parameters (?who) :precondition () :effect (done)))",
                      "(:objects a b c) (:init) (:goal (done))");
  EXPECT_EQ(task->actions.size(), 1u);
}

TEST(Ground, ArgumentsThatMustBeEqualOrDifferentAreBoundSo) {
  const auto bindings = [](const std::string& precondition) {
    return Grounded(R"((:constants b) (:predicates (at ?x) (seen ?x ?y ?z))
      (:action go :parameters (?x) :precondition () :effect (at ?x))
      (:action see :parameters (?x ?y ?z) :precondition )" +
                        precondition + " :effect (seen ?x ?y ?z))",
                    "(:objects a c) (:init) (:goal (seen a b c))")
        .bindings();
  };
  EXPECT_EQ(bindings("()"), 27u);
  EXPECT_EQ(bindings("(= ?x ?y)"), 9u);
  EXPECT_EQ(bindings("(not (= ?x ?y))"), 18u);
  EXPECT_EQ(bindings("(and (not (= ?x ?y)) (not (= ?y ?z)) (not (= ?x ?z)))"), 6u);
  EXPECT_EQ(bindings("(= ?z b)"), 9u);
  EXPECT_EQ(bindings("(and (at ?x) (at ?y) (at ?z) (not (= ?x ?y)) (not (= ?y ?z)) (not (= ?x ?z)))"), 3u + 6u)
      << "of going, and of what facts give";
  EXPECT_EQ(bindings("(and (at ?x) (= ?x ?y) (= ?z b))"), 3u + 3u);
}

TEST(Ground, RulesWhoseConditionsNeverHoldAreLeftOut) {
  const auto axioms = [](const std::string& condition) {
    return Grounded(R"((:functions (height)) (:predicates (on) (locked) (key) (lit) (seen))
      (:derived (lit) )" +
                        condition + R"()
      (:action switch :parameters () :effect (on))
      (:action sink :parameters () :effect (decrease (height) 1))
      (:durative-action unlock :parameters () :duration (= ?duration 1) :condition (at end (and (key) (locked)))
       :effect (at start (key)))
      (:action look :parameters () :precondition (and (lit) (<= (height) 0)) :effect (seen)))",
                    "(:init (= (height) 5)) (:goal (seen))")
        ->axioms.size();
  };
  EXPECT_EQ(axioms("(on)"), 1u);
  EXPECT_EQ(axioms("(or (on) (< (height) 3))"), 2u);
  EXPECT_EQ(axioms("(or (on) (> (height) 6))"), 1u) << "it only sinks";
  EXPECT_EQ(axioms("(or (on) (key))"), 1u) << "what gives it can begin and never end";
}

TEST(Ground, KeepsTheFirstOfEqualActions) {
  const Grounded task(R"((:predicates (raw) (done))
    (:durative-action by-hand :parameters () :duration (= ?duration 2) :condition (at start (raw)) :effect (at end (done)))
    (:durative-action by-machine :parameters () :duration (= ?duration 2) :condition (at start (raw)) :effect (at end (done)))
    (:durative-action slowly :parameters () :duration (= ?duration 3) :condition (at start (raw)) :effect (at end (done))))",
                      "(:init (raw)) (:goal (done))");
  EXPECT_EQ(task.actions(), (Names{"(by-hand)", "(slowly)"}));
}

TEST(Ground, KeepsActionsThatDifferInAnyPart) {
  struct Pair {
    const char* part;  ///< where they differ: "duration", "condition" or "effect"
    const char *first, *second;
  };
  const auto kept = [](const Pair& pair) {
    const std::string part = pair.part;
    const auto action = [&](const char* name, const char* differs) {
      const std::string own = std::string(" ") + differs;
      return std::string("(:durative-action ") + name + " :parameters () :duration" +
             (part == "duration" ? own : " (= ?duration 2)") + " :condition (and (at start (p))" +
             (part == "condition" ? own : "") + ") :effect (and (at end (done))" + (part == "effect" ? own : "") +
             "))\n";
    };
    return Grounded(R"((:predicates (p) (q) (r) (s) (done)) (:functions (x) (y))
      (:action turn :precondition (and (r) (s)) :effect (and (not (p)) (not (q))))
      (:action grow :effect (and (increase (x) 3) (increase (y) 3) (p) (q) (r) (s)))
      )" + action("one", pair.first) +
                        action("other", pair.second),
                    "(:init (p) (q) (= (x) 0) (= (y) 0)) (:goal (and (done) (not (p)) (not (q)) (> (x) 5) (> (y) 5)))")
        .actions();
  };
  EXPECT_EQ(kept({"condition", "(at end (q))", "(at end (q))"}), (Names{"(grow)", "(one)", "(turn)"}));
  for (const Pair& pair :
       {Pair{"condition", "(at start (q))", "(at start (r))"},
        {"condition", "(over all (q))", "(over all (r))"},
        {"condition", "(at end (q))", "(at end (r))"},
        {"condition", "(at start (q))", "(over all (q))"},
        {"condition", "(over all (q))", "(at end (q))"},
        {"condition", "(at start (> (x) 1))", "(at start (> (y) 1))"},
        {"condition", "(at start (> (x) 1))", "(at start (> (x) 2))"},
        {"condition", "(at start (> (x) 1))", "(at end (> (x) 1))"},
        {"effect", "(at start (r))", "(at end (r))"},
        {"effect", "(at end (r))", "(at end (s))"},
        {"effect", "(at start (not (p)))", "(at end (not (p)))"},
        {"effect", "(at end (not (p)))", "(at end (not (q)))"},
        {"effect", "(at end (increase (x) 1))", "(at end (increase (y) 1))"},
        {"effect", "(at end (increase (x) 1))", "(at end (increase (x) 2))"},
        {"effect", "(at end (increase (x) 7))", "(at end (assign (x) 7))"},
        {"effect", "(at end (increase (x) 1))", "(at end (decrease (x) 1))"},
        {"effect", "(at end (increase (x) (y)))", "(at end (increase (x) (x)))"},
        {"effect", "(at start (increase (x) 1))", "(at end (increase (x) 1))"},
        {"duration", "(= ?duration 2)", "(= ?duration 3)"},
        {"duration", "(and (>= ?duration 1) (<= ?duration 3))", "(and (>= ?duration 2) (<= ?duration 3))"},
        {"duration", "(and (>= ?duration 1) (<= ?duration 3))", "(and (>= ?duration 1) (<= ?duration 4))"},
        {"duration", "(= ?duration (x))", "(= ?duration (y))"}})
    EXPECT_EQ(kept(pair), (Names{"(grow)", "(one)", "(other)", "(turn)"})) << pair.first << " and " << pair.second;
}

TEST(Ground, AnAbsenceThatIsAskedForGetsAComplement) {
  const Grounded task(R"((:predicates (wet) (dry-enough))
    (:action wipe :parameters () :precondition (wet) :effect (not (wet)))
    (:action check :parameters () :precondition (not (wet)) :effect (dry-enough)))",
                      "(:init (wet)) (:goal (dry-enough))");
  EXPECT_EQ(task.facts(), (Names{"(dry-enough)", "(not (wet))", "(wet)"}));
  for (std::size_t f = 0; f < task->facts.size(); ++f) {
    const int opposite = task->facts[f].complement;
    if (opposite < 0) continue;
    EXPECT_NE(task->initial_facts[f], task->initial_facts[opposite]);
  }
}

TEST(Ground, EffectsKeepAComplementOpposite) {
  const Grounded task(R"((:predicates (wet) (dry-enough))
    (:action wipe :parameters () :precondition (wet) :effect (not (wet)))
    (:action check :parameters () :precondition (not (wet)) :effect (dry-enough)))",
                      "(:init (wet)) (:goal (dry-enough))");
  const auto wipe =
      std::ranges::find_if(task->actions, [](const GroundAction& a) { return !a.at_start.remove.empty(); });
  ASSERT_NE(wipe, task->actions.end());
  ASSERT_EQ(wipe->at_start.remove.size(), 1u);
  EXPECT_EQ(wipe->at_start.add, std::vector<int>{task->facts[wipe->at_start.remove[0]].complement});
}

TEST(Ground, ActionsThatNeedTwoFactsThatAreNeverTrueTogetherAreLeftOut) {
  const Grounded task(R"((:predicates (left) (right) (seen) (both))
    (:action turn-left :parameters () :precondition (right) :effect (and (left) (not (right))))
    (:action turn-right :parameters () :precondition (left) :effect (and (right) (not (left))))
    (:action look :parameters () :precondition (right) :effect (seen))
    (:action stare :parameters () :precondition (and (left) (right)) :effect (seen)))",
                      "(:init (left)) (:goal (seen))");
  EXPECT_EQ(task.actions(), (Names{"(look)", "(turn-left)", "(turn-right)"}));
}

TEST(Ground, TwoFactsOfTheGoalThatAreNeverTrueTogetherAreAProof) {
  const Grounded task(R"((:predicates (left) (right))
    (:action turn-left :parameters () :precondition (right) :effect (and (left) (not (right))))
    (:action turn-right :parameters () :precondition (left) :effect (and (right) (not (left)))))",
                      "(:init (left)) (:goal (and (left) (right)))");
  EXPECT_TRUE(task->proved_unsolvable);
}

TEST(Ground, AFactThatWasPossibleComesBesideOthersLater) {
  // `use` is looked at when `have` has come about without `spare`, and again when it came about beside it.
  const Grounded task(R"((:predicates (coin) (have) (spare) (used))
    (:action buy :parameters () :precondition (coin) :effect (and (have) (not (coin))))
    (:action save :parameters () :precondition (coin) :effect (and (spare) (not (coin))))
    (:action use :parameters () :precondition (have) :effect (used))
    (:action find :parameters () :precondition (spare) :effect (have)))",
                      "(:init (coin)) (:goal (and (used) (spare)))");
  EXPECT_FALSE(task->proved_unsolvable);
  EXPECT_EQ(task.actions(), (Names{"(buy)", "(find)", "(save)", "(use)"}));
}

TEST(Ground, NumbersThatNothingReadsAreLeftOut) {
  const Grounded task(R"((:functions (steps) (fuel) (cost)) (:predicates (there))
    (:action go :parameters () :precondition (>= (fuel) 1)
     :effect (and (there) (decrease (fuel) 1) (increase (steps) 1) (increase (cost) 2))))",
                      "(:init (= (steps) 0) (= (fuel) 1) (= (cost) 0)) (:goal (there)) (:metric minimize (cost))");
  EXPECT_EQ(task->numbers.size(), 2u) << "fuel and cost";
  EXPECT_EQ(significant_numbers(*task), (std::vector<char>{1, 0})) << "cost decides no action and comes last";
}

TEST(Ground, ANumberThatOnlyARateReadsStays) {
  const Grounded task(R"((:functions (level) (speed))
    (:action hurry :parameters () :effect (increase (speed) 1))
    (:durative-action run :parameters () :duration (= ?duration 5) :condition () :effect (increase (level) (* #t (speed)))))",
                      "(:init (= (level) 0) (= (speed) 1)) (:goal (>= (level) 10))");
  EXPECT_EQ(task->numbers.size(), 2u);
}

TEST(Ground, SidesThatShareATermAreComparedAsTheyAre) {
  // 2^53 + 1 is 2^53 where sums are rounded, so the sides are the same, though their terms differ by 1.
  constexpr double kLarge = 9007199254740992;
  using Step = GroundExpression::Step;
  using Kind = GroundExpression::Kind;
  const auto side = [&](int number, const Step& shared) {
    GroundExpression out;
    out.steps = {{Kind::kFunction, number, 0}, shared, {Kind::kAdd, -1, 0}};
    return out;
  };
  const double numbers[] = {1, 0, kLarge};
  for (const Step& shared :
       {Step{Kind::kConstant, -1, kLarge}, Step{Kind::kDuration, -1, 0}, Step{Kind::kFunction, 2, 0}}) {
    const auto more = GroundComparison::of(GroundComparison::Kind::kPositive, side(0, shared), side(1, shared));
    EXPECT_FALSE(more.holds(numbers, kLarge)) << static_cast<int>(shared.kind);
  }
}

TEST(Ground, EventsThatNothingTakesNoticeOfAreLeftOut) {
  const Grounded task(R"((:predicates (there) (open ?d) (dark)) (:functions (toll))
    (:action go :parameters (?d) :precondition (open ?d) :effect (and (there) (when (dark) (increase (toll) 1)))))",
                      R"((:objects near far) (:init (open near) (= (toll) 0)
      (at 2 (not (open near))) (at 3 (not (open far))) (at 4 (dark)) (at 5 (not (there))))
    (:goal (there)) (:metric minimize (toll)))");
  std::vector<double> times;
  for (const TimedEvent& event : task->events) times.push_back(static_cast<double>(event.time) / kMicrosPerSecond);
  EXPECT_EQ(times, (std::vector<double>{2, 4, 5})) << "far is never open";
}

TEST(Ground, ADurationThatEffectsReadIsOfferedSeveralTimes) {
  const std::string domain = R"((:functions (level)) (:predicates (idle))
    (:durative-action fill :parameters () :duration (and (>= ?duration 1) (<= ?duration 9)) :condition (at start (idle))
     :effect (and (at start (not (idle))) (at end (idle)) (increase (level) (* #t 2)))))";
  const Grounded task(domain, "(:init (idle) (= (level) 0)) (:goal (>= (level) 7))");
  std::vector<double> stretches;
  int aims = 0;
  for (const GroundAction& action : task->actions) {
    aims += action.aim >= 0;
    if (action.aim < 0) stretches.push_back(action.stretch);
  }
  EXPECT_EQ(aims, 1) << "until the comparison of the goal turns";
  EXPECT_EQ(stretches, (std::vector<double>{0, 0.125, 0.25, 0.5, 1}));
}

TEST(Ground, AnActionThatTakesNoTimeHasTheEffectsOfBothItsEnds) {
  const Grounded task(R"((:functions (a) (b)) (:predicates (p) (q) (r))
    (:durative-action both :parameters () :duration (= ?duration 0) :condition (at start (p))
     :effect (and (at start (increase (a) 1)) (at end (increase (b) 2)) (at start (q)) (at end (r)))))",
                      "(:init (p) (= (a) 0) (= (b) 0)) (:goal (and (q) (r) (>= (a) 2) (>= (b) 4)))");
  ASSERT_EQ(task->actions.size(), 1u);
  const GroundAction& action = task->actions[0];
  EXPECT_FALSE(action.durative);
  EXPECT_EQ(action.at_start.add.size(), 2u);
  ASSERT_EQ(action.at_start.numbers.size(), 2u) << "those of its end, too";
  EXPECT_NE(action.at_start.numbers[0].number, action.at_start.numbers[1].number);
  EXPECT_TRUE(action.at_end.empty());
}

TEST(Ground, DerivedReadsNameWhatRulesRead) {
  const Grounded task(R"((:predicates (on ?x) (lit) (shut) (plain) (done))
    (:derived (lit) (and (exists (?x) (on ?x)) (not (shut))))
    (:action read :parameters () :precondition (and (lit) (plain)) :effect (done))
    (:action shut-it :parameters () :precondition () :effect (shut))
    (:action open-it :parameters () :precondition () :effect (not (shut)))
    (:action switch :parameters (?x) :precondition () :effect (on ?x)))",
                      "(:objects a) (:init (plain)) (:goal (done))");
  ASSERT_EQ(task->derived_reads.size(), 4u);
  EXPECT_EQ(task->derived_reads[0].start.predicates, (std::vector<char>{1, 0, 1, 0, 0}))
      << "on and shut through the rule; plain is read directly";
  EXPECT_TRUE(task->derived_reads[1].start.predicates.empty());
}

TEST(Relaxation, WhatCanBeginButNeverEndIsNotApplicable) {
  const Grounded made(R"((:predicates (a) (b) (c) (goal))
    (:durative-action half :parameters () :duration (= ?duration 1) :condition (and (at start (a)) (at end (c))) :effect (at start (b)))
    (:action use :parameters () :precondition (b) :effect (goal))
    (:action other :parameters () :precondition (a) :effect (goal))
    (:action make-c :parameters () :precondition (c) :effect (c)))",
                      "(:init (a)) (:goal (goal))");
  EXPECT_EQ(made.actions(), Names{"(other)"});
}

TEST(Relaxation, NumbersMoveOnlyWhereActionsMoveThem) {
  const std::string domain = R"((:functions (x)) (:predicates (done))
    (:action up :parameters () :precondition () :effect (increase (x) 1))
    (:action finish :parameters () :precondition (%) :effect (done)))";
  const auto solvable = [&](const std::string& condition) {
    std::string with = domain;
    with.replace(with.find("(%)"), 3, condition);
    return !Grounded(with, "(:init (= (x) 5)) (:goal (done))")->proved_unsolvable;
  };
  EXPECT_TRUE(solvable("(>= (x) 100)"));
  EXPECT_TRUE(solvable("(= (x) 9)"));
  EXPECT_FALSE(solvable("(<= (x) 4)")) << "it never falls";
  EXPECT_FALSE(solvable("(< (* 2 (x)) 10)"));
  EXPECT_TRUE(solvable("(> (- 6 (x)) 0)")) << "true from the start";
  EXPECT_FALSE(solvable("(> (- 5 (x)) 0)"));
}

TEST(Ground, ListsTheNumbersWithoutAValueOnlyWhereTheyKeepTheGoalOutOfReach) {
  const std::string domain = R"((:functions (fuel ?c) (height)) (:predicates (there ?c))
    (:action drive :parameters (?c) :precondition (>= (fuel ?c) 1) :effect (there ?c))
    (:action sink :parameters () :effect (decrease (height) 1)))";
  const auto missing = [&](const std::string& fuel, const std::string& goal) {
    return Grounded(domain, "(:objects a) (:init (= (height) 0) " + fuel + ") (:goal " + goal + ")")
        ->missing_values.size();
  };
  EXPECT_EQ(missing("", "(there a)"), 1u);
  EXPECT_EQ(missing("(= (fuel a) 2)", "(there a)"), 0u);
  EXPECT_EQ(missing("", "(and (there a) (<= (height) -2))"), 1u);
  EXPECT_EQ(missing("", "(and (there a) (>= (height) 2))"), 0u) << "no value would help";
}

}  // namespace
}  // namespace cxlab::planner
