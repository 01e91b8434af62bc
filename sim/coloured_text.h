#pragma once

#include <array>
#include <string>

namespace cxlab::sim {

struct ColouredText {
  using Colour = std::array<float, 3>;  ///< red, green, blue, 0 to 1
  std::string text;
  Colour colour{1, 1, 1};
};

}  // namespace cxlab::sim
