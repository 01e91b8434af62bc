#pragma once
// Words of the RoboCup Logistics League: colours, teams, complexities. The numbers are those of the league's protocol
// (llsf_msgs) and fill the slots of a `sim::Stack`; the names are what agents read on the bus.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/world.h"

namespace cxlab::rcll {

enum class Team : std::uint8_t { kCyan = 0, kMagenta = 1 };
enum class BaseColor : std::uint8_t { kRed = 1, kBlack = 2, kSilver = 3, kClear = 4 };
enum class RingColor : std::uint8_t { kBlue = 1, kGreen = 2, kOrange = 3, kYellow = 4 };
enum class CapColor : std::uint8_t { kBlack = 1, kGrey = 2 };
/// Number of rings of a product.
enum class Complexity : std::uint8_t { kC0 = 0, kC1 = 1, kC2 = 2, kC3 = 3 };

inline constexpr std::array<Team, 2> kTeams{Team::kCyan, Team::kMagenta};
inline constexpr std::array<RingColor, 4> kRingColors{RingColor::kBlue, RingColor::kGreen, RingColor::kOrange,
                                                      RingColor::kYellow};

std::string_view to_string(Team team);              ///< "CYAN" "MAGENTA"
std::string_view to_string(BaseColor color);        ///< "BASE_RED" ...
std::string_view to_string(RingColor color);        ///< "RING_BLUE" ...
std::string_view to_string(CapColor color);         ///< "CAP_BLACK" "CAP_GREY"
std::string_view to_string(Complexity complexity);  ///< "C0" ...
std::optional<Team> team_named(std::string_view name);
std::optional<BaseColor> base_named(std::string_view name);
std::optional<RingColor> ring_named(std::string_view name);
std::optional<CapColor> cap_named(std::string_view name);
std::optional<Complexity> complexity_named(std::string_view name);

inline Team other(Team team) { return team == Team::kCyan ? Team::kMagenta : Team::kCyan; }
/// 'C' or 'M', the first letter of a machine's name.
inline char letter(Team team) { return team == Team::kCyan ? 'C' : 'M'; }

/// A product as an order describes it.
struct Product {
  BaseColor base = BaseColor::kRed;
  std::vector<RingColor> rings;
  CapColor cap = CapColor::kBlack;
};
/// What such a product looks like on the belt.
sim::Stack stack_of(const Product& product);
/// "BASE_RED RING_BLUE CAP_GREY", for logs; "nothing" for an empty stack.
std::string describe(const sim::Stack& stack);

/// Machine types of a team, without the team's letter, in the order in which stations are listed.
inline constexpr std::array<std::string_view, 7> kMachines{"BS", "CS1", "CS2", "RS1", "RS2", "SS", "DS"};
/// "CS1" -> "CS".
std::string_view kind_of(std::string_view machine);

/// The cap colour on the shelf of that cap station: CS1 grey, CS2 black.
CapColor shelf_cap(std::string_view machine);
/// RS1 mounts orange and green, RS2 blue and yellow.
std::array<RingColor, 2> rings_of(std::string_view machine);

}  // namespace cxlab::rcll
