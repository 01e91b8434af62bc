#pragma once
// The rule bases of scenarios, configurations and rule files, examined without running them (cx/check/check.h).

#include <cstddef>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/check/check.h"
#include "lab/host.h"
#include "lab/packages.h"
#include "scenarios/catalogue.h"

namespace cxlab::lab {

struct CheckOptions {
  std::vector<std::string> inputs;  ///< scenarios, configurations (YAML), and rule files, which are one rule base
  PackageOptions packages;
  std::vector<std::string> params;  ///< NODE.NAME=VALUE, of configurations: which files are loaded may depend on them
  bool graph = false;               ///< `Checked::graph` is wanted
  bool dot = false;                 ///< as text for Graphviz instead of SVG
};

struct Checked {
  std::vector<check::Finding> findings;  ///< by file and line
  std::size_t files = 0, rules = 0;      ///< that were examined
  std::string graph;                     ///< of the first environment
};

/// Plugins and rule files are loaded as in a run, with calls in batch files; no rule fires. The error is the first of
/// an input that cannot be read or loaded.
Expected<Checked> check_rules(const CheckOptions& options, const Catalogue& catalogue, const Host& host = {});

}  // namespace cxlab::lab
