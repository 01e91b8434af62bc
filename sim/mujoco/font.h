#pragma once
// The letters of MuJoCo as pixels, to write into pictures of any world.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "sim/coloured_text.h"
#include "sim/picture.h"

namespace cxlab::sim {

class Font {
 public:
  /// As the labels of pictures have it. Fails with kResource where there is no OpenGL.
  static Expected<Font> load(bool large);

  int height() const { return height_; }
  /// Each UTF-8 character that is not printable ASCII counts as one question mark.
  int width(std::string_view text) const;
  /// The text, or as much of its beginning as is not wider than that, with "..." behind it.
  std::string fitted(std::string_view text, int width) const;
  /// Writes one line whose upper left corner is there. What lies outside of the picture is not drawn.
  void write(Picture& picture, int left, int top, const ColouredText& text) const;

 private:
  static constexpr char kFirst = ' ', kLast = '~';
  struct Glyph {
    int width = 0;
    std::vector<std::uint8_t> ink;  ///< 0 to 255; top row first
  };
  /// Calls with each character's glyph, and where in the text the character ends.
  template <class Visit>
  void each(std::string_view text, Visit visit) const;

  int height_ = 0;
  std::array<Glyph, kLast - kFirst + 1> glyphs_;
};

/// Fills a rectangle, as far as it lies within the picture.
void fill(Picture& picture, int left, int top, int width, int height, const ColouredText::Colour& colour);

}  // namespace cxlab::sim
