#pragma once
// Failures that callers distinguish, and the exit codes of programs that plan or judge plans: each is defined here
// only.

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

/// Exit codes of `cxlab plan` and `cxlab validate`, beside those of ErrorKind; the scripts for other planners use them
/// too.
enum class ExitCode : int {
  kPlan = 0,
  kUnsolvable = 10,
  kEnded = 12,  ///< everything was tried, without a plan or a proof
  kOutOfMemory = 22,
  kOutOfBudget = 23,  ///< time or work units
  kBadInput = 31,
  kUnsupported = 34,
};

inline int exit_code(const Error& error) {
  if (is(error, Failure::kUnsupported)) return static_cast<int>(ExitCode::kUnsupported);
  if (is(error, Failure::kOutOfMemory)) return static_cast<int>(ExitCode::kOutOfMemory);
  if (is(error, Failure::kOutOfBudget) || is(error, Failure::kLate)) return static_cast<int>(ExitCode::kOutOfBudget);
  if (error.kind == ErrorKind::kInput) return static_cast<int>(ExitCode::kBadInput);
  return static_cast<int>(error.kind);
}

}  // namespace cxlab::planner
