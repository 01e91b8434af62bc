// Pictures of games from above, over many layouts.

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "scenarios/rcll/game/floor_plan.h"
#include "scenarios/rcll/game/game.h"
#include "scenarios/rcll/game/scene.h"
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

// Ten layouts; the long test sets CXLAB_LAYOUTS.
TEST(Pictures, ShowEveryMachineWholeWithItsLabel) {
  const char* set = std::getenv("CXLAB_LAYOUTS");
  const std::uint64_t layouts = set ? std::stoull(set) : 10;
  const sim::ModelOptions options{models_dir(), 0.01, 4};
  for (std::uint64_t seed = 1; seed <= layouts; ++seed) {
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

TEST(Pictures, FloorIsPosedAsTheSceneSays) {
  const sim::FloorPlan plan = floor_plan_of({}, game_of({}, 1)->layout);
  const auto entity = [](EntityId id, const char* kind, const char* name, const char* state, sim::Pose3 pose) {
    Entity out;
    out.id = id;
    out.kind = kind;
    out.name = name;
    out.state = state;
    out.pose = pose;
    return out;
  };
  Scene scene;
  scene.entities = {entity(1, "robot", "robot2", "pick", {{2, 3, 0}, {0, 0, 1}}),
                    entity(2, "machine", "C-RS1", "BROKEN red-blink yellow", {}),
                    entity(3, "piece", "piece7", "BASE_SILVER RING_GREEN CAP_GREY",
                           {{sim::kRobot.home_forward + 0.1, -0.02, sim::kRobot.home_height + 0.04}}),
                    entity(4, "piece", "piece8", "BASE_RED", {{1, 1, 0.9}}),
                    entity(5, "robot", "nobody", "", {}),
                    entity(6, "machine", "X-BS", "IDLE green", {})};
  scene.entities[2].carried_by = 1;
  scene.entities[2].place = "gripper";
  const sim::FloorPose pose = floor_pose_of(scene, plan);

  ASSERT_EQ(pose.robots.size(), plan.robots.size());
  EXPECT_NEAR(pose.robots[1].pose_in_world.x, 2, 1e-9);
  EXPECT_NEAR(pose.robots[1].pose_in_world.yaw, 1, 1e-9);
  EXPECT_TRUE(pose.robots[1].gripper.isApprox(sim::Vec3(0.1, -0.02, 0.04), 1e-9));
  EXPECT_NEAR(pose.robots[1].finger_opening, 0.022, 1e-9);
  EXPECT_EQ(pose.robots[0].pose_in_world.x, plan.robots[0].pose_in_world.x) << "as at the start";
  EXPECT_EQ(pose.robots[0].finger_opening, sim::kRobot.fingers_open);

  const auto lights = pose.lights[sim::index_of(*plan.find_station("C-RS1"))];
  EXPECT_EQ(lights, (sim::Lights{sim::Light::kBlink, sim::Light::kOn, sim::Light::kOff}));
  EXPECT_EQ(pose.lights[sim::index_of(*plan.find_station("C-BS"))], sim::Lights());

  ASSERT_EQ(pose.pieces.size(), 2u);
  EXPECT_EQ(pose.pieces[0].stack, (sim::Stack{3, {2, 0, 0}, 2}));
  EXPECT_NEAR(pose.pieces[0].underside_in_world.position.z(), sim::kRobot.home_height + 0.04, 1e-9);
  EXPECT_NEAR((pose.pieces[0].underside_in_world.position - sim::Vec3(2, 3, 0)).head<2>().norm(),
              std::hypot(sim::kRobot.home_forward + 0.1, 0.02), 1e-9);
  EXPECT_EQ(pose.pieces[1].stack, (sim::Stack{1, {}, 0}));
}

}  // namespace
}  // namespace cxlab::rcll
