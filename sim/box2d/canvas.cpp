#include "sim/box2d/canvas.h"

#include <algorithm>
#include <cmath>

namespace cxlab::sim {

void Canvas::clear() { std::fill(pixels_.begin(), pixels_.end(), 0); }

void Canvas::line(double x0, double y0, double x1, double y1, const Pen& pen) {
  const double reach = std::max(pen.width, 1) / 2.0;
  const double dx = x1 - x0, dy = y1 - y0, length2 = dx * dx + dy * dy;
  // At least one pixel, however thin the pen and wherever the points lie between centres.
  const double reach2 = std::max(reach * reach, 0.5);
  const auto first = [](double a, double b, double r) {
    return static_cast<int>(std::clamp(std::floor(std::min(a, b) - r), 0.0, double{kSize}));
  };
  const auto last = [](double a, double b, double r) {
    return static_cast<int>(std::clamp(std::ceil(std::max(a, b) + r), -1.0, kSize - 1.0));
  };
  const std::uint32_t ink =
      0xFF000000u | static_cast<std::uint32_t>(pen.colour.r << 16 | pen.colour.g << 8 | pen.colour.b);
  const int left = first(x0, x1, reach), right = last(x0, x1, reach);
  for (int y = first(y0, y1, reach), bottom = last(y0, y1, reach); y <= bottom; ++y)
    for (int x = left; x <= right; ++x) {
      const double along = length2 > 0 ? std::clamp(((x - x0) * dx + (y - y0) * dy) / length2, 0.0, 1.0) : 0.0;
      const double off_x = x - x0 - along * dx, off_y = y - y0 - along * dy;
      if (off_x * off_x + off_y * off_y <= reach2)
        pixels_[static_cast<std::size_t>(y) * kSize + static_cast<std::size_t>(x)] = ink;
    }
}

std::optional<Colour> Canvas::ink(int x, int y) const {
  x = std::clamp(x, 0, kSize - 1);
  y = std::clamp(y, 0, kSize - 1);
  const std::uint32_t pixel = pixels_[static_cast<std::size_t>(y) * kSize + static_cast<std::size_t>(x)];
  if (pixel == 0) return std::nullopt;
  return Colour{static_cast<std::uint8_t>(pixel >> 16), static_cast<std::uint8_t>(pixel >> 8),
                static_cast<std::uint8_t>(pixel)};
}

}  // namespace cxlab::sim
