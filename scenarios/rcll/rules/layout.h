#pragma once
// Where the fourteen machines stand: drawn from a seed by the league's rules, or given by the scenario.
//
// The cyan half is drawn and mirrored to magenta; then one ring and one cap station change sides. As in the referee
// box, all machines get a cell first, then each gets an angle among those that fit: so few stand at 45 degrees. A drawn
// half obeys (cells x = 1..7 from the centre line, y = 1..8):
//   1 no machine in the insertion area (5..7, 1), before its exit (5, 2), or in a corner of walls: (1, 1), (1, 8),
//     (7, 8), (7, 2), (4, 1); only a delivery station at (6, 2);
//   2 a machine blocks its own cell and those before each side in use (one for multiples of 90 degrees, the diagonal
//     and its two neighbours else); a delivery station uses its input only, and blocks one cell more at 135 and 315
//     degrees: the diagonal one at its back, which the referee box takes for the one at its front;
//   3 blocked cells lie inside the half and outside the insertion area, and no cell is blocked twice;
//   4 at the border belts run along it, and shelf or slide face away from the wall; a delivery station obeys that at
//     the side wall and the centre line;
//   5 no three machines in a row, straight or diagonal;
//   6 no corner of the half is closed off by machines on its two neighbours;
//   7 the cells without a machine hang together.

#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/random.h"
#include "scenarios/rcll/rules/config.h"
#include "scenarios/rcll/rules/types.h"

namespace cxlab::rcll {

inline constexpr int kColumns = 7;  ///< of a half, counted from the centre line
inline constexpr int kRows = 8;

/// One square metre of the field.
struct Zone {
  Team half = Team::kCyan;
  int column = 1;  ///< 1..7
  int row = 1;     ///< 1..8
  friend bool operator==(const Zone&, const Zone&) = default;
};
std::string to_string(const Zone& zone);  ///< "C_Z23"
std::optional<Zone> zone_named(std::string_view name);
/// The zone in which the station stands, its rotation in degrees (0..359), and whose it is.
Zone zone_of(const sim::Station& station);
int rotation_of(const sim::Station& station);
Team team_of(const sim::Station& station);
/// Robots start on their team's half.
Team team_of(const sim::RobotStart& robot);
/// The zone's centre, facing `rotation` degrees.
sim::Pose2 centre_of(const Zone& zone, int rotation);

struct Placement {
  Team team = Team::kCyan;   ///< whose machine it is, wherever it stands
  std::string_view machine;  ///< one of kMachines
  Zone zone;
  int rotation = 0;  ///< degrees, 0..315, from output to input
  std::string name() const { return std::string(1, letter(team)) + "-" + std::string(machine); }
};

/// Fourteen placements: cyan's machines, then magenta's, each in the order of kMachines.
using Layout = std::vector<Placement>;

/// Draws a layout. `shelf_faces_wall`: the referee box's angle at the outer side wall (RuleChoices).
Layout draw_layout(RandomStream& random, bool shelf_faces_wall);
/// A layout as it is listed: each machine once, each zone at most once, none in an insertion area. `key` names the list
/// in errors.
Expected<Layout> read_layout(const std::vector<PlacedMachine>& machines, const std::string& key = "world.layout");

/// One half of the field must be the mirror image of the other, as far as the border lets it. `machines` is the list
/// that `layout` was read from: errors name its entry.
Status check_mirrored(const std::vector<PlacedMachine>& machines, const Layout& layout, const std::string& key);
/// The layout as a list.
std::vector<PlacedMachine> listed(const Layout& layout);

/// How many cells and angles of an empty half the rules allow that machine.
std::size_t count_poses(std::string_view machine, bool shelf_faces_wall);

}  // namespace cxlab::rcll
