#include "planner/manager/external.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <vector>

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
std::string shell_word(const std::string& word) { return "'" + filled(word, "'", "'\\''") + "'"; }

/// The last line that is not empty.
std::string last_line(const std::string& text) {
  const std::string body = text.substr(0, text.find_last_not_of(" \t\r\n") + 1);
  return body.substr(body.find_last_of('\n') + 1);
}

/// Between texts for a servant.
const std::string kEnd(1, '\0');

/// What a planner is asked, as texts without a zero byte.
struct Question {
  std::string domain, problem;
  double timeout_s = 0;
};

/// What came of a command.
struct Outcome {
  std::optional<int> code;  ///< none if it was ended after its time
  std::string printed;
  std::optional<std::string> plan;
};

std::vector<std::string> parts_of(const std::string& text) {
  std::vector<std::string> parts(1);
  for (const char c : text)
    if (c == '\0')
      parts.emplace_back();
    else
      parts.back() += c;
  return parts;
}

/// Ended after its time, and when whoever asked is gone.
std::optional<int> wait_for(Process& process, double timeout_s, const std::function<bool()>& gone) {
  constexpr double kPart = 0.1;
  for (double left = timeout_s; left > 0 && !gone(); left -= kPart)
    if (const auto code = process.wait_for(std::min(left, kPart))) return code;
  return std::nullopt;
}

Expected<Outcome> run(const ExternalPlanner& planner, const Question& question, const std::function<bool()>& gone) {
  const auto scratch = ScratchFolder::create();
  if (!scratch) return scratch.error();
  const fs::path& folder = (*scratch)->path();
  const fs::path domain = folder / "domain.pddl", problem = folder / "problem.pddl", plan = folder / "plan.txt",
                 log = folder / "log.txt";
  std::ofstream(domain) << question.domain;
  std::ofstream(problem) << question.problem;
  std::string command = planner.command;
  for (const auto& [placeholder, value] : {std::pair<std::string, std::string>{"{domain}", domain},
                                           {"{problem}", problem},
                                           {"{plan}", plan},
                                           {"{timeout}", fixed_text(question.timeout_s, 3)}})
    command = filled(std::move(command), placeholder, value);
  ProcessOptions shell{.argv = {"/bin/sh", "-c", command}};
  shell.out = shell.err = Stream::file(log);
  auto process = Process::start(shell);
  if (!process) return process.error();
  Outcome out;
  out.code = wait_for(*process, question.timeout_s, gone);
  if (const auto printed = read_file(log)) out.printed = *printed;
  std::erase(out.printed, '\0');
  if (!is_file(plan)) return out;
  auto text = read_file(plan);
  if (!text) return text.error();
  out.plan = *std::move(text);
  return out;
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
  return {shell_word(python) + " -W ignore " + shell_word(script.string()) + " " + shell_word(engine) +
              " {domain} {problem} {plan} --timeout {timeout}",
          true,
          "set the parameter `python` to a Python interpreter that has the Unified Planning Framework; found '" +
              python + "'"};
}

static Expected<PlanAnswer> answer_of(const ExternalPlanner& planner, const Outcome& outcome, const Task& task) {
  std::fputs(outcome.printed.c_str(), stderr);  // stdout carries answers only
  if (!outcome.plan) return without_plan(planner, outcome.code, last_line(outcome.printed));

  PlanAnswer answer;
  auto steps = parse_plan(*outcome.plan, "plan.txt", task.domain, task.problem);
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

static Question question_of(const Task& task, double timeout_s) {
  return {to_pddl(task.domain), to_pddl(task.domain, task.problem), timeout_s};
}

Expected<PlanAnswer> find_plan_with(const ExternalPlanner& planner, const Task& task, double timeout_s) {
  const auto outcome = run(planner, question_of(task, timeout_s), [] { return false; });
  if (!outcome) return outcome.error();
  return answer_of(planner, *outcome, task);
}

Expected<PlannerServant> PlannerServant::start(ExternalPlanner planner) {
  auto servant = Servant::start([planner](const std::string& request, const std::function<bool()>& gone) {
    const std::vector<std::string> asked = parts_of(request);
    const auto timeout_s = asked.size() == 3 ? read_number<double>(asked[2]) : std::nullopt;
    if (!timeout_s) return Servant::Answer{"error" + kEnd + "is no question"};
    const auto outcome = run(planner, {asked[0], asked[1], *timeout_s}, gone);
    if (!outcome) return Servant::Answer{"error" + kEnd + outcome.error().text()};
    std::string text = (outcome->code ? std::to_string(*outcome->code) : "") + kEnd + outcome->printed;
    if (outcome->plan) text += kEnd + *outcome->plan;
    return Servant::Answer{text};
  });
  if (!servant) return servant.error();
  return PlannerServant(std::move(planner), *std::move(servant));
}

Expected<PlanAnswer> PlannerServant::find_plan(const Task& task, double timeout_s) {
  const Question question = question_of(task, timeout_s);
  const auto answer =
      servant_.ask(question.domain + kEnd + question.problem + kEnd + general_text(question.timeout_s, 17));
  if (!answer) return answer.error();
  const std::vector<std::string> parts = parts_of(answer->text);
  if (parts.size() < 2 || parts[0] == "error") return resource_error(parts.back());
  Outcome outcome{read_number<int>(parts[0]), parts[1], std::nullopt};
  if (parts.size() > 2) outcome.plan = parts[2];
  return answer_of(planner_, outcome, task);
}

}  // namespace cxlab::planner
