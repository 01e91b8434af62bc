#pragma once
// The drawing of the pens: 500 x 500 pixels. Untouched pixels show the background.

#include <cstdint>
#include <optional>
#include <vector>

namespace cxlab::sim {

struct Colour {
  std::uint8_t r = 0, g = 0, b = 0;
  friend bool operator==(const Colour&, const Colour&) = default;
};

struct Pen {
  Colour colour{179, 184, 255};
  int width = 3;  ///< pixels, 0 .. 255; 0 draws as 1
  bool off = false;
  friend bool operator==(const Pen&, const Pen&) = default;
};

class Canvas {
 public:
  static constexpr int kSize = 500;  ///< pixels, both ways

  Canvas() : pixels_(static_cast<std::size_t>(kSize) * kSize) {}
  void clear();
  /// A line with round ends between two points in pixels (x right, y down, whole numbers are pixels' centres), as far
  /// as it lies on the canvas.
  void line(double x0, double y0, double x1, double y1, const Pen& pen);
  /// The ink at that pixel, if there is any; coordinates beyond the edge mean the pixel there.
  std::optional<Colour> ink(int x, int y) const;
  /// Row by row from the top: 0 = untouched, else 0xFFrrggbb.
  const std::vector<std::uint32_t>& pixels() const { return pixels_; }

 private:
  std::vector<std::uint32_t> pixels_;
};

}  // namespace cxlab::sim
