#include "planner/manager/external.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "cx/base/file.h"
#include "cx/base/number_text.h"
#include "cx/base/process.h"
#include "cx/base/scratch_folder.h"
#include "planner/pddl/parser.h"
#include "planner/pddl/text.h"
#include "planner/validator/validator.h"

namespace cxlab::planner {

namespace {

namespace fs = std::filesystem;

/// s between happenings that interfere: planners keep them apart by different times.
constexpr double kLeastSeparation = 0.0001;
constexpr std::int64_t kMostJudged = 100'000'000;  ///< of objects, while its plan is judged

/// Exit codes of a shell that cannot run a command (POSIX, 2.8.2).
constexpr int kNotExecutable = 126, kNotFound = 127;

std::string filled(std::string command, const std::string& placeholder, const std::string& value) {
  for (std::size_t at = 0; (at = command.find(placeholder, at)) != std::string::npos; at += value.size())
    command.replace(at, placeholder.size(), value);
  return command;
}

/// For the shell, as one word.
std::string quoted(const std::string& word) { return "'" + filled(word, "'", "'\\''") + "'"; }

/// The last line that is not empty.
std::string last_line(const std::string& text) {
  const std::string body = text.substr(0, text.find_last_not_of(" \t\r\n") + 1);
  return body.substr(body.find_last_of('\n') + 1);
}

/// Its exit code; none if it was ended after its time. `log` is what it prints.
Expected<std::optional<int>> run(const std::string& command, const fs::path& log, double timeout_s) {
  ProcessOptions shell{.argv = {"/bin/sh", "-c", command}};
  shell.out = shell.err = Stream::file(log);
  auto process = Process::start(shell);
  if (!process) return process.error();
  return process->wait_for(timeout_s);
}

/// The answer of a planner that wrote no plan; without a code it was ended after its time. `printed` is its last line.
Expected<PlanAnswer> without_plan(const ExternalPlanner& planner, std::optional<int> code, const std::string& printed) {
  PlanAnswer answer;
  answer.status = code ? PlanStatus::kEnded : PlanStatus::kBudget;
  if (!code) {
    answer.reason = "the planner was ended after its time";
    return answer;
  }
  const std::string said = printed.empty() ? "" : ": " + printed;
  if (*code == kNotExecutable || *code == kNotFound)
    return resource_error("the planner's command cannot be run (code " + std::to_string(*code) + ")" + said + "; " +
                          planner.remedy);
  answer.reason = "the planner ended with code " + std::to_string(*code) + " and wrote no plan" + said;
  if (!planner.our_codes) return answer;
  answer.status = static_cast<PlanStatus>(*code);
  constexpr std::array kAnswers = {PlanStatus::kUnsolvable, PlanStatus::kEnded, PlanStatus::kMemory,
                                   PlanStatus::kBudget};
  if (std::ranges::find(kAnswers, answer.status) == kAnswers.end()) return resource_error(answer.reason);
  answer.reason = printed;
  return answer;
}

}  // namespace

ExternalPlanner up_engine(const fs::path& script, const std::string& python, const std::string& engine) {
  return {quoted(python) + " -W ignore " + quoted(script.string()) + " " + quoted(engine) +
              " {domain} {problem} {plan} --timeout {timeout}",
          true,
          "set the parameter `python` to a Python interpreter that has the Unified Planning Framework; found '" +
              python + "'"};
}

Expected<PlanAnswer> find_plan_with(const ExternalPlanner& planner, const Task& task, double timeout_s) {
  const auto scratch = ScratchFolder::create();
  if (!scratch) return scratch.error();
  const fs::path& folder = (*scratch)->path();
  const fs::path domain = folder / "domain.pddl", problem = folder / "problem.pddl", plan = folder / "plan.txt",
                 log = folder / "log.txt";
  std::ofstream(domain) << to_pddl(task.domain);
  std::ofstream(problem) << to_pddl(task.domain, task.problem);
  std::string command = planner.command;
  for (const auto& [placeholder, value] : {std::pair<std::string, std::string>{"{domain}", domain},
                                           {"{problem}", problem},
                                           {"{plan}", plan},
                                           {"{timeout}", fixed_text(timeout_s, 3)}})
    command = filled(std::move(command), placeholder, value);
  const auto code = run(command, log, timeout_s);
  if (!code) return code.error();
  const auto output = read_file(log.string());
  const std::string printed = output ? *output : "";
  std::fputs(printed.c_str(), stderr);  // stdout carries answers only
  if (!is_file(plan)) return without_plan(planner, *code, last_line(printed));

  PlanAnswer answer;
  auto text = read_file(plan.string());
  if (!text) return text.error();
  auto steps = parse_plan(*text, "plan.txt", task.domain, task.problem);
  if (!steps) return steps.error();
  Meter meter(kMostJudged);
  auto verdict = Validator(task.domain, task.problem, &meter).check(*steps, {.epsilon = kLeastSeparation});
  if (!verdict) return verdict.error();
  if (!verdict->valid) {
    answer.refused = 1;
    answer.reason = answer.refusal = "the planner's plan is wrong: " + to_text(*verdict->violation);
    return answer;
  }
  std::ranges::stable_sort(*steps, {}, &PlanStep::start);
  answer.status = PlanStatus::kPlan;
  answer.reason = "a plan of another planner";
  answer.plan.emplace();
  answer.plan->makespan_s = verdict->makespan;
  answer.plan->metric = verdict->metric;
  answer.plan->steps = *std::move(steps);
  return answer;
}

}  // namespace cxlab::planner
