// The canvas of turtles: how they move, what they draw, and that a log of it plays again.

#include "sim/box2d/turtle_world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/box2d/turtle_picture.h"

namespace cxlab::sim {
namespace {

constexpr double kMiddle = TurtleWorld::kSide / 2;
constexpr double kNear = 1e-4;

class TurtleWorldTest : public testing::Test {
 protected:
  void play(TurtleWorld& world, double seconds) { ASSERT_TRUE(world.advance(from_seconds(seconds)).ok()); }
  void steps(TurtleWorld& world, int count) {
    for (int i = 0; i < count; ++i) play(world, 0.016);
  }
};

TEST_F(TurtleWorldTest, AStepTurnsFirstAndThenMovesAlongTheNewHeading) {
  TurtleWorld world({});
  const TurtleId id = world.spawn(kMiddle, kMiddle, 0);
  world.drive(id, 1, 0.5, 2);
  steps(world, 1);
  const Turtle& t = *world.find(id);
  EXPECT_NEAR(t.theta, 0.032, kNear);
  EXPECT_NEAR(t.x, kMiddle + (std::cos(0.032) * 1 - std::sin(0.032) * 0.5) * 0.016, kNear);
  EXPECT_NEAR(t.y, kMiddle + (std::sin(0.032) * 1 + std::cos(0.032) * 0.5) * 0.016, kNear);
}

TEST_F(TurtleWorldTest, ACommandHoldsForOneSecond) {
  TurtleWorld world({});
  const TurtleId id = world.spawn(1, kMiddle, 0);
  world.drive(id, 1, 0, 0);
  steps(world, 62);  // 0.992 s
  EXPECT_EQ(world.find(id)->vx, 1);
  EXPECT_NEAR(world.find(id)->x, 1.992, kNear);
  steps(world, 1);
  EXPECT_EQ(world.find(id)->vx, 0) << "1.008 s after it came";
  EXPECT_NEAR(world.find(id)->x, 1.992, kNear);
  world.drive(id, 1, 0, 0);
  steps(world, 40);
  world.drive(id, 1, 0, 0);
  steps(world, 62);
  EXPECT_NEAR(world.find(id)->x, 1.992 + 102 * 0.016, 2 * kNear) << "a new command begins a new second";
}

TEST_F(TurtleWorldTest, AnglesStayWithinHalfATurn) {
  TurtleWorld world({});
  const TurtleId id = world.spawn(kMiddle, kMiddle, 3);
  world.drive(id, 0, 0, 2);
  for (int i = 0; i < 60; ++i) {
    steps(world, 1);
    EXPECT_GT(world.find(id)->theta, -std::numbers::pi);
    EXPECT_LE(world.find(id)->theta, std::numbers::pi);
  }
  EXPECT_NEAR(world.find(id)->theta, 3 + 60 * 0.032 - 2 * std::numbers::pi, 1e-3);
}

TEST_F(TurtleWorldTest, AWallStopsATurtleAndSaysWhereItWouldHaveBeen) {
  TurtleWorld world({});
  const TurtleId id = world.spawn(TurtleWorld::kSide - 0.02, kMiddle, 0);
  world.drive(id, 1, 0, 0);
  steps(world, 1);
  EXPECT_THAT(world.events(), testing::IsEmpty());
  steps(world, 1);
  ASSERT_EQ(world.events().size(), 1u);
  EXPECT_EQ(world.events()[0].kind, TurtleEvent::Kind::kHitWall);
  EXPECT_NEAR(world.events()[0].x, TurtleWorld::kSide + 0.012, kNear);
  EXPECT_TRUE(world.events()[0].first);
  EXPECT_NEAR(world.find(id)->x, TurtleWorld::kSide, kNear);
  steps(world, 1);
  ASSERT_EQ(world.events().size(), 1u) << "at each step";
  EXPECT_FALSE(world.events()[0].first);
  world.drive(id, 0, 0, 0);
  steps(world, 1);
  EXPECT_THAT(world.events(), testing::IsEmpty()) << "at rest at the wall";
}

TEST_F(TurtleWorldTest, TurtlesPassThroughEachOtherUnlessTheyCollide) {
  for (const bool collisions : {false, true}) {
    TurtleWorld world({.collisions = collisions});
    const TurtleId a = world.spawn(4, kMiddle, 0), b = world.spawn(6, kMiddle, 0);
    int touches = 0;
    for (int i = 0; i < 180; ++i) {
      world.drive(a, 1, 0, 0);
      steps(world, 1);
      for (const TurtleEvent& event : world.events()) touches += event.kind == TurtleEvent::Kind::kTouch;
    }
    const double gap = world.find(b)->x - world.find(a)->x;
    if (collisions) {
      EXPECT_NEAR(gap, 0.9, 0.05) << "it pushes the other along";
      EXPECT_GT(world.find(b)->x, 6.1);
      EXPECT_EQ(touches, 1);
    } else {
      EXPECT_NEAR(world.find(a)->x, 4 + 180 * 0.016, 0.01);
      EXPECT_EQ(world.find(b)->x, 6);
      EXPECT_EQ(touches, 0);
    }
  }
}

TEST_F(TurtleWorldTest, PensDrawWhereTurtlesGoAndJump) {
  TurtleWorld world({});
  const TurtleId id = world.spawn(1, 1, 0);
  EXPECT_EQ(world.colour_under(*world.find(id)), (Colour{69, 86, 255}));
  world.teleport(id, 3, 1, 0);
  EXPECT_EQ(world.colour_under(*world.find(id)), (Colour{179, 184, 255}));
  EXPECT_TRUE(world.canvas().ink(90, Canvas::kSize - 1 - 45)) << "the way of the jump at x = 2, y = 1";
  Pen red{{255, 0, 0}, 1, false};
  world.set_pen(id, red);
  world.teleport_relative(id, 2, std::numbers::pi / 2);
  EXPECT_NEAR(world.find(id)->x, 3, kNear);
  EXPECT_NEAR(world.find(id)->y, 3, kNear);
  EXPECT_EQ(world.canvas().ink(135, Canvas::kSize - 1 - 90), red.colour);
  red.off = true;
  world.set_pen(id, red);
  world.teleport(id, 8, 8, 0);
  world.set_background({1, 2, 3});
  EXPECT_EQ(world.colour_under(*world.find(id)), (Colour{1, 2, 3}));
  world.clear();
  EXPECT_FALSE(world.canvas().ink(90, Canvas::kSize - 1 - 45));
}

TEST_F(TurtleWorldTest, AnyDurationTakesTheStepsWhoseTimeHasCome) {
  TurtleWorld fine({}), coarse({}), late({.start = from_seconds(1)});
  for (TurtleWorld* world : {&fine, &coarse, &late}) world->drive(world->spawn(2, 2, 0.3), 1, 0, 0.4);
  for (int i = 0; i < 500; ++i) play(fine, 0.001);
  for (int i = 0; i < 25; ++i) play(coarse, 0.02);
  play(late, 1.5);
  EXPECT_EQ(fine.steps(), 31);
  EXPECT_EQ(fine.hash(), coarse.hash());
  EXPECT_EQ(late.steps(), 31);
  EXPECT_EQ(late.find(TurtleId{1})->x, fine.find(TurtleId{1})->x);
  EXPECT_EQ(fine.next_event(), from_seconds(32 * 0.016));
}

/// Two turtles that push each other about, a third that comes and goes.
void dance(TurtleWorld& world, int steps) {
  const TurtleId a = world.spawn(4, 5, 0), b = world.spawn(6, 5.1, 3);
  TurtleId c{};
  for (int i = 0; i < steps; ++i) {
    if (i % 40 == 0) world.drive(a, 1.5, 0, 0.5);
    if (i % 55 == 10) world.drive(b, 1, 0.2, -0.7);
    if (i == 100) c = world.spawn(5, 8, -1.5);
    if (i == 120) world.set_pen(c, {{10, 200, 30}, 9, false});
    if (i > 100 && i % 30 == 0) world.drive(c, 2, 0, 0.1);
    if (i == 300) world.kill(c);
    if (i == 320) world.teleport(b, 2, 2, 0.5);
    if (i == 330) world.clear();
    if (i == 340) world.set_background({200, 100, 50});
    ASSERT_TRUE(world.advance(from_seconds(0.016)).ok());
  }
}

TEST_F(TurtleWorldTest, ALogPlaysAgainToTheSameHash) {
  const TurtleWorldOptions options{.collisions = true};
  TurtleLog log;
  TurtleWorld first(options, &log), second(options);
  dance(first, 500);
  dance(second, 500);
  EXPECT_EQ(first.hash(), second.hash());
  const std::string bytes = log.take();
  TurtleReplay replay(options, bytes);
  ASSERT_TRUE(replay.advance_to(from_seconds(2)).ok());
  EXPECT_NE(replay.world().hash(), first.hash());
  ASSERT_TRUE(replay.advance_to(first.now()).ok());
  EXPECT_EQ(replay.world().hash(), first.hash());
}

TEST_F(TurtleWorldTest, ADamagedLogIsTold) {
  TurtleLog log;
  TurtleWorld world({}, &log);
  world.teleport(world.spawn(1, 1, 0), 2, 2, 0);
  const std::string bytes = log.take();
  TurtleReplay cut({}, std::string_view(bytes).substr(0, bytes.size() - 1));
  EXPECT_FALSE(cut.advance_to(from_seconds(1)).ok());
  TurtleLog strange;
  strange.record({0, TurtleVerb::kDrive, TurtleId{7}, {1, 0, 0}});
  const std::string other = strange.take();
  TurtleReplay unknown({}, other);
  EXPECT_FALSE(unknown.advance_to(from_seconds(1)).ok());
}

TEST_F(TurtleWorldTest, APictureShowsBackgroundInkAndTurtle) {
  TurtleWorld world({});
  const TurtleId id = world.spawn(2, 2, 0);
  world.teleport(id, 9, 2, 0);
  for (const int side : {500, 320}) {
    const Picture picture = draw_turtles(world, side);
    ASSERT_EQ(picture.width, side);
    ASSERT_EQ(picture.rgb.size(), 3u * static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
    const auto at = [&](double x, double y) {
      const auto px = static_cast<std::size_t>(x * 45 * side / 500),
                 py = static_cast<std::size_t>(side - 1 - y * 45 * side / 500);
      const std::uint8_t* p = &picture.rgb[3 * (py * static_cast<std::size_t>(side) + px)];
      return Colour{p[0], p[1], p[2]};
    };
    EXPECT_EQ(at(5, 9), (Colour{69, 86, 255}));
    EXPECT_GT(at(5, 2).r, 100) << "ink, or a mixture of it";
    EXPECT_EQ(at(9, 2), (Colour{60, 145, 70})) << "the shell's middle";
  }
}

}  // namespace
}  // namespace cxlab::sim
