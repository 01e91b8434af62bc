#pragma once
// The drawing over a picture: a label with name and signal lights for each machine and robot, each piece as a column of
// its colours, and a legend above. First every part gets its place, then all are painted.

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <mujoco/mujoco.h>

#include "sim/legend.h"
#include "sim/mujoco/label_places.h"
#include "sim/mujoco/physics_gate.h"

namespace cxlab::sim {

/// Which of red, yellow and green shine at that time (s).
std::array<bool, 3> shining(const Lights& lights, double time);

/// Where points of the world are in a picture.
class Projection {
 public:
  Projection(const mjvGLCamera& camera, int width, int height);
  struct Pixel {
    double x = 0, y = 0;
  };
  /// Nothing for a point behind the camera.
  std::optional<Pixel> pixel(const Vec3& point) const;
  /// Around the points that are in front of the camera; empty (width 0) if none is.
  Box around(std::span<const Vec3> points) const;

 private:
  Vec3 from_, forward_, upward_, right_;
  double pixels_, bottom_, centre_, half_width_;  ///< px at distance 1; of the picture's lower edge and middle; px
};

/// The corners of an upright box that stands on the floor.
std::array<Vec3, 8> corners(const Pose2& pose, double half_depth, double half_width, double height);

struct Overlay {
  struct Label {
    std::string name;
    std::string text;  ///< the name, or a short form of it
    Legend::Colour colour;
    Box body;                                     ///< what the label names
    Box box;                                      ///< width 0: there was no place for it
    std::optional<std::array<bool, 3>> lit = {};  ///< of a machine: which of red, yellow and green
    std::array<Box, 3> lamps = {};                ///< within the box
    Leader leader() const { return leader_of(box, body); }
  };
  struct Column {
    Box box;
    std::vector<Legend::Colour> colours;  ///< from below
  };
  struct Line {
    Box box;
    Legend::Text text;
  };
  std::vector<Label> labels;
  std::vector<Column> columns;  ///< pieces, and the products of the legend
  struct Tick {
    Box box;
    Legend::Colour colour;
  };
  std::vector<Box> cards;
  std::vector<Tick> ticks;
  std::vector<Line> lines;  ///< of the legend
};

/// The strip that the legend takes at the upper edge, px; as much as fits of it is added to the overlay.
int place_legend(const Legend& legend, const FactoryModel& factory, const mjrContext& gl, const Box& picture,
                 Overlay& overlay);

/// The input of a drawing over a picture.
struct OverlayInput {
  const PhysicsGate& world;
  const FloorPlan& plan;
  const mjData& data;                ///< the world at that time
  std::span<const int> robot_geoms;  ///< by robot: one in its middle
};
/// Adds pieces in play, where they are. `free` is the picture without the legend.
void place_pieces(const OverlayInput& input, const Projection& projection, const mjrContext& gl, const Box& free,
                  Overlay& overlay);
/// Adds labels of machines and robots, clear of the pieces.
void place_names(const OverlayInput& input, const Projection& projection, const mjrContext& gl, const Box& free,
                 Overlay& overlay);

void paint(const Overlay& overlay, const mjrContext& gl);

}  // namespace cxlab::sim
