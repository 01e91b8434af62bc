#pragma once
// What Python asks for when it plays: the scenario with its overrides, and how it is played.

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lab/session.h"

namespace cxlab::python {

/// PATH=VALUE, and the argument that errors in it name.
using Assignments = std::vector<std::pair<std::string, std::string>>;

/// The scenario of a file or name. It touches no object of Python.
Expected<Scenario> scenario_of(const std::string& name, const Assignments& assignments);

/// Raises if `journal` is no level. `out`: empty = nothing is written.
lab::PlayOptions play_options(std::optional<double> until, const std::string& journal, const std::string& out,
                              bool force);

}  // namespace cxlab::python
