#include "scenarios/rcll/world.h"

#include "scenarios/rcll/result.h"
#include "scenarios/rcll/stage.h"

namespace cxlab::rcll {

namespace {

constexpr Tier kTiers[]{Tier::kPhysics, Tier::kTimed};

}  // namespace

constinit const WorldKind kWorld{
    .name = "rcll",
    .what = "a game of the Logistics League (docs/rcll.md)",
    .settings = settings_of<WorldConfig>(),
    .set_defaults =
        [](Scenario& scenario) {
          const WorldConfig& config = scenario.world.get<WorldConfig>();
          scenario.duration = from_seconds(config.setup_s + config.production_s);
        },
    .tiers = kTiers,
    .takes_faults = true,
    .make_stage = GameStage::create,
    .replay = replay,
    .add_sample = add_sample,
};

}  // namespace cxlab::rcll
