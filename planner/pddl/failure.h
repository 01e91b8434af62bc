#pragma once
// Failures that callers distinguish, and the exit codes of programs that plan or judge plans: each is defined here
// only.

#include <string>

#include "cx/base/expected.h"

namespace cxlab::planner {

/// Failures with a word of their own in `Error::code`.
enum class Failure {
  kUnsupported,  ///< valid PDDL that is not supported
  kLate,         ///< the time ended while a file was read
  kOutOfBudget,
  kOutOfMemory,
};

inline const char* word_of(Failure failure) {
  switch (failure) {
    case Failure::kUnsupported: return "unsupported";
    case Failure::kLate: return "late";
    case Failure::kOutOfBudget: return "budget";
    case Failure::kOutOfMemory: return "memory";
  }
  return "";
}

inline bool is(const Error& error, Failure failure) { return error.code == word_of(failure); }

/// Failure::kOutOfBudget.
inline Error out_of_budget(const char* what) {
  return resource_error(std::string("the budget ended ") + what).with_code(word_of(Failure::kOutOfBudget));
}

/// How planning ended. The numbers are the exit codes of `cxlab plan`; the scripts for other planners use them, too.
enum class PlanStatus : int {
  kPlan = 0,
  kUnsolvable = 10,  ///< proved
  kEnded = 12,       ///< everything was tried, without a plan or a proof
  kMemory = 22,      ///< reported by other planners only
  kBudget = 23,      ///< units or time
};

/// Exit codes of `cxlab plan` and `cxlab validate` beside those of PlanStatus and ErrorKind.
inline constexpr int kBadInputCode = 31, kUnsupportedCode = 34;

inline int exit_code(const Error& error) {
  if (is(error, Failure::kUnsupported)) return kUnsupportedCode;
  if (is(error, Failure::kOutOfMemory)) return static_cast<int>(PlanStatus::kMemory);
  if (is(error, Failure::kOutOfBudget) || is(error, Failure::kLate)) return static_cast<int>(PlanStatus::kBudget);
  if (error.kind == ErrorKind::kInput) return kBadInputCode;
  return static_cast<int>(error.kind);
}

}  // namespace cxlab::planner
