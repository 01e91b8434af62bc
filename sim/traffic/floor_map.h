#pragma once
// The floor as a robot sees it: how far the nearest machine or wall is, ways around them and around other robots.

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "sim/world.h"

namespace cxlab::sim {

/// A segment and a radius: robots' centres stay out of it.
struct Keepout {
  Segment around;
  double radius = 0;
  bool covers(const Vec2& p) const { return distance(p, around) < radius; }
};

/// A grid of 0.1 m over the floor with the distance to the nearest machine, wall or border at each node.
/// Queries reuse memory: not for two threads.
class FloorMap {
 public:
  /// Distance that a robot's centre keeps from everything fixed: the hull and 35 mm for tracking.
  static constexpr double kClearance = 0.26;
  static_assert(kClearance >= kRobot.hull_radius + 0.035);

  explicit FloorMap(const FloorPlan& plan);

  /// From a point to the nearest fixed thing, in m; interpolated between nodes.
  double clearance(const Vec2& p) const;

  /// A smooth way between two points that keeps kClearance and stays out of the keepouts; nothing if there is none.
  /// A keepout in which the way starts shrinks until the start is outside.
  std::optional<std::vector<Vec2>> route(const Vec2& from, const Vec2& to, std::span<const Keepout> keepouts);

  /// The first node in order of driving distance from `from` that `accept` takes; nothing beyond `limit` m.
  std::optional<Vec2> nearest(const Vec2& from, std::span<const Keepout> keepouts, double limit,
                              const std::function<bool(const Vec2&)>& accept);

  /// Whether a robot that stands there leaves the others a way around it.
  bool passable_around(const Vec2& place) const;

 private:
  using Node = std::uint32_t;
  static constexpr Node kNone = ~Node{0};
  struct Open {
    double cost;
    Node node;
    bool operator>(const Open& other) const { return cost != other.cost ? cost > other.cost : node > other.node; }
  };

  Vec2 point(Node node) const;
  int column_of(double x) const;  ///< of the nearest node
  int row_of(double y) const;
  Node node_at(int column, int row) const { return static_cast<Node>(row * columns_ + column); }
  bool on_grid(int column, int row) const { return column >= 0 && row >= 0 && column < columns_ && row < rows_; }
  void block(std::span<const Keepout> keepouts);
  bool free(Node node) const {
    const auto at = static_cast<std::size_t>(node);
    return clearance_[at] >= kClearance && blocked_[at] != query_;
  }
  /// Nodes from which one drives straight to the point.
  std::vector<Node> nodes_around(const Vec2& p, std::span<const Keepout> keepouts) const;
  bool straight(const Vec2& a, const Vec2& b, double clearance, std::span<const Keepout> keepouts) const;
  /// Visits free nodes, cheapest first (A*), from `starts` on, until `found` returns true; that node, or kNone.
  /// `estimate` is a lower bound of the cost from a point to where the search should end.
  template <class Factor, class Estimate, class Found>
  Node explore(std::span<const Node> starts, const Vec2& from, Factor factor, Estimate estimate, Found found);
  Node search(std::span<const Node> starts, std::span<const Node> goals, const Vec2& from, const Vec2& to);
  void shorten(std::vector<Vec2>& way, std::span<const Keepout> keepouts) const;
  void round_off(std::vector<Vec2>& way, std::span<const Keepout> keepouts) const;

  Vec2 origin_;  ///< of the first node
  int columns_, rows_;
  std::vector<float> clearance_;
  std::vector<std::uint32_t> blocked_, reached_, closed_;  ///< equal to query_ when true
  std::vector<double> cost_;
  std::vector<Node> parent_;
  std::vector<Open> open_;
  std::uint32_t query_ = 0;
};

}  // namespace cxlab::sim
