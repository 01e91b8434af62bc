#include "fixture.h"
#include "planner/pddl/parser.h"

namespace cxlab::planner {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

TEST_F(ManagerTest, ServicesAnswerUnderTheNamesOfBothPackages) {
  start();
  load_blocks();
  EXPECT_THAT(texts(ask("get_action_names", "GetActionNames", "{pddl_instance: bw}").view(), "action_names"),
              ElementsAre("pick-up", "put-down", "stack", "unstack"));
  EXPECT_THAT(
      texts(ask("get_action_names", "GetActionNames", "{pddl_instance: bw}", "expertino_msgs").view(), "action_names"),
      ElementsAre("pick-up", "put-down", "stack", "unstack"));
  EXPECT_THAT(fluents("bw"), ElementsAre("on(c a)", "ontable(a)", "ontable(b)", "clear(b)", "clear(c)", "handempty()"));
  EXPECT_THAT(texts(ask("get_type_objects", "GetTypeObjects", "{pddl_instance: bw, type: block}").view(), "objects"),
              ElementsAre("a", "b", "c"));
  const bus::Message predicates = ask("get_predicates", "GetPredicates", "{pddl_instance: bw}");
  ASSERT_EQ(predicates->size("predicates"), 5u);
  EXPECT_THAT(texts(predicates->nested("predicates", 0), "param_names"), ElementsAre("x", "y"));
  const bus::Message functions = ask("get_functions", "GetFunctions", "{pddl_instance: bw}");
  ASSERT_EQ(functions->size("functions"), 1u);
  EXPECT_EQ(functions->nested("functions", 0).text("name"), "moves");
  EXPECT_THAT(check("{pddl_instance: bw, name: pick-up, args: [a]}", "check_action_precondition",
                    "CheckActionPrecondition", "expertino_msgs"),
              ElementsAre("clear(a)"));
}

TEST_F(ManagerTest, AppliesChangesAndNotifiesListeners) {
  start();
  load_blocks();
  const auto received = listen("/pddl_manager/instance_update", "std_msgs/msg/String");
  request("rm_fluents", "RemoveFluents", "{fluents: [{pddl_instance: bw, name: on, args: [c, a]}]}");
  request("add_fluents", "AddFluents",
          "{fluents: [{pddl_instance: bw, name: on, args: [c, b]}, {pddl_instance: bw, name: clear, args: [a]}]}");
  request("set_functions", "SetFunctions", "{functions: [{pddl_instance: bw, name: moves, args: [], value: 7}]}");
  request("add_objects", "AddObjects", "{objects: [{pddl_instance: bw, name: d, type: block}]}");
  request("add_fluent", "AddFluent", "{fluent: {pddl_instance: bw, name: ontable, args: [d]}}");
  EXPECT_EQ(received->size(), 5u);
  EXPECT_THAT(fluents("bw"), ElementsAre("ontable(a)", "ontable(b)", "clear(b)", "clear(c)", "handempty()", "on(c b)",
                                         "clear(a)", "ontable(d)"));
  EXPECT_EQ(ask("get_functions", "GetFunctions", "{pddl_instance: bw}")->nested("functions", 0).real("value"), 7);
}

TEST_F(ManagerTest, RemovingAnObjectRemovesItsFactsAndGoals) {
  start();
  load_blocks();
  request("set_goals", "SetGoals",
          "{goal_instance: base, fluents: [{pddl_instance: bw, name: on, args: [b, c]}, {pddl_instance: bw, name: "
          "ontable, args: [c]}]}");
  request("rm_objects", "RemoveObjects", "{objects: [{pddl_instance: bw, name: b, type: block}]}");
  EXPECT_THAT(fluents("bw"), ElementsAre("on(c a)", "ontable(a)", "clear(c)", "handempty()"));
  const auto answer = plan("{pddl_instance: bw, goal_instance: base}");
  ticks(200);
  EXPECT_THAT(answer->actions, ElementsAre("unstack(c a) @0.00+3 class 0", HasSubstr("put-down(c) @3.00+2 class 1")));
}

TEST_F(ManagerTest, ErrorsNameWhatWasFoundAndChangeNothing) {
  start();
  load_blocks();
  EXPECT_EQ(error_of("get_fluents", "GetFluents", "{pddl_instance: bv}"),
            "unknown pddl instance 'bv', did you mean 'bw'?");
  EXPECT_EQ(
      error_of("add_fluents", "AddFluents",
               "{fluents: [{pddl_instance: bw, name: clear, args: [a]}, {pddl_instance: bw, name: klear, args: [a]}]}"),
      "unknown fluent 'klear', did you mean 'clear'?");
  EXPECT_EQ(error_of("add_fluents", "AddFluents", "{fluents: [{pddl_instance: bw, name: on, args: [a]}]}"),
            "'on': found 1 arguments, expected 2");
  EXPECT_THAT(fluents("bw"), ::testing::Not(::testing::Contains("clear(a)")));
  EXPECT_THAT(
      error_of("set_action_filter", "SetActionFilter", "{pddl_instance: bw, goal_instance: other, actions: []}"),
      HasSubstr("create it first"));
  EXPECT_THAT(error_of("add_pddl_instance", "AddPddlInstance", "{name: y, directory: /, domain_file: nowhere.pddl}"),
              HasSubstr("/nowhere.pddl: there is no such file"));
  std::ofstream(folder_ / "d.pddl")
      << "(define (domain d)\n (:predicates (p))\n (:action a :precondition (q) :effect (p)))";
  EXPECT_THAT(error_of("add_pddl_instance", "AddPddlInstance",
                       "{name: y, directory: \"" + folder_.string() + "\", domain_file: d.pddl}"),
              ::testing::StartsWith((folder_ / "d.pddl").string() + ":3: "));
  std::ofstream(folder_ / "t.pddl")
      << "{% if true %}\n(define (domain d)\n (:predicates (p))\n (:action a :paramters ()))"
         "{% endif %}";
  EXPECT_THAT(error_of("add_pddl_instance", "AddPddlInstance",
                       "{name: y, directory: \"" + folder_.string() + "\", domain_file: t.pddl}"),
              ::testing::StartsWith((folder_ / "t.pddl").string() + " (rendered):4: "));
}

TEST_F(ManagerTest, AnInstanceThatSomebodyElseReplacesIsAWarning) {
  start();
  load_blocks();
  load_blocks();
  EXPECT_THAT(manager_->warnings(), ::testing::IsEmpty());
  client_ = bus_.join(bus::ParticipantKind::kEnvironment, {"other", "/", {}}, sink_.open_stream("other"));
  load_blocks();
  EXPECT_THAT(manager_->warnings(),
              ::testing::ElementsAre("/pddl_manager: another client replaced the pddl instance 'bw', "
                                     "expected a manager for each agent"));
}

TEST_F(ManagerTest, AListOfObjectsIsAcceptedAsAWholeOrNotAtAll) {
  start();
  load_blocks();
  request(
      "add_pddl_instance", "AddPddlInstance",
      "{name: other, directory: \"" + blocks_folder() + "\", domain_file: domain.pddl, problem_file: problem.pddl}");
  const auto objects = [&](const std::string& instance) {
    return texts(ask("get_type_objects", "GetTypeObjects", "{pddl_instance: " + instance + ", type: object}").view(),
                 "objects");
  };
  const std::vector<std::string> facts = fluents("bw");
  const auto received = listen("/pddl_manager/instance_update", "std_msgs/msg/String");
  EXPECT_EQ(error_of("add_objects", "AddObjects",
                     "{objects: [{pddl_instance: other, name: d, type: block}, {pddl_instance: bw, name: d, type: "
                     "block}, {pddl_instance: bw, name: e, type: blok}]}"),
            "unknown type 'blok', did you mean 'block'?");
  EXPECT_EQ(
      error_of("add_objects", "AddObjects",
               "{objects: [{pddl_instance: bw, name: d, type: object}, {pddl_instance: bw, name: D, type: block}]}"),
      "object 'D' is there already: found the type object, expected block");
  EXPECT_EQ(error_of("rm_objects", "RemoveObjects",
                     "{objects: [{pddl_instance: other, name: a}, {pddl_instance: bw, name: a}, {pddl_instance: bw, "
                     "name: nobody}]}"),
            "unknown object 'nobody', known: a, b, c");
  EXPECT_THAT(*received, IsEmpty());
  EXPECT_THAT(objects("bw"), ElementsAre("a", "b", "c"));
  EXPECT_THAT(objects("other"), ElementsAre("a", "b", "c"));
  EXPECT_EQ(fluents("bw"), facts);

  request("add_objects", "AddObjects",
          "{objects: [{pddl_instance: other, name: d, type: block}, {pddl_instance: bw, name: d, type: block}, "
          "{pddl_instance: bw, name: D, type: object}]}");
  request("rm_objects", "RemoveObjects",
          "{objects: [{pddl_instance: bw, name: a, type: block}, {pddl_instance: other, name: b}, {pddl_instance: bw, "
          "name: b}]}");
  EXPECT_THAT(*received, ::testing::SizeIs(4));
  EXPECT_THAT(objects("bw"), ElementsAre("c", "d"));
  EXPECT_THAT(objects("other"), ElementsAre("a", "c", "d"));
  EXPECT_THAT(fluents("bw"), ElementsAre("clear(c)", "handempty()"));
}

TEST_F(ManagerTest, ErrorsNameARemedy) {
  start();
  EXPECT_EQ(error_of("get_fluents", "GetFluents", "{pddl_instance: bw}"),
            "unknown pddl instance 'bw': none is loaded, add it with the service add_pddl_instance");
  load_text(R"((define (domain d) (:requirements :typing)
    (:types cup plate - dish place) (:predicates (on ?d - (either cup plate) ?p - place)) (:functions (price ?d - dish))
    (:action move :parameters (?d - dish) :effect (on ?d table)) (:constants table - place)))",
            "(define (problem p) (:domain d) (:objects red - cup deep - plate) (:init) (:goal (and)))");
  EXPECT_EQ(error_of("get_fluents", "GetFluents", "{pddl_instance: household}"),
            "unknown pddl instance 'household', known: x");
  EXPECT_EQ(error_of("add_fluents", "AddFluents", "{fluents: [{pddl_instance: x, name: on, args: [table, table]}]}"),
            "'on': 'table' has the wrong type for ?d: found place, expected (either cup plate)");
  EXPECT_EQ(error_of("add_fluents", "AddFluents", "{fluents: [{pddl_instance: x, name: below, args: []}]}"),
            "unknown fluent 'below', known: on");
  EXPECT_EQ(error_of("set_functions", "SetFunctions", "{functions: [{pddl_instance: x, name: weight, args: [red]}]}"),
            "unknown function 'weight', known: price");
  EXPECT_EQ(error_of("get_type_objects", "GetTypeObjects", "{pddl_instance: x, type: table}"),
            "unknown type 'table', known: object, cup, plate, place, dish");
  EXPECT_EQ(error_of("rm_objects", "RemoveObjects", "{objects: [{pddl_instance: x, name: red, type: place}]}"),
            "object 'red': found the type cup, expected place");
  EXPECT_THAT(error_of("clear_goals", "ClearGoals", "{pddl_instance: x, goal_instance: tidy}"),
              HasSubstr("create it first with the service create_goal_instance"));
  std::string many = "{objects: [";
  for (int i = 0; i < 20; ++i)
    many += std::string(i ? ", " : "") + "{pddl_instance: x, name: cup-number-" + std::to_string(i) + ", type: cup}";
  request("add_objects", "AddObjects", many + "]}");
  EXPECT_THAT(error_of("rm_objects", "RemoveObjects", "{objects: [{pddl_instance: x, name: w}]}"),
              ::testing::EndsWith("cup-number-6 and 13 more"));
}

TEST_F(ManagerTest, ObjectsAreReportedAsAddedAndAcceptedInAnyCase) {
  start();
  load_blocks();
  request("add_objects", "AddObjects", "{objects: [{pddl_instance: bw, name: Cube-7, type: Block}]}");
  request("add_fluents", "AddFluents",
          "{fluents: [{pddl_instance: bw, name: ONTABLE, args: [cube-7]}, {pddl_instance: bw, name: clear, args: "
          "[CUBE-7]}]}");
  EXPECT_THAT(texts(ask("get_type_objects", "GetTypeObjects", "{pddl_instance: bw, type: block}").view(), "objects"),
              ElementsAre("a", "b", "c", "Cube-7"));
  EXPECT_THAT(fluents("bw"), ::testing::IsSupersetOf({"ontable(Cube-7)", "clear(Cube-7)"}));
  request("set_goals", "SetGoals",
          "{goal_instance: base, fluents: [{pddl_instance: bw, name: holding, args: [Cube-7]}]}");
  request("set_object_filter", "SetObjectFilter", "{pddl_instance: bw, goal_instance: base, objects: [cube-7]}");
  const auto answer = plan("{pddl_instance: bw, goal_instance: base}");
  ticks(100);
  EXPECT_THAT(answer->actions, ElementsAre(HasSubstr("pick-up(Cube-7)")));
  request("rm_objects", "RemoveObjects", "{objects: [{pddl_instance: bw, name: cube-7, type: block}]}");
  EXPECT_THAT(texts(ask("get_type_objects", "GetTypeObjects", "{pddl_instance: bw, type: block}").view(), "objects"),
              ElementsAre("a", "b", "c"));
}

TEST_F(ManagerTest, FluentsOfTheProblemKeepTheirPlace) {
  start();
  load_blocks();
  for (const char* service : {"rm_fluents", "add_fluents"})
    request(service, service[0] == 'r' ? "RemoveFluents" : "AddFluents",
            "{fluents: [{pddl_instance: bw, name: ontable, args: [a]}]}");
  request("add_fluents", "AddFluents", "{fluents: [{pddl_instance: bw, name: holding, args: [a]}]}");
  EXPECT_THAT(fluents("bw"),
              ElementsAre("on(c a)", "ontable(a)", "ontable(b)", "clear(b)", "clear(c)", "handempty()", "holding(a)"));
}

TEST_F(ManagerTest, ARelativeDirectoryIsResolvedByTheHost) {
  PddlManagerOptions options;
  options.resolve = [](const std::string& directory) {
    return directory == "here" ? std::filesystem::path(blocks_folder()) : std::filesystem::path("nowhere");
  };
  start(std::move(options));
  request("add_pddl_instance", "AddPddlInstance", "{name: bw, directory: here, domain_file: domain.pddl}");
  EXPECT_THAT(error_of("add_pddl_instance", "AddPddlInstance", "{name: x, directory: there, domain_file: domain.pddl}"),
              HasSubstr("nowhere/domain.pddl"));
}

TEST_F(ManagerTest, ADomainAloneMakesAnInstance) {
  start();
  request("add_pddl_instance", "AddPddlInstance",
          "{name: bw, directory: \"" + blocks_folder() + "\", domain_file: domain.pddl}");
  EXPECT_THAT(fluents("bw"), IsEmpty());
  request("add_objects", "AddObjects", "{objects: [{pddl_instance: bw, name: a, type: block}]}");
  EXPECT_THAT(check("{pddl_instance: bw, name: pick-up, args: [a]}"),
              ElementsAre("clear(a)", "ontable(a)", "handempty"));
}

// --- Where the original differs

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

TEST_F(ManagerTest, EffectsAreEvaluatedInTheCurrentState) {
  start();
  load_text(kSwitches, kTwoLamps);
  EXPECT_THAT(effects("{pddl_instance: x, name: light-all, args: [r]}"),
              UnorderedElementsAre("START +lit(l1)", "END used() + 9"));
  EXPECT_THAT(effects("{pddl_instance: x, name: smash, args: [l1]}"),
              UnorderedElementsAre("START +broken(l1)", "START used() + 5"));
  request("add_fluents", "AddFluents", "{fluents: [{pddl_instance: x, name: lit, args: [l1]}]}");
  EXPECT_THAT(effects("{pddl_instance: x, name: smash, args: [l1]}"),
              UnorderedElementsAre("START +broken(l1)", "START -lit(l1)", "START used() + 5"));
}

TEST_F(ManagerTest, ConditionsAreCheckedAtEveryTimeOfAnAction) {
  start();
  load_text(kSwitches, kTwoLamps);
  const std::string action = "{pddl_instance: x, name: light-all, args: [r]}";
  const auto at = [&](const std::string& point) {
    return check(action, "check_action_condition_at", "CheckActionConditionAt", "cxlab_pddl_interfaces",
                 ", time_point: " + point);
  };
  EXPECT_THAT(check(action), ElementsAre("guarded"));  // the effect at the start breaks it at once
  EXPECT_THAT(at("START"), ElementsAre("sat"));
  EXPECT_THAT(at("OVER-ALL"), ElementsAre("guarded"));
  EXPECT_THAT(at("END"), ElementsAre("Forall (lamp l) (not broken(l))"));
  EXPECT_THAT(check("{pddl_instance: x, name: smash, args: [l1]}"),
              ElementsAre("Forall (lamp m) lit(m)", "(price(l1) <= 3)"));
  request("rm_fluents", "RemoveFluents", "{fluents: [{pddl_instance: x, name: power}]}");
  EXPECT_THAT(check(action), ElementsAre("power", "guarded"));  // all conditions that do not hold
}

TEST_F(ManagerTest, ConditionsReadAsInTheUnifiedPlanningFramework) {
  start();
  // What its version 1.3.0 answers for the same domain.
  load_text(
      R"((define (domain zoo) (:requirements :adl :durative-actions :numeric-fluents)
    (:types animal place - object dog cat - animal) (:constants home - place)
    (:predicates (at ?a - animal ?p - place) (sun) (moon) (any ?o)) (:functions (f) (g) (w ?a - animal))
    (:durative-action a :parameters (?d - dog) :duration (= ?duration 1) :condition (and
      (at start (forall (?x - animal ?p - place) (at ?x ?p))) (at start (exists (?o) (any ?o))) (at start (imply (sun) (moon)))
      (at start (imply (not (moon)) (and (moon) (sun) (any ?d)))) (at start (or (moon) (and (sun) (moon)) (not (sun))))
      (at start (< (+ (f) (g) 2) -1.5)) (at start (>= (- (f)) 0.001)) (at start (= (* (f) (g) 3) 7)) (at start (> (- (f) (g)) 100))
      (at start (<= (/ (f) 3) -4)) (at start (not (= (f) (g)))) (at start (not (> (f) -10))) (at start (not (not (moon))))
      (at start (not (or (sun) (moon)))) (at start (= 1.25 (f))) (at start (>= 3 (w ?d))))
      :effect (at end (sun)))))",
      R"((define (problem q) (:domain zoo) (:objects rex - dog tom - cat) (:init (sun) (at rex home) (= (f) 1) (= (g) 1) (= (w rex) 4)) (:goal (and))))");
  EXPECT_THAT(check("{pddl_instance: x, name: a, args: [rex]}"),
              ElementsAre("Forall (animal - object x, place - object p) at(x, p)", "Exists (object o) any(o)",
                          "(sun implies moon)", "((not moon) implies (moon and sun and any(rex)))",
                          "(moon or (sun and moon) or (not sun))", "((f + g + 2) < -3/2)", "(1/1000 <= (-1 * f))",
                          "((f * g * 3) == 7)", "(100 < (f - g))", "((f / 3) <= -4)", "(not (f == g))",
                          "(not (-10 < f))", "moon", "(not (sun or moon))", "(5/4 == f)", "(w(rex) <= 3)"));
}

TEST_F(ManagerTest, AnEffectAtTheEndRemembersItsConditionAtTheStart) {
  start();
  load_text(
      R"((define (domain d) (:requirements :adl :durative-actions) (:types t) (:constants a - t) (:predicates (wet ?x - t) (dry) (rust ?x - t))
    (:durative-action wait :parameters () :duration (= ?duration 5) :condition (at start (dry))
      :effect (and (at start (not (dry))) (forall (?x - t) (when (at start (wet ?x)) (at end (rust ?x))))
                   (when (and (at start (dry)) (at end (wet a))) (at end (dry)))))))",
      "(define (problem p) (:domain d) (:objects b - t) (:init (dry) (wet a)) (:goal (and)))");
  const std::string action = "{pddl_instance: x, name: wait}";
  EXPECT_THAT(effects(action), UnorderedElementsAre("START -dry()", "END +rust(a)", "END +dry()"))
      << "no action has begun: the state of now counts";
  EXPECT_THAT(check(action), ElementsAre("sat"));
  request("rm_fluents", "RemoveFluents",
          "{fluents: [{pddl_instance: x, name: dry}, {pddl_instance: x, name: wet, args: [a]}]}");
  request("add_fluents", "AddFluents", "{fluents: [{pddl_instance: x, name: wet, args: [b]}]}");
  EXPECT_THAT(check(action), ElementsAre("dry"));
  EXPECT_THAT(effects(action), UnorderedElementsAre("START -dry()", "END +rust(a)"))
      << "a was wet at the start; it is not at the end";
  request("add_fluents", "AddFluents",
          "{fluents: [{pddl_instance: x, name: dry}, {pddl_instance: x, name: wet, args: [a]}]}");
  EXPECT_THAT(effects(action), UnorderedElementsAre("START -dry()", "END +rust(a)", "END +dry()"));
  EXPECT_THAT(check(action), ElementsAre("sat"));
  EXPECT_THAT(effects(action), UnorderedElementsAre("START -dry()", "END +rust(a)", "END +rust(b)", "END +dry()"))
      << "it began anew";
}

TEST_F(ManagerTest, EachEffectOfAnActionRemembersItsOwnStart) {
  start();
  load_text(
      R"((define (domain d) (:requirements :adl :durative-actions) (:predicates (p) (q) (r) (s) (dry))
    (:durative-action wait :parameters () :duration (= ?duration 5) :condition (at start (dry))
      :effect (and (when (at start (p)) (at end (r))) (at start (not (dry))) (when (at start (q)) (at end (s)))))))",
      "(define (problem p) (:domain d) (:init (dry) (p) (q)) (:goal (and)))");
  const std::string action = "{pddl_instance: x, name: wait}";
  EXPECT_THAT(check(action), ElementsAre("sat"));
  request("rm_fluents", "RemoveFluents",
          "{fluents: [{pddl_instance: x, name: dry}, {pddl_instance: x, name: p}, {pddl_instance: x, name: q}]}");
  EXPECT_THAT(check(action), ElementsAre("dry"));
  EXPECT_THAT(effects(action), UnorderedElementsAre("START -dry()", "END +r()", "END +s()"));
}

TEST_F(ManagerTest, ReproducesTheOriginalOnRequest) {
  PddlManagerOptions options;
  options.original = true;
  start(std::move(options));
  load_text(kSwitches, kTwoLamps);
  EXPECT_THAT(check("{pddl_instance: x, name: light-all, args: [r]}"), ElementsAre("sat"));
  EXPECT_THAT(effects("{pddl_instance: x, name: light-all, args: [r]}"), ElementsAre("Unknown value type"));
  EXPECT_FALSE(ask("get_action_effects", "GetActionEffects", "{action: {pddl_instance: x, name: smash, args: [l1]}}")
                   ->integer("success"));
  EXPECT_EQ(ask("add_fluents", "AddFluents",
                "{fluents: [{pddl_instance: x, name: lit, args: [l1]}, {pddl_instance: x, name: lit, args: [l2]}]}")
                ->text("error"),
            "  ");
  EXPECT_FALSE(
      ask("set_goals", "SetGoals", "{goal_instance: base, functions: [{pddl_instance: x, name: used, value: 0}]}")
          ->integer("success"));
  EXPECT_FALSE(ask("add_pddl_instance", "AddPddlInstance",
                   "{name: y, directory: \"" + folder_.string() + "\", domain_file: d.pddl}")
                   ->integer("success"));
  load_text(R"((define (domain d) (:requirements :adl) (:types t) (:predicates (p ?x - t) (q ?x - t))
                (:action a :parameters (?o - t) :effect (forall (?y - t) (when (q ?y) (p ?y))))))",
            "(define (problem p) (:domain d) (:objects o1 o2 - t) (:init) (:goal (and)))");
  EXPECT_THAT(effects("{pddl_instance: x, name: a, args: [o1]}"), ElementsAre("START +p(y)"));
  request("set_action_filter", "SetActionFilter", "{pddl_instance: x, goal_instance: base, actions: [unknown-name]}");
  bool asked = false;
  const bus::ServiceType& clear = **registry_.service("cx_pddl_interfaces/srv/ClearGoals");
  auto client =
      bus_.create_client(client_, "/pddl_manager/clear_goals", clear, [&](const bus::Delivery&) { asked = true; });
  bus_.call(*client, std::make_shared<bus::Message>(
                         *bus::Message::from_yaml(*clear.request, "{pddl_instance: x, goal_instance: nope}")));
  ticks(50);
  EXPECT_FALSE(asked) << "the request for an unknown goal is not answered";
}

TEST_F(ManagerTest, EventsOfTheProblemHappenAtTheirTimes) {
  start();
  load_text(
      "(define (domain d) (:requirements :timed-initial-literals) (:predicates (open)) (:action go :precondition "
      "(open) :effect (and)))",
      "(define (problem p) (:domain d) (:init (at 1 (open)) (at 2 (not (open)))) (:goal (and)))");
  EXPECT_THAT(fluents("x"), IsEmpty());
  ticks(50);
  EXPECT_THAT(fluents("x"), ElementsAre("open()"));
  ticks(50);
  EXPECT_THAT(fluents("x"), IsEmpty());
}

TEST_F(ManagerTest, NumbersAreComparedExactly) {
  start();
  load_text(
      "(define (domain d) (:predicates (p)) (:functions (now) (due))"
      " (:action act :precondition (< (now) (due)) :effect (p))"
      " (:action late :precondition (>= (now) (due)) :effect (p)))",
      "(define (problem p) (:domain d) (:init (= (now) 1700000000) (= (due) 1700000001)))");
  EXPECT_THAT(check("{pddl_instance: x, name: act}"), ElementsAre("sat"));
  EXPECT_THAT(check("{pddl_instance: x, name: late}"), ElementsAre("(due <= now)"));
}

TEST_F(ManagerTest, NothingIsAskedOverAllOfWhatTakesNoTime) {
  start();
  load_text(
      "(define (domain d) (:predicates (p) (q)) (:functions (length))"
      " (:durative-action act :parameters () :duration (= ?duration (length)) :condition (over all (p))"
      " :effect (at end (q))))",
      "(define (problem p) (:domain d) (:init (= (length) 0)))");
  EXPECT_THAT(check("{pddl_instance: x, name: act}"), ElementsAre("sat"));
  request("set_functions", "SetFunctions", "{functions: [{pddl_instance: x, name: length, value: 1}]}");
  EXPECT_THAT(check("{pddl_instance: x, name: act}"), ElementsAre("p"));
}

TEST_F(ManagerTest, DerivedFactsOverAllAreThoseAfterTheEffectsOfTheStart) {
  start();
  load_text(
      "(define (domain d) (:predicates (lit) (dark) (seen)) (:derived (dark) (not (lit)))"
      " (:durative-action glow :parameters () :duration (= ?duration 1) :condition (over all (not (dark)))"
      " :effect (and (at start (lit)) (at end (seen))))"
      " (:durative-action hide :parameters () :duration (= ?duration 1) :condition (over all (dark))"
      " :effect (and (at start (lit)) (at end (seen)))))",
      "(define (problem p) (:domain d) (:init))");
  EXPECT_THAT(check("{pddl_instance: x, name: glow}"), ElementsAre("sat"));
  EXPECT_THAT(check("{pddl_instance: x, name: hide}"), ElementsAre("dark"));
}

TEST_F(ManagerTest, QuestionsAreMeteredAndEnd) {
  start();
  std::string names;
  for (int i = 0; i < 60; ++i) names += " o" + std::to_string(i);
  const std::string six = "(?a ?b ?c ?d ?e ?f)";
  load_text(
      "(define (domain d) (:predicates (p ?a ?b ?c ?d ?e ?f) (done) (far))"
      " (:derived (far) (exists " +
          six +
          " (p ?a ?b ?c ?d ?e ?f)))"
          " (:action ask :precondition (not (exists " +
          six +
          " (p ?a ?b ?c ?d ?e ?f))) :effect (done))"
          " (:action mark :effect (forall " +
          six +
          " (p ?a ?b ?c ?d ?e ?f)))"
          " (:action plain :precondition (not (done)) :effect (done)))",
      "(define (problem p) (:domain d) (:objects" + names + "))");
  const std::string too_many =
      "the questions of this tick try too many combinations of objects: write conditions and effects with fewer "
      "variables in one quantifier";
  EXPECT_EQ(error_of("check_action_condition", "CheckActionCondition", "{action: {pddl_instance: x, name: ask}}"),
            too_many);
  EXPECT_THAT(effects("{pddl_instance: x, name: mark}"), ElementsAre(too_many));
  EXPECT_EQ(error_of("get_fluents", "GetFluents", "{pddl_instance: x}"), too_many) << "a derived fact";
}

/// The same text for people who load a file into the manager as for those who plan with it.
TEST_F(ManagerTest, WhatIsNotSupportedIsRefusedAsPlanAndValidateRefuseIt) {
  start();
  const std::string head = "(define (domain d) (:predicates (p)) (:functions (x) (y))";
  for (const std::string section :
       {"(:requirements :preferences)", "(:constraints (always (p)))", "(:process q)", "(:event q)",
        "(:functions (who) - object)", "(:action a :effect (oneof (p) (not (p))))",
        "(:durative-action a :parameters () :duration () :effect (increase (x) (* #t (x))))",
        "(:durative-action a :parameters () :duration () :effect (increase (x) (* #t #t)))",
        "(:durative-action a :parameters () :duration () :effect (when (at start (p)) (increase (x) (* #t 1))))",
        "(:action a :precondition (preference soft (p)) :effect (p))",
        "(:action a :parameters (?n - number) :effect (p))",
        "(:action a :precondition (= (x) 9007199254740993) :effect (p))"}) {
    std::ofstream(folder_ / "d.pddl") << head + section + ")";
    std::ofstream(folder_ / "p.pddl") << "(define (problem p) (:domain d) (:init (= (x) 0)) (:goal (p)))";
    const auto task = load_task(folder_ / "d.pddl", folder_ / "p.pddl");
    ASSERT_FALSE(task) << section;
    EXPECT_EQ(exit_code(task.error()), kUnsupportedCode) << section << ": " << task.error().text();
    EXPECT_EQ(error_of("add_pddl_instance", "AddPddlInstance",
                       "{name: x, directory: \"" + folder_.string() + "\", domain_file: d.pddl, problem_file: p.pddl}"),
              task.error().text());
  }
  for (const std::string section :
       {"(:constraints (always (p)))", "(:situation s)", "(:htn :tasks ())", "(:init (at 5 (increase (x) 1)))",
        "(:init (at 9000000000 (p)))", "(:init (= (x) 9007199254740993))", "(:metric minimize (is-violated soft))",
        "(:goal (preference soft (p)))", "(:goal (sometime (p)))"}) {
    const bool goal = section.starts_with("(:goal");
    std::ofstream(folder_ / "d.pddl") << head + ")";
    std::ofstream(folder_ / "p.pddl") << "(define (problem p) (:domain d)" + section + (goal ? ")" : "(:goal (p)))");
    const auto task = load_task(folder_ / "d.pddl", folder_ / "p.pddl");
    ASSERT_FALSE(task) << section;
    EXPECT_EQ(exit_code(task.error()), kUnsupportedCode) << section << ": " << task.error().text();
    EXPECT_EQ(error_of("add_pddl_instance", "AddPddlInstance",
                       "{name: x, directory: \"" + folder_.string() + "\", domain_file: d.pddl, problem_file: p.pddl}"),
              task.error().text());
  }
}

}  // namespace
}  // namespace cxlab::planner
