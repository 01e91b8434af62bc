#pragma once
// A film of a world, written by ffmpeg, or an animated image, which needs no other program. Its frames are pictures at
// given simulated times: the same run gives the same frames.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/servant.h"
#include "lab/film_writer.h"
#include "lab/frames.h"
#include "lab/host.h"

namespace cxlab::lab {

struct VideoOptions {
  std::string file;                  ///< as film.mp4 or film.gif; empty = none
  std::vector<std::string> cameras;  ///< side by side; empty = the view's first
  int width = 0, height = 0;         ///< px; 0 = 960x600, of an animated image 640x400
  double speed = 20;                 ///< s of simulated time in a second of the film
  double frame_rate = 0;             ///< frames in a second of the film; 0 = 25, of an animated image 10
  bool caption = true;
  std::size_t most_bytes = 0;  ///< of an animated image: frames are left out, or smaller, until it fits; 0 = 5 MB

  /// With the defaults of the kind of film.
  VideoOptions complete() const;
};

class Video {
 public:
  /// The first frame shows `from`, s. Fails with kUsage for a name that is not that of a film. Fails with kResource
  /// without ffmpeg, and for a file that cannot be written. The host is notified if the size changes. `events` are for
  /// the caption; they may be none, and must outlive the film.
  static Expected<std::unique_ptr<Video>> create(const VideoOptions& options, const ViewMaker& make, const Host& host,
                                                 const Happenings* events = nullptr, double from = 0);
  /// What `create` would say, without a film: a file of that name stays as it is.
  static Status check(const VideoOptions& options, const ViewMaker& make);
  /// When the next frame is due, s.
  double next() const;
  /// Draws the frames that are due by the time `now` of the last tick, and before `next`: nothing happens in between.
  Status look(SimTime now, SimTime next);
  /// Completes the file, which has its name from then on; no frame can follow.
  Status finish(const Host& host);

 private:
  Video(VideoOptions options, std::unique_ptr<Frames> frames, double from)
      : options_(std::move(options)), frames_(std::move(frames)), from_(from) {}
  static Expected<std::unique_ptr<Video>> prepare(const VideoOptions& options, const ViewMaker& make,
                                                  const Happenings* events, double from);
  Status start(const sim::Picture& first);

  VideoOptions options_;
  std::unique_ptr<Frames> frames_;
  double from_;
  std::int64_t written_ = 0;
  std::filesystem::path file_, part_;  ///< the film, and what is written until it is whole
  /// Gives the whole film its name, and removes what is left of another one, however this process ends.
  std::unique_ptr<Servant> keeper_;
  std::unique_ptr<FilmWriter> writer_;
};

}  // namespace cxlab::lab
