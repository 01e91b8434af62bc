#pragma once
// Words of the RoboCup Logistics League: colours, teams, complexities. The numbers are those of the league's protocol
// (llsf_msgs) and fill the slots of a `sim::Stack`; the names are what agents read on the bus.

#include <algorithm>
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

/// The names of an enumeration by number, as agents read them on the bus; empty = no such number.
template <class Enum>
inline constexpr std::array<std::string_view, 0> kNames{};
template <>
inline constexpr std::array<std::string_view, 2> kNames<Team>{"CYAN", "MAGENTA"};
template <>
inline constexpr std::array<std::string_view, 5> kNames<BaseColor>{"", "BASE_RED", "BASE_BLACK", "BASE_SILVER",
                                                                   "BASE_CLEAR"};
template <>
inline constexpr std::array<std::string_view, 5> kNames<RingColor>{"", "RING_BLUE", "RING_GREEN", "RING_ORANGE",
                                                                   "RING_YELLOW"};
template <>
inline constexpr std::array<std::string_view, 3> kNames<CapColor>{"", "CAP_BLACK", "CAP_GREY"};
template <>
inline constexpr std::array<std::string_view, 4> kNames<Complexity>{"C0", "C1", "C2", "C3"};

template <class Enum>
  requires(!kNames<Enum>.empty())
constexpr std::string_view to_string(Enum value) {
  return kNames<Enum>[static_cast<std::size_t>(value)];
}
/// The value of that name, if there is one.
template <class Enum>
std::optional<Enum> named(std::string_view name) {
  const auto at = std::ranges::find(kNames<Enum>, name);
  if (name.empty() || at == kNames<Enum>.end()) return std::nullopt;
  return static_cast<Enum>(at - kNames<Enum>.begin());
}

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
/// The opposite of `describe`.
sim::Stack stack_of(std::string_view description);

/// Machine types of a team, without the team's letter, in the order in which stations are listed.
inline constexpr std::array<std::string_view, 7> kMachines{"BS", "CS1", "CS2", "RS1", "RS2", "SS", "DS"};
/// "CS1" -> "CS".
std::string_view kind_of(std::string_view machine);

/// The cap colour on the shelf of that cap station: CS1 grey, CS2 black.
CapColor shelf_cap(std::string_view machine);
/// RS1 mounts orange and green, RS2 blue and yellow.
std::array<RingColor, 2> rings_of(std::string_view machine);

}  // namespace cxlab::rcll
