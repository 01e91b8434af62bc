#include "lab/video.h"

#include <unistd.h>

#include <fstream>
#include <tuple>

#include "cx/base/file.h"
#include "cx/base/number_text.h"
#include "cx/base/process.h"

namespace cxlab::lab {
namespace {

constexpr double kSame = 1e-9;     // s: times closer than that are one
constexpr double kMostOfGif = 50;  // frames a second: faster ones are shown slowly by browsers

Error cannot_write(const std::string& file) { return resource_error("the film cannot be written", file); }

/// A film, links followed, and the name beside it that it has until it is whole.
std::pair<std::filesystem::path, std::filesystem::path> names_of(const std::string& file) {
  std::error_code error;
  std::filesystem::path film = std::filesystem::weakly_canonical(std::filesystem::absolute(file), error);
  if (error) film = std::filesystem::absolute(file);
  const std::string part = film.stem().string() + '.' + std::to_string(getpid()) + ".part" + film.extension().string();
  return {film, film.parent_path() / part};
}

/// What can be said of a film before anything is drawn.
Status check_kind(const VideoOptions& options) {
  const FilmKind kind = film_kind(options.file);
  if (kind == FilmKind::kNone)
    return usage_error("--video: " + found_text(options.file, "a name that ends in " + film_endings()));
  if (kind == FilmKind::kGif && options.frame_rate > kMostOfGif)
    return usage_error("the frame rate is " + general_text(options.frame_rate, 6) +
                       ", expected at most 50 for an animated image");
  if (kind == FilmKind::kFfmpeg && options.most_bytes > 0)
    return usage_error("--video: found '" + options.file +
                       "' with a largest size, which only an animated image (.gif) can have");
  return {};
}

/// The file can be written, by what writes it.
Status check_file(const VideoOptions& options) {
  if (film_kind(options.file) == FilmKind::kFfmpeg && !is_on_path("ffmpeg"))
    return resource_error(
        "no pictures: --video needs ffmpeg: apt-get install ffmpeg, or a name that ends in .gif, which needs nothing");
  const auto [file, part] = names_of(options.file);
  std::error_code ignored;
  if (Status s = make_folder_of(file); !s) return s;
  const bool there = path_exists(file);
  if (there && (!is_file(file) || access(file.c_str(), W_OK) != 0)) return cannot_write(options.file);
  if (!std::ofstream(part)) return cannot_write(options.file);
  std::filesystem::remove(part, ignored);
  return {};
}

/// H.264 has colours for squares of two pixels.
int even(int side) { return (side + 1) / 2 * 2; }
std::string size_text(int width, int height) { return std::to_string(width) + 'x' + std::to_string(height); }

}  // namespace

VideoOptions VideoOptions::complete() const {
  VideoOptions out = *this;
  const bool gif = film_kind(file) == FilmKind::kGif;
  if (width == 0 || height == 0) std::tie(out.width, out.height) = gif ? std::pair(640, 400) : std::pair(960, 600);
  if (frame_rate == 0) out.frame_rate = gif ? 10 : 25;
  if (most_bytes == 0) out.most_bytes = FilmFormat().most_bytes;
  return out;
}

Expected<std::unique_ptr<Video>> Video::prepare(const VideoOptions& options, const ViewMaker& make,
                                                const Happenings* events, double from) {
  if (Status s = check_kind(options); !s) return s.error();
  VideoOptions whole = options.complete();
  auto frames = Frames::create(make, {.width = whole.width,
                                      .height = whole.height,
                                      .cameras = std::max<std::size_t>(whole.cameras.size(), 1),
                                      .caption = whole.caption,
                                      .events = events});
  if (!frames) return frames.error();
  if (whole.cameras.empty()) whole.cameras = {(*frames)->cameras().front()};
  std::unique_ptr<Video> video(new Video(std::move(whole), *std::move(frames), from));
  if (const auto first = video->frames_->draw(video->options_.cameras, from_seconds(from)); !first)
    return first.error();
  if (Status s = check_file(options); !s) return s.error();
  return video;
}

Status Video::check(const VideoOptions& options, const ViewMaker& make) {
  const auto video = prepare(options, make, nullptr, 0);
  return video ? Status() : Status(video.error());
}

Expected<std::unique_ptr<Video>> Video::create(const VideoOptions& options, const ViewMaker& make, const Host& host,
                                               const Happenings* events, double from) {
  auto video = prepare(options, make, events, from);
  if (!video) return video.error();
  const auto first = (*video)->frames_->draw((*video)->options_.cameras, from_seconds(from));
  if (!first) return first.error();
  const int width = even((*first)->width), height = even((*first)->height);
  if (film_kind(options.file) == FilmKind::kFfmpeg && (width != (*first)->width || height != (*first)->height))
    host.note("the film is " + size_text(width, height) + ": its sides must be even, so it has a black edge");
  if (Status s = (*video)->start(**first); !s) return s.error();
  return video;
}

Status Video::start(const sim::Picture& first) {
  std::tie(file_, part_) = names_of(options_.file);
  auto keeper = Servant::start(
      [file = file_, part = part_](const std::string&, const auto&) {
        std::error_code error;
        if (path_exists(part)) std::filesystem::rename(part, file, error);
        return Servant::Answer{error ? error.message() : ""};
      },
      [part = part_] {
        std::error_code ignored;
        std::filesystem::remove(part, ignored);
      });
  if (!keeper) return keeper.error();
  keeper_ = std::make_unique<Servant>(*std::move(keeper));
  auto writer =
      film_writer(film_kind(options_.file), {first.width, first.height, options_.frame_rate, options_.most_bytes},
                  part_, options_.file);
  if (!writer) return writer.error();
  writer_ = *std::move(writer);
  return {};
}

double Video::next() const { return from_ + static_cast<double>(written_) * options_.speed / options_.frame_rate; }

Status Video::look(SimTime now, SimTime next_tick) {
  const double last = to_seconds(now) + kSame, before = to_seconds(next_tick) - kSame;
  while (next() <= last || next() < before) {
    auto picture = frames_->draw(options_.cameras, from_seconds(next()));
    if (!picture) return picture.error();
    if (Status s = writer_->put(**picture); !s) return s;
    ++written_;
  }
  return {};
}

Status Video::finish(const Host& host) {
  const auto remark = writer_->finish();
  if (!remark) return remark.error();
  if (!remark->empty()) host.note(*remark);
  const auto kept = keeper_->ask("whole");
  return kept && kept->text.empty() ? Status() : cannot_write(options_.file);
}

}  // namespace cxlab::lab
