#pragma once
// What is written above a picture: cards with products. Who draws knows colours of pieces, not what it is about.

#include <array>
#include <string>
#include <vector>

#include "sim/coloured_text.h"
#include "sim/world.h"

namespace cxlab::sim {

struct Legend {
  using Colour = ColouredText::Colour;
  using Text = ColouredText;
  /// A product with two lines beside it.
  struct Card {
    Stack product;
    std::array<Text, 2> lines;
    std::vector<Colour> ticks = {};  ///< from right to left
  };
  std::vector<Card> cards;  ///< from left to right, in as many rows as they need
  int rows = 0;             ///< for which there is room at least, so that the first cards move nothing
};

}  // namespace cxlab::sim
