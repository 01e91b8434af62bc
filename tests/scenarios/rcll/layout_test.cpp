#include "scenarios/rcll/rules/layout.h"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <map>
#include <set>

#include "scenarios/rcll/game/floor_plan.h"
#include "scenarios/rcll/game/game.h"
#include "tests/support/statistics.h"

namespace cxlab::rcll {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using Cells = std::multiset<std::pair<int, int>>;

constexpr int kLayouts = 2000;
constexpr double kRobotRadius = 0.225, kPlanningRadius = 0.27;

/// Cells as whole numbers over the field: column -7..-1 and 1..7.
std::pair<int, int> cell_of(const Zone& zone) {
  return {zone.half == Team::kCyan ? zone.column : -zone.column, zone.row};
}

/// The cell that lies `angle` degrees from a zone.
std::pair<int, int> neighbour(const Zone& zone, int dx, int dy) {
  int x = zone.half == Team::kCyan ? zone.column - 1 : -zone.column;  // -7..6, without a gap at the centre line
  x += dx;
  return {x >= 0 ? x + 1 : x, zone.row + dy};
}

Cells blocked_by(const Placement& p) {
  Cells cells{cell_of(p.zone)};
  std::vector<int> sides{p.rotation};
  if (p.machine != "DS") sides.push_back((p.rotation + 180) % 360);
  for (const int side : sides) {
    const double a = side * 3.14159265358979 / 180;
    const int dx = static_cast<int>(std::lround(std::cos(a) * 1.2)),
              dy = static_cast<int>(std::lround(std::sin(a) * 1.2));
    cells.insert(neighbour(p.zone, dx, dy));
    if (dx != 0 && dy != 0) {
      cells.insert(neighbour(p.zone, dx, 0));
      cells.insert(neighbour(p.zone, 0, dy));
    }
  }
  return cells;
}

sim::FloorPlan drawn_plan(const WorldConfig& config, std::uint64_t seed) {
  return floor_plan_of(config, game_of(config, seed)->layout);
}

bool is_insertion(std::pair<int, int> cell) { return cell.second == 1 && std::abs(cell.first) >= 5; }

std::string show(const Layout& layout) {
  std::string text;
  for (const Placement& p : layout)
    text += p.name() + " " + to_string(p.zone) + " " + std::to_string(p.rotation) + "\n";
  return text;
}

/// Layouts of seeds 0, 1, ..., drawn once.
const std::vector<Layout>& drawn_layouts(bool shelf_faces_wall) {
  static std::array<std::vector<Layout>, 2> drawn;
  std::vector<Layout>& layouts = drawn[shelf_faces_wall ? 1 : 0];
  for (std::uint64_t seed = layouts.size(); seed < kLayouts; ++seed) {
    RandomStream random(seed, "layout");
    layouts.push_back(draw_layout(random, shelf_faces_wall));
  }
  return layouts;
}

/// Calls `check` for each of them, until one fails.
template <class Check>
void for_layouts(Check check, bool shelf_faces_wall = false) {
  const std::vector<Layout>& layouts = drawn_layouts(shelf_faces_wall);
  for (std::size_t seed = 0; seed < layouts.size(); ++seed) {
    check(layouts[seed]);
    if (testing::Test::HasFailure()) {
      ADD_FAILURE() << "seed " << seed << "\n" << show(layouts[seed]);
      return;
    }
  }
}

TEST(DrawnLayout, AllowsEachMachineThePosesThatTheLeagueCounts) {
  for (const bool faces_wall : {false, true}) {
    EXPECT_EQ(count_poses("BS", faces_wall), 258u);
    EXPECT_EQ(count_poses("SS", faces_wall), 258u);
    EXPECT_EQ(count_poses("CS1", faces_wall), 246u);
    EXPECT_EQ(count_poses("RS2", faces_wall), 246u);
    EXPECT_EQ(count_poses("DS", faces_wall), 276u);
  }
}

TEST(DrawnLayout, Rule1KeepsInsertionAreaAndItsExitFree) {
  for_layouts([](const Layout& layout) {
    for (const Placement& p : layout) {
      EXPECT_FALSE(is_insertion(cell_of(p.zone)));
      for (const auto& [column, row] : {std::pair{5, 2}, {1, 1}, {1, 8}, {7, 8}, {7, 2}, {4, 1}})
        EXPECT_FALSE(p.zone.column == column && p.zone.row == row) << p.name();
    }
  });
}

TEST(DrawnLayout, Rules2And3BlockEachCellOnceAndOnlyOnItsOwnHalf) {
  for_layouts([](const Layout& layout) {
    Cells all;
    for (const Placement& p : layout)
      for (const auto& cell : blocked_by(p)) {
        EXPECT_EQ(cell.first > 0, p.zone.half == Team::kCyan) << p.name() << " reaches over the centre line";
        EXPECT_TRUE(std::abs(cell.first) <= 7 && cell.second >= 1 && cell.second <= 8) << p.name();
        EXPECT_FALSE(is_insertion(cell)) << p.name();
        all.insert(cell);
        EXPECT_EQ(all.count(cell), 1u) << p.name() << " at " << cell.first << " " << cell.second;
      }
  });
}

/// Whether the machine's local +y side, which carries shelf or slide, looks into that direction.
bool shelf_looks(const Placement& p, int degrees) { return (p.rotation + 90) % 360 == degrees; }

TEST(DrawnLayout, Rule4TurnsShelfAndSlideAwayFromTheWalls) {
  for_layouts([](const Layout& layout) {
    for (const Placement& p : layout) {
      if (kind_of(p.machine) != "CS" && kind_of(p.machine) != "RS") continue;
      const bool cyan = p.zone.half == Team::kCyan;
      if (p.zone.row == 1) {
        EXPECT_TRUE(shelf_looks(p, 90)) << p.name();
      }
      EXPECT_FALSE(p.zone.row == 2 && p.zone.column == 6) << p.name() << " above the insertion area";
      if (p.zone.row == 8) {
        EXPECT_TRUE(shelf_looks(p, 270)) << p.name();
      }
      if (p.zone.column == 7) {
        EXPECT_TRUE(shelf_looks(p, cyan ? 180 : 0)) << p.name();
      }
    }
  });
}

TEST(DrawnLayout, Rule4LaysBeltsAlongTheBorder) {
  for_layouts([](const Layout& layout) {
    for (const Placement& p : layout) {
      if (p.machine != "DS" && (p.zone.row == 1 || p.zone.row == 8)) {
        EXPECT_EQ(p.rotation % 180, 0) << p.name();
      }
      if (p.zone.column == 1 || p.zone.column == 7) {
        EXPECT_EQ(p.rotation % 180, 90) << p.name();
      }
    }
  });
}

TEST(DrawnLayout, TheRefereeBoxTurnsCyansShelvesToTheOuterWall) {
  int at_the_wall = 0;
  for_layouts(
      [&](const Layout& layout) {
        for (const Placement& p : layout)
          if (p.zone.column == 7 && p.zone.half == Team::kCyan &&
              (kind_of(p.machine) == "CS" || kind_of(p.machine) == "RS")) {
            EXPECT_EQ(p.rotation, 270) << p.name();
            ++at_the_wall;
          }
      },
      true);
  EXPECT_GT(at_the_wall, 100);
}

TEST(DrawnLayout, Rule5HasNoThreeMachinesInARow) {
  for_layouts([](const Layout& layout) {
    std::set<std::pair<int, int>> machines;
    for (const Placement& p : layout) machines.insert(cell_of(p.zone));
    for (const auto& [x, y] : machines)
      for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}, {1, 1}, {-1, 1}}) {
        const bool same_half = (x + 2 * dx) * x > 0;
        if (!same_half) continue;
        EXPECT_FALSE(machines.count({x + dx, y + dy}) && machines.count({x + 2 * dx, y + 2 * dy})) << x << " " << y;
      }
  });
}

TEST(DrawnLayout, Rule6ClosesOffNoCorner) {
  for_layouts([](const Layout& layout) {
    std::set<std::pair<int, int>> machines;
    for (const Placement& p : layout) machines.insert(cell_of(p.zone));
    for (const int side : {1, -1}) {
      const auto both = [&](int x0, int y0, int x1, int y1) {
        return machines.count({side * x0, y0}) && machines.count({side * x1, y1});
      };
      EXPECT_FALSE(both(2, 1, 1, 2) || both(2, 8, 1, 7) || both(6, 8, 7, 7) || both(6, 2, 7, 3));
    }
  });
}

TEST(DrawnLayout, Rule7LeavesTheFreeCellsConnected) {
  for_layouts([](const Layout& layout) {
    std::set<std::pair<int, int>> open;
    for (int x = 1; x <= 7; ++x)
      for (int y = 1; y <= 8; ++y)
        if (!is_insertion({x, y})) open.insert({x, y});
    for (const Placement& p : layout)
      if (p.zone.half == Team::kCyan) open.erase(cell_of(p.zone));
    std::vector<std::pair<int, int>> todo{*open.begin()};
    open.erase(open.begin());
    while (!todo.empty()) {
      const auto [x, y] = todo.back();
      todo.pop_back();
      for (const auto& next : {std::pair{x + 1, y}, {x - 1, y}, {x, y + 1}, {x, y - 1}})
        if (open.erase(next) > 0) todo.push_back(next);
    }
    EXPECT_THAT(open, IsEmpty());
  });
}

// 400 layouts that the referee box's generator drew (2026), seen on the cyan half before the copies for magenta are
// made.
constexpr std::array<std::array<int, 7>, 8> kRecordedCells{{{0, 65, 64, 0, 0, 0, 0},
                                                            {62, 72, 61, 55, 0, 28, 0},
                                                            {65, 68, 70, 54, 71, 71, 68},
                                                            {50, 57, 64, 65, 48, 67, 45},
                                                            {42, 66, 69, 54, 41, 63, 55},
                                                            {54, 59, 60, 55, 70, 53, 57},
                                                            {61, 62, 71, 58, 66, 67, 55},
                                                            {0, 59, 53, 59, 62, 59, 0}}};
constexpr std::array<int, 8> kRecordedAnglesOfBaseAndStorage{186, 18, 196, 19, 162, 18, 186, 15};
constexpr std::array<int, 8> kRecordedAnglesOfCapAndRing{283, 28, 326, 39, 380, 40, 473, 31};
constexpr std::array<int, 8> kRecordedAnglesOfDelivery{65, 35, 102, 8, 60, 28, 89, 13};
constexpr std::array<int, 8> kRecordedMachinesAskew{171, 178, 39, 12};  // games with 0, 1, 2 ... machines at 45 degrees
constexpr std::array<int, 8> kRecordedMachinesAtBorder{7, 40, 140, 144, 62, 7};  // games with 0, 1, 2 ... of them

TEST(DrawnLayout, PlacesAndAnglesAreAsOftenAsTheRefereeBoxDrawsThem) {
  std::array<std::array<int, 7>, 8> cells{};
  std::array<int, 8> symmetric{}, sided{}, delivery{}, askew{}, at_border{};
  for (std::size_t seed = 0; seed < 400; ++seed) {
    std::size_t askew_here = 0, border_here = 0;
    for (const Placement& p : drawn_layouts(true)[seed]) {
      if (p.zone.half != Team::kCyan) continue;
      const std::string_view kind = kind_of(p.machine);
      ++cells[static_cast<std::size_t>(p.zone.row) - 1][static_cast<std::size_t>(p.zone.column) - 1];
      ++(kind == "DS"                   ? delivery
         : kind == "CS" || kind == "RS" ? sided
                                        : symmetric)[static_cast<std::size_t>(p.rotation / 45)];
      if (p.rotation % 90 != 0) ++askew_here;
      if (p.zone.column == 1 || p.zone.column == 7 || p.zone.row == 1 || p.zone.row == 8) ++border_here;
    }
    ++askew[askew_here];
    ++at_border[border_here];
  }
  const auto flat = [](const std::array<std::array<int, 7>, 8>& rows) {
    std::vector<int> all;
    for (const auto& row : rows) all.insert(all.end(), row.begin(), row.end());
    return all;
  };
  EXPECT_LT(difference(flat(cells), flat(kRecordedCells)), kNormalLimit);
  EXPECT_LT(difference(symmetric, kRecordedAnglesOfBaseAndStorage), kNormalLimit);
  EXPECT_LT(difference(sided, kRecordedAnglesOfCapAndRing), kNormalLimit);
  EXPECT_LT(difference(delivery, kRecordedAnglesOfDelivery), kNormalLimit);
  EXPECT_LT(difference(askew, kRecordedMachinesAskew), kNormalLimit);
  EXPECT_LT(difference(at_border, kRecordedMachinesAtBorder), kNormalLimit);
}

TEST(DrawnLayout, Rules8And9MirrorTheHalvesAndSwapTwoMachines) {
  std::map<std::string, int> swapped;
  for_layouts([&](const Layout& layout) {
    ASSERT_EQ(layout.size(), 14u);
    for (std::size_t i = 0; i < 7; ++i) {
      const Placement &cyan = layout[i], &magenta = layout[i + 7];
      EXPECT_EQ(cyan.machine, magenta.machine);
      EXPECT_EQ(cyan.zone.column, magenta.zone.column);
      EXPECT_EQ(cyan.zone.row, magenta.zone.row);
      EXPECT_NE(cyan.zone.half, magenta.zone.half);
      if (cyan.zone.half == Team::kMagenta) ++swapped[std::string(cyan.machine)];
      const bool inner = cyan.zone.column > 1 && cyan.zone.column < 7 && cyan.zone.row > 2 && cyan.zone.row < 8;
      if (inner) {
        EXPECT_EQ((cyan.rotation + magenta.rotation) % 360, 180) << cyan.name();
      }
    }
  });
  EXPECT_EQ(swapped.size(), 4u) << "only ring and cap stations";
  EXPECT_EQ(swapped["RS1"] + swapped["RS2"], kLayouts);
  EXPECT_EQ(swapped["CS1"] + swapped["CS2"], kLayouts);
  EXPECT_NEAR(swapped["RS1"], kLayouts / 2, 120);
  EXPECT_NEAR(swapped["CS1"], kLayouts / 2, 120);
}

TEST(DrawnLayout, DependsOnTheSeedAlone) {
  RandomStream a(5, "layout"), b(5, "layout"), c(6, "layout");
  const std::string first = show(draw_layout(a, false));
  EXPECT_EQ(first, show(draw_layout(b, false)));
  EXPECT_NE(first, show(draw_layout(c, false)));
}

/// FNV-1a, 64 bits.
std::uint64_t fingerprint(const std::vector<Layout>& layouts) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const Layout& layout : layouts)
    for (const char c : show(layout)) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return hash;
}

TEST(DrawnLayout, OfASeedStaysTheSame) {
  EXPECT_EQ(fingerprint(drawn_layouts(false)), 12474218300076794330U);
  EXPECT_EQ(fingerprint(drawn_layouts(true)), 5851916813683144458U);
}

TEST(GeneratedFloor, EverySpotCanBeServedByARobot) {
  // Seeds 82, 109, 113, 142: the first draw has a shelf slot or slide behind the end of the insertion area's wall.
  for (const std::uint64_t seed : {0u, 1u, 2u, 3u, 4u, 5u, 6u, 7u, 82u, 109u, 113u, 142u}) {
    const sim::FloorPlan plan = drawn_plan(WorldConfig{}, seed);
    for (const sim::SpotId spot : unreachable_spots(plan, kPlanningRadius))
      ADD_FAILURE() << "seed " << seed << ": " << plan.spot(spot).name;
  }
}

TEST(GeneratedFloor, IsTheFirstDrawWhereRobotsOfTheLeagueReachEverySpot) {
  for (const auto& [seed, first] : {std::pair{1U, true}, {3U, true}, {40U, true}, {82U, false}, {109U, false}}) {
    RandomStream random(seed, "layout");
    const sim::FloorPlan drawn = make_floor_plan(draw_layout(random, false), {Team::kCyan}, 3);
    EXPECT_EQ(unreachable_spots(drawn, kPlanningRadius).empty(), first) << seed;
    const sim::FloorPlan plan = drawn_plan(WorldConfig{}, seed);
    bool same = true;
    for (std::size_t i = 0; i < drawn.stations.size(); ++i)
      same = same && plan.stations[i].pose_in_world.position() == drawn.stations[i].pose_in_world.position();
    EXPECT_EQ(same, first) << seed;
  }
}

TEST(GeneratedFloor, WithTheRefereeBoxsAnglesASlotAtTheWallIsOutOfReachAndKnown) {
  WorldConfig config;
  config.rules = "refbox";
  std::vector<std::string> names;
  const sim::FloorPlan plan = drawn_plan(config, 78);
  for (const sim::SpotId spot : unreachable_spots(plan, kRobotRadius)) names.push_back(plan.spot(spot).name);
  EXPECT_THAT(names, testing::ElementsAre("M-CS2-SHELF-RIGHT"));
}

TEST(GeneratedFloor, ARobotThatIsWalledInReachesNothing) {
  sim::FloorPlan plan = drawn_plan(WorldConfig{}, 1);
  plan.walls.push_back({{4, 1}, {5, 1}});
  EXPECT_EQ(unreachable_spots(plan, kRobotRadius).size(), plan.spots.size());
}

TEST(Reach, ARobotMustFitWhereItLinesUpAndWhereItWorks) {
  constexpr double kRadius = 0.3;
  sim::FloorPlan plan;
  plan.stations = {{"A", "BS", {0, 4, 0}, true}};
  for (sim::Spot& spot : sim::spots_of(plan.stations[0], sim::StationId{0})) plan.spots.push_back(std::move(spot));
  plan.spots.resize(1);
  plan.robots = {{"robot1", {-5, 4, 0}}};
  const auto [align, work] = plan.spots[0].footprint();
  plan.stations.clear();
  const sim::Vec2 outwards = (align - work).normalized();
  const auto reached = [&](const sim::Vec2& end_of_wall) {
    sim::FloorPlan with_wall = plan;
    with_wall.walls = {{end_of_wall, end_of_wall}};
    return unreachable_spots(with_wall, kRadius).empty();
  };
  const double room = kRadius + 0.025;  // of a wall from its middle
  EXPECT_TRUE(reached(align + (room + 0.001) * outwards));
  EXPECT_FALSE(reached(align + (room - 0.001) * outwards));
  EXPECT_TRUE(reached(work - (room + 0.001) * outwards));
  EXPECT_FALSE(reached(work - (room - 0.001) * outwards));
}

TEST(Reach, ARobotMustFitWithinTheField) {
  constexpr double kRadius = 0.3;
  for (int quarter = 0; quarter < 4; ++quarter) {
    const double yaw = quarter * std::numbers::pi / 2;
    sim::FloorPlan plan;
    plan.stations = {{"A", "BS", {0, 4, yaw}, true}};
    for (sim::Spot& spot : sim::spots_of(plan.stations[0], sim::StationId{0})) plan.spots.push_back(std::move(spot));
    plan.spots.resize(1);
    const auto [align, work] = plan.spots[0].footprint();
    plan.stations.clear();
    const sim::Vec2 outwards = (align - work).normalized(), inside = align - 3 * outwards;
    plan.robots = {{"robot1", {inside.x(), inside.y(), 0}}};
    const auto reached = [&](double room) {
      sim::FloorPlan narrow = plan;
      const sim::Vec2 end = align + room * outwards;
      if (outwards.x() > 0.5) narrow.max_x = end.x();
      if (outwards.x() < -0.5) narrow.min_x = end.x();
      if (outwards.y() > 0.5) narrow.max_y = end.y();
      if (outwards.y() < -0.5) narrow.min_y = end.y();
      return unreachable_spots(narrow, kRadius).empty();
    };
    EXPECT_TRUE(reached(kRadius + 0.001)) << quarter;
    EXPECT_FALSE(reached(kRadius - 0.001)) << quarter;
  }
}

TEST(Reach, AGapAtATwentiethOfAMetreIsFound) {
  sim::FloorPlan plan;
  plan.stations = {{"A", "BS", {2, 4, 0}, true}};
  for (sim::Spot& spot : sim::spots_of(plan.stations[0], sim::StationId{0})) plan.spots.push_back(std::move(spot));
  plan.robots = {{"robot1", {-5, 4, 0}}};
  const auto reached = [&](double middle, double width) {
    sim::FloorPlan divided = plan;
    divided.walls = {{{-1, 0}, {-1, middle - width / 2 - 0.025}}, {{-1, middle + width / 2 + 0.025}, {-1, 8}}};
    return unreachable_spots(divided, 0.25).empty();
  };
  EXPECT_TRUE(reached(4.05, 0.52));
  EXPECT_TRUE(reached(4.1, 0.52));
  EXPECT_FALSE(reached(4.05, 0.48));
}

std::vector<PlacedMachine> as_listed(const Layout& layout) {
  std::vector<PlacedMachine> listed;
  for (const Placement& p : layout) listed.push_back({p.name(), to_string(p.zone), p.rotation});
  return listed;
}

TEST(ListedLayout, IsTakenAsItStands) {
  RandomStream random(3, "layout");
  const Layout drawn = draw_layout(random, false);
  std::vector<PlacedMachine> listed = as_listed(drawn);
  std::swap(listed[0], listed[9]);  // the order of the list does not matter
  const auto read = read_layout(listed);
  ASSERT_TRUE(read);
  EXPECT_EQ(show(*read), show(drawn));
}

TEST(ListedLayout, ErrorsNameTheEntryAndWhatWasExpected) {
  RandomStream random(3, "layout");
  const std::vector<PlacedMachine> good = as_listed(draw_layout(random, false));
  const auto error_of = [&](auto change) {
    std::vector<PlacedMachine> listed = good;
    change(listed);
    const auto layout = read_layout(listed);
    return layout ? std::string("accepted") : layout.error().message;
  };
  EXPECT_THAT(error_of([](auto& l) { l[1].machine = "C-CS3"; }),
              HasSubstr("world.layout[1].machine: no machine 'C-CS3', did you mean 'C-CS1'?"));
  EXPECT_THAT(error_of([](auto& l) { l[2].zone = "C_Z91"; }), HasSubstr("world.layout[2].zone: found 'C_Z91'"));
  EXPECT_THAT(error_of([](auto& l) { l[2].zone = "M_Z61"; }), HasSubstr("insertion area"));
  EXPECT_THAT(error_of([](auto& l) { l[3].zone = l[2].zone; }), HasSubstr("two machines in"));
  EXPECT_THAT(error_of([](auto& l) { l[3].rotation = 30; }), HasSubstr("world.layout[3].rotation: found 30"));
  EXPECT_THAT(error_of([](auto& l) { l[3].machine = l[2].machine; }), HasSubstr("is placed twice"));
  EXPECT_THAT(error_of([](auto& l) { l.pop_back(); }), HasSubstr("M-DS is missing"));
}

TEST(FloorPlan, HasTheFieldsWallsMachinesAndRobots) {
  const sim::FloorPlan plan = drawn_plan(WorldConfig{}, 1);
  EXPECT_EQ(plan.stations.size(), 14u);
  EXPECT_EQ(plan.walls.size(), 14u);
  // Belts: 2 x (6 x 2 + 1), shelves 4 x 3, slides 4.
  EXPECT_EQ(plan.spots.size(), 26u + 12u + 4u);
  ASSERT_EQ(plan.robots.size(), 3u);
  EXPECT_EQ(plan.robots[2].name, "robot3");
  EXPECT_DOUBLE_EQ(plan.robots[2].pose_in_world.x, 6.5);
  EXPECT_TRUE(plan.find_spot("C-CS1-SHELF-LEFT"));

  WorldConfig magenta;
  magenta.team = "MAGENTA";
  magenta.robots = 2;
  const sim::FloorPlan other = drawn_plan(magenta, 1);
  ASSERT_EQ(other.robots.size(), 2u);
  EXPECT_DOUBLE_EQ(other.robots[0].pose_in_world.x, -4.5);
}

TEST(Floor, HasTheWallsOfTheRulebookOnBothSides) {
  using Wall = std::array<double, 4>;  // from x, y to x, y
  std::set<Wall> found, wanted;
  for (const sim::Segment& wall : make_floor_plan(drawn_layouts(true)[0], {Team::kCyan}, 0).walls)
    found.insert({wall.a.x(), wall.a.y(), wall.b.x(), wall.b.y()});
  for (const double s : {1.0, -1.0})
    wanted.insert({{4 * s, 1, 4 * s, 0},
                   {4 * s, 0, 7 * s, 0},
                   {5 * s, 1, 7 * s, 1},
                   {7 * s, 1, 7 * s, 2},
                   {7 * s, 6.5, 7 * s, 8},
                   {7 * s, 8, 0, 8},
                   {2 * s, 0, 0, 0}});
  EXPECT_EQ(found, wanted);
}

}  // namespace
}  // namespace cxlab::rcll
