#pragma once
// The options of coverage that `cxlab test` and `cxlab coverage` share.

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "lab/coverage.h"

namespace cxlab::app {

/// The page under that name, and `--fail-under`.
void add_coverage(CLI::App& command, const char* page, lab::CoverageOptions& options);

/// `--fail-under` alone.
CLI::Option* add_fail_under(CLI::App& command, std::optional<double>& percent, const std::string& what);

}  // namespace cxlab::app
