#include "fixture.h"

namespace cxlab::planner::plans_test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

constexpr const char* kTower = "{goal_instance: base, fluents: [{pddl_instance: bw, name: on, args: [a, b]}]}";
constexpr const char* kReport = "cxlab_pddl_interfaces/msg/PlanReport";

PddlManagerOptions at_cost(double a, double b) {
  PddlManagerOptions options;
  options.cost.latency_a = a;
  options.cost.latency_b = b;
  return options;
}

TEST_F(ManagerTest, APlanIsAnsweredAfterItsSimulatedTime) {
  start(at_cost(1.5, 0));
  load_blocks();
  request("set_goals", "SetGoals", kTower);
  const auto received = listen("/pddl_manager/plan_report", kReport);
  const double asked = to_seconds(now_);
  const auto answer = plan("{pddl_instance: bw, goal_instance: base}");
  ticks(100);
  EXPECT_NEAR(answer->time, asked + 1.5, 0.05);
  EXPECT_EQ(answer->status, bus::GoalStatus::kSucceeded);
  EXPECT_TRUE(answer->success);
  EXPECT_THAT(answer->actions,
              ElementsAre("unstack(c a) @0.00+3 class 0", HasSubstr("put-down(c) @3.00+2 class 1"),
                          HasSubstr("pick-up(a) @5.00+2 class 2"), HasSubstr("stack(a b) @7.00+3 class 3")));
  ASSERT_EQ(received->size(), 1u);
  EXPECT_THAT(received->front(), HasSubstr("status: \"PLAN\""));
  EXPECT_EQ(manager_->plans(), 1);
}

TEST_F(ManagerTest, AnswersAtOnceWithoutCharge) {
  PddlManagerOptions options = at_cost(1.5, 1);
  options.cost.planning_time = "free";
  start(std::move(options));
  load_blocks();
  request("set_goals", "SetGoals", kTower);
  const double asked = to_seconds(now_);
  const auto answer = plan("{pddl_instance: bw, goal_instance: base}");
  ticks(2);
  EXPECT_NEAR(answer->time, asked + 0.04, 0.001);
  EXPECT_TRUE(answer->success);
}

TEST_F(ManagerTest, GoalsArePlannedForSideBySideInSimulatedTime) {
  start(at_cost(1, 0));
  load_blocks();
  for (const char* goal : {"g1", "g2"})
    request("create_goal_instance", "CreateGoalInstance",
            std::string("{pddl_instance: bw, goal_instance: ") + goal + "}");
  request("set_goals", "SetGoals", "{goal_instance: g1, fluents: [{pddl_instance: bw, name: on, args: [b, c]}]}");
  request("set_goals", "SetGoals", "{goal_instance: g2, fluents: [{pddl_instance: bw, name: holding, args: [c]}]}");
  const double asked = to_seconds(now_);
  const auto first = plan("{pddl_instance: bw, goal_instance: g1}"),
             second = plan("{pddl_instance: bw, goal_instance: g2}", "expertino_msgs");
  ticks(60);
  EXPECT_NEAR(first->time, asked + 1, 0.05);
  EXPECT_NEAR(second->time, asked + 1, 0.05);
  EXPECT_EQ(first->actions.size(), 2u);
  EXPECT_THAT(second->actions, ElementsAre("unstack(c a) @0.00+3 class 0"));
}

TEST_F(ManagerTest, FiltersLimitWhatThePlannerSees) {
  start(at_cost(0, 0));
  load_blocks();
  request("set_goals", "SetGoals", kTower);
  const auto answer_with = [&](const std::string& service, const std::string& type, const std::string& list) {
    request(service, type, "{pddl_instance: bw, goal_instance: base, " + list + "}");
    const auto answer = plan("{pddl_instance: bw, goal_instance: base}");
    ticks(3);
    return answer->success ? std::to_string(answer->actions.size()) + " actions" : std::string("none");
  };
  EXPECT_EQ(answer_with("set_action_filter", "SetActionFilter", "actions: [pick-up, stack]"), "none");
  EXPECT_EQ(answer_with("set_action_filter", "SetActionFilter", "actions: []"), "4 actions");
  EXPECT_EQ(answer_with("set_object_filter", "SetObjectFilter", "objects: [a, b]"),
            "none");  // nobody can take c from a
  EXPECT_EQ(answer_with("set_object_filter", "SetObjectFilter", "objects: [a, b, c]"), "4 actions");
  EXPECT_EQ(answer_with("set_fluent_filter", "SetFluentFilter", "fluents: [on, ontable, clear]"),
            "none");  // no hand is empty
  EXPECT_EQ(answer_with("set_fluent_filter", "SetFluentFilter", "fluents: []"), "4 actions");
}

TEST_F(ManagerTest, NoPlanTimeoutAndCancelHaveDifferentAnswers) {
  PddlManagerOptions options = at_cost(1, 0);
  options.cost.budget = 40;
  start(std::move(options));
  load_blocks();
  const auto received = listen("/pddl_manager/plan_report", kReport);
  const auto ended = [&](const std::string& goal) {
    received->clear();
    const auto answer = plan(goal);
    ticks(100);
    EXPECT_FALSE(answer->success);
    return answer->status;
  };
  request("set_goals", "SetGoals", kTower);
  EXPECT_EQ(ended("{pddl_instance: bw, goal_instance: base}"), bus::GoalStatus::kAborted);
  EXPECT_THAT(*received, ElementsAre(HasSubstr("status: \"TIMEOUT\"")));
  EXPECT_EQ(ended("{pddl_instance: bw, goal_instance: nope}"), bus::GoalStatus::kAborted);
  EXPECT_THAT(*received, ElementsAre(HasSubstr("has no goal instance 'nope'")));
  request("set_goals", "SetGoals",
          "{goal_instance: base, fluents: [{pddl_instance: bw, name: on, args: [b, a]}, {pddl_instance: bw, name: "
          "holding, args: [b]}]}");

  manager_.reset();
  start(at_cost(1, 0));
  load_blocks();
  request("set_goals", "SetGoals", kTower);
  request("set_action_filter", "SetActionFilter", "{pddl_instance: bw, goal_instance: base, actions: [put-down]}");
  EXPECT_EQ(ended("{pddl_instance: bw, goal_instance: base}"), bus::GoalStatus::kSucceeded);
  EXPECT_THAT(*received, ElementsAre(HasSubstr("status: \"UNSOLVABLE\"")));

  received->clear();
  const auto answer = plan("{pddl_instance: bw, goal_instance: base}");
  ticks(10);
  bus_.cancel_goal(last_client_, last_goal_);
  ticks(3);
  EXPECT_EQ(answer->status, bus::GoalStatus::kCanceled);
  EXPECT_THAT(*received, ElementsAre(HasSubstr("status: \"CANCELED\"")));
  ticks(100);
  EXPECT_EQ(received->size(), 1u);
}

TEST_F(ManagerTest, TheOriginalRejectsCancelsAndReportsNoPlanAsSuccess) {
  PddlManagerOptions options = at_cost(1, 0);
  options.original = true;
  start(std::move(options));
  load_blocks();
  request("set_goals", "SetGoals", kTower);
  request("set_action_filter", "SetActionFilter", "{pddl_instance: bw, goal_instance: base, actions: [put-down]}");
  const auto answer = plan("{pddl_instance: bw, goal_instance: base}");
  ticks(10);
  bus_.cancel_goal(last_client_, last_goal_);
  ticks(100);
  EXPECT_EQ(answer->status, bus::GoalStatus::kSucceeded);
  EXPECT_FALSE(answer->success);
}

TEST_F(ManagerTest, AnotherPlannerCanMakeThePlans) {
  PddlManagerOptions options = at_cost(0.5, 1);
  const auto answer_of = [&](const std::string& command) {
    manager_.reset();
    options.other.command = command;
    start(options);
    load_blocks();
    request("set_goals", "SetGoals", "{goal_instance: base, fluents: [{pddl_instance: bw, name: holding, args: [c]}]}");
    const auto answer = plan("{pddl_instance: bw, goal_instance: base}");
    ticks(40);
    return answer;
  };
  const auto received = listen("/pddl_manager/plan_report", kReport);
  const auto answer =
      answer_of("grep -q holding {problem} && grep -q unstack {domain} && echo '0.0: (unstack c a) [3.0]' > {plan}");
  EXPECT_TRUE(answer->success);
  EXPECT_THAT(answer->actions, ElementsAre("unstack(c a) @0.00+3 class 0"));
  EXPECT_FALSE(answer_of("echo '0.0: (pick-up a) [2.0]' > {plan}")->success);
  EXPECT_THAT(received->back(), HasSubstr("the planner's plan is wrong"));
  EXPECT_EQ(answer_of("exit 7")->status, bus::GoalStatus::kSucceeded);
  EXPECT_THAT(received->back(), HasSubstr("ended with code 7 and wrote no plan"));
  EXPECT_EQ(answer_of("no-such-planner > {plan}.log")->status, bus::GoalStatus::kAborted);
  EXPECT_THAT(received->back(), testing::AllOf(HasSubstr("ERROR"), HasSubstr("cannot be run (code 127)")));
  options.cost.budget = 50'000;
  EXPECT_EQ(answer_of("sleep 10")->status, bus::GoalStatus::kAborted);
  EXPECT_THAT(received->back(), HasSubstr("TIMEOUT"));
}

TEST_F(ManagerTest, WritesTheProblemIfTheGoalNamesAFolder) {
  PddlManagerOptions options = at_cost(0, 0);
  std::map<std::string, std::string> written;
  options.write = [&](const std::filesystem::path& file, const std::string& text) {
    written[file.string()] = text;
    return Status();
  };
  start(std::move(options));
  load_blocks();
  request("set_goals", "SetGoals", kTower);
  (void)plan("{pddl_instance: bw, goal_instance: base, output_dir: /out}");
  ticks(3);
  EXPECT_THAT(written["/out/bw_base_domain.pddl"], HasSubstr("(:durative-action pick-up"));
  EXPECT_THAT(written["/out/bw_base_problem.pddl"], HasSubstr("(:goal (and (on a b)))"));
}

TEST_F(ManagerTest, ANodeHasALifecycleAndABond) {
  PddlManagerOptions options;
  options.autostart = false;
  options.bond_period = 0.5;
  start(std::move(options));
  const auto beats = listen("/bond", "bond/msg/Status");
  const auto change = [&](const std::string& label) {
    const bus::Message answer =
        ask("change_state", "ChangeState", "{transition: {label: " + label + "}}", "lifecycle_msgs");
    return answer->integer("success") != 0;
  };
  EXPECT_FALSE(change("activate"));
  EXPECT_TRUE(change("configure"));
  EXPECT_TRUE(change("activate"));
  load_blocks();
  ticks(100);
  EXPECT_GE(beats->size(), 4u);
  request("set_goals", "SetGoals", kTower);
  EXPECT_TRUE(change("deactivate"));
  EXPECT_THAT(beats->back(), HasSubstr("active: false"));
  EXPECT_TRUE(change("cleanup"));
  EXPECT_EQ(manager_->state(), cx::LifeState::kUnconfigured);
}

// --- Planning again

/// Plans for a tower of six, carries out the first steps, and plans again: the reports of both, and the second plan.
struct Replanned {
  std::int64_t units = 0;
  double makespan = 0;
  std::vector<std::string> actions;
};

constexpr const char* kSixBlocks = R"((define (problem six) (:domain blocksworld) (:objects a b c d e f - block)
  (:init (on a b) (on b c) (on c d) (ontable d) (ontable e) (on f e) (clear a) (clear f) (handempty) (= (moves) 0)) (:goal (and))))";
constexpr const char* kSixGoal =
    R"({goal_instance: base, fluents: [{pddl_instance: bw, name: on, args: [d, c]}, {pddl_instance: bw, name: on, args: [c, b]},
  {pddl_instance: bw, name: on, args: [b, f]}, {pddl_instance: bw, name: on, args: [f, a]}, {pddl_instance: bw, name: on, args: [a, e]}]})";

TEST_F(ManagerTest, PlanningAgainBeginsWithWhatIsLeftOfTheLastPlan) {
  const auto replan = [&](PddlManagerOptions options) {
    manager_.reset();
    start(std::move(options));
    load_blocks(kSixBlocks);
    request("set_goals", "SetGoals", kSixGoal);
    std::vector<std::int64_t> units;
    std::vector<double> makespans;
    auto made =
        bus_.subscribe(client_, "/pddl_manager/plan_report", **registry_.message(kReport), [&](const bus::Delivery& d) {
          units.push_back(d.message->view().integer("units"));
          makespans.push_back(d.message->view().real("makespan"));
        });
    const auto first = plan("{pddl_instance: bw, goal_instance: base}");
    ticks(3);
    // unstack a b, put-down a; meanwhile somebody else has taken f from e.
    EXPECT_THAT(first->actions.at(0), HasSubstr("unstack("));
    request("rm_fluents", "RemoveFluents",
            "{fluents: [{pddl_instance: bw, name: on, args: [a, b]}, {pddl_instance: bw, name: on, args: [f, e]}]}");
    request("add_fluents", "AddFluents",
            R"({fluents: [{pddl_instance: bw, name: ontable, args: [a]}, {pddl_instance: bw, name: clear, args: [b]},
      {pddl_instance: bw, name: ontable, args: [f]}, {pddl_instance: bw, name: clear, args: [e]}]})");
    const auto second = plan("{pddl_instance: bw, goal_instance: base}");
    ticks(3);
    bus_.remove(*made);
    EXPECT_EQ(units.size(), 2u);
    return Replanned{units.at(1), makespans.at(1), second->actions};
  };
  PddlManagerOptions options = at_cost(0, 0);
  const Replanned warm = replan(options), again = replan(options);
  options.warm_start = false;
  const Replanned anew = replan(options);
  EXPECT_LT(warm.units, anew.units);
  EXPECT_LE(warm.makespan, anew.makespan);
  EXPECT_EQ(warm.units, again.units);
  EXPECT_EQ(warm.actions, again.actions);
  options.warm_start = true;
  options.original = true;
  EXPECT_EQ(replan(options).units, anew.units) << "the original begins anew";
}

TEST_F(ManagerTest, PlanningAgainBeginsWithStepsOfTheFirstActionOfTheDomainToo) {
  const auto units_of_second = [&](bool warm_start) {
    PddlManagerOptions options = at_cost(0, 0);
    options.warm_start = warm_start;
    manager_.reset();
    start(std::move(options));
    load_text(R"((define (domain hanoi) (:requirements :strips :typing :durative-actions)
      (:predicates (clear ?x) (on ?x ?y) (smaller ?x ?y))
      (:durative-action move :parameters (?disc ?from ?to) :duration (= ?duration 1)
        :condition (and (at start (smaller ?disc ?to)) (at start (on ?disc ?from)) (at start (clear ?disc)) (at start (clear ?to)))
        :effect (and (at end (clear ?from)) (at end (on ?disc ?to)) (at start (not (on ?disc ?from))) (at start (not (clear ?to)))))))",
              R"((define (problem four) (:domain hanoi) (:objects p1 p2 p3 d1 d2 d3 d4)
      (:init (smaller d1 p1) (smaller d1 p2) (smaller d1 p3) (smaller d2 p1) (smaller d2 p2) (smaller d2 p3) (smaller d3 p1)
        (smaller d3 p2) (smaller d3 p3) (smaller d4 p1) (smaller d4 p2) (smaller d4 p3) (smaller d1 d2) (smaller d1 d3)
        (smaller d1 d4) (smaller d2 d3) (smaller d2 d4) (smaller d3 d4) (clear p2) (clear p3) (clear d1) (on d4 p1) (on d3 d4)
        (on d2 d3) (on d1 d2)) (:goal (and))))");
    request(
        "set_goals", "SetGoals",
        R"({goal_instance: base, fluents: [{pddl_instance: x, name: on, args: [d4, p3]}, {pddl_instance: x, name: on, args: [d3, d4]},
  {pddl_instance: x, name: on, args: [d2, d3]}, {pddl_instance: x, name: on, args: [d1, d2]}]})");
    std::int64_t units = 0;
    auto made = bus_.subscribe(client_, "/pddl_manager/plan_report", **registry_.message(kReport),
                               [&](const bus::Delivery& d) { units = d.message->view().integer("units"); });
    for (int i = 0; i < 2; ++i) {
      const auto answer = plan("{pddl_instance: x, goal_instance: base}");
      ticks(3);
      EXPECT_TRUE(answer->success);
    }
    bus_.remove(*made);
    return units;
  };
  EXPECT_LT(units_of_second(true), units_of_second(false));
}

TEST_F(ManagerTest, PlanBeginsWithThatOfAnotherGoalInstanceWithMostGoalsInCommonAndFewestOthers) {
  const auto units_after = [&](std::vector<std::string> goals) {
    manager_.reset();
    start(at_cost(0, 0));
    load_blocks(kSixBlocks);
    request("set_goals", "SetGoals", kSixGoal);
    for (const char* other : {"few", "most", "astray"})
      request("create_goal_instance", "CreateGoalInstance",
              std::string("{pddl_instance: bw, goal_instance: ") + other + "}");
    request("set_goals", "SetGoals", "{goal_instance: few, fluents: [{pddl_instance: bw, name: on, args: [a, e]}]}");
    request("set_goals", "SetGoals",
            "{goal_instance: astray, fluents: [{pddl_instance: bw, name: on, args: [a, e]}, "
            "{pddl_instance: bw, name: on, args: [c, d]}, {pddl_instance: bw, name: on, args: [d, f]}]}");
    request(
        "set_goals", "SetGoals",
        R"({goal_instance: most, fluents: [{pddl_instance: bw, name: on, args: [c, b]}, {pddl_instance: bw, name: on, args: [b, f]},
  {pddl_instance: bw, name: on, args: [f, a]}, {pddl_instance: bw, name: on, args: [a, e]}]})");
    std::int64_t units = 0;
    auto made = bus_.subscribe(client_, "/pddl_manager/plan_report", **registry_.message(kReport),
                               [&](const bus::Delivery& d) { units = d.message->view().integer("units"); });
    goals.push_back("base");
    for (const std::string& goal : goals) {
      const auto answer = plan("{pddl_instance: bw, goal_instance: " + goal + "}");
      ticks(3);
      EXPECT_TRUE(answer->success) << goal;
    }
    bus_.remove(*made);
    return units;
  };
  EXPECT_LT(units_after({"most"}), units_after({}));
  EXPECT_NE(units_after({"most"}), units_after({"few"}));
  EXPECT_EQ(units_after({"most", "few"}), units_after({"most"}));
  EXPECT_NE(units_after({"astray"}), units_after({"few"}));
  EXPECT_EQ(units_after({"few", "astray"}), units_after({"few"})) << "of as many common goals, that with fewest others";
}

TEST_F(ManagerTest, APlanForOtherGoalsBeginsAgain) {
  const auto units_of_second = [&](bool warm_start) {
    PddlManagerOptions options = at_cost(0, 0);
    options.warm_start = warm_start;
    manager_.reset();
    start(std::move(options));
    load_blocks();
    request("set_goals", "SetGoals", kTower);
    (void)plan("{pddl_instance: bw, goal_instance: base}");
    ticks(3);
    request("clear_goals", "ClearGoals", "{pddl_instance: bw, goal_instance: base}");
    request("set_goals", "SetGoals", "{goal_instance: base, fluents: [{pddl_instance: bw, name: on, args: [b, c]}]}");
    std::int64_t units = 0;
    auto made = bus_.subscribe(client_, "/pddl_manager/plan_report", **registry_.message(kReport),
                               [&](const bus::Delivery& d) { units = d.message->view().integer("units"); });
    const auto answer = plan("{pddl_instance: bw, goal_instance: base}");
    ticks(3);
    bus_.remove(*made);
    EXPECT_EQ(answer->actions.size(), 2u);
    return units;
  };
  EXPECT_EQ(units_of_second(true), units_of_second(false));
}

TEST_F(ManagerTest, TwoRunsAreTheSameToTheLastByte) {
  const auto run = [&] {
    KeptRecords sink;
    bus::Bus bus(registry_, sink);
    auto manager = PddlManager::create(at_cost(0.1, 1e-6), bus, sink);
    EXPECT_TRUE(manager.ok());
    const auto agent = bus.join(bus::ParticipantKind::kEnvironment, {"agent", "/", {}}, sink.open_stream("agent"));
    const auto call = [&](const std::string& name, const std::string& type, const std::string& request) {
      const bus::ServiceType& service = **registry_.service("cx_pddl_interfaces/srv/" + type);
      auto made = bus.create_client(agent, "/pddl_manager/" + name, service, nullptr);
      bus.call(*made, std::make_shared<bus::Message>(*bus::Message::from_yaml(*service.request, request)));
    };
    call("add_pddl_instance", "AddPddlInstance",
         "{name: bw, directory: \"" + blocks_folder() + "\", domain_file: domain.pddl, problem_file: problem.pddl}");
    call("set_goals", "SetGoals", kTower);
    const bus::ActionType& type = **registry_.action("cx_pddl_interfaces/action/PlanTemporal");
    auto made = bus.create_action_client(agent, "/pddl_manager/temp_plan", type, {});
    bus.send_goal(*made, std::make_shared<bus::Message>(
                             *bus::Message::from_yaml(*type.goal, "{pddl_instance: bw, goal_instance: base}")));
    for (int i = 1; i < 50; ++i) {
      bus.begin_tick(SimTime{i * 20'000'000});
      EXPECT_TRUE((*manager)->sense(bus.now()).ok());
      bus.deliver(agent);
      EXPECT_TRUE((*manager)->act(bus.now()).ok());
    }
    return sink.text();
  };
  const std::string first = run();
  EXPECT_THAT(first, HasSubstr("unstack"));
  EXPECT_EQ(first, run());
}

TEST_F(ManagerTest, RequestsWithoutAPlanAreCountedByStatus) {
  start();
  load_text("(define (domain d) (:predicates (p) (q)) (:action a :precondition (q) :effect (p)))",
            "(define (problem p) (:domain d))");
  request("set_goals", "SetGoals", "{goal_instance: base, fluents: [{pddl_instance: x, name: p}]}");
  EXPECT_THAT(manager_->warnings(), ::testing::IsEmpty());
  for (int i = 0; i < 3; ++i) {
    plan("{pddl_instance: x, goal_instance: base}");
    ticks(200);
  }
  for (int i = 0; i < 2; ++i) {
    plan("{pddl_instance: x, goal_instance: nowhere}");
    ticks(200);
  }
  EXPECT_THAT(
      manager_->warnings(),
      ElementsAre(AllOf(StartsWith("/pddl_manager: no plan at 0."), HasSubstr(" s and 2 times more: the goal (p) "
                                                                              "is out of reach: only a (d.pddl:1)")),
                  "/pddl_manager: no plan was found in 5 requests (ERROR 2, UNSOLVABLE 3)"));
}

TEST_F(ManagerTest, FiveCausesOfMissingPlansAreNamedAndTheOthersCounted) {
  start(at_cost(0, 0));
  load_text("(define (domain d) (:predicates (q ?x) (r)) (:action b :effect (r)))",
            "(define (problem p) (:domain d) (:objects a b c d e f))");
  const auto ask = [&](const std::string& object) {
    request("create_goal_instance", "CreateGoalInstance", "{pddl_instance: x, goal_instance: " + object + "}");
    request("set_goals", "SetGoals",
            "{goal_instance: " + object + ", fluents: [{pddl_instance: x, name: q, args: [" + object + "]}]}");
    plan("{pddl_instance: x, goal_instance: " + object + "}");
    ticks(3);
  };
  for (const char* object : {"a", "b", "c", "d", "e"}) ask(object);
  EXPECT_THAT(manager_->warnings(), ElementsAre(HasSubstr("(q a)"), HasSubstr("(q b)"), HasSubstr("(q c)"),
                                                HasSubstr("(q d)"), HasSubstr("(q e)"), HasSubstr("in 5 requests")));
  ask("f");
  ASSERT_EQ(manager_->warnings().size(), 7U);
  EXPECT_EQ(manager_->warnings()[5], "/pddl_manager: 1 more causes of missing plans are in its log");
}

TEST_F(ManagerTest, APlanForTheSameGoalInstanceOfTheSameInstanceIsAReplan) {
  start(at_cost(0, 0));
  load_blocks();
  request("set_goals", "SetGoals", kTower);
  load_text("(define (domain d) (:predicates (r)) (:action b :effect (r)))", "(define (problem p) (:domain d))");
  request("set_goals", "SetGoals", "{goal_instance: base, fluents: [{pddl_instance: x, name: r}]}");
  const auto replans_after = [&](const std::string& instance) {
    const auto answer = plan("{pddl_instance: " + instance + ", goal_instance: base}");
    ticks(3);
    EXPECT_TRUE(answer->success);
    return manager_->replans();
  };
  EXPECT_EQ(replans_after("bw"), 0);
  EXPECT_EQ(replans_after("x"), 0);
  EXPECT_EQ(replans_after("bw"), 1);
}

TEST_F(ManagerTest, EachCauseOfAMissingPlanIsAWarningOnce) {
  start(at_cost(1, 0));
  const auto received = listen("/pddl_manager/plan_report", kReport);
  load_text(
      "(define (domain d) (:predicates (p ?x) (q ?x) (r)) (:constants k) (:action a :parameters (?x) :precondition "
      "(q ?x) :effect (p ?x)) (:action b :effect (r)))",
      "(define (problem p) (:domain d) (:objects l))");
  const auto goal = [&](const std::string& name, const std::string& fluent) {
    request("create_goal_instance", "CreateGoalInstance", "{pddl_instance: x, goal_instance: " + name + "}");
    request("set_goals", "SetGoals", "{goal_instance: " + name + ", fluents: [{pddl_instance: x, " + fluent + "}]}");
    plan("{pddl_instance: x, goal_instance: " + name + "}");
    ticks(200);
  };
  goal("one", "name: p, args: [l]");
  goal("two", "name: q, args: [k]");
  goal("three", "name: p, args: [l]");
  goal("four", "name: r");
  EXPECT_THAT(
      manager_->warnings(),
      ElementsAre(EndsWith("s and once more: the goal (p l) is out of reach: only a (d.pddl:1) makes it true, "
                           "and needs (q l); no action makes it true, and the instance lacks it"),
                  EndsWith("s: the goal (q k) is out of reach: no action makes it true, and the instance lacks it")));
  ASSERT_EQ(received->size(), 4U);
  EXPECT_THAT((*received)[1], HasSubstr("reason: \"the goal (q k) is out of reach: no action makes it true"));
  const std::vector<std::string> told = manager_->warnings();
  plan("{pddl_instance: x, goal_instance: one}");
  ticks(1);
  bus_.cancel_goal(last_client_, last_goal_);
  ticks(200);
  EXPECT_THAT(received->back(), HasSubstr("status: \"CANCELED\""));
  EXPECT_EQ(manager_->warnings(), told) << "a cancel is no cause";
}

}  // namespace
}  // namespace cxlab::planner::plans_test
