#include "scenarios/rcll/rules/types.h"

#include <sstream>

namespace cxlab::rcll {

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

sim::Stack stack_of(std::string_view description) {
  sim::Stack stack;
  std::istringstream words{std::string(description)};
  for (std::string word; words >> word;) {
    if (const auto base = named<BaseColor>(word)) stack.base = static_cast<std::uint8_t>(*base);
    if (const auto ring = named<RingColor>(word); ring && stack.rings.back() == 0)
      stack.mount(sim::Part::kRing, static_cast<std::uint8_t>(*ring));
    if (const auto cap = named<CapColor>(word)) stack.cap = static_cast<std::uint8_t>(*cap);
  }
  return stack;
}

std::string_view kind_of(std::string_view machine) { return machine.substr(0, 2); }

CapColor shelf_cap(std::string_view machine) { return machine.ends_with('1') ? CapColor::kGrey : CapColor::kBlack; }

std::array<RingColor, 2> rings_of(std::string_view machine) {
  if (machine.ends_with('1')) return {RingColor::kOrange, RingColor::kGreen};
  return {RingColor::kBlue, RingColor::kYellow};
}

}  // namespace cxlab::rcll
