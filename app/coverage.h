#pragma once
// The options of coverage that `cxlab test` and `cxlab coverage` share.

#include <CLI/CLI.hpp>

#include "lab/coverage.h"

namespace cxlab::app {

/// The page under that name, and `--fail-under`.
void add_coverage(CLI::App& command, const char* page, lab::CoverageOptions& options);

}  // namespace cxlab::app
