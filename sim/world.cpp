#include "sim/world.h"

#include <cmath>
#include <cstddef>
#include <numbers>

namespace cxlab::sim {
namespace {

struct SpotShape {
  const char* suffix;
  SpotKind kind;
  double x, y;   ///< of a piece that rests there, in the station's frame
  double side;   ///< +1 input side, -1 output side
  double reach;  ///< distance of the working pose from the face
};

constexpr SpotShape kInput{"-INPUT", SpotKind::kBeltInput, kMachine.belt_rest_x, kMachine.belt_y, 1, kStanding.belt};
constexpr SpotShape kOutput{"-OUTPUT", SpotKind::kBeltOutput, -kMachine.belt_rest_x, kMachine.belt_y,
                            -1,        kStanding.belt};
constexpr SpotShape kShelf[] = {
    {"-SHELF-LEFT", SpotKind::kShelf, kMachine.shelf_x, kMachine.shelf_y[0], 1, kStanding.shelf},
    {"-SHELF-MIDDLE", SpotKind::kShelf, kMachine.shelf_x, kMachine.shelf_y[1], 1, kStanding.shelf},
    {"-SHELF-RIGHT", SpotKind::kShelf, kMachine.shelf_x, kMachine.shelf_y[2], 1, kStanding.shelf},
};
constexpr SpotShape kSlide{"-SLIDE", SpotKind::kSlide, kMachine.slide_rest_x, kMachine.slide_y, 1, kStanding.belt};

Spot make_spot(const Station& station, StationId id, const SpotShape& shape) {
  const auto robot_at = [&](double distance) {
    const double yaw = shape.side > 0 ? std::numbers::pi : 0.0;
    return compose(station.pose_in_world, {shape.side * (kMachine.half_depth + distance), shape.y, yaw});
  };
  return {station.name + shape.suffix,
          id,
          shape.kind,
          {shape.x, shape.y, kMachine.working_height},
          robot_at(kStanding.align),
          robot_at(shape.reach)};
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
