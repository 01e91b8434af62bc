// When plans are answered and events happen, and which state the planner receives.

#include "fixture.h"

namespace cxlab::planner::times_test {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr const char* kReport = "cxlab_pddl_interfaces/msg/PlanReport";
constexpr const char* kGate =
    R"((define (domain gate) (:requirements :durative-actions :timed-initial-literals :derived-predicates)
  (:types thing) (:constants door - thing) (:predicates (open) (near ?t - thing) (through) (ready)) (:functions (toll ?t - thing))
  (:derived (ready) (and (open) (near door)))
  (:durative-action walk :parameters (?t - thing) :duration (= ?duration 2) :condition () :effect (at end (near ?t)))
  (:durative-action pass :parameters () :duration (= ?duration 1) :condition (and (over all (open)) (over all (near door)))
   :effect (at end (through)))))";
constexpr const char* kOpenFrom4To8 =
    "(define (problem p) (:domain gate) (:objects bell lamp - thing) (:init (near door) (= (toll bell) 1) (at 4 "
    "(open)) "
    "(at 8 (not (open)))) (:goal (and)) (:metric minimize (+ (total-time) (toll bell))))";
constexpr const char* kThrough = "{goal_instance: base, fluents: [{pddl_instance: x, name: through}]}";
constexpr const char* kPlanThrough = "{pddl_instance: x, goal_instance: base}";

class ManagerTimes : public ManagerTest {
 protected:
  void begin(double a = 0, double b = 0) {
    PddlManagerOptions options;
    options.cost.latency_a = a;
    options.cost.latency_b = b;
    start(std::move(options));
  }
  void load_gate() {
    loaded_ = now_ + SimTime{20'000'000};
    load_text(kGate, kOpenFrom4To8);
    request("set_goals", "SetGoals", kThrough);
  }
  /// Ticks until that many seconds after the gate was loaded.
  void until(double seconds) {
    while (now_ < loaded_ + from_seconds(seconds)) tick();
  }
  std::shared_ptr<Answer> answered(const std::string& goal) {
    auto answer = plan(goal);
    ticks(3);
    return answer;
  }
  SimTime loaded_{};
};

TEST_F(ManagerTimes, APlanCountsTheTimesOfEventsFromNow) {
  begin();
  load_gate();
  for (const double later : {0.5, 3.0}) {
    until(later);
    const double before = to_seconds(now_ - loaded_);
    const auto answer = answered(kPlanThrough);
    ASSERT_EQ(answer->actions.size(), 1u);
    double begins = -1;
    ASSERT_EQ(std::sscanf(answer->actions[0].c_str(), "pass() @%lf", &begins), 1);
    EXPECT_NEAR(begins, 4 - before, 0.05);
  }
  until(5);
  EXPECT_THAT(answered(kPlanThrough)->actions, ElementsAre("pass() @0.00+1 class 0"));
  request("rm_fluents", "RemoveFluents", "{fluents: [{pddl_instance: x, name: open}]}");
  EXPECT_FALSE(answered(kPlanThrough)->success) << "an event happens only once";
}

TEST_F(ManagerTimes, AnEventComesAtItsTickAndDerivedFactsFollow) {
  begin();
  load_gate();
  EXPECT_THAT(fluents("x"), ElementsAre("near(door)"));
  until(3.96);
  EXPECT_THAT(fluents("x"), ElementsAre("near(door)")) << "at 3.98 s";
  tick();
  ASSERT_EQ(now_ - loaded_, from_seconds(4.02));
  EXPECT_THAT(fluents("x"), ElementsAre("near(door)", "open()", "ready()"));
}

TEST_F(ManagerTimes, AnEventHappensAtItsExactTime) {
  begin();
  load_gate();
  until(3.98);
  ASSERT_EQ(now_ - loaded_, from_seconds(3.98));
  EXPECT_THAT(fluents("x"), Contains("open()")) << "asked at 4 s";
}

TEST_F(ManagerTimes, EventsStillHappenAfterObjectsAreRemoved) {
  begin();
  load_gate();
  until(5);
  EXPECT_THAT(fluents("x"), Contains("open()"));
  request("rm_objects", "RemoveObjects", "{objects: [{pddl_instance: x, name: lamp, type: thing}]}");
  EXPECT_THAT(fluents("x"), Contains("open()"));
  until(9);
  EXPECT_THAT(fluents("x"), Not(Contains("open()")));
}

TEST_F(ManagerTimes, AMetricThatReadsFilteredObjectsIsLeftOut) {
  begin();
  load_gate();
  until(5);
  request("set_object_filter", "SetObjectFilter", "{pddl_instance: x, goal_instance: base, objects: [lamp]}");
  EXPECT_TRUE(answered(kPlanThrough)->success);
}

TEST_F(ManagerTimes, ARemovedObjectLeavesTheFilters) {
  begin();
  load_gate();
  const auto received = listen("/pddl_manager/plan_report", kReport);
  request("set_object_filter", "SetObjectFilter", "{pddl_instance: x, goal_instance: base, objects: [bell, lamp]}");
  request("rm_objects", "RemoveObjects", "{objects: [{pddl_instance: x, name: lamp, type: thing}]}");
  request("add_objects", "AddObjects", "{objects: [{pddl_instance: x, name: lamp, type: thing}]}");
  request("set_goals", "SetGoals", "{goal_instance: base, fluents: [{pddl_instance: x, name: near, args: [lamp]}]}");
  EXPECT_FALSE(answered(kPlanThrough)->success);
  ASSERT_EQ(received->size(), 1u);
  EXPECT_THAT(received->front(), HasSubstr("names an object that the object filter leaves out"));
}

TEST_F(ManagerTimes, DerivedFactsAndConstantsStay) {
  begin();
  load_gate();
  EXPECT_THAT(error_of("add_fluents", "AddFluents", "{fluents: [{pddl_instance: x, name: ready}]}"),
              HasSubstr("'ready' is derived"));
  EXPECT_THAT(error_of("rm_objects", "RemoveObjects", "{objects: [{pddl_instance: x, name: door, type: thing}]}"),
              HasSubstr("'door' is a constant of the domain"));
  EXPECT_THAT(fluents("x"), ElementsAre("near(door)"));
}

TEST_F(ManagerTimes, StepsThatBeginTogetherLaterAreOneClassToo) {
  begin();
  load_text(R"((define (domain d) (:requirements :durative-actions) (:predicates (begun) (a) (b) (c))
    (:durative-action open :parameters () :duration (= ?duration 2) :condition () :effect (at end (begun)))
    (:durative-action left :parameters () :duration (= ?duration 3) :condition (at start (begun)) :effect (at end (a)))
    (:durative-action right :parameters () :duration (= ?duration 3) :condition (at start (begun)) :effect (at end (b)))))",
            "(define (problem p) (:domain d) (:init) (:goal (and)))");
  request("set_goals", "SetGoals",
          "{goal_instance: base, fluents: [{pddl_instance: x, name: a}, {pddl_instance: x, name: b}]}");
  const auto answer = answered(kPlanThrough);
  ASSERT_EQ(answer->actions.size(), 3u);
  EXPECT_THAT(answer->actions[0], HasSubstr("class 0"));
  EXPECT_THAT(answer->actions[1], HasSubstr("class 1"));
  EXPECT_THAT(answer->actions[2], HasSubstr("class 1"));
}

TEST_F(ManagerTimes, UnitsTakeSimulatedTimeAndTheShorterAnswerComesFirst) {
  begin(0.5, 1e-6);
  load_blocks();
  request("create_goal_instance", "CreateGoalInstance", "{pddl_instance: bw, goal_instance: small}");
  request("set_goals", "SetGoals", "{goal_instance: small, fluents: [{pddl_instance: bw, name: holding, args: [c]}]}");
  request("set_goals", "SetGoals", "{goal_instance: base, fluents: [{pddl_instance: bw, name: on, args: [a, b]}]}");
  std::vector<std::string> goals;
  std::vector<std::int64_t> units;
  ASSERT_TRUE(bus_.subscribe(client_, "/pddl_manager/plan_report", **registry_.message(kReport),
                             [&](const bus::Delivery& d) {
                               goals.push_back(d.message->view().text("goal_instance"));
                               units.push_back(d.message->view().integer("units"));
                               EXPECT_THAT(d.message->view().to_string(), HasSubstr("status: \"PLAN\""));
                             })
                  .ok());
  const SimTime asked = now_ + SimTime{20'000'000};
  (void)plan("{pddl_instance: bw, goal_instance: base}");
  (void)plan("{pddl_instance: bw, goal_instance: small}");
  ticks(2);
  EXPECT_GE(manager_->next_due(), asked + from_seconds(0.5));
  EXPECT_LT(manager_->next_due(), asked + from_seconds(0.6));
  ticks(30);
  EXPECT_THAT(goals, ElementsAre("small", "base")) << "at one tick, by their times";
  EXPECT_EQ(manager_->next_due(), kNever);
  EXPECT_EQ(manager_->replans(), 0);

  PddlManagerOptions dear;
  dear.cost.latency_a = 0;
  dear.cost.latency_b = 1e-3;
  manager_.reset();
  start(dear);
  load_blocks();
  request("set_goals", "SetGoals", "{goal_instance: base, fluents: [{pddl_instance: bw, name: on, args: [a, b]}]}");
  const double second_asked = to_seconds(now_);
  const auto answer = plan("{pddl_instance: bw, goal_instance: base}");
  ticks(100);
  const double wait = 1e-3 * static_cast<double>(units.back());
  EXPECT_GT(wait, 0.06);
  EXPECT_NEAR(answer->time, second_asked + wait, 0.05);
  (void)plan("{pddl_instance: bw, goal_instance: base}");
  ticks(100);
  EXPECT_EQ(manager_->plans(), 2);
  EXPECT_EQ(manager_->replans(), 1);
}

TEST_F(ManagerTimes, AnOrderingWithoutALatestTimeHasMinusOne) {
  begin();
  load_blocks();
  request("set_goals", "SetGoals", "{goal_instance: base, fluents: [{pddl_instance: bw, name: on, args: [a, b]}]}");
  const auto received = listen("/pddl_manager/plan_report", kReport);
  (void)answered("{pddl_instance: bw, goal_instance: base}");
  ASSERT_EQ(received->size(), 1u);
  EXPECT_THAT(received->front(), HasSubstr("at_most: -1"));
  EXPECT_THAT(received->front(), HasSubstr("at_most: 3")) << "of a duration";
}

}  // namespace
}  // namespace cxlab::planner::times_test
