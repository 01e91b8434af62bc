#include "sim/skills/pose_noise.h"

#include <gtest/gtest.h>

namespace cxlab::sim {
namespace {

TEST(PoseNoise, ARobotIsOffByItsErrorWhereThereIsRoomElseByLess) {
  FloorPlan plan;
  plan.walls = {{{2, 0}, {2, 8}}};
  const Traffic traffic(plan);
  struct Case {
    Pose2 error;
    double x, y;
  };
  for (const auto& [error, x, y] : {Case{{-0.4, 0.2, 0.5}, 0.6, 4.2},  //
                                    Case{{0.6, 0, 0}, 1.6, 4},         // 0.375 m from the wall
                                    Case{{0.8, 0.4, 0}, 1.4, 4.2},     // half
                                    Case{{2.4, 0, 0}, 1.6, 4},         // a quarter
                                    Case{{8, 0, -0.1}, 1, 4}}) {       // only turned
    const Pose2 there = astray({1, 4, 3}, error, traffic);
    EXPECT_NEAR(there.x, x, 1e-9);
    EXPECT_NEAR(there.y, y, 1e-9);
    EXPECT_NEAR(there.yaw, wrap_angle(3 + error.yaw), 1e-9);
  }
}

TEST(PoseNoise, TheCameraFindsASpotThatIsNearEnoughAndAhead) {
  const Pose2 align{1, 2, 3.1};
  EXPECT_TRUE(in_sight(align, align));
  EXPECT_TRUE(in_sight(align, {1.2, 2.28, -2.8}));
  EXPECT_FALSE(in_sight(align, {1.2, 2.3, 3.1}));
  EXPECT_FALSE(in_sight(align, {1, 2, 2.5}));
  EXPECT_FALSE(in_sight(align, {1, 2, -2.6}));
}

}  // namespace
}  // namespace cxlab::sim
