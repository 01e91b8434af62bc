#include "app/exit_codes.h"

#include <csignal>

#include "cx/base/expected.h"
#include "lab/sweep/judge.h"
#include "planner/pddl/failure.h"

namespace cxlab::app {

namespace {

using planner::PlanStatus;

constexpr ExitCode kExitCodes[] = {
    {0, "", "done", "The command did what was asked, and the answer is yes."},
    {int(ErrorKind::kNo), "", "the answer is no",
     "The answer is no. A test failed, a plan is not valid, two runs differ, an expectation of the scenario does not "
     "hold, `check` has findings, or the value of `--fail-under` is not reached."},
    {int(ErrorKind::kUsage), "", "usage",
     "The command line is wrong: an unknown command or option, a missing argument, or an output folder that is in "
     "use."},
    {int(ErrorKind::kInput), "", "bad input", "A file or value cannot be used."},
    {int(ErrorKind::kRun), "", "the run failed",
     "The run failed: a rule raised an error, rules gave up or went round in a loop, the world diverged, or a plugin "
     "failed. `env` ends with this code for errors of rules only with `--stop-on-rule-error`."},
    {int(ErrorKind::kResource), "", "output or resource",
     "The machine lacks something, such as room on the disk, memory or a library, or a picture or film cannot be "
     "made."},
    {lab::kUndecidedExit, "bench", "", "The rows of the sweep do not decide the question: more seeds may."},
    {int(PlanStatus::kUnsolvable), "plan", "", "The problem has no plan, and the planner proved it."},
    {int(PlanStatus::kEnded), "plan", "", "The search ended without a plan and without a proof that none exists."},
    {int(PlanStatus::kMemory), "plan", "", "The memory that the search may use is exhausted."},
    {int(PlanStatus::kBudget), "plan, validate", "", "The time or the budget of work units ended."},
    {planner::kBadInputCode, "plan, validate", "", "A PDDL file or plan cannot be used."},
    {planner::kUnsupportedCode, "plan, validate", "", "A file is valid PDDL but uses a feature that is not supported."},
    {int(ErrorKind::kBug), "", "a bug of cxlab",
     "cxlab has a bug, or a rule or native plugin crashed the process. The message names the signal and the rule at "
     "work."},
    {128 + SIGINT, "", "", "SIGINT (Ctrl-C) ended the command."},
    {128 + SIGTERM, "", "", "SIGTERM ended the command."},
};

}  // namespace

std::span<const ExitCode> exit_codes() { return kExitCodes; }

std::string exit_codes_line() {
  std::string line = "Exit codes:";
  for (const ExitCode& row : exit_codes())
    if (!row.brief.empty()) line += ' ' + std::to_string(row.code) + ' ' + std::string(row.brief) + ';';
  return line + ' ' + std::to_string(128 + SIGINT) + ", " + std::to_string(128 + SIGTERM) + " ended by a signal.";
}

}  // namespace cxlab::app
