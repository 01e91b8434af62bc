#include "lab/film_writer.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <fstream>
#include <optional>
#include <string_view>
#include <vector>

#include "cx/base/number_text.h"
#include "cx/base/process.h"
#include "lab/gif.h"

namespace cxlab::lab {
namespace {

constexpr std::array<std::string_view, 5> kOfFfmpeg{".mp4", ".mkv", ".mov", ".avi", ".webm"};

Error film_error(const std::string& film) { return resource_error("the film cannot be written", film); }

// --- ffmpeg

class FfmpegFilm final : public FilmWriter {
 public:
  static Expected<std::unique_ptr<FilmWriter>> start(const FilmFormat& format, const std::filesystem::path& part,
                                                     const std::string& film) {
    const std::string size = std::to_string(format.width) + 'x' + std::to_string(format.height);
    // H.264 has colours for squares of two pixels. "file:": a name is not read as a protocol.
    ProcessOptions ffmpeg{.argv = {"ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s",
                                   size, "-r", general_text(format.rate, 6), "-i", "-", "-vf",
                                   "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p", "file:" + part.string()}};
    ffmpeg.in = Stream::pipe();
    auto started = Process::start(ffmpeg);
    if (!started) return started.error();
    return std::unique_ptr<FilmWriter>(new FfmpegFilm(*std::move(started), film));
  }

  Status put(const sim::Picture& picture) override {
    return ffmpeg_.write({reinterpret_cast<const char*>(picture.rgb.data()), picture.rgb.size()})
               ? Status()
               : Status(film_error(film_));
  }
  Expected<std::string> finish() override {
    ffmpeg_.close_input();
    if (ffmpeg_.wait() != 0) return film_error(film_);
    return std::string();
  }

 private:
  FfmpegFilm(Process ffmpeg, std::string film) : ffmpeg_(std::move(ffmpeg)), film_(std::move(film)) {}
  Process ffmpeg_;
  std::string film_;
};

// --- An animated image

/// Frames one after the other, as what differs from the one before. Those that repeat the one before cost nothing.
class FrameStore {
 public:
  /// Frame `number`; numbers grow.
  void put(std::int64_t number, const sim::Picture& picture) {
    if (last_.rgb.empty())
      last_ = {picture.width, picture.height, std::vector<std::uint8_t>(picture.rgb.size())};
    else if (picture.rgb == last_.rgb)
      return;
    std::vector<std::uint8_t> change(picture.rgb.size());
    for (std::size_t i = 0; i < change.size(); ++i) change[i] = picture.rgb[i] ^ last_.rgb[i];
    uLongf size = compressBound(change.size());
    std::string packed(size, '\0');
    // Fails only without memory, or called wrongly.
    if (compress2(reinterpret_cast<Bytef*>(packed.data()), &size, change.data(), change.size(), 1) != Z_OK) return;
    packed.resize(size);
    packed.shrink_to_fit();
    bytes_ += size;
    changes_.push_back({number, std::move(packed)});
    last_.rgb = picture.rgb;
  }
  std::size_t bytes() const { return bytes_; }

  /// Calls with each frame that differs from the one before, and its number, until that returns false.
  template <class Visit>
  void each(Visit visit) const {
    sim::Picture picture{last_.width, last_.height, std::vector<std::uint8_t>(last_.rgb.size())};
    std::vector<std::uint8_t> change(picture.rgb.size());
    for (const auto& [number, packed] : changes_) {
      uLongf size = change.size();
      uncompress(change.data(), &size, reinterpret_cast<const Bytef*>(packed.data()), packed.size());
      for (std::size_t i = 0; i < change.size(); ++i) picture.rgb[i] ^= change[i];
      if (!visit(number, picture)) return;
    }
  }

 private:
  struct Change {
    std::int64_t number;
    std::string packed;
  };
  std::vector<Change> changes_;
  sim::Picture last_;
  std::size_t bytes_ = 0;
};

/// `length` pixels become `to` of them: which pixels make up pixel `k`, and how much of each.
struct Shrinking {
  int length, to;
  template <class Visit>
  void each(int k, Visit visit) const {
    for (int i = k * length / to; i < length && i * to < (k + 1) * length; ++i) {
      const int part = std::min((i + 1) * to, (k + 1) * length) - std::max(i * to, k * length);
      if (part > 0) visit(i, part);
    }
  }
};

sim::Picture shrunk(const sim::Picture& from, int width, int height) {
  sim::Picture out{width, height, {}};
  out.rgb.reserve(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  const Shrinking across{from.width, width}, down{from.height, height};
  const std::int64_t whole = static_cast<std::int64_t>(from.width) * from.height;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      std::array<std::int64_t, 3> sums{};
      down.each(y, [&](int row, int high) {
        across.each(x, [&](int column, int wide) {
          const std::uint8_t* pixel =
              from.rgb.data() + 3 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(from.width) +
                                     static_cast<std::size_t>(column));
          for (std::size_t c = 0; c < 3; ++c) sums[c] += std::int64_t{high} * wide * pixel[c];
        });
      });
      for (const std::int64_t sum : sums) out.rgb.push_back(static_cast<std::uint8_t>((sum + whole / 2) / whole));
    }
  return out;
}

/// How frames are thinned until the film fits: every `step`-th frame stays, with `percent` of its width and height.
struct Fitting {
  int step = 1, percent = 100;
};
constexpr Fitting kFittings[]{{1, 100}, {2, 100}, {2, 75}, {2, 60},  {4, 60},
                              {4, 45},  {8, 45},  {8, 30}, {16, 30}, {32, 20}};

class GifFilm final : public FilmWriter {
 public:
  static Expected<std::unique_ptr<FilmWriter>> start(const FilmFormat& format, const std::filesystem::path& part,
                                                     const std::string& film) {
    // It is opened now: later this process may have no right to.
    std::unique_ptr<GifFilm> made(new GifFilm(format, part, film));
    if (!made->file_) return film_error(film);
    return std::unique_ptr<FilmWriter>(std::move(made));
  }

  Status put(const sim::Picture& picture) override {
    if (frames_ % step_ == 0) store_.put(frames_, picture);
    ++frames_;
    // Far too many for a file of that size: half of them are enough.
    if (store_.bytes() > kMuchMore * format_.most_bytes) thin_out();
    return {};
  }

  Expected<std::string> finish() override {
    const std::string_view last_words =
        "--speed, a smaller --size or a shorter stretch (--from, --to) makes it smaller";
    for (const Fitting& fitting : kFittings) {
      const auto bytes = encoded(fitting);
      if (!bytes) continue;
      file_.write(bytes->data(), static_cast<std::streamsize>(bytes->size()));
      file_.close();
      if (!file_) return film_error(film_);
      return remark(fitting, bytes->size());
    }
    return resource_error("the animated image does not fit into " + megabytes(format_.most_bytes) +
                              ", whatever is left out: " + std::string(last_words),
                          film_);
  }

 private:
  static constexpr std::size_t kMuchMore = 16;

  GifFilm(const FilmFormat& format, const std::filesystem::path& part, std::string film)
      : format_(format), film_(std::move(film)), file_(part, std::ios::binary) {}

  static std::string megabytes(std::size_t bytes) { return fixed_text(static_cast<double>(bytes) / 1e6, 2) + " MB"; }
  int side(int pixels, const Fitting& fitting) const { return std::max(1, pixels * fitting.percent / 100); }

  void thin_out() {
    step_ *= 2;
    FrameStore fewer;
    const sim::Picture* shown = nullptr;
    std::int64_t due = 0;
    sim::Picture before;
    store_.each([&](std::int64_t number, const sim::Picture& picture) {
      for (; shown && due < number; due += step_) fewer.put(due, before);
      before = picture;
      shown = &before;
      return true;
    });
    for (; shown && due < frames_; due += step_) fewer.put(due, before);
    store_ = std::move(fewer);
  }

  /// Hundredths of a second at which a frame begins.
  std::int64_t begin_of(std::int64_t frame) const {
    return std::llround(100 * static_cast<double>(frame) / format_.rate);
  }

  /// Nothing if it is too large.
  std::optional<std::string> encoded(const Fitting& fitting) const {
    const std::int64_t step = std::int64_t{step_} * fitting.step;
    const int width = side(format_.width, fitting), height = side(format_.height, fitting);
    GifEncoder gif(width, height);
    sim::Picture shown;  // from `due` on
    std::int64_t due = 0;
    const auto show_until = [&](std::int64_t frame) {
      if (due >= frame || shown.rgb.empty()) return;
      const std::int64_t end = (frame + step - 1) / step * step;
      const bool whole = shown.width == width && shown.height == height;
      gif.add(whole ? shown : shrunk(shown, width, height),
              static_cast<int>(begin_of(std::min(end, frames_)) - begin_of(due)));
      due = end;
    };
    store_.each([&](std::int64_t number, const sim::Picture& picture) {
      show_until(number);
      shown = picture;
      return gif.size() < format_.most_bytes;
    });
    show_until(frames_);
    std::string bytes = gif.take();
    if (bytes.size() > format_.most_bytes) return std::nullopt;
    return bytes;
  }

  std::string remark(const Fitting& fitting, std::size_t bytes) const {
    std::string text;
    const int step = step_ * fitting.step;
    if (step > 1)
      text = general_text(format_.rate / step, 3) + " frames a second instead of " + general_text(format_.rate, 3);
    const auto size = [](int width, int height) { return std::to_string(width) + 'x' + std::to_string(height); };
    if (fitting.percent < 100)
      text += (text.empty() ? "" : " and ") + size(side(format_.width, fitting), side(format_.height, fitting)) +
              " instead of " + size(format_.width, format_.height);
    if (text.empty()) return text;
    return film_ + ": " + megabytes(bytes) + " with " + text + ", to stay below " + megabytes(format_.most_bytes);
  }

  FilmFormat format_;
  std::string film_;
  std::ofstream file_;
  FrameStore store_;
  std::int64_t frames_ = 0;
  int step_ = 1;  ///< only each `step_`-th frame is kept
};

}  // namespace

FilmKind film_kind(const std::string& file) {
  std::string ending = std::filesystem::path(file).extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return std::tolower(c); });
  if (ending == ".gif") return FilmKind::kGif;
  return std::ranges::find(kOfFfmpeg, ending) != kOfFfmpeg.end() ? FilmKind::kFfmpeg : FilmKind::kNone;
}

std::string film_endings() {
  std::string text;
  for (const std::string_view ending : kOfFfmpeg) (text += ending) += ", ";
  return text.substr(0, text.size() - 2) + " or .gif";
}

Expected<std::unique_ptr<FilmWriter>> film_writer(FilmKind kind, const FilmFormat& format,
                                                  const std::filesystem::path& part, const std::string& film) {
  return kind == FilmKind::kGif ? GifFilm::start(format, part, film) : FfmpegFilm::start(format, part, film);
}

}  // namespace cxlab::lab
