#include "scenarios/turtlesim/stage.h"

#include <cstdio>

namespace cxlab::turtlesim {

namespace {

/// Puts world and node on the stage.
Expected<const TurtlesimNode*> set_up(const Config& config, SimTime step, sim::TurtleTap* tap, Stage& stage,
                                      bus::Bus& bus, RecordSink& sink, cx::LogSink* log) {
  auto world = std::make_unique<sim::TurtleWorld>(world_options(config, step), tap);
  auto node = TurtlesimNode::create(config, *world, bus, sink, log);
  if (!node) return node.error();
  const TurtlesimNode* made = node->get();
  stage.worlds.push_back(std::move(world));
  stage.servers.push_back(*std::move(node));
  return made;
}

}  // namespace

sim::TurtleWorldOptions world_options(const Config& config, SimTime step) {
  const auto byte = [](int value) { return static_cast<std::uint8_t>(value); };
  const sim::Colour background{byte(config.background_r), byte(config.background_g), byte(config.background_b)};
  return {.step = step, .start = config.start, .background = background, .collisions = config.collisions};
}

Expected<std::unique_ptr<TurtleStage>> TurtleStage::create(const Config& config, SimTime step, bus::Bus& bus,
                                                           RecordSink& sink, cx::LogSink* log) {
  auto stage = std::make_unique<TurtleStage>();
  auto node = set_up(config, step, &stage->writes_, *stage, bus, sink, log);
  if (!node) return node.error();
  stage->node_ = *node;
  return stage;
}

void TurtleStage::report(Result& result) const {
  for (const TurtleStory& story : node_->stories())
    result.turtles.push_back({story.name, story.alive, story.x, story.y, story.theta, story.driven_m, story.walls,
                              story.touches, story.teleports});
  result.steps = node_->world().steps();
  char hash[17];
  std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(node_->world().hash()));
  result.physics_hash = hash;
}

Status add_turtlesim(const Config& config, Stage& stage, bus::Bus& bus, RecordSink& sink, cx::LogSink* log) {
  auto node = set_up(config, sim::TurtleWorldOptions().step, nullptr, stage, bus, sink, log);
  return node ? Status() : Status(node.error());
}

}  // namespace cxlab::turtlesim
