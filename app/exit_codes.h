#pragma once
// The exit codes of the program: help, man page and docs/reference/commands.md show this table.

#include <span>
#include <string>
#include <string_view>

namespace cxlab::app {

struct ExitCode {
  int code;
  std::string_view commands;  ///< those that alone use the code; empty: all
  std::string_view brief;     ///< for the last line of each help; empty: not shown there
  std::string_view meaning;
};

std::span<const ExitCode> exit_codes();

/// "Exit codes: 0 done; 1 the answer is no; ...", the last line of each help.
std::string exit_codes_line();

}  // namespace cxlab::app
