// Pictures of games from above, over many layouts.

#include <gtest/gtest.h>

#include "scenarios/rcll/game/floor_plan.h"
#include "scenarios/rcll/game/game.h"
#include "sim/mujoco/mujoco_world.h"
#include "sim/mujoco/overlay.h"
#include "sim/mujoco/render.h"
#include "tests/support/files.h"

namespace cxlab::rcll {
namespace {

/// Every machine whole, its label beside it and over nothing else.
void expect_labelled(const sim::Overlay& overlay, const sim::Box& picture, const std::string& where) {
  EXPECT_EQ(overlay.labels.size(), 17u) << where;
  for (const auto& label : overlay.labels) {
    const std::string what = where + ' ' + label.name;
    EXPECT_TRUE(label.body.within(picture)) << what;
    EXPECT_GE(std::min(label.body.width, label.body.height), 12) << what;
    ASSERT_GT(label.box.width, 0) << what;
    EXPECT_TRUE(label.box.within(picture)) << what;
    EXPECT_LE(sim::gap_between(label.box, label.body), label.box.width) << what;
    for (const auto& other : overlay.labels) {
      EXPECT_FALSE(label.box.overlaps(other.body)) << what << " covers " << other.name;
      EXPECT_FALSE(&other != &label && label.box.overlaps(other.box)) << what << ' ' << other.name;
    }
    for (const auto& column : overlay.columns) EXPECT_FALSE(label.box.overlaps(column.box)) << what;
  }
}

TEST(Pictures, ShowEveryMachineWholeWithItsLabelInFiftyLayouts) {
  const sim::ModelOptions options{models_dir(), 0.01, 4};
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    auto world = sim::MujocoWorld::create(floor_plan_of({}, game_of({}, seed)->layout), options);
    ASSERT_TRUE(world.ok()) << world.error().text();
    const int width = 640, height = seed % 2 ? 480 : 360;
    auto renderer = sim::Renderer::create((*world)->plan(), (*world)->gate(), width, height);
    ASSERT_TRUE(renderer.ok()) << renderer.error().text();
    for (const char* camera : {"field", "top"}) {
      ASSERT_TRUE((*renderer)->draw((*world)->gate(), camera).ok());
      expect_labelled((*renderer)->overlay(), {0, 0, width, height}, std::to_string(seed) + ' ' + camera);
    }
  }
}

}  // namespace
}  // namespace cxlab::rcll
