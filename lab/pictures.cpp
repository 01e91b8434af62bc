#include "lab/pictures.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "cx/base/number_text.h"
#include "cx/journal/run_folder.h"

namespace cxlab::lab {

namespace {

constexpr int kWidth = 640, kHeight = 400;

}  // namespace

Expected<std::vector<double>> snapshot_times(const std::string& text, double end) {
  const auto wrong = [](const std::string& message) { return usage_error("--snapshot: " + message); };
  const auto bad = [&] { return wrong(found_text(text, "every:SECONDS or SECONDS,SECONDS,...")); };
  std::vector<double> times;
  if (text.empty()) return times;
  if (text.starts_with("every:")) {
    const auto step = read_number<double>(text.substr(6));
    constexpr double kLeast = 1e-3;  // s; no tick in use is shorter, and every time is kept
    if (!step || !(*step > 0) || std::isinf(*step)) return bad();
    if (*step < kLeast) return wrong(found_text(text, "at least " + seconds_text(kLeast)));
    for (int k = 0; k * *step <= end; ++k) times.push_back(k * *step);
    return times;
  }
  std::stringstream words(text);
  for (std::string word; std::getline(words, word, ',');) {
    const auto time = read_number<double>(word);
    if (!time || !(*time >= 0)) return bad();
    if (*time > end)
      return wrong("there is no picture at " + seconds_text(*time) + ": the run ends at " + seconds_text(end));
    times.push_back(*time);
  }
  if (times.empty()) return bad();
  std::sort(times.begin(), times.end());
  return times;
}

Expected<std::unique_ptr<Pictures>> Pictures::create(Episode& episode, const std::filesystem::path& run_folder,
                                                     std::vector<double> times, bool caption,
                                                     const Happenings* events) {
  std::unique_ptr<Pictures> pictures(new Pictures);
  if (times.empty()) return pictures;
  const auto none = [](const std::string& why) { return resource_error("no pictures: " + why); };
  const ViewMaker make = [&](int width, int height) -> Expected<std::unique_ptr<View>> {
    auto view = view_of(episode.stage(), width, height);
    if (!view) return none(view.error().message);
    return view;
  };
  auto frames =
      Frames::create(make, {.width = kWidth, .height = kHeight, .cameras = 1, .caption = caption, .events = events});
  if (!frames) return frames.error();
  if (run_folder.empty()) return none("--snapshot needs the folder of a run, which --out none does not make");
  pictures->folder_ = run_folder / "snapshots";
  if (Status s = make_folder(pictures->folder_); !s) return s.error();
  pictures->times_ = std::move(times);
  pictures->frames_ = *std::move(frames);
  return pictures;
}

Status Pictures::look(SimTime now, SimTime next) {
  for (; next_ < times_.size(); ++next_) {
    const SimTime due = from_seconds(times_[next_]);
    if (due > now && due >= next) return {};
    if (Status s = snapshot(times_[next_]); !s) return s;
  }
  return {};
}

Status Pictures::snapshot(double t) {
  for (const std::string& camera : frames_->cameras()) {
    auto picture = frames_->draw({&camera, 1}, from_seconds(t));
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

}  // namespace cxlab::lab
