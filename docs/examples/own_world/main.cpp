// The program cxlab with one world more: own_world run maze.yaml, own_world list worlds, ...

#include <app/program.h>
#include <scenarios/shipped/catalogue.h>

#include "grid.h"

int main(int argc, char** argv) {
  cxlab::Catalogue catalogue = cxlab::shipped();
  catalogue.worlds.push_back(&grid::kWorld);
  return cxlab::app::run_program(argc, argv, catalogue);
}
