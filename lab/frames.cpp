#include "lab/frames.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <sstream>

#include "cx/base/number_text.h"
#include "sim/mujoco/font.h"

namespace cxlab::lab {
namespace {

using Colour = sim::ColouredText::Colour;

constexpr int kGap = 2;                // px between tiles
constexpr int kFirst = 5, kOther = 3;  // share of the first tile or row, and of each other one
constexpr double kTileShape = 1.6;     // width to height: tiles come as near to it as their number allows
constexpr int kLargePicture = 1000;    // px high, from which texts are larger
constexpr int kMargin = 4;             // px around the caption's lines
constexpr int kWordGap = 14;           // px between words of the caption
constexpr int kCaptionLines = 2;
constexpr double kFresh = 30;  // s: an event that is not older is bright
constexpr Colour kBackground{0.07f, 0.08f, 0.10f}, kPlain{1, 1, 1}, kFaded{0.62f, 0.65f, 0.70f}, kBad{1, 0.60f, 0.45f};

/// Whether a kind of event is about something that went wrong.
bool is_bad(const PageEvent& event) {
  constexpr std::string_view kBadKinds[]{"error", "fault", "failed", "broken", "lost"};
  return std::ranges::find(kBadKinds, event.kind) != std::end(kBadKinds);
}

/// "5:12".
std::string clock_of(double seconds) {
  const auto whole = static_cast<long long>(std::floor(seconds + 1e-9));
  return std::to_string(whole / 60) + (whole % 60 < 10 ? ":0" : ":") + std::to_string(whole % 60);
}

std::string text_of_event(const PageEvent& event) {
  std::string text = clock_of(event.t) + ' ' + event.who;
  if (!event.who.empty()) text += ' ';
  text += event.text;
  if (!event.reason.empty()) text += ": " + event.reason;
  return text;
}

/// Copies a picture into the middle of a rectangle of another one.
void paste(const sim::Picture& from, int left, int top, int width, int height, sim::Picture& to) {
  const int columns = std::min(from.width, width), rows = std::min(from.height, height);
  const int x = left + (width - columns) / 2, y = top + (height - rows) / 2;
  for (int row = 0; row < rows; ++row)
    std::memcpy(to.rgb.data() + 3 * (static_cast<std::size_t>(y + row) * static_cast<std::size_t>(to.width) +
                                     static_cast<std::size_t>(x)),
                from.rgb.data() + 3 * static_cast<std::size_t>(row) * static_cast<std::size_t>(from.width),
                3 * static_cast<std::size_t>(columns));
}

}  // namespace

Frames::Frames(const FrameOptions& options) : options_(options) {}
Frames::~Frames() = default;

std::vector<std::string> camera_names(const std::string& text) {
  std::vector<std::string> names;
  std::istringstream words(text);
  for (std::string word; std::getline(words, word, ',');)
    if (!word.empty()) names.push_back(word);
  return names;
}

std::vector<std::array<int, 4>> tile_places(std::size_t count, int width, int height) {
  const int tiles = static_cast<int>(count);
  int columns = 1;
  double best = 1e9;
  for (int tried = 1; tried <= tiles; ++tried) {
    const int rows = (tiles + tried - 1) / tried;
    const double shape = (static_cast<double>(width) / tried) / (static_cast<double>(height) / rows);
    if (const double off = std::abs(std::log(shape / kTileShape)); off < best) {
      best = off;
      columns = tried;
    }
  }
  const int rows = (tiles + columns - 1) / columns;
  // Edges of parts with gaps between them: equal ones, or the first larger than the others.
  const auto edge = [](int length, int parts, int k, bool equal) {
    const int first = equal ? kOther : kFirst, whole = first + (parts - 1) * kOther;
    return k == 0 ? 0 : (length + kGap) * (first + (k - 1) * kOther) / whole;
  };
  std::vector<std::array<int, 4>> places;
  for (int row = 0; row < rows; ++row) {
    const int in_row = row == 0 ? tiles - columns * (rows - 1) : columns;
    const int top = edge(height, rows, row, false), bottom = edge(height, rows, row + 1, false) - kGap;
    for (int k = 0; k < in_row; ++k) {
      const int left = edge(width, in_row, k, rows > 1), right = edge(width, in_row, k + 1, rows > 1) - kGap;
      places.push_back({left, top, right - left, bottom - top});
    }
  }
  return places;
}

Expected<std::unique_ptr<Frames>> Frames::create(const ViewMaker& make, const FrameOptions& options) {
  std::unique_ptr<Frames> frames(new Frames(options));
  if (Status s = frames->open(make); !s) return s.error();
  return frames;
}

Expected<View*> Frames::view_of(const ViewMaker& make, int width, int height) {
  if (const auto known = std::ranges::find(sizes_, std::pair(width, height)); known != sizes_.end())
    return views_[static_cast<std::size_t>(known - sizes_.begin())].get();
  auto view = make(width, height);
  if (!view) return view.error();
  sizes_.emplace_back(width, height);
  views_.push_back(*std::move(view));
  return views_.back().get();
}

Status Frames::open(const ViewMaker& make) {
  const int width = options_.width;
  caption_top_ = options_.height;
  if (options_.caption) {
    auto whole = view_of(make, width, options_.height);
    if (!whole) return whole.error();
    if (!(*whole)->headline().empty() || (options_.events && options_.events->told_by_world())) {
      auto font = sim::Font::load(options_.height >= kLargePicture);
      if (!font) return font.error();
      const int lines = kCaptionLines * font->height() + 2 * kMargin;
      if (4 * lines <= options_.height) {  // else the picture would be all caption
        font_ = std::make_unique<sim::Font>(*std::move(font));
        caption_top_ -= lines;
        views_.clear();
        sizes_.clear();
      }
    }
  }
  for (const auto& [left, top, w, h] : tile_places(options_.cameras, width, caption_top_)) {
    auto view = view_of(make, w, h);
    if (!view) return view.error();
    tiles_.push_back({left, top, w, h, *view});
  }
  return {};
}

Expected<const sim::Picture*> Frames::draw(std::span<const std::string> cameras, SimTime now) {
  for (const auto& view : views_) view->set_time(now);
  const bool alone = cameras.size() == 1 && !font_;
  if (!alone && picture_.rgb.empty()) {
    picture_ = {options_.width, options_.height, {}};
    picture_.rgb.resize(3 * static_cast<std::size_t>(options_.width) * static_cast<std::size_t>(options_.height));
    sim::fill(picture_, 0, 0, picture_.width, picture_.height, kBackground);
  }
  if (font_) sim::fill(picture_, 0, caption_top_, picture_.width, picture_.height, kBackground);
  for (std::size_t i = 0; i < tiles_.size() && i < cameras.size(); ++i) {
    const Tile& tile = tiles_[i];
    auto picture = tile.view->draw(cameras[i]);
    if (!picture || alone) return picture;
    paste(**picture, tile.left, tile.top, tile.width, tile.height, picture_);
  }
  if (font_) write_caption(now);
  return &picture_;
}

void Frames::write_caption(SimTime now) {
  const double t = to_seconds(now);
  const int right = picture_.width - kMargin;
  int left = kMargin, top = caption_top_ + kMargin;
  const auto write = [&](const sim::ColouredText& words) {
    const std::string shown = font_->fitted(words.text, right - left);
    font_->write(picture_, left, top, {shown, words.colour});
    left += font_->width(shown) + kWordGap;
  };
  const auto headline = tiles_.front().view->headline();
  // The time of the run, where the world's own clock shows another one.
  if (headline.empty() || !headline.front().text.starts_with(clock_of(t) + ' ')) write({clock_of(t), kFaded});
  for (const sim::ColouredText& words : headline) write(words);
  if (!options_.events) return;
  constexpr std::size_t kMost = 8;
  for (const PageEvent& event : options_.events->last(t, kMost)) {
    const std::string text = text_of_event(event);
    const bool fits = left + font_->width(text) <= right;
    if (!fits && left > kMargin) {
      left = kMargin;
      top += font_->height();
      if (top + font_->height() > picture_.height) return;
    }
    write({text, t - event.t > kFresh ? kFaded : is_bad(event) ? kBad : kPlain});
  }
}

}  // namespace cxlab::lab
