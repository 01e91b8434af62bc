#include "sim/mujoco/posed_floor.h"

#include <algorithm>

namespace cxlab::sim {

Expected<std::unique_ptr<PosedFloor>> PosedFloor::create(const FloorPlan& plan, ModelOptions options) {
  options.pieces = kMostPieces;
  auto factory = build_factory(plan, options);
  if (!factory) return factory.error();
  factory->model->opt.enableflags &= ~mjENBL_SLEEP;  // MuJoCo would not look at bodies that sleep
  return std::unique_ptr<PosedFloor>(new PosedFloor(std::move(*factory), plan));
}

void PosedFloor::pose(const FloorPose& pose, double time) {
  gate_.show_time(time);
  for (std::size_t i = 0; i < pose.robots.size(); ++i) gate_.show(static_cast<RobotId>(i), pose.robots[i]);
  for (std::size_t i = 0; i < pose.lights.size(); ++i)
    if (const auto station = static_cast<StationId>(i); gate_.lights(station) != pose.lights[i])
      gate_.lights(station, pose.lights[i]);
  const std::size_t bodies = std::min(pose.pieces.size(), gate_.factory().pieces.size());
  for (std::size_t body = bodies; body < shown_.size(); ++body) gate_.park(body);
  shown_.resize(bodies);
  for (std::size_t body = 0; body < bodies; ++body) {
    const auto& [stack, underside] = pose.pieces[body];
    if (shown_[body] != stack) gate_.shape(body, shown_[body] = stack);
    gate_.show(body, underside);
  }
}

}  // namespace cxlab::sim
