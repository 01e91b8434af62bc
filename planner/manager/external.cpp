#include "planner/manager/external.h"

#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>

#include "planner/pddl/parser.h"
#include "planner/pddl/text.h"
#include "planner/validator/validator.h"

extern char** environ;

namespace cxlab::planner {

namespace {

namespace fs = std::filesystem;

/// A folder that is gone afterwards.
class WorkFolder {
 public:
  WorkFolder() {
    std::string pattern = (fs::temp_directory_path() / "cxlab-plan-XXXXXX").string();
    if (const char* made = mkdtemp(pattern.data())) path_ = made;
  }
  ~WorkFolder() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

std::string filled(std::string command, const std::string& placeholder, const fs::path& file) {
  for (std::size_t at = 0; (at = command.find(placeholder, at)) != std::string::npos; at += file.string().size())
    command.replace(at, placeholder.size(), file.string());
  return command;
}

struct Ended {
  bool in_time = true;
  int code = 0;
};

/// The command with all that it starts is a process group of its own.
Expected<Ended> run(const std::string& command, double timeout_s) {
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, STDERR_FILENO, STDOUT_FILENO);  // stdout carries answers only
  std::string shell = "sh", option = "-c", text = command;
  char* arguments[] = {shell.data(), option.data(), text.data(), nullptr};
  pid_t child = 0;
  const int refused = posix_spawn(&child, "/bin/sh", &files, &attributes, arguments, environ);
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  if (refused != 0) return Error{ErrorKind::kResource, "the planner's command could not be started: " + command, {}, 0, {}};

  const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeout_s);
  Ended ended;
  int status = 0;
  while (waitpid(child, &status, WNOHANG) == 0) {
    if (std::chrono::steady_clock::now() >= deadline) {
      ended.in_time = false;
      kill(-child, SIGKILL);
      waitpid(child, &status, 0);
      break;
    }
    usleep(2000);
  }
  ended.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return ended;
}

}  // namespace

Expected<PlanAnswer> find_plan_with(const std::string& command, const Task& task, double timeout_s) {
  const WorkFolder folder;
  if (folder.path().empty()) return Error{ErrorKind::kResource, "no folder for the planner's files could be made", {}, 0, {}};
  const fs::path domain = folder.path() / "domain.pddl", problem = folder.path() / "problem.pddl", plan = folder.path() / "plan.txt";
  std::ofstream(domain) << to_pddl(task.domain);
  std::ofstream(problem) << to_pddl(task.domain, task.problem);
  auto ended = run(filled(filled(filled(command, "{domain}", domain), "{problem}", problem), "{plan}", plan), timeout_s);
  if (!ended) return ended.error();

  PlanAnswer answer;
  if (!fs::is_regular_file(plan)) {
    answer.status = ended->in_time ? PlanStatus::kEnded : PlanStatus::kBudget;
    answer.reason = ended->in_time ? "the planner ended with code " + std::to_string(ended->code) + " and wrote no plan" : "the planner was ended after its time";
    return answer;
  }
  auto text = read_text(plan.string());
  if (!text) return text.error();
  auto steps = parse_plan(*text, "plan.txt", task.domain, task.problem);
  if (!steps) return steps.error();
  auto verdict = Validator(task.domain, task.problem).check(*steps);
  if (!verdict) return verdict.error();
  if (!verdict->valid) {
    answer.refused = 1;
    answer.reason = answer.refusal = "the planner's plan is wrong: " + to_text(*verdict->violation);
    return answer;
  }
  std::stable_sort(steps->begin(), steps->end(), [](const PlanStep& a, const PlanStep& b) { return a.start < b.start; });
  answer.status = PlanStatus::kPlan;
  answer.reason = "a plan of another planner";
  answer.plan.emplace();
  answer.plan->makespan_s = verdict->makespan;
  answer.plan->metric = verdict->metric;
  answer.plan->steps = *std::move(steps);
  return answer;
}

}  // namespace cxlab::planner
