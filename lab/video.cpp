#include "lab/video.h"

#include <fstream>

namespace cxlab::lab {
namespace {

constexpr double kFramesPerSecond = 25;  // of the film
constexpr double kSame = 1e-9;           // s: times closer than that are one

Error cannot_write(const std::string& file) { return resource_error("the film cannot be written", file); }

}  // namespace

Expected<std::unique_ptr<Video>> Video::create(const VideoOptions& options, std::unique_ptr<View> view, double from) {
  std::unique_ptr<Video> video(new Video(options, std::move(view), from));
  if (video->options_.camera.empty()) video->options_.camera = video->view_->cameras().front();
  auto first = video->view_->draw(video->options_.camera);
  if (!first) return first.error();
  if (!is_on_path("ffmpeg")) return resource_error("no pictures: --video needs ffmpeg: apt-get install ffmpeg");
  if (!std::ofstream(options.file)) return cannot_write(options.file);
  if (Status s = video->start(**first); !s) return s.error();
  return video;
}

Status Video::start(const sim::Picture& first) {
  const std::string size = std::to_string(first.width) + 'x' + std::to_string(first.height);
  const std::string rate = std::to_string(static_cast<int>(kFramesPerSecond));
  // H.264 has colours for squares of two pixels, so that sides are even. "file:": a name is not read as a protocol.
  ProcessOptions ffmpeg{.argv = {"ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s",
                                 size, "-r", rate, "-i", "-", "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt",
                                 "yuv420p", "file:" + options_.file}};
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
  return ffmpeg_->wait() == 0 ? Status() : cannot_write(options_.file);
}

}  // namespace cxlab::lab
