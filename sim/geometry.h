#pragma once
// The measures of floor, machines, pieces and robots: SI units, each once. The MJCF of models/ has them again; a
// physics world compares the two when it is made (sim/mujoco/geometry_check.h). docs/reference/models.md has drawings
// in words and reasons.

#include <array>

namespace cxlab::sim {

/// The field, in the world's frame: x from -half_length to half_length, y from 0 to width.
struct FieldGeometry {
  double half_length = 7;
  double width = 8;
};
inline constexpr FieldGeometry kField;

struct WallGeometry {
  double half_thickness = 0.025;
  double half_height = 0.25;
};
inline constexpr WallGeometry kWall;

/// A machine. Frame: x from output to input, y left of it, z up, origin on the floor under its centre.
struct MachineGeometry {
  double half_depth = 0.175;        ///< of the body along x; its faces at input and output
  double half_width = 0.35;         ///< of the body along y
  double working_height = 0.898;    ///< z of the belt, of the shelf, and of the slide's floor at its mouth
  double belt_y = -0.025;           ///< centre line of the belt
  double belt_half_length = 0.175;  ///< ends of the belt: a piece beyond them falls
  double belt_rest_x = 0.155;       ///< where a piece rests at the input; at the output it is -belt_rest_x
  double processing_x = 0;          ///< where the machine works on a piece
  double shelf_x = 0.105;
  std::array<double, 3> shelf_y{0.075, 0.175, 0.275};  ///< slots left, middle, right, seen from the input
  double slide_y = 0.25;
  double slide_mouth_x = 0.155;    ///< the slide's floor begins there and goes down inwards
  double slide_rest_x = 0.145;     ///< where a robot lets go of a piece
  double slide_counted_x = 0.100;  ///< a piece that is further in counts as a payment
};
inline constexpr MachineGeometry kMachine;

/// Where a robot stands to use a spot: distance of its centre from the machine's face, in line with the spot.
struct StandingGeometry {
  double align = 0.50;  ///< before and after
  double belt = 0.33;   ///< to reach belt or slide
  double shelf = 0.30;  ///< to reach the shelf
};
inline constexpr StandingGeometry kStanding;

/// How far a piece may be off a spot and still count as lying there.
struct SpotTolerance {
  double along_belt = 0.010;
  double across_belt = 0.015;
  double shelf = 0.040;   ///< in any direction
  double height = 0.030;  ///< above or below the working height
};
inline constexpr SpotTolerance kSpotTolerance;

/// A piece: cylinders of one radius, a base with up to three rings and a cap on top.
struct PieceGeometry {
  double radius = 0.020;
  double base_height = 0.025;
  double ring_height = 0.008;
  double cap_height = 0.004;
  double base_mass = 0.050;  ///< kg
  double part_mass = 0.005;  ///< kg, of a ring or a cap
};
inline constexpr PieceGeometry kPiece;

/// A robot. Frame: x ahead, y left, z up, origin on the floor under its centre. The gripper's frame is the underside of
/// a held piece.
struct RobotGeometry {
  double hull_radius = 0.225;
  double home_forward = 0.139;      ///< x of the gripper when all axes are 0
  double home_height = 0.888;       ///< z of the gripper when all axes are 0
  double forward_stroke = 0.24;     ///< axis from 0 to this
  double left_stroke = 0.0375;      ///< axis from minus this to this
  double up_stroke = 0.057;         ///< axis from 0 to this
  double carried_height = 0.945;    ///< z of the gripper on a drive: the up axis at its end
  double fingers_open = 0.035;      ///< distance of a fingertip from the middle at the zero of its joint
  double fingers_widest = 0.045;    ///< the same at the outer end of the joint's range
  double fingers_squeeze = -0.010;  ///< commanded to hold a piece: beyond the range, so that the motor presses
};
inline constexpr RobotGeometry kRobot;

}  // namespace cxlab::sim
