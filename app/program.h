#pragma once
// The program `cxlab` as a function, for programs that have its commands and worlds of their own:
//
//   cxlab::Catalogue catalogue = cxlab::shipped();
//   catalogue.worlds.push_back(&grid::kWorld);
//   return cxlab::app::run_program(argc, argv, catalogue);

#include "scenarios/catalogue.h"

namespace cxlab::app {

/// Carries out the command line; returns the exit code (docs/reference/contracts.md). Scenarios and `--with` may name
/// what the catalogue has. Once a process: it sets handlers of signals.
int run_program(int argc, char** argv, const Catalogue& catalogue);
/// The same with the command `run` alone.
int run_first_program(int argc, char** argv, const Catalogue& catalogue);

}  // namespace cxlab::app
