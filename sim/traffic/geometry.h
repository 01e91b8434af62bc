#pragma once
// Points and capsules on the floor, in metres.

#include <algorithm>
#include <cmath>

#include "sim/world.h"

namespace cxlab::sim {

struct Point2 {
  double x = 0, y = 0;
  friend bool operator==(const Point2&, const Point2&) = default;
};

inline Point2 point_of(const Pose2& pose) { return {pose.x, pose.y}; }
inline double distance_squared(Point2 a, Point2 b) { return (a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y); }
inline double distance(Point2 a, Point2 b) { return std::sqrt(distance_squared(a, b)); }
inline Point2 between(Point2 a, Point2 b, double part) { return {a.x + part * (b.x - a.x), a.y + part * (b.y - a.y)}; }

/// Where a robot's centre stands or sweeps: the way from a to b (one point when it stands).
struct Footprint {
  Point2 a, b;
};
inline Footprint footprint_at(const Pose2& pose) { return {point_of(pose), point_of(pose)}; }

inline double distance(Point2 p, const Footprint& f) {
  const double dx = f.b.x - f.a.x, dy = f.b.y - f.a.y;
  const double length2 = dx * dx + dy * dy;
  const double t = length2 > 0 ? std::clamp(((p.x - f.a.x) * dx + (p.y - f.a.y) * dy) / length2, 0.0, 1.0) : 0.0;
  return distance(p, Point2{f.a.x + t * dx, f.a.y + t * dy});
}

/// Exact unless the two cross, which robots' footprints do not.
inline double distance(const Footprint& f, const Footprint& g) {
  return std::min(std::min(distance(f.a, g), distance(f.b, g)), std::min(distance(g.a, f), distance(g.b, f)));
}

/// Robots' centres stay out of it.
struct Keepout {
  Footprint around;
  double radius = 0;
};

}  // namespace cxlab::sim
