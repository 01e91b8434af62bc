// What a bag has of a scene that cannot be shown as it was recorded.

#include "lab/export/scene_channels.h"

#include "folder.h"
#include "tests/support/test_bus.h"

namespace cxlab::lab {

namespace {

class SceneChannelsTest : public FolderTest {};

TEST_F(SceneChannelsTest, LookThatCannotBeReadIsAnError) {
  write("canvas.yaml", "schema: 1\nworld: {kind: turtlesim}\nduration_s: 0.2\n");
  play("canvas");
  auto file = mcap::Writer::create(path("a.mcap"), "ros2", "test");
  ASSERT_TRUE(file);
  bus::Registry own;
  bus::add_interfaces(own);
  RosBag bag(*std::move(file), std::move(own));
  auto channels = SceneChannels::create(bag, run(), {});
  ASSERT_TRUE(channels) << channels.error().text();
  Scene scene;
  scene.entities = {
      {.id = 1,
       .kind = "chair",
       .name = "c1",
       .state = {},
       .look = "box 1 1 1 0 0 0 #ffffff",
       .pose = {},
       .carried_by = {},
       .place = {}},
      {.id = 2, .kind = "lamp", .name = "l1", .state = {}, .look = "ball 3", .pose = {}, .carried_by = {}, .place = {}},
      {.id = 3, .kind = "table", .name = "t1", .state = {}, .look = {}, .pose = {}, .carried_by = {}, .place = {}}};
  const Status seen = channels->see(scene);
  ASSERT_FALSE(seen);
  EXPECT_EQ(seen.error().message.substr(0, 34), "the look of l1: look 'ball 3': fou");
  scene.entities[1].look = "box 1 1 1 0 0 0 #ffffff";
  ASSERT_TRUE(channels->see(scene));
  const auto topics = bag.topics();
  for (const char* kind : {"chair", "lamp", "table"})
    EXPECT_NE(std::ranges::find(topics, std::string("/cxlab/scene/") + kind), topics.end()) << kind;
}

}  // namespace

}  // namespace cxlab::lab
