#include "sim/mujoco/render.h"

#include <array>
#include <cstdlib>
#include <fstream>
#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/mujoco/mujoco_world.h"
#include "sim/mujoco/overlay.h"
#include "sim/mujoco/posed_floor.h"
#include "test_floor.h"

namespace cxlab::sim {
namespace {

using testing::HasSubstr;

class Rendering : public testing::Test {
 protected:
  void SetUp() override {
    world_ = std::move(*MujocoWorld::create(small_floor(), test_options()));
    auto made = Renderer::create(small_floor(), world_->gate(), 320, 240);
    ASSERT_TRUE(made.ok()) << made.error().text();
    renderer_ = std::move(*made);
  }
  StationId station(const char* name) { return *world_->plan().find_station(name); }
  std::vector<std::uint8_t> draw(const char* camera) {
    auto picture = renderer_->draw(world_->gate(), camera);
    EXPECT_TRUE(picture.ok()) << picture.error().text();
    return (*picture)->rgb;
  }
  /// Pixels in which one channel is bright and the two others are not.
  static int pixels_of(const std::vector<std::uint8_t>& rgb, int channel) {
    int count = 0;
    for (std::size_t i = 0; i < rgb.size(); i += 3) {
      const auto at = [&](int c) { return rgb[i + static_cast<std::size_t>(c % 3)]; };
      if (at(channel) > 130 && at(channel + 1) < 70 && at(channel + 2) < 70) ++count;
    }
    return count;
  }
  std::unique_ptr<MujocoWorld> world_;
  std::unique_ptr<Renderer> renderer_;
};

TEST_F(Rendering, EveryCameraShowsAnotherPicture) {
  std::vector<std::vector<std::uint8_t>> seen;
  for (const std::string& camera : renderer_->cameras()) {
    seen.push_back(draw(camera.c_str()));
    for (std::size_t i = 0; i + 1 < seen.size(); ++i) EXPECT_NE(seen.back(), seen[i]) << camera;
  }
  EXPECT_EQ(seen.size(), 2u + 2u + 2u + 4u);
}

TEST_F(Rendering, UnknownCameraNamesTheNearest) {
  const auto picture = renderer_->draw(world_->gate(), "C-CS2");
  ASSERT_FALSE(picture.ok());
  EXPECT_THAT(picture.error().message, HasSubstr("no camera 'C-CS2', expected one of: field, top, follow-R1, "));
  EXPECT_THAT(picture.error().message, HasSubstr("did you mean 'C-CS1'?"));
}

TEST_F(Rendering, LightsShineAndBlinkTwiceASecond) {
  const auto dark = draw("C-CS1");
  world_->set_lights(station("C-CS1"), {Light::kOn, Light::kOff, Light::kOff});
  const int lit = pixels_of(draw("C-CS1"), 0);
  EXPECT_GT(lit, pixels_of(dark, 0) + 20);

  world_->set_lights(station("C-CS1"), {Light::kBlink, Light::kOff, Light::kOff});
  std::string phases;
  for (int tick = 0; tick < 50; ++tick) {
    phases += pixels_of(draw("C-CS1"), 0) > lit / 2 ? '#' : '.';
    ASSERT_TRUE(world_->advance(std::chrono::milliseconds(20)).ok());
  }
  EXPECT_THAT(phases, testing::MatchesRegex("#+[.]+#+[.]+#+"));
}

TEST_F(Rendering, PieceIsSeenInItsColours) {
  const int before = pixels_of(draw("C-CS1"), 0);
  ASSERT_TRUE(world_->dispense(station("C-CS1"), 0.155, Stack{1, {}, 0}).ok());
  EXPECT_GT(pixels_of(draw("C-CS1"), 0), before + 20);
}

TEST_F(Rendering, OverviewShowsPiecesAndSignalLights) {
  for (const char* camera : {"field", "top"}) {
    const auto before = draw(camera);
    ASSERT_TRUE(world_->dispense(station("C-BS"), 0.155, Stack{1, {}, 0}).ok());
    EXPECT_GT(pixels_of(draw(camera), 0), pixels_of(before, 0) + 10) << camera;
    world_->retire(PieceId{camera == std::string("field") ? 1 : 2}, Holder::kGate);

    const int dark = pixels_of(draw(camera), 1);
    world_->set_lights(station("C-CS1"), {Light::kOff, Light::kOff, Light::kOn});
    EXPECT_GT(pixels_of(draw(camera), 1), dark + 10) << camera;
    world_->set_lights(station("C-CS1"), {});
  }
}

/// The colour of the pixel at a place of the overlay, which counts from below.
std::array<int, 3> pixel(const Picture& picture, int x, int y) {
  const auto at = 3 * static_cast<std::size_t>((picture.height - 1 - y) * picture.width + x);
  return {picture.rgb[at], picture.rgb[at + 1], picture.rgb[at + 2]};
}

TEST_F(Rendering, LabelsHaveTheLampsOfTheirMachine) {
  world_->set_lights(station("C-RS1"), {Light::kOn, Light::kOff, Light::kOn});
  world_->set_lights(station("C-DS"), {Light::kOff, Light::kOn, Light::kOff});
  using Lamps = std::array<std::array<int, 3>, 3>;
  const std::map<std::string, Lamps> expected{{"C-RS1", {{{255, 38, 25}, {56, 48, 0}, {38, 242, 64}}}},
                                              {"C-DS", {{{56, 8, 6}, {255, 217, 0}, {8, 53, 14}}}}};
  for (const char* camera : {"field", "top", "follow-R1"}) {
    const Picture& picture = **renderer_->draw(world_->gate(), camera);
    std::size_t seen = 0;
    for (const Overlay::Label& label : renderer_->overlay().labels) {
      if (!expected.contains(label.name) || label.box.width == 0) continue;
      ++seen;
      for (std::size_t k = 0; k < 3; ++k) {
        const Box& lamp = label.lamps[k];
        EXPECT_TRUE(lamp.within(label.box));
        const auto colour = pixel(picture, lamp.middle_x(), lamp.middle_y());
        for (std::size_t c = 0; c < 3; ++c)
          EXPECT_NEAR(colour[c], expected.at(label.name)[k][c], 2) << camera << ' ' << label.name << ' ' << k;
      }
    }
    EXPECT_GE(seen, std::string(camera) == "follow-R1" ? 0u : 2u) << camera;
  }
}

TEST_F(Rendering, ColumnsShowAllPartsOfAProduct) {
  const PieceId piece = *world_->dispense(station("C-RS1"), 0, Stack{1, {}, 0});
  for (std::uint8_t ring = 1; ring <= 3; ++ring) world_->mount(piece, Part::kRing, ring);
  world_->mount(piece, Part::kCap, 2);
  const std::vector<std::array<int, 3>> colours{
      {217, 20, 20}, {26, 64, 230}, {26, 166, 51}, {255, 128, 13}, {140, 143, 148}};
  for (const char* camera : {"field", "top"}) {
    const Picture& picture = **renderer_->draw(world_->gate(), camera);
    const auto& columns = renderer_->overlay().columns;
    ASSERT_EQ(columns.size(), 1u);
    const Box& box = columns[0].box;
    const int layer = (box.height - 2) / 6;
    for (int part = 0; part < 5; ++part) {
      const int y = box.bottom + 1 + (part == 0 ? layer : (part + 1) * layer + layer / 2);
      const auto colour = pixel(picture, box.middle_x(), y);
      for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(colour[c], colours[static_cast<std::size_t>(part)][c], 2) << camera << " part " << part;
    }
  }
}

TEST_F(Rendering, LegendHasProductsInTheirColoursAndCoversNothing) {
  Legend legend;
  legend.cards = {{Stack{1, {1, 2, 3}, 2}, {{{"1 C3"}, {"0:00-1:00"}}}, {{0, 1, 1}}},
                  {Stack{3, {}, 1}, {{{"2 C0"}, {"0:00-1:00"}}}, {}}};
  auto renderer = std::move(*Renderer::create(small_floor(), world_->gate(), 640, 480));
  for (const char* camera : {"field", "top", "follow-R1"}) {
    const Picture& picture = **renderer->draw(world_->gate(), camera, legend);
    const Overlay& overlay = renderer->overlay();
    ASSERT_EQ(overlay.columns.size(), 2u) << camera;
    const Box& box = overlay.columns[0].box;
    const int layer = (box.height - 2) / 6;
    const std::array<int, 3> base = pixel(picture, box.middle_x(), box.bottom + layer);
    const std::array<int, 3> ring = pixel(picture, box.middle_x(), box.bottom + 1 + 4 * layer + layer / 2);
    EXPECT_EQ(base, (std::array<int, 3>{217, 20, 20})) << camera;
    EXPECT_EQ(ring, (std::array<int, 3>{255, 128, 13})) << camera;
    ASSERT_EQ(overlay.ticks.size(), 1u);
    EXPECT_TRUE(overlay.ticks[0].box.within(overlay.cards[0]));
    const Box& tick = overlay.ticks[0].box;
    EXPECT_GT(pixel(picture, tick.right() - 1, tick.top() - 1)[1], 200);

    EXPECT_EQ(overlay.lines.size(), 4u);
    ASSERT_EQ(overlay.cards.size(), 2u);
    for (const Overlay::Line& line : overlay.lines) EXPECT_TRUE(line.box.within({0, 0, 640, 480})) << line.text.text;
    EXPECT_FALSE(overlay.cards[0].overlaps(overlay.cards[1]));
    for (const Overlay::Label& label : overlay.labels)
      for (const Box& card : overlay.cards) {
        EXPECT_FALSE(card.overlaps(label.box)) << camera << ' ' << label.name;
        EXPECT_FALSE(card.overlaps(label.body)) << camera << ' ' << label.name;
      }
  }
  ASSERT_TRUE(renderer->draw(world_->gate(), "R1", legend).ok());
  EXPECT_TRUE(renderer->overlay().cards.empty()) << "what a robot sees has nothing written over it";
}

TEST_F(Rendering, LegendOfManyCardsLeavesHalfOfThePicture) {
  Legend legend;
  for (int i = 0; i < 60; ++i) legend.cards.push_back({Stack{1, {}, 1}, {{{"1 C0"}, {"0:00-1:00"}}}, {}});
  ASSERT_TRUE(renderer_->draw(world_->gate(), "field", legend).ok());
  EXPECT_GT(renderer_->overlay().cards.size(), 5u);
  for (const Box& card : renderer_->overlay().cards) EXPECT_GE(card.bottom, 120);
}

/// The corners of the small floor's field and of what stands on it.
std::array<Vec3, 8> field_corners(const FloorPlan& plan) {
  return corners({(plan.min_x + plan.max_x) / 2, (plan.min_y + plan.max_y) / 2, 0}, (plan.max_x - plan.min_x) / 2,
                 (plan.max_y - plan.min_y) / 2, 1.1);
}

struct Shape {
  int width, height;
  double least;  ///< share of the picture that the field's outline has
};

TEST_F(Rendering, FieldFillsPicturesOfAnyShape) {
  const auto one_team = [] {  // one half of the field
    FloorPlan plan = small_floor();
    plan.min_x = 0;
    return plan;
  };
  for (const FloorPlan& plan : {small_floor(), one_team()}) {
    auto world = std::move(*MujocoWorld::create(plan, test_options()));
    const double field = (plan.max_x - plan.min_x) / (plan.max_y - plan.min_y);
    for (const auto& [width, height, least] : {Shape{640, 480, 0.6},
                                               {640, 360, 0.75},
                                               {961, 400, 0.75},
                                               {300, 640, 0.5},
                                               {480, 480, 0.45},
                                               {101, 77, 0.5}}) {
      auto renderer = std::move(*Renderer::create(plan, world->gate(), width, height));
      for (const char* camera : {"field", "top"}) {
        const std::string where = std::to_string(width) + 'x' + std::to_string(height) + ' ' + camera;
        const Picture picture = **renderer->draw(world->gate(), camera);
        const auto points = field_corners(plan);
        const Box outline = renderer->projection().around(points);
        EXPECT_TRUE(outline.within({0, 0, width, height})) << where;
        // As large as the picture lets it be, in one direction at least.
        EXPECT_TRUE(outline.width > width * 0.9 || outline.height > (height - 60) * 0.8) << where << outline.height;
        const double share = static_cast<double>(outline.width) * outline.height / (width * height);
        if (field > 1.5) {
          EXPECT_GT(share, camera == std::string("field") ? least : least * 0.8) << where;
        }
        // No sky, which is lighter than the ground around the field.
        for (const auto& [x, y] : {std::pair{0, 0}, {width - 1, 0}, {0, height - 1}, {width - 1, height - 1}})
          EXPECT_LT(pixel(picture, x, y)[2], 130) << where << ' ' << x << ' ' << y;
      }
    }
  }
}

TEST_F(Rendering, ThingsAreWhereTheProjectionSays) {
  world_->set_lights(station("C-CS1"), {Light::kOff, Light::kOff, Light::kOff});
  const PieceId piece = *world_->dispense(station("C-CS1"), 0.155, Stack{1, {}, 0});
  for (const auto& [width, height] : {std::pair{640, 480}, {300, 640}}) {
    auto renderer = std::move(*Renderer::create(small_floor(), world_->gate(), width, height));
    for (const char* camera : {"field", "top"}) {
      const Picture& picture = **renderer->draw(world_->gate(), camera);
      const auto at = renderer->projection().pixel(world_->find(piece)->position_in_world);
      ASSERT_TRUE(at);
      const auto colour = pixel(picture, static_cast<int>(at->x), static_cast<int>(at->y) + 4);
      EXPECT_EQ(colour, (std::array<int, 3>{217, 20, 20})) << camera << ' ' << width;
    }
  }
}

TEST_F(Rendering, PosedFloorLooksAsTheWorldThatItIsPosedAs) {
  const PieceId piece = *world_->dispense(station("C-CS1"), 0.155, Stack{3, {2, 4, 0}, 1});
  world_->set_lights(station("C-RS1"), {Light::kOn, Light::kOff, Light::kBlink});
  for (int tick = 0; tick < 60; ++tick) {
    world_->command_base(RobotId{0}, 0.4, 0.2, 0.7);
    world_->command_gripper(RobotId{1}, {0.1, 0.02, 0.03});
    world_->command_fingers(RobotId{1}, 0.01);
    ASSERT_TRUE(world_->advance(std::chrono::milliseconds(20)).ok());
  }
  auto floor = std::move(*PosedFloor::create(small_floor(), test_options()));
  const auto pose_of_world = [&] {
    FloorPose pose;
    for (int i = 0; i < 2; ++i) pose.robots.push_back(world_->robot(RobotId{i}));
    for (int i = 0; i < 4; ++i) pose.lights.push_back(world_->lights(StationId{i}));
    for (const Piece& one : world_->pieces())
      pose.pieces.push_back(
          {one.stack, compose(pose_in_space(small_floor().stations[1].pose_in_world), world_->pose_in_holder(one))});
    return pose;
  };
  const auto expect_alike = [&](const char* camera) {
    const auto moved = draw(camera);
    auto renderer = std::move(*Renderer::create(small_floor(), floor->gate(), 320, 240));
    const auto& posed = (*renderer->draw(floor->gate(), camera))->rgb;
    std::size_t others = 0;
    for (std::size_t i = 0; i < moved.size(); ++i) others += std::abs(moved[i] - posed[i]) > 8;
    // Fingers may differ by a hair, and edges of what is small by a pixel.
    EXPECT_LT(others, moved.size() / (camera == std::string("field") ? 100 : 500)) << camera;
  };
  floor->pose(pose_of_world(), to_seconds(world_->now()));
  for (const char* camera : {"field", "C-CS1", "R2", "follow-R1"}) expect_alike(camera);
  world_->retire(piece, Holder::kGate);
  world_->set_lights(station("C-RS1"), {});
  floor->pose(pose_of_world(), to_seconds(world_->now()));
  for (const char* camera : {"field", "C-CS1"}) expect_alike(camera);
}

TEST_F(Rendering, PosedFloorLeavesOutPiecesThatItHasNoBodiesFor) {
  auto floor = std::move(*PosedFloor::create(small_floor(), test_options()));
  FloorPose pose;
  pose.pieces.resize(PosedFloor::kMostPieces + 10, {Stack{1, {}, 0}, {{1, 1, 1}}});
  floor->pose(pose, 0);
  auto renderer = std::move(*Renderer::create(small_floor(), floor->gate(), 320, 240));
  EXPECT_TRUE(renderer->draw(floor->gate(), "top").ok());
}

TEST_F(Rendering, CameraThatFollowsHasItsRobotInTheMiddle) {
  for (int tick = 0; tick < 100; ++tick) {
    world_->command_base(RobotId{0}, 0.5, 0.3, 1);
    ASSERT_TRUE(world_->advance(std::chrono::milliseconds(20)).ok());
  }
  ASSERT_TRUE(renderer_->draw(world_->gate(), "follow-R1").ok());
  const auto& labels = renderer_->overlay().labels;
  const auto robot = std::ranges::find(labels, "R1", &Overlay::Label::name);
  ASSERT_NE(robot, labels.end());
  EXPECT_TRUE(robot->body.overlaps({155, 115, 10, 10}));
  EXPECT_GT(robot->body.height, 50);
}

TEST_F(Rendering, DrawingMovesNothing) {
  auto other = std::move(*MujocoWorld::create(small_floor(), test_options()));
  for (MujocoWorld* world : {world_.get(), other.get()}) {
    ASSERT_TRUE(world->dispense(station("C-BS"), 0, Stack{1, {}, 0}).ok());
    world->run_belt(station("C-BS"), 0.1, 0.155);
    for (int tick = 0; tick < 40; ++tick) {
      world->command_base(RobotId{0}, 0.3, 0.1, 0.2);
      ASSERT_TRUE(world->advance(std::chrono::milliseconds(20)).ok());
      if (world == world_.get() && tick % 8 == 0) draw("field");
    }
  }
  EXPECT_EQ(world_->physics_hash(), other->physics_hash());
}

TEST_F(Rendering, PngIsWrittenOrItIsAnError) {
  auto picture = renderer_->draw(world_->gate(), "top");
  ASSERT_TRUE(picture.ok());
  const auto file = std::filesystem::path(testing::TempDir()) / "cxlab_top.png";
  ASSERT_TRUE(write_png(**picture, file).ok());
  char head[8] = {};
  std::ifstream(file, std::ios::binary).read(head, 8);
  EXPECT_EQ(std::string(head, 8), "\x89PNG\r\n\x1a\n");
  std::filesystem::remove(file);
  EXPECT_EQ(write_png(**picture, "/nowhere/top.png").error().kind, ErrorKind::kResource);
}

TEST_F(Rendering, BothWaysToOpenGlGiveTheSamePicture) {
  std::vector<std::uint8_t> pictures[2];
  int i = 0;
  for (const char* way : {"osmesa", "egl"}) {
    setenv("CXLAB_GL", way, 1);
    auto made = Renderer::create(small_floor(), world_->gate(), 320, 240);
    if (!made) GTEST_SKIP() << way << ": " << made.error().text();
    pictures[i++] = (*(*made)->draw(world_->gate(), "field"))->rgb;
  }
  unsetenv("CXLAB_GL");
  EXPECT_EQ(pictures[0], pictures[1]);
}

TEST(GlContext, WordThatIsNoWayIsRefused) {
  setenv("CXLAB_GL", "vulkan", 1);
  const auto context = GlContext::create(64, 64);
  unsetenv("CXLAB_GL");
  ASSERT_FALSE(context.ok());
  EXPECT_THAT(context.error().message, HasSubstr("expected osmesa or egl"));
}

}  // namespace
}  // namespace cxlab::sim
