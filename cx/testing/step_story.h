#pragma once
// A story that is played step by step in C++: the rules run while an expectation waits for them, and each skill ends
// when the test says so (docs/reference/stories.md).
//
//   Story story({.config = "params/agent.yaml", .packages = {{"my_agent", "."}}}, setup, report);
//   story.skill("/R1/fetch", "my_msgs/action/Fetch");
//   story.given("(order (id O1) (base RED))");
//   story.expect_command("R1", "fetch", "RED");
//   story.skill_fails("R1", "fetch", 206);
//   story.expect_command("R1", "fetch", "RED");

#include <functional>
#include <memory>
#include <source_location>
#include <string>

#include "cx/testing/story.h"

namespace cxlab::testing {

class Story {
 public:
  using Where = std::source_location;
  /// Called with each failure at once; with GoogleTest: `ADD_FAILURE_AT(where.file_name(), where.line()) << what;`
  using Report = std::function<void(const Where& where, const std::string& what)>;

  /// Uses of the spec: config or rules, packages, environment, seed. A rule file that cannot be used is a failure.
  Story(StorySpec spec, StorySetup setup, Report report, Where where = Where::current());
  /// Errors in rules that nobody has seen yet are failures.
  ~Story();
  Story(const Story&) = delete;
  Story& operator=(const Story&) = delete;

  /// Serves an action; its goals are taken, and end by `skill_succeeds` and `skill_fails`.
  void skill(const std::string& action, const std::string& type, Where where = Where::current());
  void given(const std::string& fact, Where where = Where::current());
  /// Time goes by.
  void pass(double seconds, Where where = Where::current());

  /// Within `patience` a goal comes to /ROBOT/SKILL whose field `target` is that. Each goal is expected once.
  void expect_command(const std::string& robot, const std::string& skill, const std::string& target,
                      Where where = Where::current());
  /// Within `patience` there is such a fact (pattern as in story files).
  void expect_fact(const std::string& pattern, Where where = Where::current());
  /// There is no such fact now.
  void expect_no_fact(const std::string& pattern, Where where = Where::current());

  /// The goal that /ROBOT/SKILL has taken ends, with the fields `success` and `error_code` where its result has them.
  void skill_succeeds(const std::string& robot, const std::string& skill, Where where = Where::current());
  void skill_fails(const std::string& robot, const std::string& skill, int error_code, Where where = Where::current());

  /// How long an expectation waits, s of simulated time (10).
  void set_patience(double seconds);
  double now_s() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cxlab::testing
