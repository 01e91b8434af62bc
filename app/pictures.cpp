#include "app/pictures.h"

namespace cxlab::app {

namespace {

constexpr double kFramesPerSecond = 10;  // of simulated time; the film plays 20 times as fast
constexpr int kWidth = 640, kHeight = 480;

void note(const std::string& text) { std::fprintf(stderr, "no pictures: %s\n", text.c_str()); }

/// In single quotes for the shell.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + '\'';
}

}  // namespace

Expected<std::unique_ptr<Pictures>> Pictures::create(Episode& episode, const RunFolder* folder,
                                                     std::vector<double> times, const std::string& video) {
  std::unique_ptr<Pictures> pictures(new Pictures);
  if (times.empty() && video.empty()) return pictures;
  auto view = view_of(episode.stage(), kWidth, kHeight);
  if (!view) {
    note(view.error().message);
    return pictures;
  }
  if (folder) {
    auto below = folder->subfolder("snapshots");
    if (!below) return below.error();
    pictures->folder_ = *below;
    pictures->times_ = std::move(times);
  } else if (!times.empty()) {
    note("with --out none there is no folder for --snapshot");
  }
  if (!video.empty()) {
    auto first = (*view)->draw((*view)->cameras().front());
    if (!first) return first.error();
    const std::string size = std::to_string((*first)->width) + 'x' + std::to_string((*first)->height);
    const std::string command = "ffmpeg -loglevel error -y -f rawvideo -pix_fmt rgb24 -s " + size +
                                " -r 200 -i - -r 25 -pix_fmt yuv420p " + quoted(video);
    if (std::system("command -v ffmpeg >/dev/null 2>&1") != 0)
      note("--video needs ffmpeg: apt-get install ffmpeg");
    else
      pictures->film_ = popen(command.c_str(), "w");
    pictures->video_ = video;
  }
  pictures->view_ = *std::move(view);
  return pictures;
}

Pictures::~Pictures() {
  if (film_) pclose(film_);
}

Status Pictures::look(Episode& episode) {
  if (!view_) return {};
  const double t = to_seconds(episode.now());
  const bool picture_due = next_ < times_.size() && times_[next_] <= t;
  const bool frame_due = film_ && next_frame_ <= t;
  if (!picture_due && !frame_due) return {};
  if (picture_due) {
    while (next_ < times_.size() && times_[next_] <= t) ++next_;
    if (Status s = snapshot(t); !s) return s;
  }
  return frame_due ? frame() : Status();
}

Status Pictures::snapshot(double t) {
  for (const std::string& camera : view_->cameras()) {
    auto picture = view_->draw(camera);
    if (!picture) return picture.error();
    char name[64];
    std::snprintf(name, sizeof name, "%07.2f-%s.png", t, camera.c_str());
    const std::filesystem::path file = folder_ / name;
    if (Status s = sim::write_png(**picture, file); !s) return s;
    char caption[64];
    std::snprintf(caption, sizeof caption, "%s at %.0f s", camera.c_str(), t);
    taken_.push_back({caption, file});
  }
  return {};
}

Status Pictures::frame() {
  next_frame_ += 1 / kFramesPerSecond;
  auto picture = view_->draw(view_->cameras().front());
  if (!picture) return picture.error();
  const auto& rgb = (*picture)->rgb;
  if (std::fwrite(rgb.data(), 1, rgb.size(), film_) != rgb.size())
    return resource_error("ffmpeg took no more pictures for " + video_);
  return {};
}

Status Pictures::finish() {
  if (!film_) return {};
  const int code = pclose(film_);
  film_ = nullptr;
  if (code != 0) return resource_error("ffmpeg could not write " + video_);
  return {};
}

}  // namespace cxlab::app
