#include "sim/world.h"

#include <cmath>
#include <cstddef>
#include <numbers>

namespace cxlab::sim {
namespace {

// docs/models.md: the machine and where a robot stands to reach into it.
constexpr double kFace = 0.175;  ///< half of the machine's depth
constexpr double kBeltRestX = 0.155;
constexpr double kBeltY = -0.025;
constexpr double kWorkingHeight = 0.898;  ///< belt, shelf and mouth of the slide
constexpr double kShelfX = 0.105;
constexpr double kSlideX = 0.145;
constexpr double kSlideY = 0.25;
constexpr double kAlignDistance = 0.50;  ///< robot's centre from the face
constexpr double kBeltReach = 0.33;
constexpr double kShelfReach = 0.30;

struct SpotShape {
  const char* suffix;
  SpotKind kind;
  Vec3 rest;
  double side;   ///< +1 input side, -1 output side
  double reach;  ///< distance of the working pose from the face
};

constexpr SpotShape kInput{"-INPUT", SpotKind::kBeltInput, {kBeltRestX, kBeltY, kWorkingHeight}, 1, kBeltReach};
constexpr SpotShape kOutput{"-OUTPUT", SpotKind::kBeltOutput, {-kBeltRestX, kBeltY, kWorkingHeight}, -1, kBeltReach};
constexpr SpotShape kShelf[] = {
    {"-SHELF-LEFT", SpotKind::kShelf, {kShelfX, 0.075, kWorkingHeight}, 1, kShelfReach},
    {"-SHELF-MIDDLE", SpotKind::kShelf, {kShelfX, 0.175, kWorkingHeight}, 1, kShelfReach},
    {"-SHELF-RIGHT", SpotKind::kShelf, {kShelfX, 0.275, kWorkingHeight}, 1, kShelfReach},
};
constexpr SpotShape kSlide{"-SLIDE", SpotKind::kSlide, {kSlideX, kSlideY, kWorkingHeight}, 1, kBeltReach};

Spot make_spot(const Station& station, StationId id, const SpotShape& shape) {
  const auto robot_at = [&](double distance) {
    const double yaw = shape.side > 0 ? std::numbers::pi : 0.0;
    return compose(station.pose_in_world, {shape.side * (kFace + distance), shape.rest.y, yaw});
  };
  return {station.name + shape.suffix, id, shape.kind, shape.rest, robot_at(kAlignDistance), robot_at(shape.reach)};
}

template <class Id, class Items>
std::optional<Id> find_by_name(const Items& items, std::string_view name) {
  for (std::size_t i = 0; i < items.size(); ++i)
    if (items[i].name == name) return static_cast<Id>(i);
  return std::nullopt;
}

}  // namespace

double wrap_angle(double a) {
  const double wrapped = std::remainder(a, 2 * std::numbers::pi);
  return wrapped <= -std::numbers::pi ? std::numbers::pi : wrapped;
}

Pose2 compose(const Pose2& frame, const Pose2& local) {
  const double c = std::cos(frame.yaw), s = std::sin(frame.yaw);
  return {frame.x + c * local.x - s * local.y, frame.y + s * local.x + c * local.y, wrap_angle(frame.yaw + local.yaw)};
}

Vec3 transform(const Pose2& frame, const Vec3& local) {
  const double c = std::cos(frame.yaw), s = std::sin(frame.yaw);
  return {frame.x + c * local.x - s * local.y, frame.y + s * local.x + c * local.y, local.z};
}

Vec3 inverse_transform(const Pose2& frame, const Vec3& point) {
  const double c = std::cos(frame.yaw), s = std::sin(frame.yaw);
  const double dx = point.x - frame.x, dy = point.y - frame.y;
  return {c * dx + s * dy, -s * dx + c * dy, point.z};
}

std::optional<SpotId> FloorPlan::find_spot(std::string_view name) const { return find_by_name<SpotId>(spots, name); }

std::optional<StationId> FloorPlan::find_station(std::string_view name) const {
  return find_by_name<StationId>(stations, name);
}

std::optional<RobotId> FloorPlan::find_robot(std::string_view name) const {
  return find_by_name<RobotId>(robots, name);
}

std::vector<Spot> spots_of(const Station& station, StationId id) {
  std::vector<Spot> spots;
  if (station.has_belt) {
    spots.push_back(make_spot(station, id, kInput));
    if (station.kind != "DS") spots.push_back(make_spot(station, id, kOutput));
  }
  if (station.kind == "CS")
    for (const SpotShape& slot : kShelf) spots.push_back(make_spot(station, id, slot));
  if (station.kind == "RS") spots.push_back(make_spot(station, id, kSlide));
  return spots;
}

std::string_view to_string(Holder holder) {
  switch (holder) {
    case Holder::kDispenser: return "dispenser";
    case Holder::kGripper: return "gripper";
    case Holder::kBelt: return "belt";
    case Holder::kSlot: return "slot";
    case Holder::kSlide: return "slide";
    case Holder::kFloor: return "floor";
    case Holder::kGate: return "gate";
  }
  return "unknown";
}

}  // namespace cxlab::sim
