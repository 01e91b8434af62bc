// cxlab_first: what `./dev run` builds first in a fresh clone. It plays the game of the league and has no other
// command, so it needs half of the sources of cxlab. Its games are those of cxlab, byte for byte.

#include "app/program.h"
#include "scenarios/rcll/refbox/node.h"
#include "scenarios/rcll/world.h"

int main(int argc, char** argv) {
  const cxlab::Catalogue catalogue{.worlds = {&cxlab::kEmptyWorld, &cxlab::rcll::kWorld},
                                   .nodes = {&cxlab::rcll::kLeagueClient}};
  return cxlab::app::run_first_program(argc, argv, catalogue);
}
