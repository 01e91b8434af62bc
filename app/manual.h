#pragma once
// The command line described in other forms. The declarations of the commands are the only source.

#include <CLI/CLI.hpp>
#include <string>

namespace cxlab::app {

/// A page for man(1), in roff.
std::string manual_page(const CLI::App& app, const std::string& version);
/// Scripts that complete commands, options and their values.
std::string bash_completion(const CLI::App& app);
std::string zsh_completion(const CLI::App& app);

}  // namespace cxlab::app
