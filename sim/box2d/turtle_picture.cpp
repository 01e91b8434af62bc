#include "sim/box2d/turtle_picture.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace cxlab::sim {

namespace {

constexpr int kSamples = 4;     // of a turtle's pixel, both ways
constexpr double kReach = 0.6;  // m: no part of a turtle is further from its middle

/// Shells and skins; turtles take them in turn.
struct Livery {
  Colour shell, rim, skin;
};
constexpr std::array<Livery, 6> kLiveries{{
    {{60, 145, 70}, {28, 78, 36}, {150, 190, 95}},
    {{205, 85, 60}, {120, 40, 28}, {235, 180, 120}},
    {{235, 190, 60}, {140, 105, 20}, {245, 225, 150}},
    {{130, 90, 180}, {70, 42, 110}, {200, 170, 225}},
    {{70, 160, 170}, {30, 90, 98}, {165, 215, 210}},
    {{150, 110, 80}, {85, 58, 38}, {215, 185, 150}},
}};

/// An ellipse of the turtle, in metres: x ahead, y to the left.
struct Part {
  double x, y, rx, ry;
  enum class Paint { kSkin, kRim, kShell, kEye } paint;
};
constexpr std::array<Part, 16> kParts{{
    // from below to the top
    {-0.44, 0, 0.12, 0.04, Part::Paint::kSkin},
    {0.26, 0.30, 0.12, 0.09, Part::Paint::kSkin},
    {0.26, -0.30, 0.12, 0.09, Part::Paint::kSkin},
    {-0.27, 0.27, 0.10, 0.08, Part::Paint::kSkin},
    {-0.27, -0.27, 0.10, 0.08, Part::Paint::kSkin},
    {0.44, 0, 0.14, 0.11, Part::Paint::kSkin},
    {0.49, 0.06, 0.025, 0.025, Part::Paint::kEye},
    {0.49, -0.06, 0.025, 0.025, Part::Paint::kEye},
    {0, 0, 0.38, 0.33, Part::Paint::kRim},
    {0, 0, 0.11, 0.10, Part::Paint::kShell},
    {0.21, 0, 0.08, 0.08, Part::Paint::kShell},
    {-0.21, 0, 0.08, 0.08, Part::Paint::kShell},
    {0.11, 0.18, 0.08, 0.07, Part::Paint::kShell},
    {0.11, -0.18, 0.08, 0.07, Part::Paint::kShell},
    {-0.11, 0.18, 0.08, 0.07, Part::Paint::kShell},
    {-0.11, -0.18, 0.08, 0.07, Part::Paint::kShell},
}};

/// What the turtle shows at a point of its own frame.
std::optional<Colour> paint_at(double x, double y, const Livery& livery) {
  for (auto part = kParts.rbegin(); part != kParts.rend(); ++part) {
    const double dx = (x - part->x) / part->rx, dy = (y - part->y) / part->ry;
    if (dx * dx + dy * dy > 1) continue;
    switch (part->paint) {
      case Part::Paint::kSkin: return livery.skin;
      case Part::Paint::kRim: return livery.rim;
      case Part::Paint::kShell: return livery.shell;
      case Part::Paint::kEye: return Colour{20, 20, 20};
    }
  }
  return std::nullopt;
}

struct Sum {
  double r = 0, g = 0, b = 0;
  void add(const Colour& c, double weight) {
    r += weight * c.r;
    g += weight * c.g;
    b += weight * c.b;
  }
};

void put(Picture& picture, int x, int y, const Sum& sum) {
  std::uint8_t* pixel = &picture.rgb[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) +
                                          static_cast<std::size_t>(x))];
  pixel[0] = static_cast<std::uint8_t>(std::lround(sum.r));
  pixel[1] = static_cast<std::uint8_t>(std::lround(sum.g));
  pixel[2] = static_cast<std::uint8_t>(std::lround(sum.b));
}

/// Background and ink, between the canvas' pixels a mixture of the four around.
void lay_canvas(const Canvas& canvas, const Colour& background, Picture& picture) {
  const double scale = double(Canvas::kSize) / picture.width;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const double cx = (x + 0.5) * scale - 0.5, cy = (y + 0.5) * scale - 0.5;
      const int left = static_cast<int>(std::floor(cx)), top = static_cast<int>(std::floor(cy));
      Sum sum;
      for (int dy = 0; dy < 2; ++dy)
        for (int dx = 0; dx < 2; ++dx) {
          const double weight = (dx ? cx - left : 1 - cx + left) * (dy ? cy - top : 1 - cy + top);
          if (weight > 0) sum.add(canvas.ink(left + dx, top + dy).value_or(background), weight);
        }
      put(picture, x, y, sum);
    }
}

void lay_turtle(const Turtle& turtle, Picture& picture) {
  const Livery& livery = kLiveries[static_cast<std::size_t>(static_cast<int>(turtle.id) - 1) % kLiveries.size()];
  const double metre = TurtleWorld::kPixelsPerMetre * picture.width / Canvas::kSize;
  const double middle_x = turtle.x * metre + 0.5 * picture.width / Canvas::kSize;
  const double middle_y = picture.height - turtle.y * metre - 0.5 * picture.width / Canvas::kSize;
  const auto clamped = [&](double v) { return std::clamp(static_cast<int>(std::floor(v)), 0, picture.width - 1); };
  const double c = std::cos(turtle.theta), s = std::sin(turtle.theta);
  for (int y = clamped(middle_y - kReach * metre); y <= clamped(middle_y + kReach * metre); ++y)
    for (int x = clamped(middle_x - kReach * metre); x <= clamped(middle_x + kReach * metre); ++x) {
      Sum sum;
      const std::uint8_t* below =
          &picture.rgb[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) +
                            static_cast<std::size_t>(x))];
      const Colour under{below[0], below[1], below[2]};
      for (int i = 0; i < kSamples * kSamples; ++i) {
        const double px = (x + (i % kSamples + 0.5) / kSamples - middle_x) / metre,
                     py = -(y + (i / kSamples + 0.5) / kSamples - middle_y) / metre;
        sum.add(paint_at(c * px + s * py, -s * px + c * py, livery).value_or(under), 1.0 / (kSamples * kSamples));
      }
      put(picture, x, y, sum);
    }
}

}  // namespace

Picture draw_turtles(const TurtleWorld& world, int side) {
  assert(side >= 16);
  Picture picture{side, side,
                  std::vector<std::uint8_t>(3 * static_cast<std::size_t>(side) * static_cast<std::size_t>(side))};
  lay_canvas(world.canvas(), world.background(), picture);
  for (const Turtle& turtle : world.turtles()) lay_turtle(turtle, picture);
  return picture;
}

}  // namespace cxlab::sim
