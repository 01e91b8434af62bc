#include "sim/mujoco/font.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <mujoco/mujoco.h>

#include "sim/mujoco/factory_model.h"
#include "sim/mujoco/gl_context.h"

namespace cxlab::sim {
namespace {

constexpr int kCell = 128;  // px, both ways: larger than any letter

std::uint8_t byte_of(float part) { return static_cast<std::uint8_t>(std::lround(255 * std::clamp(part, 0.0f, 1.0f))); }

/// Bytes of the character that begins there; what is no UTF-8 is a character of one byte.
std::size_t length_of_character(std::string_view text, std::size_t at) {
  const auto byte = static_cast<unsigned char>(text[at]);
  const std::size_t wanted = byte >= 0xf0 ? 4 : byte >= 0xe0 ? 3 : byte >= 0xc0 ? 2 : 1;
  std::size_t length = 1;
  while (length < wanted && at + length < text.size() && (static_cast<unsigned char>(text[at + length]) & 0xc0) == 0x80)
    ++length;
  return length;
}

}  // namespace

Expected<Font> Font::load(bool large) {
  auto context = GlContext::create(kCell, kCell);
  if (!context) return context.error();
  if (!(*context)->make_current()) return resource_error("OpenGL context was lost").with_code("no_opengl");
  // An empty world, for a buffer to draw in.
  const std::unique_ptr<mjSpec, void (*)(mjSpec*)> spec(mj_makeSpec(), mj_deleteSpec);
  const std::unique_ptr<mjModel, MjDeleter> model(mj_compile(spec.get(), nullptr));
  if (!model) return resource_error(mjs_getError(spec.get())).with_code("no_opengl");
  model->vis.global.offwidth = model->vis.global.offheight = kCell;
  model->vis.quality.shadowsize = 0;
  mjrContext gl;
  mjr_defaultContext(&gl);
  mjr_makeContext(model.get(), &gl, large ? mjFONTSCALE_150 : mjFONTSCALE_50);
  mjr_setBuffer(mjFB_OFFSCREEN, &gl);
  Font font;
  font.height_ = std::min(gl.charHeight, kCell);
  for (char c = kFirst; c <= kLast; ++c) {
    Glyph& glyph = font.glyphs_[static_cast<std::size_t>(c - kFirst)];
    glyph.width = std::min(gl.charWidth[static_cast<int>(c)], kCell);
    const mjrRect cell{0, 0, glyph.width, font.height_};
    const char text[] = {c, '\0'};
    mjr_label(cell, mjFONT_NORMAL, text, 0, 0, 0, 1, 1, 1, 1, &gl);
    std::vector<std::uint8_t> rgb(3 * static_cast<std::size_t>(glyph.width * font.height_));
    mjr_readPixels(rgb.data(), nullptr, cell, &gl);
    for (int y = font.height_ - 1; y >= 0; --y)
      for (int x = 0; x < glyph.width; ++x) glyph.ink.push_back(rgb[3 * static_cast<std::size_t>(y * glyph.width + x)]);
  }
  mjr_freeContext(&gl);
  return font;
}

template <class Visit>
void Font::each(std::string_view text, Visit visit) const {
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at] >= kFirst && text[at] <= kLast ? text[at] : '?';
    at += length_of_character(text, at);
    visit(glyphs_[static_cast<std::size_t>(c - kFirst)], at);
  }
}

int Font::width(std::string_view text) const {
  int width = 0;
  each(text, [&](const Glyph& glyph, std::size_t) { width += glyph.width; });
  return width;
}

std::string Font::fitted(std::string_view text, int most) const {
  if (width(text) <= most) return std::string(text);
  constexpr std::string_view kDots = "...";
  const int room = most - width(kDots);
  if (room < 0) return {};
  int used = 0;
  std::size_t kept = 0;
  each(text, [&](const Glyph& glyph, std::size_t end) {
    used += glyph.width;
    if (used <= room) kept = end;
  });
  return std::string(text.substr(0, kept)).append(kDots);
}

void Font::write(Picture& picture, int left, int top, const ColouredText& text) const {
  each(text.text, [&](const Glyph& glyph, std::size_t) {
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < glyph.width; ++x) {
        const int ink = glyph.ink[static_cast<std::size_t>(y * glyph.width + x)];
        if (ink == 0 || left + x < 0 || left + x >= picture.width || top + y < 0 || top + y >= picture.height) continue;
        std::uint8_t* pixel = picture.rgb.data() + 3 * static_cast<std::size_t>((top + y) * picture.width + left + x);
        for (std::size_t channel = 0; channel < 3; ++channel)
          pixel[channel] =
              static_cast<std::uint8_t>(pixel[channel] + (byte_of(text.colour[channel]) - pixel[channel]) * ink / 255);
      }
    left += glyph.width;
  });
}

void fill(Picture& picture, int left, int top, int width, int height, const ColouredText::Colour& colour) {
  const int right = std::min(left + width, picture.width), bottom = std::min(top + height, picture.height);
  const std::uint8_t rgb[] = {byte_of(colour[0]), byte_of(colour[1]), byte_of(colour[2])};
  for (int y = std::max(top, 0); y < bottom; ++y)
    for (int x = std::max(left, 0); x < right; ++x)
      std::copy_n(rgb, 3, picture.rgb.begin() + 3 * (std::ptrdiff_t{y} * picture.width + x));
}

}  // namespace cxlab::sim
