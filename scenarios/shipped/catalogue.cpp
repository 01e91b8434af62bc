#include "scenarios/shipped/catalogue.h"

#include "scenarios/pddl/node.h"
#include "scenarios/rcll/refbox/node.h"
#include "scenarios/rcll/world.h"
#include "scenarios/rl/node.h"
#include "scenarios/story/world.h"
#include "scenarios/turtlesim/world.h"

namespace cxlab {

const Catalogue& shipped() {
  static const Catalogue kCatalogue{.worlds = {&kEmptyWorld, &rcll::kWorld, &turtlesim::kWorld, &story::kWorld},
                                    .nodes = {&turtlesim::kNode, &pddl::kNode, &rl::kNode, &rcll::kLeagueClient}};
  return kCatalogue;
}

}  // namespace cxlab
