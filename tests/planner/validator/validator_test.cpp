#include "planner/validator/validator.h"

#include <gmock/gmock.h>

#include "checker.h"

namespace cxlab::planner {
namespace {

using ::testing::HasSubstr;

// A robot walks between places; it works where it stands, while the place is open.
const char* kWorld = R"((:types robot place)
  (:predicates (at ?r - robot ?p - place) (road ?a ?b - place) (open ?p - place) (free ?r - robot) (done ?p - place) (dirty ?p - place))
  (:durative-action go :parameters (?r - robot ?a ?b - place) :duration (= ?duration 5)
    :condition (and (at start (at ?r ?a)) (over all (road ?a ?b)))
    :effect (and (at start (not (at ?r ?a))) (at end (at ?r ?b))))
  (:durative-action work :parameters (?r - robot ?p - place) :duration (and (>= ?duration 2) (<= ?duration 4))
    :condition (and (at start (free ?r)) (over all (at ?r ?p)) (over all (open ?p)) (at end (not (dirty ?p))))
    :effect (and (at start (not (free ?r))) (at end (free ?r)) (at end (done ?p))))
  (:action sweep :parameters (?p - place) :precondition (dirty ?p) :effect (not (dirty ?p)))
  (:action soil :parameters (?p - place) :precondition (not (dirty ?p)) :effect (dirty ?p)))";
const char* kStart =
    R"((:objects r - robot a b - place) (:init (at r a) (free r) (road a b) (open b)) (:goal (done b)))";

TEST(Validator, AcceptsAValidPlan) {
  const auto verdict = Checker(kWorld, kStart).check("0: (go r a b) [5]\n5.001: (work r b) [2.5]\n");
  ASSERT_TRUE(verdict);
  EXPECT_TRUE(verdict->valid);
  EXPECT_NEAR(verdict->makespan, 7.501, 1e-9);
}

TEST(Validator, ConditionAtStartIsReadBeforeTheHappening) {
  EXPECT_EQ(Checker(kWorld, kStart).verdict("0: (go r a b) [5]\n6: (go r a b) [5]\n"),
            "6.000: (go r a b) (line 2): a condition at start does not hold at 6.000: (at r a); (at r a) was made "
            "false by the start of "
            "0.000: (go r a b) (line 1)\n  advice: add a step before 6.000 that makes it true: go");
}

TEST(Validator, AConditionThatBecomesTrueLaterGetsAdvice) {
  EXPECT_EQ(Checker(kWorld, kStart).verdict("0: (go r a b) [5]\n4: (work r b) [2]\n"),
            "4.000: (work r b) (line 2): a condition over all does not hold at 4.000: (at r b); (at r b) has been "
            "false from the beginning\n"
            "  advice: let 4.000: (work r b) (line 2) begin at 5.001 or later: the end at 5.000 of 0.000: (go r a b) "
            "(line 1) makes (at r b) true");
}

TEST(Validator, ConditionOverAllFailsWhereAnActionDeletesItsFact) {
  const char* start =
      R"((:objects r - robot a b - place) (:init (at r b) (free r) (road b a) (open b)) (:goal (done b)))";
  EXPECT_EQ(Checker(kWorld, start).verdict("0: (work r b) [3]\n2: (go r b a) [5]\n"),
            "0.000: (work r b) (line 1): a condition over all does not hold at 2.000: (at r b); (at r b) was made "
            "false by the start of "
            "2.000: (go r b a) (line 2)\n  advice: let the start of 2.000: (go r b a) (line 2) wait until 3.000, when "
            "0.000: (work r b) (line 1) has ended");
  EXPECT_EQ(Checker(kWorld, start).verdict("0: (work r b) [3]\n3: (go r b a) [5]\n"), "valid")
      << "the interval is open";
}

TEST(Validator, HappeningsThatInterfereAreEpsilonApart) {
  const Checker checker(kWorld, kStart);
  const auto valid = [&](const std::string& sweep, double epsilon) {
    const auto verdict = checker.check("0: (soil a)\n" + sweep + ": (sweep a)\n1: (go r a b) [5]\n7: (work r b) [2]\n",
                                       {.epsilon = epsilon});
    EXPECT_TRUE(verdict);
    EXPECT_TRUE(verdict->valid || verdict->violation->kind == Violation::Kind::kInterference);
    return verdict->valid;
  };
  EXPECT_TRUE(valid("0.001", 0.001));
  EXPECT_FALSE(valid("0.000999", 0.001));
  EXPECT_FALSE(valid("0.0006", 0.001)) << "more than half of epsilon";
  EXPECT_FALSE(valid("0.0001", 0.001));
  EXPECT_TRUE(valid("0.0006", 0.0005));
  EXPECT_FALSE(valid("0.009", 0.01));
  const char* between =
      "0: (soil a)\n0.0005: (soil b)\n0.001: (sweep a)\n0.5: (sweep b)\n1: (go r a b) [5]\n7: (work r b) [2]";
  EXPECT_EQ(checker.verdict(between, {.epsilon = 0.001}), "valid") << "also where something happens in between";
  EXPECT_THAT(checker.verdict(between, {.epsilon = 0.0011}), HasSubstr("(dirty a)"));
}

TEST(Validator, ConditionAtEndIsReadBeforeTheEnd) {
  const char* start = R"((:objects r - robot b - place) (:init (at r b) (free r) (open b)) (:goal (done b)))";
  const Checker checker(kWorld, start);
  EXPECT_EQ(checker.verdict("0: (work r b) [3]\n1: (soil b)\n2: (sweep b)"), "valid");
  EXPECT_THAT(checker.verdict("0: (work r b) [3]\n1: (soil b)\n"),
              HasSubstr("a condition at end does not hold at 3.000: (not (dirty b)); (dirty b) was made true by 1.000: "
                        "(soil b) (line 2)\n"
                        "  advice: add a step before 3.000 that makes it false: sweep"));
}

TEST(Validator, DurationMustBeWithinItsBounds) {
  const Checker checker(kWorld, kStart);
  EXPECT_EQ(checker.verdict("0: (go r a b) [6]"),
            "0.000: (go r a b) (line 1): the duration is 6.000, expected 5.000\n  advice: write [5.000]");
  EXPECT_THAT(checker.verdict("0: (go r a b) [5]\n5.001: (work r b) [1]"),
              HasSubstr("the duration is 1.000, expected at least 2.000"));
  EXPECT_THAT(checker.verdict("0: (go r a b) [5]\n5.001: (work r b) [5]"),
              HasSubstr("the duration is 5.000, expected at most 4.000"));
  EXPECT_EQ(checker.verdict("0: (go r a b) [5.001]\n5.002: (work r b) [3]"), "valid") << "within the tolerance";
  EXPECT_EQ(checker.verdict("0: (go r a b) [4.999]\n5.002: (work r b) [3]"), "valid") << "within the tolerance";
  EXPECT_THAT(checker.verdict("0: (go r a b) [4.998]"), HasSubstr("the duration is 4.998, expected 5.000"));
  EXPECT_THAT(checker.verdict("0: (go r a b) [5.002]"), HasSubstr("the duration is 5.002, expected 5.000"));
}

TEST(Validator, InterferingHappeningsNeedEpsilon) {
  const Checker checker(kWorld, kStart);
  EXPECT_EQ(checker.verdict("0: (go r a b) [5]\n5: (work r b) [3]\n"), "valid")
      << "over all (at r b) counts in the open interval, and the start of work does not read it";
  const char* both = R"((:objects r - robot a b - place) (:init (at r a) (road a b) (road b a)) (:goal (at r a)))";
  EXPECT_EQ(Checker(kWorld, both).verdict("0: (go r a b) [5]\n5: (go r b a) [5]\n"),
            "5.000: (go r b a) (line 2): a condition at start does not hold at 5.000: (at r b); (at r b) has been "
            "false from the beginning\n"
            "  advice: let 5.000: (go r b a) (line 2) begin at 5.001 or later: the end at 5.000 of 0.000: (go r a b) "
            "(line 1) makes (at r b) true");
  EXPECT_EQ(Checker(kWorld, both).verdict("0: (go r a b) [5]\n5.0005: (go r b a) [5]\n"),
            "the end at 5.000 of 0.000: (go r a b) (line 1) and the start of 5.0005: (go r b a) (line 2) both use (at "
            "r b) and one of them "
            "changes it; they are 0.0005 s apart, expected at least 0.001 s\n  advice: move one of them by 0.0005 s");
  EXPECT_EQ(Checker(kWorld, both).verdict("0: (go r a b) [5]\n5.001: (go r b a) [5]\n"), "valid");
  EXPECT_EQ(Checker(kWorld, both).verdict("0: (go r a b) [5]\n5.0005: (go r b a) [5]\n", {0.0001, 0.001}), "valid");
}

TEST(Validator, AddingAndDeletingAFactAtOneTimeInterfere) {
  const char* start = R"((:objects r - robot a - place) (:init (dirty a)) (:goal (and)))";
  const char* world = R"((:types place robot) (:predicates (dirty ?p - place))
    (:action sweep :parameters (?p - place) :effect (not (dirty ?p))) (:action soil :parameters (?p - place) :effect (dirty ?p)))";
  EXPECT_THAT(Checker(world, start).verdict("1: (sweep a)\n1: (soil a)"),
              HasSubstr("at the same time, expected at least 0.001 s"));
  EXPECT_EQ(Checker(world, start).verdict("1: (sweep a)\n1: (sweep a)"), "valid");
}

TEST(Validator, AConditionReadsAllThatItNamesAsInVAL) {
  const auto verdict = [](const std::string& condition) {
    return Checker(
               R"((:types lamp) (:constants l m - lamp) (:predicates (on ?l - lamp) (fixed ?l - lamp) (loose ?l - lamp) (seen))
      (:action look :precondition )" +
                   condition +
                   R"( :effect (seen)) (:action switch-off :parameters (?l - lamp) :precondition (fixed ?l) :effect (not (on ?l))))",
               "(:init (fixed l) (on l)) (:goal (seen))")
        .verdict("1: (look)\n1: (switch-off l)");
  };
  for (const char* condition :
       {"(or (fixed l) (on l))", "(imply (loose l) (on l))", "(forall (?l - lamp) (imply (loose ?l) (on ?l)))",
        "(exists (?l - lamp) (or (fixed ?l) (on ?l)))", "(or (= l l) (on l))"})
    EXPECT_THAT(verdict(condition), HasSubstr("(on l)")) << condition;
  EXPECT_EQ(verdict("(not (on m))"), "valid");
}

TEST(Validator, AConditionOfAnEffectReadsOnlyWhatCanMatter) {
  const auto verdict = [](const std::string& condition) {
    return Checker(R"((:predicates (on) (fixed) (loose) (seen) (noted)) (:action look :effect (and (seen) (when )" +
                       condition + R"( (noted))))
      (:action switch-off :precondition (fixed) :effect (not (on))))",
                   "(:init (fixed) (on)) (:goal (seen))")
        .verdict("1: (look)\n1: (switch-off)");
  };
  EXPECT_EQ(verdict("(and (loose) (on))"), "valid");
  EXPECT_THAT(verdict("(and (fixed) (on))"), HasSubstr("(on)"));
}

TEST(Validator, AConditionOfAnEffectIsReadAtTheTimeThatItNames) {
  const auto verdict = [](const std::string& time, const std::string& switched) {
    return Checker(R"((:predicates (on) (seen) (noted))
      (:durative-action look :duration (= ?duration 5)
        :effect (and (at end (seen)) (when (at )" +
                       time + R"( (on)) (at end (noted)))))
      (:action switch-off :effect (not (on))))",
                   "(:init (on)) (:goal (seen))")
        .verdict("1: (look) [5]\n" + switched + ": (switch-off)");
  };
  EXPECT_THAT(verdict("start", "1"), HasSubstr("(on)"));
  EXPECT_EQ(verdict("start", "6"), "valid");
  EXPECT_EQ(verdict("end", "1"), "valid");
  EXPECT_THAT(verdict("end", "6"), HasSubstr("(on)"));
}

TEST(Validator, AConditionOfAnEffectThatIsDecidedReadsNothing) {
  const auto verdict = [](const std::string& condition) {
    return Checker(R"((:types lamp) (:constants l m - lamp)
      (:predicates (on ?l - lamp) (fixed ?l - lamp) (seen) (noted)) (:functions (left))
      (:action look :effect (and (seen) (when )" +
                       condition + R"( (noted))))
      (:action switch-off :effect (and (not (on l)) (not (on m)) (decrease (left) 1))))",
                   "(:init (fixed l) (on l) (on m) (= (left) 5)) (:goal (seen))")
        .verdict("1: (look)\n1: (switch-off)");
  };
  for (const char* decided :
       {"(or (fixed l) (on l))", "(and (fixed m) (on l))", "(imply (fixed m) (on l))", "(imply (on l) (fixed l))",
        "(exists (?l - lamp) (or (fixed ?l) (on ?l)))", "(forall (?l - lamp) (and (fixed ?l) (on ?l)))",
        "(not (or (fixed l) (on l)))", "(or (fixed l) (> (left) 2))", "(and (not (fixed l)) (> (left) 2))",
        "(or (= l l) (on l))", "(and (= l m) (on l))"})
    EXPECT_EQ(verdict(decided), "valid") << decided;
  for (const auto& [open, read] : {std::pair{"(or (fixed m) (on l))", "(on l)"},
                                   {"(and (fixed l) (on l))", "(on l)"},
                                   {"(imply (fixed l) (on m))", "(on m)"},
                                   {"(imply (on l) (fixed m))", "(on l)"},
                                   {"(exists (?l - lamp) (and (fixed ?l) (on ?l)))", "(on l)"},
                                   {"(forall (?l - lamp) (or (fixed ?l) (on ?l)))", "(on "},
                                   {"(not (on m))", "(on m)"},
                                   {"(and (fixed l) (> (left) 2))", "(left)"},
                                   {"(or (= l m) (on m))", "(on m)"}})
    EXPECT_THAT(verdict(open), HasSubstr(read)) << open;
}

TEST(Validator, GoalMustHoldAtTheEnd) {
  EXPECT_EQ(
      Checker(kWorld, kStart).verdict("0: (go r a b) [5]"),
      "the goal does not hold at the end of the plan (5.000): (done b); (done b) has been false from the beginning\n"
      "  advice: add a step before 5.000 that makes it true: work");
  EXPECT_THAT(Checker(kWorld, kStart).verdict(""), HasSubstr("the goal does not hold"));
}

TEST(Validator, ConditionThatNoActionChangesNamesTheProblem) {
  EXPECT_THAT(Checker(kWorld, R"((:objects r - robot a b - place) (:init (at r a)) (:goal (and)))")
                  .verdict("0: (go r a b) [5]"),
              HasSubstr("(road a b) has been false from the beginning\n  advice: no action changes road: choose other "
                        "arguments, or fix :init of p.pddl"));
}

TEST(Validator, StepsMayNotBeginBeforeZero) {
  EXPECT_EQ(Checker(kWorld, kStart).verdict("-1440: (go r a b) [5]"),
            "-1440.000: (go r a b) (line 1) begins before 0\n  advice: let all steps begin 1440.000 s later");
  EXPECT_THAT(Checker(kWorld, kStart).verdict("-0.5: (go r a b) [5]"), HasSubstr("begins before 0"));
}

TEST(Validator, QuantifiersAndImplicationsNameTheObject) {
  const char* world = R"((:types lamp) (:predicates (on ?l - lamp) (mine ?l - lamp) (lit))
    (:action off :parameters (?l - lamp) :precondition (on ?l) :effect (not (on ?l)))
    (:action leave :precondition (forall (?l - lamp) (imply (mine ?l) (not (on ?l)))) :effect (lit))
    (:action stay :precondition (exists (?l - lamp) (and (mine ?l) (on ?l))) :effect (lit)))";
  const char* start = R"((:objects x y z - lamp) (:init (on x) (on y) (on z) (mine x) (mine y)) (:goal (lit)))";
  const Checker checker(world, start);
  EXPECT_EQ(checker.verdict("0: (off x)\n1: (leave)"),
            "1.000: (leave) (line 2): a condition does not hold at 1.000: (not (on y)); (on y) has been true from the "
            "beginning\n"
            "  advice: add a step before 1.000 that makes it false: off");
  EXPECT_EQ(checker.verdict("0: (off x)\n0: (off y)\n1: (leave)"), "valid");
  EXPECT_EQ(checker.verdict("0: (off x)\n0: (off y)\n0.0005: (off z)\n1: (leave)"), "valid");
  EXPECT_EQ(checker.verdict("0: (stay)"), "valid");
  EXPECT_THAT(checker.verdict("0: (off x)\n0: (off y)\n1: (stay)"),
              HasSubstr("(exists (?l - lamp) (and (mine ?l) (on ?l)))"));
  EXPECT_THAT(checker.verdict("0: (off z)\n0: (stay)"), HasSubstr("both use (on z)"))
      << "z does not belong to the owner, but the message names its lamp";
  EXPECT_THAT(checker.verdict("0: (off x)\n0: (stay)"), HasSubstr("both use (on x)"));
}

TEST(Validator, ConditionalAndUniversalEffectsAreEvaluatedInTheState) {
  const char* world = R"((:types box) (:predicates (in ?b - box) (wet ?b - box) (rain) (ready))
    (:action carry :effect (forall (?b - box) (when (rain) (wet ?b))))
    (:action stop :effect (not (rain))))";
  const char* start = R"((:objects x y - box) (:init (rain)) (:goal (and (wet x) (wet y))))";
  EXPECT_EQ(Checker(world, start).verdict("1: (carry)"), "valid");
  EXPECT_THAT(Checker(world, start).verdict("0: (stop)\n1: (carry)"), HasSubstr("(wet x) has been false"));
}

TEST(Validator, EffectAtEndMayDependOnStartAndOverAll) {
  const char* world = R"((:predicates (light) (seen) (ready) (found))
    (:durative-action watch :parameters () :duration (= ?duration 10)
      :effect (and (when (at start (light)) (at end (seen))) (when (and (at start (light)) (over all (light))) (at end (ready)))
        (when (and (at start (light)) (at end (light))) (at end (found)))))
    (:action dim :effect (not (light))) (:action shine :effect (light)))";
  const auto with_goal = [&](const char* goal) {
    return Checker(world, std::string("(:init (light)) (:goal ") + goal + ")");
  };
  EXPECT_EQ(with_goal("(and (seen) (ready))").verdict("0: (watch) [10]"), "valid");
  EXPECT_EQ(with_goal("(and (seen) (not (ready)))").verdict("0: (watch) [10]\n5: (dim)\n6: (shine)"), "valid");
  EXPECT_EQ(with_goal("(and (found) (not (ready)))").verdict("0: (watch) [10]\n5: (dim)\n6: (shine)"), "valid");
  EXPECT_EQ(with_goal("(and (seen) (not (found)))").verdict("0: (watch) [10]\n5: (dim)"), "valid");
  EXPECT_EQ(with_goal("(not (seen))").verdict("0: (dim)\n1: (watch) [10]\n2: (shine)"), "valid");
}

TEST(Validator, DerivedFactsFollowTheState) {
  const char* world = R"((:types place) (:predicates (road ?a ?b - place) (reach ?a ?b - place) (arrived))
    (:derived (reach ?a ?b - place) (or (road ?a ?b) (exists (?c - place) (and (reach ?a ?c) (road ?c ?b)))))
    (:action build :parameters (?a ?b - place) :effect (road ?a ?b))
    (:action travel :parameters (?a ?b - place) :precondition (reach ?a ?b) :effect (arrived)))";
  const Checker checker(world, "(:objects a b c - place) (:init (road a b)) (:goal (arrived))");
  EXPECT_EQ(checker.verdict("0: (build b c)\n1: (travel a c)"), "valid");
  EXPECT_THAT(checker.verdict("1: (travel a c)"), HasSubstr("(reach a c); reach is derived by a rule"));
  EXPECT_THAT(checker.verdict("0: (build b c)\n0.0001: (travel a c)"), HasSubstr("both use (road b c)"));
}

TEST(Validator, BasesOfADerivedFactInterfereThroughOtherDerivedFacts) {
  const char* world = R"((:predicates (road) (open) (way) (arrived)) (:functions (water))
    (:derived (way) (open)) (:derived (open) (and (road) (<= (water) 2)))
    (:action mend :effect (road)) (:action pump :effect (decrease (water) 1))
    (:action travel :precondition (way) :effect (arrived)))";
  const Checker checker(world, "(:init (road) (= (water) 1)) (:goal (arrived))");
  EXPECT_EQ(checker.verdict("0: (mend)\n0.001: (pump)\n0.002: (travel)"), "valid");
  EXPECT_THAT(checker.verdict("0: (mend)\n0.0001: (travel)"), HasSubstr("both use (road)"));
  EXPECT_THAT(checker.verdict("0: (pump)\n0.0001: (travel)"), HasSubstr("both use (water)"));
}

TEST(Validator, ADerivedFactThatReadsTheAbsenceOfAnotherComesAfterIt) {
  const auto verdict = [](const std::string& condition) {
    return Checker("(:predicates (road) (quiet) (reach) (calm) (left)) (:derived (calm) " + condition +
                       ") (:derived (reach) (road)) (:action leave :precondition (calm) :effect (left))",
                   "(:init (road)) (:goal (left))")
        .verdict("0: (leave)");
  };
  for (const char* condition : {"(not (reach))", "(imply (reach) (quiet))", "(not (and (road) (reach)))"})
    EXPECT_THAT(verdict(condition), HasSubstr("(calm)")) << condition << ": there is a road";
  EXPECT_EQ(verdict("(not (and (quiet) (reach)))"), "valid");
}

TEST(Validator, AFactThatOneActionDeletesAndAddsIsTrueAfterwards) {
  EXPECT_EQ(
      Checker("(:predicates (lit)) (:action flicker :effect (and (lit) (not (lit))))", "(:init (lit)) (:goal (lit))")
          .verdict("1: (flicker)"),
      "valid");
}

TEST(Validator, EventsFromOutsideOpenAndCloseWindows) {
  const char* start =
      R"((:objects r - robot b - place) (:init (at r b) (free r) (at 5 (open b)) (at 9 (not (open b)))) (:goal (done b)))";
  const Checker checker(kWorld, start);
  EXPECT_EQ(checker.verdict("5: (work r b) [4]"), "valid") << "over all counts inside the window";
  EXPECT_EQ(checker.verdict("4: (work r b) [4]"),
            "4.000: (work r b) (line 1): a condition over all does not hold at 4.000: (open b); (open b) has been "
            "false from the beginning\n"
            "  advice: let 4.000: (work r b) (line 1) begin at 5.001 or later: the initial state's event at 5.000 "
            "makes (open b) true");
  EXPECT_EQ(checker.verdict("6: (work r b) [4]"),
            "6.000: (work r b) (line 1): a condition over all does not hold at 9.000: (open b); (open b) was made "
            "false by the initial state's "
            "event at 9.000\n  advice: let 6.000: (work r b) (line 1) end at 9.000 or before");
}

TEST(Validator, TheGoalIsJudgedAfterAllEvents) {
  const char* world = "(:predicates (lit) (day)) (:action light :effect (lit))";
  EXPECT_EQ(Checker(world, "(:init (at 9 (day))) (:goal (and (lit) (day)))").verdict("1: (light)"), "valid");
  EXPECT_EQ(Checker(world, "(:init (at 9 (not (lit)))) (:goal (lit))").verdict("1: (light)"),
            "the goal does not hold after the last event from outside (9.000): (lit); (lit) was made false by the "
            "initial state's event at 9.000\n"
            "  advice: add a step after 9.000 that makes it true: light");
  EXPECT_EQ(Checker(world, "(:init (at 9 (not (lit)))) (:goal (lit))").verdict("9.5: (light)"), "valid");
  EXPECT_EQ(Checker(world, "(:init (at 8 (not (lit))) (at 9 (lit))) (:goal (lit))").verdict("1: (light)"), "valid");
}

TEST(Validator, AcceptsRequiredConcurrency) {
  const char* world = R"((:types match fuse) (:predicates (light) (unused ?m - match) (mended ?f - fuse))
    (:durative-action burn :parameters (?m - match) :duration (= ?duration 5) :condition (at start (unused ?m))
      :effect (and (at start (light)) (at start (not (unused ?m))) (at end (not (light)))))
    (:durative-action mend :parameters (?f - fuse) :duration (= ?duration 4) :condition (over all (light)) :effect (at end (mended ?f))))";
  const Checker checker(world, "(:objects m - match f - fuse) (:init (unused m)) (:goal (mended f))");
  EXPECT_EQ(checker.verdict("0: (burn m) [5]\n0.001: (mend f) [4]"), "valid");
  EXPECT_THAT(checker.verdict("0: (burn m) [5]\n1.5: (mend f) [4]"),
              HasSubstr("(light) was made false by the end at 5.000 of 0.000: (burn m)"));
}

}  // namespace
}  // namespace cxlab::planner
