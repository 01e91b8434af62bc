#include "scenarios/rcll/game/floor_plan.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace cxlab::rcll {
namespace {

constexpr double kGrid = 0.05;             ///< m
constexpr double kRobotWithMargin = 0.27;  ///< m, radius that robots of the league plan with

/// The free space around a disc, m. If it is negative, the disc would have to move at least so far.
double margin_of(const sim::FloorPlan& plan, const sim::Vec2& p, double radius) {
  return std::min({p.x() - radius - plan.min_x, plan.max_x - (p.x() + radius), p.y() - radius - plan.min_y,
                   plan.max_y - (p.y() + radius), plan.clearance(p) - radius});
}

bool disc_fits(const sim::FloorPlan& plan, const sim::Vec2& p, double radius) {
  return margin_of(plan, p, radius) >= 0;
}

/// Which points of a grid over the field a disc can get to.
class ReachGrid {
 public:
  ReachGrid(const sim::FloorPlan& plan, double radius)
      : plan_(plan),
        columns_(static_cast<int>(std::lround((plan.max_x - plan.min_x) / kGrid)) + 1),
        rows_(static_cast<int>(std::lround((plan.max_y - plan.min_y) / kGrid)) + 1),
        free_(static_cast<std::size_t>(columns_ * rows_)),
        reached_(free_.size()) {
    for (int r = 0; r < rows_; ++r)
      for (int c = 0; c < columns_;) {
        // The margin changes by no more than the way does: as far as it reaches, all is as here.
        const double margin = margin_of(plan, point(c, r), radius);
        const int alike = 1 + static_cast<int>(std::max(0.0, std::abs(margin) - 1e-6) / kGrid);
        for (const int end = std::min(c + alike, columns_); c < end; ++c) free_[index(c, r)] = margin >= 0;
      }
  }

  void flood_from(const sim::Vec2& p) {
    std::vector<std::pair<int, int>> open{cell_of(p)};
    while (!open.empty()) {
      const auto [c, r] = open.back();
      open.pop_back();
      if (c < 0 || r < 0 || c >= columns_ || r >= rows_ || !free_[index(c, r)] || reached_[index(c, r)]) continue;
      reached_[index(c, r)] = true;
      for (const auto& [dc, dr] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) open.emplace_back(c + dc, r + dr);
    }
  }

  /// A reached point within a cell's diagonal.
  bool reached_near(const sim::Vec2& p) const {
    const auto [c0, r0] = cell_of(p);
    for (int c = std::max(c0 - 1, 0); c <= std::min(c0 + 1, columns_ - 1); ++c)
      for (int r = std::max(r0 - 1, 0); r <= std::min(r0 + 1, rows_ - 1); ++r)
        if (reached_[index(c, r)]) return true;
    return false;
  }

 private:
  std::size_t index(int column, int row) const { return static_cast<std::size_t>(row * columns_ + column); }
  sim::Vec2 point(int column, int row) const { return {plan_.min_x + column * kGrid, plan_.min_y + row * kGrid}; }
  std::pair<int, int> cell_of(const sim::Vec2& p) const {
    return {static_cast<int>(std::lround((p.x() - plan_.min_x) / kGrid)),
            static_cast<int>(std::lround((p.y() - plan_.min_y) / kGrid))};
  }

  const sim::FloorPlan& plan_;
  int columns_, rows_;
  std::vector<bool> free_, reached_;
};

sim::Pose2 start_pose(Team team, int index) {
  const double x = 4.5 + index;
  return {team == Team::kCyan ? x : -x, 0.5, std::numbers::pi / 2};
}

}  // namespace

sim::FloorPlan make_floor_plan(const Layout& layout, const std::vector<Team>& teams, int robots) {
  sim::FloorPlan plan;
  for (const double s : {1.0, -1.0}) {
    const std::vector<std::vector<sim::Vec2>> lines{{{4 * s, 1}, {4 * s, 0}, {7 * s, 0}},
                                                    {{5 * s, 1}, {7 * s, 1}, {7 * s, 2}},
                                                    {{7 * s, 6.5}, {7 * s, 8}, {0, 8}},
                                                    {{2 * s, 0}, {0, 0}}};
    for (const auto& line : lines)
      for (std::size_t i = 1; i < line.size(); ++i) plan.walls.push_back({line[i - 1], line[i]});
  }
  for (const Placement& placement : layout) {
    const auto id = static_cast<sim::StationId>(plan.stations.size());
    plan.stations.push_back({placement.name(), std::string(kind_of(placement.machine)),
                             centre_of(placement.zone, placement.rotation), true});
    for (sim::Spot& spot : sim::spots_of(plan.stations.back(), id)) plan.spots.push_back(std::move(spot));
  }
  for (const Team team : teams)
    for (int i = 0; i < robots; ++i)
      plan.robots.push_back({"robot" + std::to_string(plan.robots.size() + 1), start_pose(team, i)});
  return plan;
}

std::vector<sim::SpotId> unreachable_spots(const sim::FloorPlan& plan, double radius) {
  ReachGrid grid(plan, radius);
  for (const sim::RobotStart& robot : plan.robots) grid.flood_from(robot.pose_in_world.position());
  std::vector<sim::SpotId> unreachable;
  for (std::size_t i = 0; i < plan.spots.size(); ++i) {
    const auto [align, work] = plan.spots[i].footprint();
    if (!grid.reached_near(align) || !disc_fits(plan, align, radius) || !disc_fits(plan, work, radius))
      unreachable.push_back(static_cast<sim::SpotId>(i));
  }
  return unreachable;
}

Layout draw_reachable_layout(RandomStream& random, const WorldConfig& config) {
  // At (4, 2) the end of the insertion area's wall can stand in the way of a shelf's or slide's last slot: 4 % of
  // draws.
  const bool as_refbox = choices_of(*named<Rules>(config.rules)).shelf_faces_wall;
  Layout layout = draw_layout(random, as_refbox);
  while (!as_refbox && config.robots > 0 && !unreachable_spots(floor_plan_of(config, layout), kRobotWithMargin).empty())
    layout = draw_layout(random, as_refbox);
  return layout;
}

sim::FloorPlan floor_plan_of(const WorldConfig& config, const Layout& layout) {
  return make_floor_plan(layout, teams_of(config), config.robots);
}

}  // namespace cxlab::rcll
