#include "sim/traffic/floor_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace cxlab::sim {
namespace {

constexpr double kGrid = 0.1;             ///< m between nodes
constexpr double kRoomy = 0.34;           ///< m: closer to fixed things than this costs extra
constexpr double kCrampedCost = 1.5;      ///< times the length, at kClearance
constexpr double kJoin = 0.35;            ///< m: how far a pose may lie from the nodes it joins
constexpr double kJoinClearance = 0.235;  ///< beside a machine at work a robot is closer than on its ways
constexpr double kStraightStep = 0.05;
constexpr double kRoundStep = 0.1;
constexpr int kRoundings = 50;
constexpr int kNeighbours[8][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 1}, {-1, 1}, {-1, -1}, {1, -1}};

double to_box(Point2 p, const Pose2& centre) {
  const Vec3 local = inverse_transform(centre, {p.x, p.y, 0});
  const double dx = std::max(0.0, std::abs(local.x) - kMachine.half_depth);
  const double dy = std::max(0.0, std::abs(local.y) - kMachine.half_width);
  return std::hypot(dx, dy);
}

double step_length(int k) { return k < 4 ? kGrid : kGrid * 1.4142135623730951; }

/// Least cost between two points on the grid without obstacles.
double octile(Point2 a, Point2 b) {
  const double dx = std::abs(a.x - b.x), dy = std::abs(a.y - b.y);
  return std::max(dx, dy) + 0.4142135623730951 * std::min(dx, dy);
}

}  // namespace

FloorMap::FloorMap(const FloorPlan& plan)
    : min_x_(plan.min_x),
      min_y_(plan.min_y),
      columns_(static_cast<int>(std::lround((plan.max_x - plan.min_x) / kGrid)) + 1),
      rows_(static_cast<int>(std::lround((plan.max_y - plan.min_y) / kGrid)) + 1) {
  const auto n = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  clearance_.resize(n);
  blocked_.assign(n, 0);
  reached_.assign(n, 0);
  closed_.assign(n, 0);
  cost_.assign(n, 0);
  parent_.assign(n, -1);
  for (std::size_t i = 0; i < n; ++i) {
    const Point2 p = point(static_cast<Node>(i));
    double nearest =
        std::min(std::min(p.x - plan.min_x, plan.max_x - p.x), std::min(p.y - plan.min_y, plan.max_y - p.y));
    nearest -= kWall.half_thickness;
    for (const Station& station : plan.stations) nearest = std::min(nearest, to_box(p, station.pose_in_world));
    for (const WallSegment& wall : plan.walls)
      nearest =
          std::min(nearest, distance(p, Footprint{{wall.x0, wall.y0}, {wall.x1, wall.y1}}) - kWall.half_thickness);
    clearance_[i] = static_cast<float>(nearest);
  }
}

Point2 FloorMap::point(Node node) const {
  return {min_x_ + kGrid * (node % columns_), min_y_ + kGrid * (node / columns_)};
}

double FloorMap::clearance(Point2 p) const {
  const double gx = (p.x - min_x_) / kGrid, gy = (p.y - min_y_) / kGrid;
  if (gx < 0 || gy < 0 || gx > columns_ - 1 || gy > rows_ - 1) return 0;
  const int cx = std::min(static_cast<int>(gx), columns_ - 2), cy = std::min(static_cast<int>(gy), rows_ - 2);
  const double fx = gx - cx, fy = gy - cy;
  const float* row = &clearance_[static_cast<std::size_t>(node_at(cx, cy))];
  const double low = row[0] + fx * (row[1] - row[0]);
  const double high = row[columns_] + fx * (row[columns_ + 1] - row[columns_]);
  return low + fy * (high - low);
}

void FloorMap::block(std::span<const Keepout> keepouts) {
  ++query_;
  for (const Keepout& k : keepouts) {
    const Footprint& f = k.around;
    const auto column = [&](double x) {
      return std::clamp(static_cast<int>(std::floor((x - min_x_) / kGrid)), 0, columns_ - 1);
    };
    const auto row = [&](double y) {
      return std::clamp(static_cast<int>(std::floor((y - min_y_) / kGrid)), 0, rows_ - 1);
    };
    const int c0 = column(std::min(f.a.x, f.b.x) - k.radius), c1 = column(std::max(f.a.x, f.b.x) + k.radius);
    const int r0 = row(std::min(f.a.y, f.b.y) - k.radius), r1 = row(std::max(f.a.y, f.b.y) + k.radius);
    for (int r = r0; r <= r1; ++r)
      for (int c = c0; c <= c1; ++c) {
        const Node node = node_at(c, r);
        if (distance(point(node), f) < k.radius) blocked_[node] = query_;
      }
  }
}

bool FloorMap::straight(Point2 a, Point2 b, double clearance_needed, std::span<const Keepout> keepouts) const {
  const int steps = std::max(1, static_cast<int>(std::ceil(distance(a, b) / kStraightStep)));
  for (int i = 0; i <= steps; ++i) {
    const Point2 p = between(a, b, static_cast<double>(i) / steps);
    if (clearance(p) < clearance_needed) return false;
    for (const Keepout& k : keepouts)
      if (distance(p, k.around) < k.radius) return false;
  }
  return true;
}

std::vector<FloorMap::Node> FloorMap::nodes_around(Point2 p, std::span<const Keepout> keepouts) const {
  std::vector<Node> nodes;
  const int column = static_cast<int>(std::lround((p.x - min_x_) / kGrid));
  const int row = static_cast<int>(std::lround((p.y - min_y_) / kGrid));
  const double needed = std::min(kJoinClearance, clearance(p) - 1e-6);
  constexpr int kReach = static_cast<int>(kJoin / kGrid);
  for (int ring = 1; ring <= kReach && nodes.empty(); ++ring)
    for (int r = std::max(0, row - ring); r <= std::min(rows_ - 1, row + ring); ++r)
      for (int c = std::max(0, column - ring); c <= std::min(columns_ - 1, column + ring); ++c) {
        const Node node = node_at(c, r);
        if (free(node) && straight(p, point(node), needed, keepouts)) nodes.push_back(node);
      }
  return nodes;
}

bool FloorMap::search(std::span<const Node> starts, std::span<const Node> goals, Point2 from, Point2 to) {
  open_.clear();
  const auto push = [&](Node node, double cost, Node parent) {
    if (reached_[node] == query_ && cost_[node] <= cost) return;
    reached_[node] = query_;
    cost_[node] = cost;
    parent_[node] = parent;
    open_.push_back({cost + octile(point(node), to), node});
    std::push_heap(open_.begin(), open_.end(), std::greater<>());
  };
  for (const Node node : starts) push(node, distance(from, point(node)), -1);
  while (!open_.empty()) {
    std::pop_heap(open_.begin(), open_.end(), std::greater<>());
    const Node node = open_.back().node;
    open_.pop_back();
    if (closed_[node] == query_) continue;
    closed_[node] = query_;
    if (std::ranges::find(goals, node) != goals.end()) {
      open_.assign(1, {cost_[node], node});
      return true;
    }
    const int column = node % columns_, row = node / columns_;
    for (int k = 0; k < 8; ++k) {
      const int c = column + kNeighbours[k][0], r = row + kNeighbours[k][1];
      if (c < 0 || r < 0 || c >= columns_ || r >= rows_) continue;
      const Node next = node_at(c, r);
      if (!free(next) || closed_[next] == query_) continue;
      const double cramped = std::max(0.0, (kRoomy - clearance_[next]) / (kRoomy - kClearance));
      push(next, cost_[node] + step_length(k) * (1 + kCrampedCost * cramped), node);
    }
  }
  return false;
}

std::optional<std::vector<Point2>> FloorMap::route(Point2 from, Point2 to, std::span<const Keepout> keepouts) {
  std::vector<Keepout> outside(keepouts.begin(), keepouts.end());
  for (Keepout& k : outside) k.radius = std::min(k.radius, distance(from, k.around) - 0.002);
  for (const Keepout& k : outside)
    if (distance(to, k.around) < k.radius) return std::nullopt;
  block(outside);
  std::vector<Point2> way;
  if (distance(from, to) < 1.0 &&
      straight(from, to, std::min(kClearance, std::min(clearance(from), clearance(to)) - 1e-6), outside)) {
    way = {from, to};
  } else {
    const std::vector<Node> starts = nodes_around(from, outside), goals = nodes_around(to, outside);
    if (starts.empty() || goals.empty() || !search(starts, goals, from, to)) return std::nullopt;
    way.push_back(to);
    for (Node node = open_.front().node; node >= 0; node = parent_[node]) way.push_back(point(node));
    way.push_back(from);
    std::ranges::reverse(way);
    shorten(way, outside);
  }
  round_off(way, outside);
  return way;
}

/// Replaces detours of the grid by straight lines, where these are no closer to fixed things.
void FloorMap::shorten(std::vector<Point2>& way, std::span<const Keepout> keepouts) const {
  std::vector<Point2> kept{way.front()};
  std::size_t i = 0;
  while (i + 1 < way.size()) {
    std::size_t best = i + 1;
    double narrow = std::min(clearance(way[i]), clearance(way[i + 1]));
    std::size_t failures = 0;
    for (std::size_t j = i + 2; j < way.size() && failures < 6; ++j) {
      narrow = std::min(narrow, clearance(way[j]));
      const double needed = std::clamp(narrow - 1e-6, kJoinClearance, kRoomy - 0.02);
      if (straight(way[i], way[j], needed, keepouts)) {
        best = j;
        failures = 0;
      } else {
        ++failures;
      }
    }
    kept.push_back(way[best]);
    i = best;
  }
  way = std::move(kept);
}

/// Pulls the corners inwards like a rubber band, as far as the clearance allows: wide curves can be driven fast.
void FloorMap::round_off(std::vector<Point2>& way, std::span<const Keepout> keepouts) const {
  std::vector<Point2> fine{way.front()};
  for (std::size_t i = 1; i < way.size(); ++i) {
    const int steps = std::max(1, static_cast<int>(std::ceil(distance(way[i - 1], way[i]) / kRoundStep)));
    for (int k = 1; k <= steps; ++k) fine.push_back(between(way[i - 1], way[i], static_cast<double>(k) / steps));
  }
  if (way.size() > 2) {
    std::vector<double> room(fine.size());
    for (std::size_t i = 0; i < fine.size(); ++i) room[i] = clearance(fine[i]);
    for (int pass = 0; pass < kRoundings; ++pass)
      for (std::size_t i = 1; i + 1 < fine.size(); ++i) {
        const Point2 middle = between(fine[i - 1], fine[i + 1], 0.5);
        if (distance_squared(middle, fine[i]) < 1e-10) continue;
        const double there = clearance(middle);
        if (there < std::min(room[i], kRoomy - 0.02)) continue;
        if (std::ranges::any_of(keepouts, [&](const Keepout& k) { return distance(middle, k.around) < k.radius; }))
          continue;
        fine[i] = middle;
        room[i] = there;
      }
  }
  way = std::move(fine);
}

std::optional<Point2> FloorMap::nearest(Point2 from, std::span<const Keepout> keepouts, double limit,
                                        const std::function<bool(Point2)>& accept) {
  std::vector<Keepout> outside(keepouts.begin(), keepouts.end());
  for (Keepout& k : outside) k.radius = std::min(k.radius, distance(from, k.around) - 0.002);
  block(outside);
  const std::uint32_t query = query_;
  std::vector<Open> open;
  const auto push = [&](Node node, double cost) {
    if (reached_[node] == query && cost_[node] <= cost) return;
    reached_[node] = query;
    cost_[node] = cost;
    open.push_back({cost, node});
    std::push_heap(open.begin(), open.end(), std::greater<>());
  };
  for (const Node node : nodes_around(from, outside)) push(node, distance(from, point(node)));
  while (!open.empty()) {
    std::pop_heap(open.begin(), open.end(), std::greater<>());
    const auto [cost, node] = open.back();
    open.pop_back();
    if (closed_[node] == query) continue;
    if (cost > limit) return std::nullopt;
    closed_[node] = query;
    if (accept(point(node))) return point(node);
    const int column = node % columns_, row = node / columns_;
    for (int k = 0; k < 8; ++k) {
      const int c = column + kNeighbours[k][0], r = row + kNeighbours[k][1];
      if (c < 0 || r < 0 || c >= columns_ || r >= rows_) continue;
      const Node next = node_at(c, r);
      if (free(next) && closed_[next] != query) push(next, cost + step_length(k));
    }
  }
  return std::nullopt;
}

bool FloorMap::passable_around(Point2 place) {
  constexpr double kTaken = 0.5, kRing = 0.65, kWindow = 1.6;
  const int column = static_cast<int>(std::lround((place.x - min_x_) / kGrid));
  const int row = static_cast<int>(std::lround((place.y - min_y_) / kGrid));
  constexpr int kHalf = static_cast<int>(kWindow / kGrid);
  constexpr int kSide = 2 * kHalf + 1;
  std::array<bool, static_cast<std::size_t>(kSide) * kSide> open{};
  std::vector<int> ring, stack;
  for (int r = -kHalf; r <= kHalf; ++r)
    for (int c = -kHalf; c <= kHalf; ++c) {
      if (column + c < 0 || row + r < 0 || column + c >= columns_ || row + r >= rows_) continue;
      const Node node = node_at(column + c, row + r);
      const double d = distance(point(node), place);
      const int cell = (r + kHalf) * kSide + c + kHalf;
      open[static_cast<std::size_t>(cell)] = clearance_[node] >= kClearance && d >= kTaken;
      if (open[static_cast<std::size_t>(cell)] && d < kRing) ring.push_back(cell);
    }
  if (ring.empty()) return false;
  stack.push_back(ring.front());
  open[static_cast<std::size_t>(ring.front())] = false;
  while (!stack.empty()) {
    const int cell = stack.back();
    stack.pop_back();
    const int r = cell / kSide, c = cell % kSide;
    for (int k = 0; k < 8; ++k) {
      const int nr = r + kNeighbours[k][1], nc = c + kNeighbours[k][0];
      if (nr < 0 || nc < 0 || nr >= kSide || nc >= kSide) continue;
      const auto next = static_cast<std::size_t>(nr * kSide + nc);
      if (!open[next]) continue;
      open[next] = false;
      stack.push_back(static_cast<int>(next));
    }
  }
  return std::ranges::none_of(ring, [&](int cell) { return open[static_cast<std::size_t>(cell)]; });
}

}  // namespace cxlab::sim
