#pragma once
// Another planner, run as a command.

#include <string>

#include "cx/base/expected.h"
#include "planner/planner.h"

namespace cxlab::planner {

/// Runs `command` with /bin/sh: {domain} and {problem} are files that it reads, {plan} is the file that it writes, in the
/// format of PDDL 2.1. After `timeout_s` of wall time it is ended. A plan that our validator does not accept is none: the
/// answer's reason says what is wrong with it. Its units are 0. Fails if the command cannot be run, or wrote no plan
/// that can be read.
Expected<PlanAnswer> find_plan_with(const std::string& command, const Task& task, double timeout_s);

}  // namespace cxlab::planner
