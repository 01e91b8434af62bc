#pragma once
// What the files of TurtlesimNode share.

#include "scenarios/turtlesim/node.h"

namespace cxlab::turtlesim {

/// Message types and the fields that are written each step.
struct TurtlesimNode::Types {
  const bus::MessageType *pose = nullptr, *colour = nullptr, *twist = nullptr;
  const bus::ActionType* rotate = nullptr;
  const bus::Field *x = nullptr, *y = nullptr, *theta = nullptr, *linear_velocity = nullptr,
                   *angular_velocity = nullptr;
  const bus::Field *r = nullptr, *g = nullptr, *b = nullptr;
  const bus::Field *linear = nullptr, *angular = nullptr, *vector_x = nullptr, *vector_y = nullptr, *vector_z = nullptr;

  Status find(bus::Registry& registry);
};

/// A goal of rotate_absolute that is being carried out.
struct TurtlesimNode::Rotation {
  bus::GoalId goal{};
  double theta = 0, from = 0;  ///< rad
  bool arrived = false;
};

struct TurtlesimNode::Turtle {
  sim::TurtleId id{};
  std::string name;
  std::size_t story = 0;  // index
  bus::EndpointId pose{}, colour{}, rotate{};
  std::vector<bus::EndpointId> endpoints;  // all
  std::optional<Rotation> rotation;
  std::array<double, 3> commanded{};  // vx, vy, omega of the last message
};

inline bus::SharedMessage shared(bus::Message message) {
  return std::make_shared<const bus::Message>(std::move(message));
}

}  // namespace cxlab::turtlesim
