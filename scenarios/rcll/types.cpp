#include "scenarios/rcll/types.h"

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

std::string_view kind_of(std::string_view machine) { return machine.substr(0, 2); }

CapColor shelf_cap(std::string_view machine) { return machine.ends_with('1') ? CapColor::kGrey : CapColor::kBlack; }

std::array<RingColor, 2> rings_of(std::string_view machine) {
  if (machine.ends_with('1')) return {RingColor::kOrange, RingColor::kGreen};
  return {RingColor::kBlue, RingColor::kYellow};
}

}  // namespace cxlab::rcll
