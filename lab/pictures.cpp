#include "lab/pictures.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "cx/base/number_text.h"
#include "cx/journal/run_folder.h"

namespace cxlab::lab {

namespace {

constexpr double kFramesPerSecond = 10;  // of simulated time; the film plays 20 times as fast
constexpr int kWidth = 640, kHeight = 480;

std::string seconds(double value) { return general_text(value, 6) + " s"; }

}  // namespace

Expected<std::vector<double>> snapshot_times(const std::string& text, double end) {
  const auto wrong = [](const std::string& message) { return usage_error("--snapshot: " + message); };
  const auto bad = [&] { return wrong("found '" + text + "', expected every:SECONDS or SECONDS,SECONDS,..."); };
  std::vector<double> times;
  if (text.empty()) return times;
  if (text.starts_with("every:")) {
    const auto step = read_number<double>(text.substr(6));
    constexpr double kLeast = 1e-3;  // s; no tick in use is shorter, and every time is kept
    if (!step || !(*step > 0) || std::isinf(*step)) return bad();
    if (*step < kLeast) return wrong("found '" + text + "', expected at least " + seconds(kLeast));
    for (int k = 0; k * *step <= end; ++k) times.push_back(k * *step);
    return times;
  }
  std::stringstream words(text);
  for (std::string word; std::getline(words, word, ',');) {
    const auto time = read_number<double>(word);
    if (!time || !(*time >= 0)) return bad();
    if (*time > end) return wrong("there is no picture at " + seconds(*time) + ": the run ends at " + seconds(end));
    times.push_back(*time);
  }
  if (times.empty()) return bad();
  std::sort(times.begin(), times.end());
  return times;
}

Expected<std::unique_ptr<Pictures>> Pictures::create(Episode& episode, const std::filesystem::path& run_folder,
                                                     std::vector<double> times, const std::string& video) {
  std::unique_ptr<Pictures> pictures(new Pictures);
  if (times.empty() && video.empty()) return pictures;
  const auto none = [](const std::string& why) { return resource_error("no pictures: " + why); };
  auto view = view_of(episode.stage(), kWidth, kHeight);
  if (!view) return none(view.error().message);
  if (!times.empty()) {
    if (run_folder.empty()) return none("--snapshot needs the folder of a run, which --out none does not make");
    pictures->folder_ = run_folder / "snapshots";
    if (Status s = make_folder(pictures->folder_); !s) return s.error();
    pictures->times_ = std::move(times);
  }
  if (!video.empty()) {
    auto first = (*view)->draw((*view)->cameras().front());
    if (!first) return first.error();
    if (!is_on_path("ffmpeg")) return none("--video needs ffmpeg: apt-get install ffmpeg");
    const std::string size = std::to_string((*first)->width) + 'x' + std::to_string((*first)->height);
    ProcessOptions ffmpeg{.argv = {"ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s",
                                   size, "-r", "200", "-i", "-", "-r", "25", "-pix_fmt", "yuv420p", video}};
    ffmpeg.in = Stream::pipe();
    auto film = Process::start(ffmpeg);
    if (!film) return film.error();
    pictures->film_ = *std::move(film);
    pictures->video_ = video;
  }
  pictures->view_ = *std::move(view);
  return pictures;
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
  if (!film_->write({reinterpret_cast<const char*>(rgb.data()), rgb.size()}))
    return resource_error("ffmpeg took no more pictures for " + video_);
  return {};
}

Status Pictures::finish() {
  if (!film_) return {};
  film_->close_input();
  const int code = film_->wait();
  film_.reset();
  if (code != 0) return resource_error("ffmpeg could not write " + video_);
  return {};
}

}  // namespace cxlab::lab
