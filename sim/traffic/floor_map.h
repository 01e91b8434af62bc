#pragma once
// The floor as a robot sees it: how far the next machine or wall is, ways around them and around other robots.

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "sim/traffic/geometry.h"

namespace cxlab::sim {

/// A grid of 0.1 m over the floor with the distance to the nearest machine, wall or border at each node.
/// Queries reuse memory: not for two threads.
class FloorMap {
 public:
  /// Distance that a robot's centre keeps from everything fixed: its radius of 0.225 m and 35 mm for tracking.
  static constexpr double kClearance = 0.26;

  explicit FloorMap(const FloorPlan& plan);

  /// From a point to the nearest fixed thing, in m; interpolated between nodes.
  double clearance(Point2 p) const;

  /// A smooth way between two points that keeps kClearance and stays out of the keepouts; nothing if there is none.
  /// A keepout in which the way starts shrinks until the start is outside.
  std::optional<std::vector<Point2>> route(Point2 from, Point2 to, std::span<const Keepout> keepouts);

  /// The first node in order of driving distance from `from` that `accept` takes; nothing beyond `limit` m.
  std::optional<Point2> nearest(Point2 from, std::span<const Keepout> keepouts, double limit,
                                const std::function<bool(Point2)>& accept);

  /// Whether a robot that stands there leaves the others a way around it.
  bool passable_around(Point2 place);

 private:
  using Node = std::int32_t;
  struct Open {
    double cost;
    Node node;
    bool operator>(const Open& other) const { return cost != other.cost ? cost > other.cost : node > other.node; }
  };

  Point2 point(Node node) const;
  Node node_at(int column, int row) const { return row * columns_ + column; }
  void block(std::span<const Keepout> keepouts);
  bool free(Node node) const {
    const auto at = static_cast<std::size_t>(node);
    return clearance_[at] >= kClearance && blocked_[at] != query_;
  }
  /// Nodes from which one drives straight to the point.
  std::vector<Node> nodes_around(Point2 p, std::span<const Keepout> keepouts) const;
  bool straight(Point2 a, Point2 b, double clearance, std::span<const Keepout> keepouts) const;
  bool search(std::span<const Node> starts, std::span<const Node> goals, Point2 from, Point2 to);
  void shorten(std::vector<Point2>& way, std::span<const Keepout> keepouts) const;
  void round_off(std::vector<Point2>& way, std::span<const Keepout> keepouts) const;

  double min_x_, min_y_;
  int columns_, rows_;
  std::vector<float> clearance_;
  std::vector<std::uint32_t> blocked_, reached_, closed_;  ///< equal to query_ when true
  std::vector<double> cost_;
  std::vector<Node> parent_;
  std::vector<Open> open_;
  std::uint32_t query_ = 0;
};

}  // namespace cxlab::sim
