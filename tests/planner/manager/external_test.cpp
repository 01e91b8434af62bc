// Planners of others, run as commands.

#include "planner/manager/external.h"

#include <unistd.h>

#include <fstream>

#include "../validator/checker.h"

namespace cxlab::planner {
namespace {

TEST(FindPlanWith, OurExitCodesAreAnswers) {
  const Checker world("(:action light :effect (lit)) (:predicates (lit))", "(:init) (:goal (lit))");
  const auto answer = [&](int code) {
    return find_plan_with({"echo why >&2; exit " + std::to_string(code), true}, world.task(), 10);
  };
  for (const auto& [code, status] : {std::pair{10, PlanStatus::kUnsolvable},
                                     {12, PlanStatus::kEnded},
                                     {22, PlanStatus::kMemory},
                                     {23, PlanStatus::kBudget}}) {
    ASSERT_TRUE(answer(code)) << code;
    EXPECT_EQ(answer(code)->status, status) << code;
    EXPECT_EQ(answer(code)->reason, "why");
  }
  ASSERT_FALSE(answer(5));
  EXPECT_EQ(answer(5).error().message, "the planner ended with code 5 and wrote no plan: why");
  EXPECT_EQ(find_plan_with({"echo why; exit 10", false}, world.task(), 10)->reason,
            "the planner ended with code 10 and wrote no plan: why");
}

TEST(FindPlanWith, ACommandThatTheShellCannotRunIsAnError) {
  const Checker world("(:predicates (lit))", "(:init) (:goal (lit))");
  for (const auto& [command, code] : {std::pair{"no-such-planner {domain}", "127"}, {"/dev/null {domain}", "126"}}) {
    const auto answer = find_plan_with({command, false}, world.task(), 10);
    ASSERT_FALSE(answer) << command;
    EXPECT_EQ(answer.error().message.rfind("the planner's command cannot be run (code " + std::string(code) + "): ", 0),
              0u)
        << answer.error().message;
    EXPECT_NE(answer.error().message.find("parameter `command`"), std::string::npos) << answer.error().message;
  }
  const auto answer = find_plan_with(up_engine("up_engine.py", "nopython", "aries"), world.task(), 10);
  ASSERT_FALSE(answer);
  EXPECT_NE(answer.error().message.find("; set the parameter `python` to a Python interpreter that has the Unified "
                                        "Planning Framework; found 'nopython'"),
            std::string::npos)
      << answer.error().message;
}

TEST(FindPlanWith, OtherPlannersNeedOnlyATenthOfAMillisecondBetweenSteps) {
  const Checker world(
      "(:predicates (lit) (seen)) (:action light :effect (lit)) (:action see :precondition (lit) :effect (seen))",
      "(:init) (:goal (seen))");
  const auto found = [&](const char* second) {
    return find_plan_with({std::string("printf '0: (light)\\n") + second + ": (see)\\n' > {plan}", false}, world.task(),
                          10)
        ->plan.has_value();
  };
  EXPECT_TRUE(found("0.0002"));
  EXPECT_FALSE(found("0.00002"));
}

TEST(FindPlanWith, APlanOfAnotherPlannerHasTheMakespanAndTheMetricThatTheValidatorFinds) {
  const Checker world(
      "(:predicates (lit) (seen)) (:durative-action light :parameters () :duration (= ?duration 4) :condition () "
      ":effect "
      "(at end (lit))) (:action see :precondition (lit) :effect (seen))",
      "(:init) (:goal (seen)) (:metric minimize (* 2 (total-time)))");
  const auto answer = find_plan_with({"printf '7: (see)\\n2: (light) [4]\\n' > {plan}", false}, world.task(), 10);
  ASSERT_TRUE(answer) << answer.error().text();
  ASSERT_TRUE(answer->plan) << answer->reason;
  EXPECT_NEAR(answer->plan->makespan_s, 7, 1e-9);
  ASSERT_TRUE(answer->plan->metric);
  EXPECT_NEAR(*answer->plan->metric, 14, 1e-9);
  ASSERT_EQ(answer->plan->steps.size(), 2u);
  EXPECT_EQ(answer->plan->steps[0].start, 2) << "steps are in the order of their beginnings";
}

TEST(FindPlanWith, EndsProcessesThatThePlannerLeavesRunning) {
  const Checker world("(:predicates (lit))", "(:init) (:goal (lit))");
  const auto is_gone = [](pid_t process) {
    for (int tries = 0; tries < 200; ++tries, usleep(10'000)) {
      std::ifstream stat("/proc/" + std::to_string(process) + "/stat");
      std::string id, name, state;
      if (!(stat >> id >> name >> state) || state == "Z") return true;
    }
    return false;
  };
  const std::string file = testing::TempDir() + "left_running";
  for (const auto& [ends, timeout] : {std::pair{"exit 1", 10.0}, {"sleep 60", 0.2}}) {
    (void)find_plan_with({"sleep 60 & echo $! > " + file + "; " + ends, false}, world.task(), timeout);
    pid_t left = 0;
    std::ifstream(file) >> left;
    ASSERT_GT(left, 0);
    EXPECT_TRUE(is_gone(left)) << ends;
  }
}

}  // namespace
}  // namespace cxlab::planner
