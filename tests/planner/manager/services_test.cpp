#include "fixture.h"

namespace cxlab::planner {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

TEST_F(ManagerTest, AnInstanceIsAskedAboutUnderTheNamesOfBothPackages) {
  start();
  load_blocks();
  EXPECT_THAT(texts(ask("get_action_names", "GetActionNames", "{pddl_instance: bw}").view(), "action_names"),
              ElementsAre("pick-up", "put-down", "stack", "unstack"));
  EXPECT_THAT(texts(ask("get_action_names", "GetActionNames", "{pddl_instance: bw}", "expertino_msgs").view(), "action_names"),
              ElementsAre("pick-up", "put-down", "stack", "unstack"));
  EXPECT_THAT(fluents("bw"), ElementsAre("on(c a)", "ontable(a)", "ontable(b)", "clear(b)", "clear(c)", "handempty()"));
  EXPECT_THAT(texts(ask("get_type_objects", "GetTypeObjects", "{pddl_instance: bw, type: block}").view(), "objects"), ElementsAre("a", "b", "c"));
  const bus::Message predicates = ask("get_predicates", "GetPredicates", "{pddl_instance: bw}");
  ASSERT_EQ(predicates->size("predicates"), 5u);
  EXPECT_THAT(texts(predicates->nested("predicates", 0), "param_names"), ElementsAre("x", "y"));
  const bus::Message functions = ask("get_functions", "GetFunctions", "{pddl_instance: bw}");
  ASSERT_EQ(functions->size("functions"), 1u);
  EXPECT_EQ(functions->nested("functions", 0).text("name"), "moves");
  EXPECT_THAT(check("{pddl_instance: bw, name: pick-up, args: [a]}", "check_action_precondition", "CheckActionPrecondition", "expertino_msgs"),
              ElementsAre("clear(a)"));
}

TEST_F(ManagerTest, WhatIsSetIsSoAndListenersHearOfIt) {
  start();
  load_blocks();
  const auto heard = listen("/pddl_manager/instance_update", "std_msgs/msg/String");
  tell("rm_fluents", "RemoveFluents", "{fluents: [{pddl_instance: bw, name: on, args: [c, a]}]}");
  tell("add_fluents", "AddFluents", "{fluents: [{pddl_instance: bw, name: on, args: [c, b]}, {pddl_instance: bw, name: clear, args: [a]}]}");
  tell("set_functions", "SetFunctions", "{functions: [{pddl_instance: bw, name: moves, args: [], value: 7}]}");
  tell("add_objects", "AddObjects", "{objects: [{pddl_instance: bw, name: d, type: block}]}");
  tell("add_fluent", "AddFluent", "{fluent: {pddl_instance: bw, name: ontable, args: [d]}}");
  EXPECT_EQ(heard->size(), 5u);
  EXPECT_THAT(fluents("bw"), ElementsAre("ontable(a)", "ontable(b)", "clear(b)", "clear(c)", "handempty()", "on(c b)", "clear(a)", "ontable(d)"));
  EXPECT_EQ(ask("get_functions", "GetFunctions", "{pddl_instance: bw}")->nested("functions", 0).real("value"), 7);
}

TEST_F(ManagerTest, AnObjectTakesItsFactsAndGoalsWithIt) {
  start();
  load_blocks();
  tell("set_goals", "SetGoals", "{goal_instance: base, fluents: [{pddl_instance: bw, name: on, args: [b, c]}, {pddl_instance: bw, name: ontable, args: [c]}]}");
  tell("rm_objects", "RemoveObjects", "{objects: [{pddl_instance: bw, name: b, type: block}]}");
  EXPECT_THAT(fluents("bw"), ElementsAre("on(c a)", "ontable(a)", "clear(c)", "handempty()"));
  const auto answer = plan("{pddl_instance: bw, goal_instance: base}");
  ticks(200);
  EXPECT_THAT(answer->actions, ElementsAre("unstack(c a) @0.00+3 class 0", HasSubstr("put-down(c) @3.00+2 class 1")));
}

TEST_F(ManagerTest, ErrorsNameWhatWasFoundAndChangeNothing) {
  start();
  load_blocks();
  EXPECT_EQ(error_of("get_fluents", "GetFluents", "{pddl_instance: bv}"), "unknown pddl instance 'bv', did you mean 'bw'?");
  EXPECT_EQ(error_of("add_fluents", "AddFluents", "{fluents: [{pddl_instance: bw, name: clear, args: [a]}, {pddl_instance: bw, name: klear, args: [a]}]}"),
            "unknown fluent 'klear', did you mean 'clear'?");
  EXPECT_EQ(error_of("add_fluents", "AddFluents", "{fluents: [{pddl_instance: bw, name: on, args: [a]}]}"), "'on': found 1 arguments, expected 2");
  EXPECT_THAT(fluents("bw"), ::testing::Not(::testing::Contains("clear(a)")));
  EXPECT_THAT(error_of("set_action_filter", "SetActionFilter", "{pddl_instance: bw, goal_instance: other, actions: []}"), HasSubstr("create it first"));
  EXPECT_THAT(error_of("add_pddl_instance", "AddPddlInstance", "{name: y, directory: /, domain_file: nowhere.pddl}"), HasSubstr("/nowhere.pddl: there is no such file"));
  std::ofstream(folder_ / "d.pddl") << "(define (domain d)\n (:predicates (p))\n (:action a :precondition (q) :effect (p)))";
  EXPECT_THAT(error_of("add_pddl_instance", "AddPddlInstance", "{name: y, directory: \"" + folder_.string() + "\", domain_file: d.pddl}"), HasSubstr("d.pddl:3:"));
}

TEST_F(ManagerTest, ADomainAloneMakesAnInstance) {
  start();
  tell("add_pddl_instance", "AddPddlInstance", "{name: bw, directory: \"" + blocks_folder() + "\", domain_file: domain.pddl}");
  EXPECT_THAT(fluents("bw"), IsEmpty());
  tell("add_objects", "AddObjects", "{objects: [{pddl_instance: bw, name: a, type: block}]}");
  EXPECT_THAT(check("{pddl_instance: bw, name: pick-up, args: [a]}"), ElementsAre("clear(a)", "ontable(a)", "handempty"));
}

// --- What the original gets wrong

constexpr const char* kSwitches = R"((define (domain switches)
  (:requirements :adl :durative-actions :numeric-fluents)
  (:types lamp room)
  (:predicates (lit ?l - lamp) (broken ?l - lamp) (power) (guarded))
  (:functions (used) (price ?l - lamp))
  (:durative-action light-all
    :parameters (?r - room)
    :duration (= ?duration 4)
    :condition (and (at start (power)) (over all (guarded)) (at end (forall (?l - lamp) (not (broken ?l)))))
    :effect (and (forall (?l - lamp) (when (at start (not (broken ?l))) (at start (lit ?l))))
                 (at end (increase (used) (+ (used) (* 2 ?duration))))))
  (:action smash
    :parameters (?l - lamp)
    :precondition (and (forall (?m - lamp) (lit ?m)) (<= (price ?l) 3))
    :effect (and (broken ?l) (when (lit ?l) (not (lit ?l))) (increase (used) (price ?l)))))
)";
constexpr const char* kTwoLamps = R"((define (problem p) (:domain switches)
  (:objects l1 l2 - lamp r - room)
  (:init (power) (broken l2) (= (used) 1) (= (price l1) 5) (= (price l2) 2))
  (:goal (and))))";

TEST_F(ManagerTest, EffectsAreThoseOfTheStateOfNow) {
  start();
  load_text(kSwitches, kTwoLamps);
  EXPECT_THAT(effects("{pddl_instance: x, name: light-all, args: [r]}"), UnorderedElementsAre("START +lit(l1)", "END used() + 9"));
  EXPECT_THAT(effects("{pddl_instance: x, name: smash, args: [l1]}"), UnorderedElementsAre("START +broken(l1)", "START used() + 5"));
  tell("add_fluents", "AddFluents", "{fluents: [{pddl_instance: x, name: lit, args: [l1]}]}");
  EXPECT_THAT(effects("{pddl_instance: x, name: smash, args: [l1]}"), UnorderedElementsAre("START +broken(l1)", "START -lit(l1)", "START used() + 5"));
}

TEST_F(ManagerTest, ConditionsAreCheckedAtEveryTimeOfAnAction) {
  start();
  load_text(kSwitches, kTwoLamps);
  const std::string action = "{pddl_instance: x, name: light-all, args: [r]}";
  const auto at = [&](const std::string& point) {
    return check(action, "check_action_condition_at", "CheckActionConditionAt", "cxlab_pddl_interfaces", ", time_point: " + point);
  };
  EXPECT_THAT(check(action), ElementsAre("guarded"));  // it would not last a moment
  EXPECT_THAT(at("START"), ElementsAre("sat"));
  EXPECT_THAT(at("OVER-ALL"), ElementsAre("guarded"));
  EXPECT_THAT(at("END"), ElementsAre("Forall (lamp l) (not broken(l))"));
  EXPECT_THAT(check("{pddl_instance: x, name: smash, args: [l1]}"), ElementsAre("Forall (lamp m) lit(m)", "(price(l1) <= 3)"));
}

TEST_F(ManagerTest, TheOriginalIsReproducedWhereThatIsWanted) {
  PddlManagerOptions options;
  options.original = true;
  start(std::move(options));
  load_text(kSwitches, kTwoLamps);
  EXPECT_THAT(check("{pddl_instance: x, name: light-all, args: [r]}"), ElementsAre("sat"));
  EXPECT_THAT(effects("{pddl_instance: x, name: light-all, args: [r]}"), ElementsAre("Unknown value type"));
  EXPECT_FALSE(ask("get_action_effects", "GetActionEffects", "{action: {pddl_instance: x, name: smash, args: [l1]}}")->integer("success"));
  EXPECT_EQ(ask("add_fluents", "AddFluents", "{fluents: [{pddl_instance: x, name: lit, args: [l1]}, {pddl_instance: x, name: lit, args: [l2]}]}")->text("error"), "  ");
  EXPECT_FALSE(ask("set_goals", "SetGoals", "{goal_instance: base, functions: [{pddl_instance: x, name: used, value: 0}]}")->integer("success"));
  EXPECT_FALSE(ask("add_pddl_instance", "AddPddlInstance", "{name: y, directory: \"" + folder_.string() + "\", domain_file: d.pddl}")->integer("success"));
  load_text(R"((define (domain d) (:requirements :adl) (:types t) (:predicates (p ?x - t) (q ?x - t))
                (:action a :parameters (?o - t) :effect (forall (?y - t) (when (q ?y) (p ?y))))))",
            "(define (problem p) (:domain d) (:objects o1 o2 - t) (:init) (:goal (and)))");
  EXPECT_THAT(effects("{pddl_instance: x, name: a, args: [o1]}"), ElementsAre("START +p(y)"));
}

TEST_F(ManagerTest, EventsOfTheProblemComeInTheirTime) {
  start();
  load_text("(define (domain d) (:requirements :timed-initial-literals) (:predicates (open)) (:action go :precondition (open) :effect (and)))",
            "(define (problem p) (:domain d) (:init (at 1 (open)) (at 2 (not (open)))) (:goal (and)))");
  EXPECT_THAT(fluents("x"), IsEmpty());
  ticks(50);
  EXPECT_THAT(fluents("x"), ElementsAre("open()"));
  ticks(50);
  EXPECT_THAT(fluents("x"), IsEmpty());
}

}  // namespace
}  // namespace cxlab::planner
