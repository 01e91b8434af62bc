#pragma once
// What is written above a picture: lines of text and products. Who draws knows colours of pieces, not what it is about.

#include <array>
#include <string>
#include <vector>

#include "sim/world.h"

namespace cxlab::sim {

struct Legend {
  using Colour = std::array<float, 3>;  ///< red, green, blue, 0 to 1
  struct Text {
    std::string text;
    Colour colour{1, 1, 1};
  };
  /// A product with two lines beside it.
  struct Card {
    Stack product;
    std::array<Text, 2> lines;
    std::vector<Colour> ticks = {};  ///< from right to left
  };
  std::vector<Text> title;  ///< one line
  std::vector<Card> cards;  ///< from left to right, in as many rows as they need
  bool empty() const { return title.empty() && cards.empty(); }
};

}  // namespace cxlab::sim
