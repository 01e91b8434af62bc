#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "planner/pddl/parser.h"

namespace cxlab::planner::problem_parser_test {
namespace {

constexpr const char* kDomain =
    "(define (domain work-flow) (:types robot place - object depot - place)\n"
    "(:constants base - depot)\n"
    "(:predicates (at ?r - robot ?p - place) (open ?p - place))\n"
    "(:functions (battery ?r - robot) (total-cost)))";

const Domain& domain() {
  static const Domain parsed = *parse_domain(kDomain, "d.pddl");
  return parsed;
}

Problem parsed(const std::string& sections) {
  auto problem =
      parse_problem("(define (problem p) (:domain work_flow) (:objects r1 r2 - robot hall - place)\n" + sections + ")",
                    "p.pddl", domain());
  EXPECT_TRUE(problem) << problem.error().text();
  return problem ? std::move(*problem) : Problem{};
}

std::string error_of(const std::string& sections) {
  const auto problem =
      parse_problem("(define (problem p) (:domain work_flow) (:objects r1 r2 - robot hall - place)\n" + sections + ")",
                    "p.pddl", domain());
  return problem ? "no error" : problem.error().text();
}

TEST(ProblemParser, ConstantsComeBeforeObjects) {
  const Problem problem = parsed("");
  ASSERT_EQ(problem.objects.size(), 4u);
  EXPECT_EQ(problem.objects[0].name, "base");
  EXPECT_EQ(objects_of(domain(), problem, {find(domain().type_names, "place")}), (std::vector<ObjectId>{0, 3}));
}

TEST(ProblemParser, InitHoldsFactsValuesAndLaterEvents) {
  const Problem problem = parsed(
      "(:init (at r1 base) (at r1 base) (not (open hall)) (= (battery r1) 2.5)"
      " (at 9 (not (open hall))) (at 5 (open hall)) (at 7.5 (= (battery r1) 1)) (at 0 (open base)))"
      " (:goal (and (open hall) (exists (?r - robot) (at ?r hall)))) (:metric minimize (+ (total-time) (* 2 "
      "(total-cost))))");
  EXPECT_EQ(problem.init.size(), 1u) << "one fact twice";
  ASSERT_EQ(problem.timed_facts.size(), 3u);
  EXPECT_EQ(problem.timed_facts[0].time, 0) << "an event, too";
  EXPECT_EQ(problem.timed_facts[1].time, 5);
  EXPECT_FALSE(problem.timed_facts[2].value);
  EXPECT_EQ(problem.timed_values.at(0).assignment.value, 1);
  EXPECT_EQ(problem.goal_slots, 1);
  EXPECT_FALSE(problem.metric->maximize);
  ASSERT_EQ(problem.values.size(), 2u);
  EXPECT_EQ(problem.values[1].value, 0) << "total-cost begins with 0";
}

TEST(ProblemParser, ObjectDeclaredTwiceBelongsToBothTypes) {
  const Problem problem = parsed("(:objects r1 - place)");
  EXPECT_EQ(problem.objects.size(), 4u);
  EXPECT_EQ(problem.objects[1].types.size(), 2u);
}

TEST(ProblemParser, ErrorsNameBothFiles) {
  EXPECT_EQ(error_of("(:init (at hall r1))"),
            "p.pddl:2: found hall of type place, expected type robot for argument 1 of at; 'hall' is declared at "
            "p.pddl:1; 'at' is declared at d.pddl:3");
  EXPECT_EQ(error_of("(:init (at r3 base))"),
            "p.pddl:2: found 'r3', expected a variable or an object; did you mean 'r1'?");
  EXPECT_EQ(error_of("(:init (= (battery r1) 1)\n (= (battery r1) 2))"),
            "p.pddl:3: found a second value for (battery r1), expected one");
  EXPECT_EQ(error_of("(:init (= (battery r1) x))"),
            "p.pddl:2: found (= (battery r1) x), expected (= (FUNCTION OBJECT...) NUMBER)");
  EXPECT_EQ(error_of("(:init (at -1 (open hall)))"), "p.pddl:2: found time -1, expected a time that is not negative");
  EXPECT_EQ(error_of("(:goal (open hall) (open base))"),
            "p.pddl:2: found 2 conditions in :goal, expected one; several are joined by (and ...)");
  EXPECT_EQ(error_of("(:goal (and))\n(:goal (and))"), "p.pddl:3: found :goal a second time, expected one");
  EXPECT_EQ(error_of("(:goals)"), "p.pddl:2: found (:goals), expected :domain, :objects, :init, :goal or :metric");
}

TEST(ProblemParser, NamesOfDomainsMayDifferInDashesOnly) {
  EXPECT_TRUE(parse_problem("(define (problem p) (:domain Work_Flow))", "p.pddl", domain()));
  EXPECT_EQ(parse_problem("(define (problem p) (:domain flow))", "p.pddl", domain()).error().text(),
            "p.pddl:1: found domain 'flow', expected 'work-flow', the name in d.pddl");
}

TEST(ProblemParser, PreferencesAreNotSupported) {
  const auto problem =
      parse_problem("(define (problem p) (:domain work-flow) (:goal (preference x (open base))))", "p.pddl", domain());
  ASSERT_FALSE(problem);
  EXPECT_TRUE(is(problem.error(), Failure::kUnsupported));
}

TEST(ProblemParser, StopsWhenTheDeadlineHasPassed) {
  const std::string text = "(define (problem p) (:domain work-flow) (:init) (:goal (and)))";
  const auto now = std::chrono::steady_clock::now();
  EXPECT_TRUE(parse_problem(text, "p.pddl", domain(), now + std::chrono::hours(1)));
  const auto late = parse_problem(text, "p.pddl", domain(), now);
  ASSERT_FALSE(late);
  EXPECT_TRUE(is(late.error(), Failure::kLate));
}

TEST(ProblemParser, LengthIsAdvice) {
  for (const char* length : {"(:length (:serial 5) (:parallel 3))", "(:length)", "(:length (:parallel 2))"})
    EXPECT_EQ(error_of(length + std::string(" (:init (open hall)) (:goal (open hall))")), "no error");
}

TEST(ProblemParser, EventsThatContradictEachOtherAreRefused) {
  EXPECT_EQ(
      error_of("(:init (at 5 (open hall))\n (at 5.0 (not (open hall))))"),
      "p.pddl:3: found (not (open hall)) and its opposite at one time, expected one of them; declared at p.pddl:2");
  EXPECT_EQ(error_of("(:init (at 5 (= (battery r1) 3)) (at 5 (= (battery r1) 4)))"),
            "p.pddl:2: found a second value for (battery r1) at one time, expected one");
  EXPECT_EQ(error_of("(:init (at 5 (open hall)) (at 5 (open hall)) (at 5 (= (battery r1) 3)) (at 5 (= (battery r1) 3))"
                     " (at 6 (not (open hall))) (open hall) (at 0 (not (open hall))))"),
            "no error");
}

TEST(ProblemParser, TimedAssignmentsMayBeWrittenAsEffects) {
  const Problem problem = parsed("(:init (at 1.0 (assign (battery r1) 2)))");
  ASSERT_EQ(problem.timed_values.size(), 1u);
  EXPECT_EQ(problem.timed_values[0].assignment.value, 2);
  for (const char* effect :
       {"(increase (battery r1) 2)", "(forall (?p - place) (open ?p))", "(when (open hall) (open base))"})
    EXPECT_THAT(error_of("(:init (at 1.0 " + std::string(effect) + "))"),
                testing::HasSubstr("found the timed effect ("));
}

TEST(ProblemParser, TimesHaveALimit) {
  EXPECT_EQ(error_of("(:init (at 1700000000 (open hall)))"), "no error");
  EXPECT_EQ(error_of("(:init (at 9000000000 (open hall)))"),
            "p.pddl:2: found time 9000000000: only times below 9000000000 s are supported");
}

TEST(LoadTask, AProblemNeedsAGoal) {
  const auto domain = testing::TempDir() + "goal-domain.pddl", problem = testing::TempDir() + "goal-problem.pddl";
  std::ofstream(domain) << "(define (domain d) (:predicates (p)))";
  std::ofstream(problem) << "(define (problem p) (:domain d) (:init (p)))";
  EXPECT_EQ(load_task(domain, problem).error().text(),
            problem + ": found no :goal, expected (:goal CONDITION); (:goal (and)) always holds");
  std::ofstream(problem) << "(define (problem p) (:domain d) (:init (p)) (:goal ()))";
  EXPECT_TRUE(load_task(domain, problem));
}

TEST(LoadTask, TemplatesSeeTheData) {
  const auto domain = testing::TempDir() + "data-domain.pddl", problem = testing::TempDir() + "data-problem.pddl";
  std::ofstream(domain) << "(define (domain d) (:predicates {% for r in robots %}({{ r.name }}) {% endfor %}))";
  std::ofstream(problem) << "(define (problem p) (:domain d) (:goal ({{ robots[1].name }})))";
  const auto task = load_task(domain, problem, {.data = R"({"robots": [{"name": "a"}, {"name": "b"}]})"});
  ASSERT_TRUE(task) << task.error().text();
  EXPECT_EQ(task->domain.predicates.size(), 2u);
  EXPECT_EQ(task->problem.goal.predicate, 1);
}

TEST(LoadTask, ExampleOfTheDocsMakesADomain) {
  const std::string folder = std::string(std::getenv("CXLAB_SOURCE_DIR")) + "/docs/examples/planning/";
  const auto problem = testing::TempDir() + "stations-problem.pddl";
  std::ofstream(problem) << "(define (problem p) (:domain delivery) (:init) (:goal (and)))";
  const auto task = load_task(folder + "stations.pddl", problem);
  ASSERT_TRUE(task) << task.error().text();
  ASSERT_EQ(task->domain.actions.size(), 2u);
  EXPECT_EQ(task->domain.actions[1].duration.at(0).bound.value, 10);
}

TEST(LoadTask, TemplatesAreRenderedFirst) {
  const auto folder = std::filesystem::temp_directory_path() / ("cxlab-load-" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "base") << "(define (domain d) (:predicates {% block p %}{% endblock %}))";
  std::ofstream(folder / "d")
      << "{% extends 'base' %}{% block p %}{% for n in range(3) %}(p{{ n }}) {% endfor %}{% endblock %}";
  std::ofstream(folder / "p") << "(define (problem p) (:domain d)\n{# two #}\n(:init {{ '(p0)' }} (p9)))";
  const auto task = load_task(folder / "d", folder / "p");
  ASSERT_FALSE(task);
  EXPECT_EQ(
      task.error().text(),
      (folder / "p").string() + " (rendered):3: found 'p9', expected a predicate of the domain; did you mean 'p0'?");
  std::ofstream(folder / "p") << "(define (problem p) (:domain d) (:init (p2)) (:goal (p0)))";
  const auto right = load_task(folder / "d", folder / "p");
  ASSERT_TRUE(right) << right.error().text();
  EXPECT_EQ(right->domain.predicates.size(), 3u);
  std::filesystem::remove_all(folder);
}

TEST(LoadTask, MissingFileIsAnError) {
  EXPECT_EQ(load_task("/nonexistent.pddl", "/nonexistent.pddl").error().text(),
            "/nonexistent.pddl: there is no such file");
}

}  // namespace
}  // namespace cxlab::planner::problem_parser_test
