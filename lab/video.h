#pragma once
// A film of a world, written by ffmpeg. Its frames are pictures at given simulated times: the same run gives the same
// frames.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "cx/base/expected.h"
#include "cx/base/process.h"
#include "cx/base/servant.h"
#include "lab/host.h"
#include "scenarios/view.h"

namespace cxlab::lab {

struct VideoOptions {
  std::string file;    ///< as film.mp4; empty = none
  std::string camera;  ///< empty = the view's first
  int width = 960, height = 720;
  double speed = 20;  ///< s of simulated time in a second of the film
};

class Video {
 public:
  /// The view is of that size or smaller; the first frame shows `from`, s. kUsage for a name that is not that of a
  /// film, kResource where there is no ffmpeg, and for a file that cannot be written. The host hears of a size that
  /// changes.
  static Expected<std::unique_ptr<Video>> create(const VideoOptions& options, std::unique_ptr<View> view,
                                                 const Host& host, double from = 0);
  /// What `create` would say, without a film: a file of that name stays as it is.
  static Status check(const VideoOptions& options, View& view);
  /// When the next frame is due, s.
  double next() const;
  /// Draws the world as it is at `now` for all frames that are due.
  Status look(double now);
  /// Completes the file, which has its name from then on; no frame can follow.
  Status finish();

 private:
  Video(VideoOptions options, std::unique_ptr<View> view, double from)
      : options_(std::move(options)), view_(std::move(view)), from_(from) {}
  Status start(const sim::Picture& first);

  VideoOptions options_;
  std::unique_ptr<View> view_;
  double from_;
  std::int64_t frames_ = 0;            ///< written
  std::filesystem::path file_, part_;  ///< the film, and what ffmpeg writes until it is whole
  /// Gives the whole film its name, and removes what is left of another one, however this process ends.
  std::unique_ptr<Servant> keeper_;
  std::unique_ptr<Process> ffmpeg_;
};

}  // namespace cxlab::lab
