#include "lab/video.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <tuple>

#include "cx/base/file.h"

namespace cxlab::lab {
namespace {

constexpr double kFramesPerSecond = 25;  // of the film
constexpr double kSame = 1e-9;           // s: times closer than that are one

Error cannot_write(const std::string& file) { return resource_error("the film cannot be written", file); }

/// ffmpeg takes the kind of a film from its name.
Status check_name(const std::string& file) {
  std::string suffix = std::filesystem::path(file).extension().string();
  std::ranges::transform(suffix, suffix.begin(), [](unsigned char c) { return std::tolower(c); });
  constexpr std::string_view kKinds[]{".mp4", ".mkv", ".mov", ".avi", ".webm"};
  if (std::ranges::find(kKinds, suffix) != std::end(kKinds)) return {};
  return usage_error("--video: found '" + file + "', expected a name that ends in .mp4, .mkv, .mov, .avi or .webm");
}

/// A film, links followed, and the name beside it that it has until it is whole.
std::pair<std::filesystem::path, std::filesystem::path> names_of(const std::string& file) {
  std::error_code error;
  std::filesystem::path film = std::filesystem::weakly_canonical(std::filesystem::absolute(file), error);
  if (error) film = std::filesystem::absolute(file);
  const std::string part = film.stem().string() + '.' + std::to_string(getpid()) + ".part" + film.extension().string();
  return {film, film.parent_path() / part};
}

/// H.264 has colours for squares of two pixels.
int even(int side) { return (side + 1) / 2 * 2; }
std::string size_text(int width, int height) { return std::to_string(width) + 'x' + std::to_string(height); }

}  // namespace

Status Video::check(const VideoOptions& options, View& view) {
  if (Status s = check_name(options.file); !s) return s;
  if (const auto first = view.draw(options.camera.empty() ? view.cameras().front() : options.camera); !first)
    return first.error();
  if (!is_on_path("ffmpeg")) return resource_error("no pictures: --video needs ffmpeg: apt-get install ffmpeg");
  const auto [file, part] = names_of(options.file);
  std::error_code ignored;
  if (Status s = make_folder_of(file); !s) return s;
  const bool there = path_exists(file);
  if (there && (!is_file(file) || access(file.c_str(), W_OK) != 0)) return cannot_write(options.file);
  if (!std::ofstream(part)) return cannot_write(options.file);
  std::filesystem::remove(part, ignored);
  return {};
}

Expected<std::unique_ptr<Video>> Video::create(const VideoOptions& options, std::unique_ptr<View> view,
                                               const Host& host, double from) {
  if (Status s = check(options, *view); !s) return s.error();
  std::unique_ptr<Video> video(new Video(options, std::move(view), from));
  if (video->options_.camera.empty()) video->options_.camera = video->view_->cameras().front();
  auto first = video->view_->draw(video->options_.camera);
  if (!first) return first.error();
  const int width = even((*first)->width), height = even((*first)->height);
  if (width != (*first)->width || height != (*first)->height)
    host.note("the film is " + size_text(width, height) + ": its sides must be even, so it has a black edge");
  if (Status s = video->start(**first); !s) return s.error();
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
  const std::string size = size_text(first.width, first.height);
  const std::string rate = std::to_string(static_cast<int>(kFramesPerSecond));
  // "file:": a name is not read as a protocol.
  ProcessOptions ffmpeg{.argv = {"ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s",
                                 size, "-r", rate, "-i", "-", "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt",
                                 "yuv420p", "file:" + part_.string()}};
  ffmpeg.in = Stream::pipe();
  auto started = Process::start(ffmpeg);
  if (!started) return started.error();
  ffmpeg_ = std::make_unique<Process>(*std::move(started));
  return {};
}

double Video::next() const { return from_ + static_cast<double>(frames_) * options_.speed / kFramesPerSecond; }

Status Video::look(double now) {
  if (next() > now + kSame) return {};
  auto picture = view_->draw(options_.camera);
  if (!picture) return picture.error();
  const auto& rgb = (*picture)->rgb;
  for (; next() <= now + kSame; ++frames_)
    if (!ffmpeg_->write({reinterpret_cast<const char*>(rgb.data()), rgb.size()})) return cannot_write(options_.file);
  return {};
}

Status Video::finish() {
  ffmpeg_->close_input();
  if (ffmpeg_->wait() != 0) return cannot_write(options_.file);
  const auto kept = keeper_->ask("whole");
  return kept && kept->text.empty() ? Status() : cannot_write(options_.file);
}

}  // namespace cxlab::lab
