#include <algorithm>
#include <random>
#include <set>

#include "fixture.h"

namespace cxlab::planner {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* kReport = "cxlab_pddl_interfaces/msg/PlanReport";
constexpr const char* kHold = "{goal_instance: base, fluents: [{pddl_instance: bw, name: holding, args: [c]}]}";

TEST_F(ManagerTest, ManagersInNamespacesAreIndependent) {
  PddlManagerOptions options;
  options.bond_period = 0.5;
  options.node.name_space = "/cyan";
  auto cyan = PddlManager::create(options, bus_, sink_);
  options.node.name_space = "/magenta";
  auto magenta = PddlManager::create(options, bus_, sink_);
  ASSERT_TRUE(cyan.ok() && magenta.ok());
  const auto cyan_beats = listen("/cyan/bond", "bond/msg/Status"),
             magenta_beats = listen("/magenta/bond", "bond/msg/Status");
  const auto cyan_updates = listen("/cyan/pddl_manager/instance_update", "std_msgs/msg/String");
  const auto magenta_updates = listen("/magenta/pddl_manager/instance_update", "std_msgs/msg/String");
  const auto ask_one = [&](const std::string& name, const std::string& type, const std::string& request) {
    const bus::ServiceType& service = **registry_.service("cx_pddl_interfaces/srv/" + type);
    bus::Message answer(*service.response);
    auto made = bus_.create_client(client_, name, service, [&](const bus::Delivery& d) { answer = *d.message; });
    EXPECT_TRUE(made.ok());
    bus_.call(*made, std::make_shared<bus::Message>(*bus::Message::from_yaml(*service.request, request)));
    for (int i = 0; i < 2; ++i) {
      now_ += SimTime{500'000'000};
      bus_.begin_tick(now_);
      EXPECT_TRUE((*cyan)->sense(now_).ok() && (*magenta)->sense(now_).ok());
      bus_.deliver(client_);
      EXPECT_TRUE((*cyan)->act(now_).ok() && (*magenta)->act(now_).ok());
    }
    return std::pair(answer->integer("success") != 0, answer->text("error"));
  };
  const std::string load =
      "{name: bw, directory: \"" + blocks_folder() + "\", domain_file: domain.pddl, problem_file: problem.pddl}";
  EXPECT_TRUE(ask_one("/cyan/pddl_manager/add_pddl_instance", "AddPddlInstance", load).first);
  EXPECT_TRUE(ask_one("/cyan/pddl_manager/add_fluents", "AddFluents",
                      "{fluents: [{pddl_instance: bw, name: clear, args: [a]}]}")
                  .first);
  EXPECT_EQ(
      ask_one("/magenta/pddl_manager/get_fluents", "GetFluents", "{pddl_instance: bw}"),
      std::pair(false,
                std::string("unknown pddl instance 'bw': none is loaded, add it with the service add_pddl_instance")));
  EXPECT_THAT(*cyan_updates, ElementsAre(HasSubstr("bw")));
  EXPECT_THAT(*magenta_updates, IsEmpty());
  EXPECT_GE(cyan_beats->size(), 3u);
  EXPECT_THAT(*cyan_beats, Each(HasSubstr("/cyan/pddl_manager")));
  EXPECT_GE(magenta_beats->size(), 3u);
  EXPECT_THAT(*magenta_beats, Each(HasSubstr("/magenta/pddl_manager")));
}

TEST_F(ManagerTest, ReportsEveryChangeOnceAndNothingElse) {
  start();
  load_blocks();
  const auto received = listen("/pddl_manager/instance_update", "std_msgs/msg/String");
  const auto notifications = [&] {
    const std::size_t count = received->size();
    EXPECT_THAT(*received, Each(HasSubstr("data: \"bw\"")));
    received->clear();
    return count;
  };
  request("add_objects", "AddObjects",
          "{objects: [{pddl_instance: bw, name: d, type: block}, {pddl_instance: bw, name: e, type: block}]}");
  EXPECT_EQ(notifications(), 1u);
  request("add_fluents", "AddFluents",
          "{fluents: [{pddl_instance: bw, name: clear, args: [d]}, {pddl_instance: bw, name: clear, args: [e]}]}");
  EXPECT_EQ(notifications(), 1u);
  request("rm_fluents", "RemoveFluents", "{fluents: [{pddl_instance: bw, name: clear, args: [e]}]}");
  EXPECT_EQ(notifications(), 1u);
  request("set_functions", "SetFunctions", "{functions: [{pddl_instance: bw, name: moves, value: 2}]}");
  EXPECT_EQ(notifications(), 1u);
  request("rm_objects", "RemoveObjects", "{objects: [{pddl_instance: bw, name: d, type: block}]}");
  EXPECT_EQ(notifications(), 1u);
  (void)error_of("add_fluents", "AddFluents", "{fluents: [{pddl_instance: bw, name: clear, args: [nobody]}]}");
  (void)error_of("add_objects", "AddObjects", "{objects: [{pddl_instance: bw, name: d, type: nothing}]}");
  (void)fluents("bw");
  (void)check("{pddl_instance: bw, name: pick-up, args: [a]}");
  (void)effects("{pddl_instance: bw, name: pick-up, args: [a]}");
  request("set_goals", "SetGoals", kHold);
  EXPECT_EQ(notifications(), 0u);
}

TEST_F(ManagerTest, StepsThatBeginTogetherAreOneClass) {
  start();
  load_text(R"((define (domain d) (:requirements :durative-actions) (:predicates (a) (b) (c) (p ?x) (free))
    (:durative-action left :parameters () :duration (= ?duration 3) :condition (at start (a)) :effect (at end (b)))
    (:durative-action right :parameters () :duration (= ?duration 5) :condition (at start (a)) :effect (at end (c)))
    (:durative-action both :parameters () :duration (= ?duration 1) :condition (and (at start (b)) (at start (c))) :effect (at end (free)))))",
            "(define (problem p) (:domain d) (:init (a)) (:goal (and)))");
  request("set_goals", "SetGoals", "{goal_instance: base, fluents: [{pddl_instance: x, name: free}]}");
  const auto answer = plan("{pddl_instance: x, goal_instance: base}");
  ticks(50);
  ASSERT_EQ(answer->actions.size(), 3u);
  EXPECT_THAT(std::vector(answer->actions.begin(), answer->actions.begin() + 2), Each(HasSubstr("@0.00+")));
  EXPECT_THAT(std::vector(answer->actions.begin(), answer->actions.begin() + 2), Each(HasSubstr("class 0")));
  EXPECT_THAT(answer->actions[2], HasSubstr("both() @5.00+1 class 1"));
}

TEST_F(ManagerTest, AGoalCanRequireTheNumberZero) {
  start();
  load_text(R"((define (domain d) (:requirements :numeric-fluents) (:functions (n)) (:predicates (ready))
    (:action less :precondition (> (n) 0) :effect (decrease (n) 1))))",
            "(define (problem p) (:domain d) (:init (= (n) 2)) (:goal (and)))");
  request("set_goals", "SetGoals", "{goal_instance: base, functions: [{pddl_instance: x, name: n, value: 0}]}");
  const auto answer = plan("{pddl_instance: x, goal_instance: base}");
  ticks(50);
  EXPECT_EQ(answer->actions.size(), 2u);
}

TEST_F(ManagerTest, GoalsAreAddedUntilTheyAreCleared) {
  PddlManagerOptions options;
  options.cost.planning_time = "free";
  start(std::move(options));
  load_blocks();
  const auto steps = [&] {
    const auto answer = plan("{pddl_instance: bw, goal_instance: base}");
    ticks(3);
    return answer->success ? answer->actions.size() : 99;
  };
  EXPECT_EQ(steps(), 0u) << "the goals of the problem are dropped, and base is there";
  request("set_goals", "SetGoals", "{goal_instance: base, fluents: [{pddl_instance: bw, name: ontable, args: [c]}]}");
  EXPECT_EQ(steps(), 2u);
  request("set_goals", "SetGoals", "{goal_instance: base, fluents: [{pddl_instance: bw, name: on, args: [b, a]}]}");
  EXPECT_EQ(steps(), 4u);
  request("clear_goals", "ClearGoals", "{pddl_instance: bw, goal_instance: base}");
  EXPECT_EQ(steps(), 0u);
}

TEST_F(ManagerTest, AFilterReplacesTheLastOneAndAnErrorLeavesItUnchanged) {
  PddlManagerOptions options;
  options.cost.planning_time = "free";
  start(std::move(options));
  load_blocks();
  request("set_goals", "SetGoals", kHold);
  const auto planned = [&] {
    const auto answer = plan("{pddl_instance: bw, goal_instance: base}");
    ticks(3);
    return answer->success;
  };
  request("set_action_filter", "SetActionFilter", "{pddl_instance: bw, goal_instance: base, actions: [STACK]}");
  EXPECT_FALSE(planned());
  EXPECT_EQ(
      error_of("set_action_filter", "SetActionFilter", "{pddl_instance: bw, goal_instance: base, actions: [unstak]}"),
      "unknown action 'unstak', did you mean 'unstack'?");
  EXPECT_FALSE(planned());
  request("set_action_filter", "SetActionFilter", "{pddl_instance: bw, goal_instance: base, actions: [unstack]}");
  EXPECT_TRUE(planned());
  request("set_object_filter", "SetObjectFilter", "{pddl_instance: bw, goal_instance: base, objects: [a, b]}");
  EXPECT_FALSE(planned()) << "the goal names c";
  request("create_goal_instance", "CreateGoalInstance", "{pddl_instance: bw, goal_instance: base}");
  request("set_goals", "SetGoals", kHold);
  EXPECT_TRUE(planned()) << "a goal instance that is created again has no filters";
}

TEST_F(ManagerTest, DeactivatingTheNodeEndsRunningRequests) {
  PddlManagerOptions options;
  options.cost.latency_a = 1;
  start(std::move(options));
  load_blocks();
  request("set_goals", "SetGoals", kHold);
  const auto reports = listen("/pddl_manager/plan_report", kReport);
  const auto change = [&](const std::string& label) {
    return ask("change_state", "ChangeState", "{transition: {label: " + label + "}}", "lifecycle_msgs")
               ->integer("success") != 0;
  };
  const auto under_way = plan("{pddl_instance: bw, goal_instance: base}");
  ticks(5);
  EXPECT_TRUE(change("deactivate"));
  EXPECT_EQ(under_way->status, bus::GoalStatus::kAborted);
  EXPECT_THAT(*reports, ElementsAre(HasSubstr("the node was deactivated")));
  EXPECT_FALSE(fluents("bw").empty()) << "questions are still answered";

  const auto refused = plan("{pddl_instance: bw, goal_instance: base}");
  ticks(100);
  EXPECT_LT(refused->time, 0) << "no plan is made while it is not active";
  EXPECT_TRUE(change("activate"));
  const auto again = plan("{pddl_instance: bw, goal_instance: base}");
  ticks(100);
  EXPECT_TRUE(again->success);

  EXPECT_TRUE(change("deactivate"));
  EXPECT_TRUE(change("cleanup"));
  EXPECT_TRUE(change("configure"));
  EXPECT_EQ(error_of("get_fluents", "GetFluents", "{pddl_instance: bw}"),
            "unknown pddl instance 'bw': none is loaded, add it with the service add_pddl_instance");
}

TEST_F(ManagerTest, AnInstanceThatIsLoadedAgainIsNew) {
  start();
  load_blocks();
  request("set_goals", "SetGoals", kHold);
  request("add_fluents", "AddFluents", "{fluents: [{pddl_instance: bw, name: clear, args: [a]}]}");
  load_blocks();
  EXPECT_THAT(fluents("bw"), ElementsAre("on(c a)", "ontable(a)", "ontable(b)", "clear(b)", "clear(c)", "handempty()"));
  const auto answer = plan("{pddl_instance: bw, goal_instance: base}");
  ticks(100);
  EXPECT_TRUE(answer->success);
  EXPECT_THAT(answer->actions, IsEmpty());
}

/// The true facts of blocksworld as a set of texts, and how requests change them.
struct Blocks {
  std::set<std::string> objects = {"a", "b", "c"},
                        facts = {"on(c a)", "ontable(a)", "ontable(b)", "clear(b)", "clear(c)", "handempty()"};

  void remove(const std::string& object) {
    objects.erase(object);
    std::erase_if(facts, [&](const std::string& fact) {
      const std::string arguments = " " + fact.substr(fact.find('(') + 1, fact.size() - fact.find('(') - 2) + " ";
      return arguments.find(" " + object + " ") != std::string::npos;
    });
  }
};

TEST_F(ManagerTest, AnInstanceAgreesWithASetUnderRandomRequests) {
  PddlManagerOptions options;
  options.cost.planning_time = "free";
  options.cost.budget = 20'000;
  start(std::move(options));
  load_blocks();
  Blocks blocks;
  std::mt19937 draw(7);
  const auto one_of = [&](const std::vector<std::string>& texts) { return texts[draw() % texts.size()]; };
  const std::vector<std::string> names = {"a", "b", "c", "d", "E", "f"};
  int plans = 0;
  for (int round = 0; round < 1000; ++round) {
    const std::string x = one_of(names), y = one_of(names);
    const bool known_x = blocks.objects.contains(x), known_y = blocks.objects.contains(y);
    switch (draw() % 6) {
      case 0: {
        EXPECT_EQ(ask("add_objects", "AddObjects", "{objects: [{pddl_instance: bw, name: " + x + ", type: block}]}")
                      ->integer("success"),
                  1);
        blocks.objects.insert(x);
        break;
      }
      case 1: {
        if (draw() % 4 != 0) break;  // else few blocks are left
        const bool done =
            ask("rm_objects", "RemoveObjects", "{objects: [{pddl_instance: bw, name: " + x + ", type: block}]}")
                ->integer("success") != 0;
        EXPECT_EQ(done, known_x);
        blocks.remove(x);
        break;
      }
      case 2:
      case 3: {
        const bool add = draw() % 3 != 0;
        const std::string request = "{fluents: [{pddl_instance: bw, name: on, args: [" + x + ", " + y +
                                    "]}, {pddl_instance: bw, name: clear, args: [" + x + "]}]}";
        const bus::Message answer =
            add ? ask("add_fluents", "AddFluents", request) : ask("rm_fluents", "RemoveFluents", request);
        EXPECT_EQ(answer->integer("success") != 0, known_x && known_y) << answer->text("error");
        EXPECT_EQ(answer->text("error").empty(), known_x && known_y);
        if (!known_x || !known_y) break;
        for (const std::string& fact : {"on(" + x + " " + y + ")", "clear(" + x + ")"})
          add ? (void)blocks.facts.insert(fact) : (void)blocks.facts.erase(fact);
        break;
      }
      case 4: {
        if (!known_x || !known_y) break;
        request("create_goal_instance", "CreateGoalInstance", "{pddl_instance: bw, goal_instance: g}");
        request("set_goals", "SetGoals",
                "{goal_instance: g, fluents: [{pddl_instance: bw, name: clear, args: [" + x +
                    "]}, {pddl_instance: bw, name: clear, args: [" + y + "]}]}");
        const auto answer = plan("{pddl_instance: bw, goal_instance: g}");
        ticks(3);
        EXPECT_GE(answer->time, 0);
        plans += answer->success;
        break;
      }
      default: {
        if (!known_x) break;
        std::vector<std::string> missing;
        for (const std::string& fact : {"clear(" + x + ")", "ontable(" + x + ")", std::string("handempty()")})
          if (!blocks.facts.contains(fact)) missing.push_back(fact == "handempty()" ? "handempty" : fact);
        EXPECT_EQ(check("{pddl_instance: bw, name: pick-up, args: [" + x + "]}"),
                  missing.empty() ? std::vector<std::string>{"sat"} : missing);
      }
    }
    const std::vector<std::string> now = fluents("bw");
    ASSERT_EQ(std::set<std::string>(now.begin(), now.end()), blocks.facts) << "after request " << round;
    ASSERT_EQ(now.size(), blocks.facts.size());
  }
  EXPECT_GT(plans, 20);
}

}  // namespace
}  // namespace cxlab::planner
