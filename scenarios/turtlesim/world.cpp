#include "scenarios/turtlesim/world.h"

#include "scenarios/turtlesim/stage.h"

namespace cxlab::turtlesim {

namespace {

constexpr Tier kTiers[]{Tier::kPhysics};
constexpr std::string_view kName = "turtlesim", kWhat = "turtles on a canvas (docs/turtlesim.md)";

}  // namespace

constinit const WorldKind kWorld{
    .name = kName,
    .what = kWhat,
    .settings = settings_of<Config>(),
    .tick = sim::TurtleWorldOptions().step,
    .physics_step = sim::TurtleWorldOptions().step,
    .tiers = kTiers,
    .any_tick = true,
    .make_stage = TurtleStage::create,
    .replay = replay,
    .add_sample = add_sample,
};

constinit const NodeKind kNode{.name = kName, .what = kWhat, .settings = settings_of<Config>(), .add = add_turtlesim};

}  // namespace cxlab::turtlesim
