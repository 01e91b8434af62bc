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

double step_length(int k) { return k < 4 ? kGrid : kGrid * 1.4142135623730951; }

/// Least cost between two points on the grid without obstacles.
double octile(const Vec2& a, const Vec2& b) {
  const Vec2 way = (a - b).cwiseAbs();
  return way.maxCoeff() + 0.4142135623730951 * way.minCoeff();
}

/// Shrinks the keepouts that contain the point until it is outside.
std::vector<Keepout> shrunk(std::span<const Keepout> keepouts, const Vec2& p) {
  std::vector<Keepout> outside(keepouts.begin(), keepouts.end());
  for (Keepout& k : outside) k.radius = std::min(k.radius, distance(p, k.around) - 0.002);
  return outside;
}

}  // namespace

FloorMap::FloorMap(const FloorPlan& plan)
    : origin_(plan.min_x, plan.min_y),
      columns_(static_cast<int>(std::lround((plan.max_x - plan.min_x) / kGrid)) + 1),
      rows_(static_cast<int>(std::lround((plan.max_y - plan.min_y) / kGrid)) + 1) {
  const auto n = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  clearance_.resize(n);
  blocked_.assign(n, 0);
  reached_.assign(n, 0);
  closed_.assign(n, 0);
  cost_.assign(n, 0);
  parent_.assign(n, kNone);
  for (Node node = 0; node < n; ++node) {
    const Vec2 p = point(node);
    const double to_border = std::min({p.x() - plan.min_x, plan.max_x - p.x(), p.y() - plan.min_y, plan.max_y - p.y()});
    clearance_[node] = static_cast<float>(std::min(to_border - kWall.half_thickness, plan.clearance(p)));
  }
}

Vec2 FloorMap::point(Node node) const {
  const int n = static_cast<int>(node);
  return origin_ + kGrid * Vec2(n % columns_, n / columns_);
}

int FloorMap::column_of(double x) const { return static_cast<int>(std::lround((x - origin_.x()) / kGrid)); }
int FloorMap::row_of(double y) const { return static_cast<int>(std::lround((y - origin_.y()) / kGrid)); }

double FloorMap::clearance(const Vec2& p) const {
  const Vec2 at = (p - origin_) / kGrid;
  if (at.x() < 0 || at.y() < 0 || at.x() > columns_ - 1 || at.y() > rows_ - 1) return 0;
  const int column = std::min(static_cast<int>(at.x()), columns_ - 2),
            row = std::min(static_cast<int>(at.y()), rows_ - 2);
  const double fx = at.x() - column, fy = at.y() - row;
  const float* below = &clearance_[node_at(column, row)];
  const float* above = &clearance_[node_at(column, row + 1)];
  const double low = below[0] + fx * (below[1] - below[0]);
  const double high = above[0] + fx * (above[1] - above[0]);
  return low + fy * (high - low);
}

/// Marks the nodes within the keepouts. Begins a query.
void FloorMap::block(std::span<const Keepout> keepouts) {
  ++query_;
  for (const Keepout& k : keepouts) {
    const Vec2 reach = Vec2::Constant(k.radius);
    const Vec2 low = k.around.a.cwiseMin(k.around.b) - reach - origin_;
    const Vec2 high = k.around.a.cwiseMax(k.around.b) + reach - origin_;
    const auto cell = [](double at, int count) {
      return std::clamp(static_cast<int>(std::floor(at / kGrid)), 0, count - 1);
    };
    for (int r = cell(low.y(), rows_); r <= cell(high.y(), rows_); ++r)
      for (int c = cell(low.x(), columns_); c <= cell(high.x(), columns_); ++c) {
        const Node node = node_at(c, r);
        if (k.covers(point(node))) blocked_[node] = query_;
      }
  }
}

bool FloorMap::straight(const Vec2& a, const Vec2& b, double needed, std::span<const Keepout> keepouts) const {
  const int steps = std::max(1, static_cast<int>(std::ceil(distance(a, b) / kStraightStep)));
  for (int i = 0; i <= steps; ++i) {
    const Vec2 p = between(a, b, static_cast<double>(i) / steps);
    if (clearance(p) < needed) return false;
    if (std::ranges::any_of(keepouts, [&](const Keepout& k) { return k.covers(p); })) return false;
  }
  return true;
}

std::vector<FloorMap::Node> FloorMap::nodes_around(const Vec2& p, std::span<const Keepout> keepouts) const {
  std::vector<Node> nodes;
  const int column = column_of(p.x()), row = row_of(p.y());
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

template <class Factor, class Estimate, class Found>
FloorMap::Node FloorMap::explore(std::span<const Node> starts, const Vec2& from, Factor factor, Estimate estimate,
                                 Found found) {
  open_.clear();
  const auto push = [&](Node node, double cost, Node parent) {
    if (reached_[node] == query_ && cost_[node] <= cost) return;
    reached_[node] = query_;
    cost_[node] = cost;
    parent_[node] = parent;
    open_.push_back({cost + estimate(point(node)), node});
    std::push_heap(open_.begin(), open_.end(), std::greater<>());
  };
  for (const Node node : starts) push(node, distance(from, point(node)), kNone);
  while (!open_.empty()) {
    std::pop_heap(open_.begin(), open_.end(), std::greater<>());
    const Node node = open_.back().node;
    open_.pop_back();
    if (closed_[node] == query_) continue;
    closed_[node] = query_;
    if (found(node)) return node;
    const int column = static_cast<int>(node) % columns_, row = static_cast<int>(node) / columns_;
    for (int k = 0; k < 8; ++k) {
      const int c = column + kNeighbours[k][0], r = row + kNeighbours[k][1];
      if (!on_grid(c, r)) continue;
      const Node next = node_at(c, r);
      if (free(next) && closed_[next] != query_) push(next, cost_[node] + step_length(k) * factor(next), node);
    }
  }
  return kNone;
}

FloorMap::Node FloorMap::search(std::span<const Node> starts, std::span<const Node> goals, const Vec2& from,
                                const Vec2& to) {
  if (goals.empty()) return kNone;
  const auto cramped = [this](Node node) {
    return 1 + kCrampedCost * std::max(0.0, (kRoomy - clearance_[node]) / (kRoomy - kClearance));
  };
  return explore(
      starts, from, cramped, [&](const Vec2& p) { return octile(p, to); },
      [&](Node node) { return std::ranges::find(goals, node) != goals.end(); });
}

std::optional<std::vector<Vec2>> FloorMap::route(const Vec2& from, const Vec2& to, std::span<const Keepout> keepouts) {
  const std::vector<Keepout> outside = shrunk(keepouts, from);
  if (std::ranges::any_of(outside, [&](const Keepout& k) { return k.covers(to); })) return std::nullopt;
  block(outside);
  std::vector<Vec2> way;
  if (distance(from, to) < 1.0 &&
      straight(from, to, std::min(kClearance, std::min(clearance(from), clearance(to)) - 1e-6), outside)) {
    way = {from, to};
  } else {
    const Node end = search(nodes_around(from, outside), nodes_around(to, outside), from, to);
    if (end == kNone) return std::nullopt;
    way.push_back(to);
    for (Node node = end; node != kNone; node = parent_[node]) way.push_back(point(node));
    way.push_back(from);
    std::ranges::reverse(way);
    shorten(way, outside);
  }
  round_off(way, outside);
  return way;
}

/// Replaces detours of the grid by straight lines, where these are no closer to fixed things.
void FloorMap::shorten(std::vector<Vec2>& way, std::span<const Keepout> keepouts) const {
  std::vector<Vec2> kept{way.front()};
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
void FloorMap::round_off(std::vector<Vec2>& way, std::span<const Keepout> keepouts) const {
  std::vector<Vec2> fine{way.front()};
  for (std::size_t i = 1; i < way.size(); ++i) {
    const int steps = std::max(1, static_cast<int>(std::ceil(distance(way[i - 1], way[i]) / kRoundStep)));
    for (int k = 1; k <= steps; ++k) fine.push_back(between(way[i - 1], way[i], static_cast<double>(k) / steps));
  }
  if (way.size() > 2) {
    std::vector<double> room(fine.size());
    for (std::size_t i = 0; i < fine.size(); ++i) room[i] = clearance(fine[i]);
    for (int pass = 0; pass < kRoundings; ++pass)
      for (std::size_t i = 1; i + 1 < fine.size(); ++i) {
        const Vec2 middle = between(fine[i - 1], fine[i + 1], 0.5);
        if ((middle - fine[i]).squaredNorm() < 1e-10) continue;
        const double there = clearance(middle);
        if (there < std::min(room[i], kRoomy - 0.02)) continue;
        if (std::ranges::any_of(keepouts, [&](const Keepout& k) { return k.covers(middle); })) continue;
        fine[i] = middle;
        room[i] = there;
      }
  }
  way = std::move(fine);
}

std::optional<Vec2> FloorMap::nearest(const Vec2& from, std::span<const Keepout> keepouts, double limit,
                                      const std::function<bool(const Vec2&)>& accept) {
  const std::vector<Keepout> outside = shrunk(keepouts, from);
  block(outside);
  const Node end = explore(
      nodes_around(from, outside), from, [](Node) { return 1.0; }, [](const Vec2&) { return 0.0; },
      [&](Node node) { return cost_[node] > limit || accept(point(node)); });
  if (end == kNone || cost_[end] > limit) return std::nullopt;
  return point(end);
}

bool FloorMap::passable_around(const Vec2& place) const {
  constexpr double kTaken = 0.5, kRing = 0.65, kWindow = 1.6;
  const int column = column_of(place.x()), row = row_of(place.y());
  constexpr int kHalf = static_cast<int>(kWindow / kGrid);
  constexpr int kSide = 2 * kHalf + 1;
  std::array<bool, static_cast<std::size_t>(kSide) * kSide> open{};
  const auto cell = [](int c, int r) { return static_cast<std::size_t>((r + kHalf) * kSide + c + kHalf); };
  std::vector<std::size_t> ring;
  for (int r = -kHalf; r <= kHalf; ++r)
    for (int c = -kHalf; c <= kHalf; ++c) {
      if (!on_grid(column + c, row + r)) continue;
      const Node node = node_at(column + c, row + r);
      const double d = distance(point(node), place);
      open[cell(c, r)] = clearance_[node] >= kClearance && d >= kTaken;
      if (open[cell(c, r)] && d < kRing) ring.push_back(cell(c, r));
    }
  if (ring.empty()) return false;
  std::vector<std::size_t> stack{ring.front()};
  open[ring.front()] = false;
  while (!stack.empty()) {
    const int r = static_cast<int>(stack.back()) / kSide - kHalf, c = static_cast<int>(stack.back()) % kSide - kHalf;
    stack.pop_back();
    for (const auto& [dc, dr] : kNeighbours) {
      if (std::abs(c + dc) > kHalf || std::abs(r + dr) > kHalf || !open[cell(c + dc, r + dr)]) continue;
      open[cell(c + dc, r + dr)] = false;
      stack.push_back(cell(c + dc, r + dr));
    }
  }
  return std::ranges::none_of(ring, [&](std::size_t at) { return open[at]; });
}

}  // namespace cxlab::sim
