#pragma once
// Names that completion offers for an argument: they are looked up when the script is made.

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

namespace cxlab::app {

using Suggestions = std::function<std::vector<std::string>()>;

/// The argument may be one of these names; `files`: or a file.
CLI::Option* suggest(CLI::Option* option, Suggestions names, bool files = false);

struct Suggested {
  std::vector<std::string> names;
  bool files = true;
};
Suggested suggested_for(const CLI::Option& option);

/// Scenarios that come with cxlab.
std::vector<std::string> scenario_names();

}  // namespace cxlab::app
