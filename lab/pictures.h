#pragma once
// Pictures of a run: snapshots at given times, and a film. Taken between ticks; they change nothing.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/process.h"
#include "lab/picture.h"
#include "scenarios/episode.h"
#include "scenarios/view.h"

namespace cxlab::lab {

/// The times (s) that `text` asks for: `every:T` up to `end`, or `T,T,...`, none of which may be after `end`.
Expected<std::vector<double>> snapshot_times(const std::string& text, double end);

class Pictures {
 public:
  /// `times` (s) in order. kResource where a picture is asked for that cannot be made: no OpenGL, a world without
  /// bodies, no folder, no ffmpeg.
  static Expected<std::unique_ptr<Pictures>> create(Episode& episode, const std::filesystem::path& run_folder,
                                                    std::vector<double> times, const std::string& video);
  /// Takes what is due at the episode's time.
  Status look(Episode& episode);
  Status finish();
  const std::vector<Picture>& taken() const { return taken_; }

 private:
  Pictures() = default;
  Status snapshot(double t);
  Status frame();

  std::unique_ptr<View> view_;
  std::filesystem::path folder_;
  std::vector<double> times_;
  std::size_t next_ = 0;
  std::string video_;
  std::optional<Process> film_;  // ffmpeg
  double next_frame_ = 0;
  std::vector<Picture> taken_;
};

}  // namespace cxlab::lab
