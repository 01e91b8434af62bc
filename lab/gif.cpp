#include "lab/gif.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

namespace cxlab::lab {
namespace {

using Rgb = std::array<std::uint8_t, 3>;

constexpr std::size_t kMostColours = 255;  // one number is for what does not change
constexpr int kLongestDelay = 65535;       // hundredths of a second

std::uint32_t number_of(const std::uint8_t* pixel) {
  return static_cast<std::uint32_t>(pixel[0]) << 16 | static_cast<std::uint32_t>(pixel[1]) << 8 | pixel[2];
}
Rgb rgb_of(std::uint32_t number) {
  return {static_cast<std::uint8_t>(number >> 16), static_cast<std::uint8_t>(number >> 8),
          static_cast<std::uint8_t>(number)};
}

// --- Colours

/// Pixels whose colours have the same five upper bits in each channel.
struct Cell {
  std::uint16_t key = 0;
  std::uint32_t pixels = 0;
  std::array<std::uint64_t, 3> sums{};
  int channel(std::size_t c) const { return key >> (10 - 5 * c) & 31; }
};
std::uint16_t cell_of(std::uint32_t colour) {
  return static_cast<std::uint16_t>((colour >> 19 & 31) << 10 | (colour >> 11 & 31) << 5 | (colour >> 3 & 31));
}

/// Cells that share a colour.
struct ColourBox {
  std::span<Cell> cells;
  std::size_t widest = 0;   ///< the channel in which they differ most
  std::uint64_t worth = 0;  ///< of being cut
  explicit ColourBox(std::span<Cell> those) : cells(those) {
    std::uint64_t pixels = 0, extent = 0;
    for (const Cell& cell : cells) pixels += cell.pixels;
    for (std::size_t c = 0; c < 3; ++c) {
      const auto [low, high] = std::ranges::minmax(cells, {}, [c](const Cell& cell) { return cell.channel(c); });
      const auto wide = static_cast<std::uint64_t>(high.channel(c) - low.channel(c));
      if (wide > extent) {
        extent = wide;
        widest = c;
      }
    }
    worth = pixels * extent;
  }
  Rgb mean() const {
    std::uint64_t pixels = 0;
    std::array<std::uint64_t, 3> sums{};
    for (const Cell& cell : cells) {
      pixels += cell.pixels;
      for (std::size_t c = 0; c < 3; ++c) sums[c] += cell.sums[c];
    }
    Rgb mean{};
    for (std::size_t c = 0; c < 3; ++c) mean[c] = static_cast<std::uint8_t>(sums[c] / pixels);
    return mean;
  }
};

/// The colours of a frame, and which of them each colour of its pixels becomes: exactly itself where there are few.
class Palette {
 public:
  explicit Palette(std::vector<std::uint32_t> pixels) {
    std::ranges::sort(pixels);
    exact_ = pixels;
    const auto doubles = std::ranges::unique(exact_);
    exact_.erase(doubles.begin(), doubles.end());
    if (exact_.size() <= kMostColours)
      for (const std::uint32_t colour : exact_) colours_.push_back(rgb_of(colour));
    else
      cut(pixels);
  }
  const std::vector<Rgb>& colours() const { return colours_; }
  std::uint8_t index_of(std::uint32_t colour) const {
    if (!index_of_cell_.empty()) return index_of_cell_[cell_of(colour)];
    return static_cast<std::uint8_t>(std::ranges::lower_bound(exact_, colour) - exact_.begin());
  }

 private:
  /// Heckbert's median cut.
  void cut(const std::vector<std::uint32_t>& pixels) {
    std::vector<Cell> all(1 << 15);
    for (const std::uint32_t colour : pixels) {
      Cell& cell = all[cell_of(colour)];
      ++cell.pixels;
      const Rgb rgb = rgb_of(colour);
      for (std::size_t c = 0; c < 3; ++c) cell.sums[c] += rgb[c];
    }
    std::vector<Cell> cells;
    for (std::size_t key = 0; key < all.size(); ++key)
      if (all[key].pixels > 0) {
        all[key].key = static_cast<std::uint16_t>(key);
        cells.push_back(all[key]);
      }
    std::vector<ColourBox> boxes{ColourBox(cells)};
    while (boxes.size() < kMostColours) {
      const auto box = std::ranges::max_element(boxes, {}, &ColourBox::worth);
      if (box->worth == 0) break;
      std::ranges::sort(box->cells, {},
                        [c = box->widest](const Cell& cell) { return std::pair(cell.channel(c), cell.key); });
      std::uint64_t in_box = 0, before = 0;
      for (const Cell& cell : box->cells) in_box += cell.pixels;
      std::size_t half = 0;
      while (half + 1 < box->cells.size() && (half == 0 || 2 * (before + box->cells[half].pixels) <= in_box))
        before += box->cells[half++].pixels;
      const std::span<Cell> upper = box->cells.subspan(half);
      *box = ColourBox(box->cells.first(half));
      boxes.emplace_back(upper);
    }
    index_of_cell_.resize(all.size());
    for (const ColourBox& box : boxes) {
      for (const Cell& cell : box.cells) index_of_cell_[cell.key] = static_cast<std::uint8_t>(colours_.size());
      colours_.push_back(box.mean());
    }
  }

  std::vector<std::uint32_t> exact_;  ///< in order
  std::vector<std::uint8_t> index_of_cell_;
  std::vector<Rgb> colours_;
};

// --- LZW as GIF has it

class CodeWriter {
 public:
  explicit CodeWriter(std::string& out) : out_(out) {}
  void put(int code, int bits) {
    waiting_ |= static_cast<std::uint32_t>(code) << count_;
    for (count_ += bits; count_ >= 8; count_ -= 8, waiting_ >>= 8) byte(static_cast<char>(waiting_ & 0xff));
  }
  void end() {
    if (count_ > 0) byte(static_cast<char>(waiting_ & 0xff));
    flush();
    out_ += '\0';
  }

 private:
  void byte(char value) {
    block_ += value;
    if (block_.size() == 255) flush();
  }
  void flush() {
    if (block_.empty()) return;
    out_ += static_cast<char>(block_.size());
    out_ += block_;
    block_.clear();
  }
  std::string& out_;
  std::string block_;
  std::uint32_t waiting_ = 0;
  int count_ = 0;
};

/// `bits`: of an index.
void put_pixels(std::span<const std::uint8_t> indices, int bits, std::string& out) {
  constexpr int kMostBits = 12, kLastCode = (1 << kMostBits) - 1;
  const int clear = 1 << bits, end = clear + 1;
  std::vector<std::uint16_t> codes;  // by code of what came before and next index; 0: none
  int next = 0, width = 0;
  const auto restart = [&] {
    codes.assign(static_cast<std::size_t>(kLastCode + 1) << 8, 0);
    next = clear + 2;
    width = bits + 1;
  };
  out += static_cast<char>(bits);
  CodeWriter writer(out);
  restart();
  writer.put(clear, width);
  int so_far = indices.front();
  for (const std::uint8_t index : indices.subspan(1)) {
    std::uint16_t& known = codes[static_cast<std::size_t>(so_far) << 8 | index];
    if (known != 0) {
      so_far = known;
      continue;
    }
    writer.put(so_far, width);
    so_far = index;
    if (next == kLastCode) {
      writer.put(clear, width);
      restart();
      continue;
    }
    known = static_cast<std::uint16_t>(next);
    if (next == 1 << width) ++width;
    ++next;
  }
  writer.put(so_far, width);
  if (next == 1 << width && width < kMostBits) ++width;
  writer.put(end, width);
  writer.end();
}

/// A rectangle of pixels; right and bottom are behind it.
struct Part {
  int left, top, right = 0, bottom = 0;
  bool empty() const { return right == 0; }
};

/// What of a picture differs from another one.
Part difference(const sim::Picture& a, const sim::Picture& b) {
  Part part{a.width, a.height};
  for (int y = 0; y < a.height; ++y) {
    const auto row = 3 * static_cast<std::ptrdiff_t>(y) * a.width;
    const auto *p = a.rgb.data() + row, *q = b.rgb.data() + row;
    if (std::equal(p, p + 3 * a.width, q)) continue;
    part.top = std::min(part.top, y);
    part.bottom = y + 1;
    int x = 0;
    while (number_of(p + 3 * x) == number_of(q + 3 * x)) ++x;
    part.left = std::min(part.left, x);
    x = a.width;
    while (number_of(p + 3 * (x - 1)) == number_of(q + 3 * (x - 1))) --x;
    part.right = std::max(part.right, x);
  }
  return part;
}

}  // namespace

GifEncoder::GifEncoder(int width, int height) : width_(width), height_(height) {
  bytes_ = "GIF89a";
  put_number(width);
  put_number(height);
  bytes_ += std::string("\x70\0\0", 3);                                // no colours for all frames
  bytes_ += std::string("\x21\xff\x0bNETSCAPE2.0\x03\x01\0\0\0", 19);  // again and again
}

void GifEncoder::put_number(int number) {
  bytes_ += static_cast<char>(number & 0xff);
  bytes_ += static_cast<char>(number >> 8 & 0xff);
}

void GifEncoder::begin_frame(int hundredths) {
  bytes_ += std::string("\x21\xf9\x04\x05", 4);  // stays where the next is transparent; has a transparent index
  delay_at_ = bytes_.size();
  put_number(delay_ = hundredths);
  bytes_ += std::string("\0\0", 2);  // the transparent index is 0
}

void GifEncoder::lengthen_last_frame(int hundredths) {
  delay_ = std::min(delay_ + hundredths, kLongestDelay);
  bytes_[delay_at_] = static_cast<char>(delay_ & 0xff);
  bytes_[delay_at_ + 1] = static_cast<char>(delay_ >> 8 & 0xff);
}

void GifEncoder::add(const sim::Picture& picture, int hundredths) {
  const bool first = last_.rgb.empty();
  const Part part = first ? Part{0, 0, width_, height_} : difference(picture, last_);
  if (part.empty()) return lengthen_last_frame(hundredths);
  hundredths = std::min(hundredths, kLongestDelay);

  const auto each = [&](auto visit) {
    for (int y = part.top; y < part.bottom; ++y)
      for (int x = part.left; x < part.right; ++x) {
        const std::size_t at =
            3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x));
        const std::uint32_t colour = number_of(picture.rgb.data() + at);
        visit(colour, first || colour != number_of(last_.rgb.data() + at));
      }
  };
  std::vector<std::uint32_t> changed;
  each([&](std::uint32_t colour, bool is_new) {
    if (is_new) changed.push_back(colour);
  });
  const Palette palette(std::move(changed));
  std::vector<std::uint8_t> indices;
  each([&](std::uint32_t colour, bool is_new) {
    indices.push_back(is_new ? static_cast<std::uint8_t>(palette.index_of(colour) + 1) : 0);
  });

  int bits = 2;
  while (std::size_t{1} << bits < palette.colours().size() + 1) ++bits;
  begin_frame(hundredths);
  bytes_ += '\x2c';
  for (const int number : {part.left, part.top, part.right - part.left, part.bottom - part.top}) put_number(number);
  bytes_ += static_cast<char>(0x80 | (bits - 1));  // its own colours follow
  for (std::size_t i = 0; i < std::size_t{1} << bits; ++i) {
    const Rgb colour = i == 0 || i > palette.colours().size() ? Rgb{} : palette.colours()[i - 1];
    bytes_.append(colour.begin(), colour.end());
  }
  put_pixels(indices, bits, bytes_);
  last_ = picture;
}

std::string GifEncoder::take() {
  bytes_ += '\x3b';
  return std::move(bytes_);
}

}  // namespace cxlab::lab
