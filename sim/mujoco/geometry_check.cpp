#include "sim/mujoco/geometry_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <string>

#include "sim/geometry.h"

namespace cxlab::sim {
namespace {

constexpr double kTolerance = 1e-6;
constexpr double kSlideTolerance = 1e-4;  ///< the slide's angle is rounded in its file
constexpr double kMissing[4] = {NAN, NAN, NAN, NAN};

/// A named element of the model with those numbers that it has.
struct Element {
  std::string label;  ///< "geom 'belt'"
  const mjtNum *size = kMissing, *place = kMissing, *quat = kMissing, *range = kMissing;
  double mass = NAN;
};

class GeometryCheck {
 public:
  GeometryCheck(const mjModel& model, const std::filesystem::path& models) : model_(model), models_(models) {}

  /// Copies of a part are alike: the first one stands for all.
  Status check(const FloorPlan& plan) {
    const auto first = [&](auto uses) {
      const auto found = std::ranges::find_if(plan.stations, uses);
      return found == plan.stations.end() ? std::string() : found->name;
    };
    check_machine(first([](const Station&) { return true; }));
    check_belt(first([](const Station& s) { return s.has_belt; }));
    check_shelf(first([](const Station& s) { return s.kind == "CS"; }));
    check_slide(first([](const Station& s) { return s.kind == "RS"; }));
    check_robot(plan.robots.empty() ? "" : plan.robots.front().name);
    check_piece("piece-0");
    if (difference_) return *difference_;
    return {};
  }

 private:
  void check_machine(const std::string& owner) {
    if (!begin("machine.xml", owner)) return;
    const Element body = find(mjOBJ_GEOM, "body");
    expect(body, "x", body.place[0], 0);
    expect(body, "y", body.place[1], 0);
    expect(body, "half size along x", body.size[0], kMachine.half_depth);
    expect(body, "half size along y", body.size[1], kMachine.half_width);
  }

  void check_belt(const std::string& owner) {
    if (!begin("belt.xml", owner)) return;
    const Element belt = find(mjOBJ_GEOM, "belt");
    expect(belt, "x", belt.place[0], 0);
    expect(belt, "y", belt.place[1], kMachine.belt_y);
    expect(belt, "z of the top", belt.place[2] + belt.size[2], kMachine.working_height);
    expect(belt, "half size along x", belt.size[0], kMachine.belt_half_length);
  }

  void check_shelf(const std::string& owner) {
    if (!begin("shelf.xml", owner)) return;
    const Element shelf = find(mjOBJ_GEOM, "shelf");
    expect(shelf, "z of the top", shelf.place[2] + shelf.size[2], kMachine.working_height);
    const char* marks[] = {"mark-left", "mark-middle", "mark-right"};
    for (std::size_t slot = 0; slot < kMachine.shelf_y.size(); ++slot) {
      const Element mark = find(mjOBJ_GEOM, marks[slot]);
      expect(mark, "x", mark.place[0], kMachine.shelf_x);
      expect(mark, "y", mark.place[1], kMachine.shelf_y[slot]);
    }
  }

  void check_slide(const std::string& owner) {
    if (!begin("slide.xml", owner)) return;
    const Element slide = find(mjOBJ_GEOM, "slide");
    expect(slide, "y", slide.place[1], kMachine.slide_y);
    mjtNum rotation[9];
    mju_quat2Mat(rotation, slide.quat);
    const double up_x = rotation[2], up_z = rotation[8];  // of the floor's normal
    const double inwards = kMachine.slide_mouth_x - slide.place[0];
    expect(slide, "z of the floor at the mouth", slide.place[2] + (slide.size[2] - up_x * inwards) / up_z,
           kMachine.working_height, kSlideTolerance);
  }

  void check_robot(const std::string& owner) {
    if (!begin("robot.xml", owner)) return;
    const Element hull = find(mjOBJ_GEOM, "hull");
    expect(hull, "radius", hull.size[0], kRobot.hull_radius);
    const Element arm = find(mjOBJ_BODY, "arm");
    expect(arm, "x", arm.place[0], kRobot.home_forward);
    expect(arm, "y", arm.place[1], 0);
    expect(arm, "z", arm.place[2], kRobot.home_height);
    expect_range("forward", 0, kRobot.forward_stroke);
    expect_range("left", -kRobot.left_stroke, kRobot.left_stroke);
    expect_range("up", 0, kRobot.up_stroke);
    for (const char* side : {"finger-left", "finger-right"}) {
      const Element finger = find(mjOBJ_BODY, side);
      expect(finger, "distance from the middle", std::abs(finger.place[1]), kRobot.fingers_open);
      expect_range(side, kRobot.fingers_open - kRobot.fingers_widest, kRobot.fingers_open);
    }
  }

  void check_piece(const std::string& owner) {
    begin("piece.xml", owner);
    const Element piece = find(mjOBJ_BODY, "piece");
    expect(piece, "mass", piece.mass, kPiece.base_mass);
    const Element base = find(mjOBJ_GEOM, "base");
    expect(base, "z", base.place[2], 0);
    expect(base, "radius", base.size[0], kPiece.radius);
    expect(base, "half height", base.size[1], kPiece.base_height / 2);
    double top = kPiece.base_height / 2;
    for (const char* name : {"ring-1", "ring-2", "ring-3"}) {
      const Element ring = find(mjOBJ_GEOM, name);
      expect(ring, "radius", ring.size[0], kPiece.radius);
      expect(ring, "half height", ring.size[1], kPiece.ring_height / 2);
      expect(ring, "z", ring.place[2], top + kPiece.ring_height / 2);
      top += kPiece.ring_height;
    }
    const Element cap = find(mjOBJ_GEOM, "cap");
    expect(cap, "radius", cap.size[0], kPiece.radius);
  }

  /// Turns to a part; false when the plan has none.
  bool begin(const char* file, const std::string& owner) {
    file_ = file;
    prefix_ = owner + "/";
    return !owner.empty();
  }

  Element find(mjtObj kind, const char* name) {
    Element element;
    element.label = std::string(mju_type2Str(kind)) + " '" + name + "'";
    const int id = mj_name2id(&model_, kind, (prefix_ + name).c_str());
    if (id < 0) {
      report(element.label + " is missing");
    } else if (kind == mjOBJ_GEOM) {
      element.size = model_.geom_size + 3 * id;
      element.place = model_.geom_pos + 3 * id;
      element.quat = model_.geom_quat + 4 * id;
    } else if (kind == mjOBJ_BODY) {
      element.place = model_.body_pos + 3 * id;
      element.mass = model_.body_mass[id];
    } else {
      element.range = model_.jnt_range + 2 * id;
    }
    return element;
  }

  void expect_range(const char* joint, double low, double high) {
    const Element element = find(mjOBJ_JOINT, joint);
    expect(element, "lower end of the range", element.range[0], low);
    expect(element, "upper end of the range", element.range[1], high);
  }

  void expect(const Element& element, const char* measure, double found, double expected,
              double tolerance = kTolerance) {
    if (std::abs(found - expected) <= tolerance) return;
    char numbers[80];
    std::snprintf(numbers, sizeof numbers, " is %.6g, expected %.6g", found, expected);
    report(element.label + ": " + measure + numbers + " as in sim/geometry.h");
  }

  void report(std::string message) {
    if (!difference_) difference_ = input_error(std::move(message), (models_ / file_).string());
  }

  const mjModel& model_;
  const std::filesystem::path& models_;
  std::string file_, prefix_;
  std::optional<Error> difference_;  ///< the first
};

}  // namespace

Status check_geometry(const mjModel& model, const FloorPlan& plan, const std::filesystem::path& models) {
  return GeometryCheck(model, models).check(plan);
}

}  // namespace cxlab::sim
