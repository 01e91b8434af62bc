#pragma once
// Another planner, run as a command.

#include <filesystem>
#include <string>
#include <utility>

#include "cx/base/expected.h"
#include "cx/base/servant.h"
#include "planner/planner.h"

namespace cxlab::planner {

struct ExternalPlanner {
  std::string command;     ///< for /bin/sh; empty: none
  bool our_codes = false;  ///< its exit codes are those of `cxlab plan`, its last line on stderr is the reason
  std::string remedy =
      "does the parameter `command` name a program that is installed and may be run?";  ///< where the shell cannot run
                                                                                        ///< it
};

/// An engine of the Unified Planning Framework, NAME or MODULE:CLASS, run by `script` (up_engine.py) with the Python
/// interpreter that has it.
ExternalPlanner up_engine(const std::filesystem::path& script, const std::string& python, const std::string& engine);

/// Runs the command. {domain} and {problem} are files that it reads, and {plan} is the file that it writes, in the
/// format of PDDL 2.1. The word {timeout} is the wall time in seconds after which the command is ended with all that it
/// started. Its output goes to stderr. A plan that our validator does not accept (with 0.1 ms between happenings) is
/// none: the answer's reason names the fault. The answer's units are 0. Fails if the command cannot be run (the shell
/// ends with 126 or 127; the error ends with the remedy) or if it wrote a plan that cannot be read. With `our_codes`,
/// fails too if it ended with a code that is no answer.
Expected<PlanAnswer> find_plan_with(const ExternalPlanner& planner, const Task& task, double timeout_s);

/// The same by a servant that runs this one command and nothing else, also where this process starts no programs any
/// more (cx/wall/wall.h).
class PlannerServant {
 public:
  static Expected<PlannerServant> start(ExternalPlanner planner);
  Expected<PlanAnswer> find_plan(const Task& task, double timeout_s);

 private:
  PlannerServant(ExternalPlanner planner, Servant servant)
      : planner_(std::move(planner)), servant_(std::move(servant)) {}

  ExternalPlanner planner_;
  Servant servant_;
};

}  // namespace cxlab::planner
