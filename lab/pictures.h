#pragma once
// Snapshots of a run at given times. Taken between ticks; they change nothing.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "lab/frames.h"
#include "lab/picture.h"
#include "scenarios/episode.h"

namespace cxlab::lab {

/// The times (s) that `text` asks for: `every:T` up to `end`, or `T,T,...`, none of which may be after `end`.
Expected<std::vector<double>> snapshot_times(const std::string& text, double end);

class Pictures {
 public:
  /// `times` (s) in order. kResource where a picture is asked for that cannot be made: no OpenGL, a world without
  /// bodies, no folder. `events`, which may be none, are for captions and outlive it.
  static Expected<std::unique_ptr<Pictures>> create(Episode& episode, const std::filesystem::path& run_folder,
                                                    std::vector<double> times, bool caption = true,
                                                    const Happenings* events = nullptr);
  /// Takes what is due by the time `now` of the last tick, and before `next`: nothing happens in between.
  Status look(SimTime now, SimTime next);
  const std::vector<Picture>& taken() const { return taken_; }

 private:
  Pictures() = default;
  Status snapshot(double t);

  std::unique_ptr<Frames> frames_;
  std::filesystem::path folder_;
  std::vector<double> times_;
  std::size_t next_ = 0;
  std::vector<Picture> taken_;
};

}  // namespace cxlab::lab
