#include "scenarios/rcll/rules/layout.h"

#include <algorithm>
#include <array>
#include <numbers>
#include <optional>
#include <span>
#include <tuple>

namespace cxlab::rcll {
namespace {

constexpr int W = kColumns, H = kRows;

struct Cell {
  int x = 0, y = 0;
  friend bool operator==(const Cell&, const Cell&) = default;
};

bool in_half(Cell c) { return c.x >= 1 && c.x <= W && c.y >= 1 && c.y <= H; }
bool in_insertion(Cell c) { return c.x >= W - 2 && c.y == 1; }
bool machine_forbidden(Cell c) {
  static constexpr Cell kCorners[]{{1, 1}, {1, H}, {W, H}, {W, 2}, {W - 3, 1}};
  return in_insertion(c) || c == Cell{W - 2, 2} || std::ranges::find(kCorners, c) != std::end(kCorners);
}

/// One yes or no for each cell; outside of the half it is always no.
class CellSet {
 public:
  bool has(Cell c) const { return in_half(c) && bits_[index(c)]; }
  void add(Cell c) { bits_[index(c)] = true; }

 private:
  static std::size_t index(Cell c) { return static_cast<std::size_t>((c.y - 1) * W + c.x - 1); }
  std::array<bool, W * H> bits_{};
};

struct Pose {
  Cell cell;
  int rotation = 0;
};

/// Which rule of the border holds for a machine: belts on both sides and nothing else, with shelf or slide, input only.
enum class Shape { kSymmetric, kSided, kInputOnly };
Shape shape_of(std::string_view machine) {
  if (machine == "DS") return Shape::kInputOnly;
  return kind_of(machine) == "CS" || kind_of(machine) == "RS" ? Shape::kSided : Shape::kSymmetric;
}

int sign(int v) { return (v > 0) - (v < 0); }

/// The cells before a side that looks in `direction`.
void add_side(Cell c, int direction, std::vector<Cell>& cells) {
  static constexpr int kDx[]{1, 1, 0, -1, -1, -1, 0, 1}, kDy[]{0, 1, 1, 1, 0, -1, -1, -1};
  const int dx = kDx[direction / 45 % 8], dy = kDy[direction / 45 % 8];
  cells.push_back({c.x + dx, c.y + dy});
  if (direction % 90 == 0) return;
  cells.push_back({c.x + sign(dx), c.y});
  cells.push_back({c.x, c.y + sign(dy)});
}

std::vector<Cell> blocked_cells(const Pose& pose, Shape shape) {
  std::vector<Cell> cells{pose.cell};
  add_side(pose.cell, pose.rotation, cells);
  if (shape != Shape::kInputOnly) {
    add_side(pose.cell, pose.rotation + 180, cells);
  } else if (pose.rotation == 135 || pose.rotation == 315) {
    const int out = pose.rotation == 135 ? 1 : -1;
    cells.push_back({pose.cell.x + out, pose.cell.y - out});
  }
  return cells;
}

/// Rule 4.
bool border_allows(const Pose& pose, Shape shape, bool shelf_faces_wall) {
  const auto [x, y] = pose.cell;
  const int r = pose.rotation;
  const bool sided = shape == Shape::kSided;
  const bool along_x = r == 0 || r == 180, along_y = r == 90 || r == 270;
  if ((x == 1 || x == W) && !along_y) return false;
  if (shape == Shape::kInputOnly) return true;
  if (y == 2 && x == W - 1) return false;
  if (y == 1 && !(sided ? r == 0 : along_x)) return false;
  if (y == H && !(sided ? r == 180 : along_x)) return false;
  return !sided || x != W || r == (shelf_faces_wall ? 270 : 90);
}

/// The angles at which a machine of that shape may stand in the cell, as far as no other machine is concerned.
std::vector<int> admissible_angles(Cell cell, Shape shape, bool shelf_faces_wall) {
  std::vector<int> angles;
  if (machine_forbidden(cell)) return angles;
  for (int r = 0; r < 360; r += 45) {
    const Pose pose{cell, r};
    const std::vector<Cell> cells = blocked_cells(pose, shape);
    if (border_allows(pose, shape, shelf_faces_wall) &&
        std::ranges::all_of(cells, [](Cell c) { return in_half(c) && !in_insertion(c); }))
      angles.push_back(r);
  }
  return angles;
}

/// Rule 5, for one more machine at `c`.
bool makes_three_in_a_row(const CellSet& machines, Cell c) {
  for (const Cell& step : {Cell{1, 0}, Cell{0, 1}, Cell{1, 1}, Cell{-1, 1}}) {
    const auto at = [&](int n) { return machines.has({c.x + n * step.x, c.y + n * step.y}); };
    if ((at(-2) && at(-1)) || (at(-1) && at(1)) || (at(1) && at(2))) return true;
  }
  return false;
}

/// Rule 6, for one more machine at `c`.
bool locks_corner(const CellSet& machines, Cell c) {
  static constexpr std::pair<Cell, Cell> kLocks[]{
      {{2, 1}, {1, 2}}, {{2, H}, {1, H - 1}}, {{W - 1, H}, {W, H - 1}}, {{W - 1, 2}, {W, 3}}};
  return std::ranges::any_of(kLocks, [&](const auto& lock) {
    return (c == lock.first && machines.has(lock.second)) || (c == lock.second && machines.has(lock.first));
  });
}

/// Rule 7.
bool free_cells_connected(const CellSet& machines) {
  const auto free = [&](Cell c) { return in_half(c) && !in_insertion(c) && !machines.has(c); };
  std::size_t free_count = 0;
  std::vector<Cell> open;
  CellSet seen;
  for (int y = 1; y <= H; ++y)
    for (int x = 1; x <= W; ++x)
      if (free({x, y}) && free_count++ == 0) open.push_back({x, y});
  if (!open.empty()) seen.add(open.front());
  std::size_t reached = 0;
  while (!open.empty()) {
    const Cell c = open.back();
    open.pop_back();
    ++reached;
    for (const Cell next : {Cell{c.x + 1, c.y}, {c.x - 1, c.y}, {c.x, c.y + 1}, {c.x, c.y - 1}}) {
      if (!free(next) || seen.has(next)) continue;
      seen.add(next);
      open.push_back(next);
    }
  }
  return reached == free_count;
}

using HalfLayout = std::array<Pose, kMachines.size()>;

/// Draws a half in two steps, as the referee box's generator does: first a cell for each machine, then the angles.
class HalfDraw {
 public:
  HalfDraw(RandomStream& random, bool shelf_faces_wall) : random_(random), shelf_faces_wall_(shelf_faces_wall) {}

  /// One try.
  std::optional<HalfLayout> draw() {
    if (!draw_cells() || !free_cells_connected(machines_)) return std::nullopt;
    std::vector<std::size_t> order = placed_;
    random_.shuffle(order);
    if (!draw_angles(order)) return std::nullopt;
    return half_;
  }

 private:
  /// Goes through the cells in random order; each gets one of the machines that fit, or none.
  bool draw_cells() {
    std::vector<Cell> cells;
    for (int x = 1; x <= W; ++x)
      for (int y = 1; y <= H; ++y) cells.push_back({x, y});
    random_.shuffle(cells);
    for (const Cell cell : cells) {
      if (makes_three_in_a_row(machines_, cell) || locks_corner(machines_, cell)) continue;
      std::vector<std::size_t> fitting;
      for (std::size_t m = 0; m < kMachines.size(); ++m)
        if (std::ranges::find(placed_, m) == placed_.end() && fits(m, cell)) fitting.push_back(m);
      const std::size_t choice = random_.below(fitting.size() + 1);
      if (choice == fitting.size()) continue;
      half_[fitting[choice]].cell = cell;
      placed_.push_back(fitting[choice]);
      machines_.add(cell);
      if (placed_.size() == kMachines.size()) return true;
    }
    return false;
  }

  /// Whether each machine, that one included, keeps an angle at which it blocks no other machine's cell.
  bool fits(std::size_t machine, Cell cell) {
    CellSet machines = machines_;
    machines.add(cell);
    if (angles_of(machine, cell, machines).empty()) return false;
    return std::ranges::none_of(placed_, [&](std::size_t m) { return angles_of(m, half_[m].cell, machines).empty(); });
  }

  std::vector<int> angles_of(std::size_t machine, Cell cell, const CellSet& machines) const {
    const Shape shape = shape_of(kMachines[machine]);
    std::vector<int> angles = admissible_angles(cell, shape, shelf_faces_wall_);
    std::erase_if(angles, [&](int angle) {
      return std::ranges::any_of(blocked_cells({cell, angle}, shape),
                                 [&](Cell c) { return c != cell && machines.has(c); });
    });
    return angles;
  }

  /// Gives the machines in that order a random angle that blocks no cell twice; goes back where none is left.
  bool draw_angles(std::span<const std::size_t> order) {
    if (order.empty()) return true;
    Pose& pose = half_[order.front()];
    const Shape shape = shape_of(kMachines[order.front()]);
    std::vector<int> angles = angles_of(order.front(), pose.cell, machines_);
    random_.shuffle(angles);
    const CellSet before = blocked_;
    for (const int angle : angles) {
      pose.rotation = angle;
      const std::vector<Cell> cells = blocked_cells(pose, shape);
      if (std::ranges::any_of(cells, [&](Cell c) { return before.has(c); })) continue;
      for (const Cell c : cells) blocked_.add(c);
      if (draw_angles(order.subspan(1))) return true;
      blocked_ = before;
    }
    return false;
  }

  RandomStream& random_;
  bool shelf_faces_wall_;
  HalfLayout half_;
  std::vector<std::size_t> placed_;
  CellSet machines_, blocked_;
};

int mirrored(int rotation) { return (540 - rotation) % 360; }
Zone mirrored(const Zone& zone) { return {other(zone.half), zone.column, zone.row}; }

/// The angle of magenta's copy.
int mirrored_rotation(const Pose& pose, Shape shape) {
  const auto [x, y] = pose.cell;
  if (shape == Shape::kSided) {
    if (y == H) return 180;
    if (y == 1 || (y == 2 && x >= W - 2)) return 0;
    if (x == W) return 270;
  }
  return mirrored(pose.rotation);
}

void swap_sides(Layout& layout, std::string_view machine) {
  std::vector<Placement*> pair;
  for (Placement& p : layout)
    if (p.machine == machine) pair.push_back(&p);
  std::swap(pair[0]->zone, pair[1]->zone);
  std::swap(pair[0]->rotation, pair[1]->rotation);
}

}  // namespace

std::string to_string(const Zone& zone) {
  return std::string(1, letter(zone.half)) + "_Z" + std::to_string(zone.column) + std::to_string(zone.row);
}

std::optional<Zone> zone_named(std::string_view name) {
  if (name.size() != 5 || (name[0] != 'C' && name[0] != 'M') || name.substr(1, 2) != "_Z") return std::nullopt;
  const Zone zone{name[0] == 'C' ? Team::kCyan : Team::kMagenta, name[3] - '0', name[4] - '0'};
  if (!in_half({zone.column, zone.row})) return std::nullopt;
  return zone;
}

Zone zone_of(const sim::Station& station) {
  const sim::Pose2& pose = station.pose_in_world;
  return {pose.x > 0 ? Team::kCyan : Team::kMagenta, static_cast<int>(std::abs(pose.x)) + 1,
          static_cast<int>(pose.y) + 1};
}

int rotation_of(const sim::Station& station) { return sim::whole_degrees(station.pose_in_world.yaw); }

Team team_of(const sim::Station& station) { return station.name.front() == 'C' ? Team::kCyan : Team::kMagenta; }

Team team_of(const sim::RobotStart& robot) { return robot.pose_in_world.x > 0 ? Team::kCyan : Team::kMagenta; }

sim::Pose2 centre_of(const Zone& zone, int rotation) {
  const double x = zone.column - 0.5;
  return {zone.half == Team::kCyan ? x : -x, zone.row - 0.5, sim::wrap_angle(rotation * std::numbers::pi / 180)};
}

Layout draw_layout(RandomStream& random, bool shelf_faces_wall) {
  std::optional<HalfLayout> half;
  while (!half) half = HalfDraw(random, shelf_faces_wall).draw();
  Layout layout;
  for (const Team team : kTeams)
    for (std::size_t m = 0; m < kMachines.size(); ++m) {
      const Pose& pose = (*half)[m];
      const int rotation = team == Team::kCyan ? pose.rotation : mirrored_rotation(pose, shape_of(kMachines[m]));
      layout.push_back({team, kMachines[m], {team, pose.cell.x, pose.cell.y}, rotation});
    }
  swap_sides(layout, random.chance(0.5) ? "RS1" : "RS2");
  swap_sides(layout, random.chance(0.5) ? "CS1" : "CS2");
  return layout;
}

Expected<Layout> read_layout(const std::vector<PlacedMachine>& machines, const std::string& key) {
  Layout layout;
  for (const Team team : kTeams)
    for (const std::string_view machine : kMachines) layout.push_back({team, machine, {}, -1});
  std::vector<std::string> names;
  for (const Placement& p : layout) names.push_back(p.name());

  std::vector<std::string> taken;
  for (std::size_t i = 0; i < machines.size(); ++i) {
    const PlacedMachine& given = machines[i];
    const auto fail = [&](const std::string& what) {
      return input_error(key + "[" + std::to_string(i) + "]." + what, given.origin);
    };
    const auto at = std::ranges::find(names, given.machine);
    if (at == names.end()) {
      const std::string near = nearest_word(given.machine, names);
      return fail("machine: no machine '" + given.machine + "'" +
                  (near.empty() ? ", expected C- or M- and BS, CS1, CS2, RS1, RS2, SS or DS"
                                : ", did you mean '" + near + "'?"));
    }
    Placement& placement = layout[static_cast<std::size_t>(at - names.begin())];
    if (placement.rotation >= 0) return fail("machine: " + given.machine + " is placed twice");
    const auto zone = zone_named(given.zone);
    if (!zone) return fail("zone: " + found_text(given.zone, "C_Z11 to C_Z78 or M_Z11 to M_Z78"));
    if (in_insertion({zone->column, zone->row}))
      return fail("zone: " + given.zone + " is in an insertion area, where robots start");
    if (std::ranges::find(taken, given.zone) != taken.end()) return fail("zone: two machines in " + given.zone);
    if (given.rotation < 0 || given.rotation > 315 || given.rotation % 45 != 0)
      return fail("rotation: " + found_expected(std::to_string(given.rotation), "a multiple of 45 from 0 to 315"));
    taken.push_back(given.zone);
    placement.zone = *zone;
    placement.rotation = given.rotation;
  }
  for (const Placement& p : layout)
    if (p.rotation < 0) return input_error(key + ": " + p.name() + " is missing");
  return layout;
}

namespace {

/// Whether two machines in zones that mirror each other face opposite ways. At a border the referee box turns the one
/// on magenta's half so that its shelf or slide can be reached.
bool face_opposite_ways(const Placement& one, const Placement& two) {
  const auto& [cyan, magenta] = one.zone.half == Team::kCyan ? std::tie(one, two) : std::tie(two, one);
  const Pose pose{{cyan.zone.column, cyan.zone.row}, cyan.rotation};
  return magenta.rotation == mirrored(cyan.rotation) ||
         magenta.rotation == mirrored_rotation(pose, shape_of(cyan.machine));
}

}  // namespace

Status check_mirrored(const std::vector<PlacedMachine>& machines, const Layout& layout, const std::string& key) {
  for (std::size_t m = 0; m < kMachines.size(); ++m) {
    const Placement& cyan = layout[m];
    const Placement& magenta = layout[m + kMachines.size()];
    const auto listed = std::ranges::find(machines, magenta.name(), &PlacedMachine::machine);
    const auto fail = [&](const std::string& what, const std::string& found, const std::string& expected) {
      return input_error(key + "[" + std::to_string(listed - machines.begin()) + "]." + what + ": " +
                             found_expected(found, expected + ", opposite to " + cyan.name() +
                                                       "; a field that is not mirrored has 'mirrored: false'"),
                         listed->origin);
    };
    const Zone zone = mirrored(cyan.zone);
    if (!(magenta.zone == zone)) return fail("zone", to_string(magenta.zone), to_string(zone));
    if (!face_opposite_ways(cyan, magenta))
      return fail("rotation", std::to_string(magenta.rotation), std::to_string(mirrored(cyan.rotation)));
  }
  return {};
}

std::vector<PlacedMachine> listed(const Layout& layout) {
  std::vector<PlacedMachine> machines;
  for (const Placement& p : layout) machines.push_back({p.name(), to_string(p.zone), p.rotation});
  return machines;
}

std::size_t count_poses(std::string_view machine, bool shelf_faces_wall) {
  std::size_t count = 0;
  for (int x = 1; x <= W; ++x)
    for (int y = 1; y <= H; ++y) count += admissible_angles({x, y}, shape_of(machine), shelf_faces_wall).size();
  return count;
}

}  // namespace cxlab::rcll
