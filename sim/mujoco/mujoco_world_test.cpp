#include "sim/mujoco/mujoco_world.h"

#include <gtest/gtest.h>

#include "sim/mujoco/test_floor.h"

namespace cxlab::sim {
namespace {

using std::chrono::milliseconds;

TEST(MujocoWorld, Builds) {
  auto world = MujocoWorld::create(small_floor(), test_options());
  ASSERT_TRUE(world.ok()) << world.error().text();
  for (int i = 0; i < 50; ++i) ASSERT_TRUE((*world)->advance(milliseconds(20)).ok());
}

}  // namespace
}  // namespace cxlab::sim
