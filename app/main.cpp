// cxlab: the command line. One process plays one episode.

#include "app/program.h"
#include "scenarios/shipped/catalogue.h"

int main(int argc, char** argv) { return cxlab::app::run_program(argc, argv, cxlab::shipped()); }
