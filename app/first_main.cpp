// cxlab_first: what `./dev run` builds in a fresh clone. It plays the game of the league and has no other command, so it needs
// half of the sources of cxlab. Its games are those of cxlab, byte for byte.

#include "app/command.h"
#include "scenarios/rcll/refbox/node.h"
#include "scenarios/rcll/world.h"

namespace {

cxlab::Status add_first(CLI::App& app, cxlab::app::Action& action) {
  app.footer("This program is the first part of a build. `./dev cxlab --help` builds the whole, with all commands and worlds.");
  cxlab::app::add_run(app, action);
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  const cxlab::Catalogue catalogue{.worlds = {&cxlab::kEmptyWorld, &cxlab::rcll::kWorld},
                                   .nodes = {&cxlab::rcll::kLeagueClient}};
  return cxlab::app::run_commands(argc, argv, catalogue, add_first);
}
