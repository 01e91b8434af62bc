#pragma once
// The legend above a picture: cards with products. The code that draws knows the colours of pieces, but not what they
// mean.

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
