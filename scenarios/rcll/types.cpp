#include "scenarios/rcll/types.h"

namespace cxlab::rcll {
namespace {

using Names = std::span<const std::string_view>;

constexpr std::string_view kTeamNames[]{"CYAN", "MAGENTA"};
constexpr std::string_view kBaseNames[]{"BASE_RED", "BASE_BLACK", "BASE_SILVER", "BASE_CLEAR"};
constexpr std::string_view kRingNames[]{"RING_BLUE", "RING_GREEN", "RING_ORANGE", "RING_YELLOW"};
constexpr std::string_view kCapNames[]{"CAP_BLACK", "CAP_GREY"};
constexpr std::string_view kComplexityNames[]{"C0", "C1", "C2", "C3"};

/// Enumerators are numbered from `first` in the order of their names.
template <class Enum>
std::optional<Enum> named(Names names, int first, std::string_view name) {
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i] == name) return static_cast<Enum>(static_cast<int>(i) + first);
  return std::nullopt;
}

template <class Enum>
std::string_view name_of(Names names, int first, Enum value) {
  return names[static_cast<std::size_t>(static_cast<int>(value) - first)];
}

}  // namespace

std::string_view to_string(Team team) { return name_of(kTeamNames, 0, team); }
std::string_view to_string(BaseColor color) { return name_of(kBaseNames, 1, color); }
std::string_view to_string(RingColor color) { return name_of(kRingNames, 1, color); }
std::string_view to_string(CapColor color) { return name_of(kCapNames, 1, color); }
std::string_view to_string(Complexity complexity) { return name_of(kComplexityNames, 0, complexity); }

std::optional<Team> team_named(std::string_view name) { return named<Team>(kTeamNames, 0, name); }
std::optional<BaseColor> base_named(std::string_view name) { return named<BaseColor>(kBaseNames, 1, name); }
std::optional<RingColor> ring_named(std::string_view name) { return named<RingColor>(kRingNames, 1, name); }
std::optional<CapColor> cap_named(std::string_view name) { return named<CapColor>(kCapNames, 1, name); }
std::optional<Complexity> complexity_named(std::string_view name) {
  return named<Complexity>(kComplexityNames, 0, name);
}

sim::Stack stack_of(const Product& product) {
  sim::Stack stack;
  stack.base = static_cast<std::uint8_t>(product.base);
  for (std::size_t i = 0; i < product.rings.size(); ++i) stack.rings[i] = static_cast<std::uint8_t>(product.rings[i]);
  stack.cap = static_cast<std::uint8_t>(product.cap);
  return stack;
}

std::string describe(const sim::Stack& stack) {
  std::string text;
  const auto add = [&](std::string_view part) { text.append(text.empty() ? "" : " ").append(part); };
  if (stack.base != 0) add(to_string(static_cast<BaseColor>(stack.base)));
  for (const std::uint8_t ring : stack.rings)
    if (ring != 0) add(to_string(static_cast<RingColor>(ring)));
  if (stack.cap != 0) add(to_string(static_cast<CapColor>(stack.cap)));
  return text.empty() ? "nothing" : text;
}

std::string_view kind_of(std::string_view machine) { return machine.substr(0, 2); }

CapColor shelf_cap(std::string_view machine) { return machine.ends_with('1') ? CapColor::kGrey : CapColor::kBlack; }

std::array<RingColor, 2> rings_of(std::string_view machine) {
  if (machine.ends_with('1')) return {RingColor::kOrange, RingColor::kGreen};
  return {RingColor::kBlue, RingColor::kYellow};
}

}  // namespace cxlab::rcll
