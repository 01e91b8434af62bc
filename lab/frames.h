#pragma once
// Pictures of a world as people get them, one or film by film: what cameras show, side by side, above a caption with
// time, points and the last events. The same world gives the same pixels.

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/time.h"
#include "lab/happenings.h"
#include "scenarios/view.h"
#include "sim/picture.h"

namespace cxlab::sim {
class Font;
}

namespace cxlab::lab {

struct FrameOptions {
  int width = 960, height = 600;       ///< px; a canvas may choose less
  std::size_t cameras = 1;             ///< that are drawn at once
  bool caption = true;                 ///< where the world tells anything
  const Happenings* events = nullptr;  ///< for the caption; may be none
};

class Frames {
 public:
  /// `make` makes a view of the world for a size. Everything that a picture needs is opened here; where a caption is
  /// due and there is no OpenGL, kResource.
  static Expected<std::unique_ptr<Frames>> create(const ViewMaker& make, const FrameOptions& options);
  ~Frames();
  Frames(const Frames&) = delete;
  Frames& operator=(const Frames&) = delete;

  /// The first is the default.
  std::vector<std::string> cameras() const { return tiles_.front().view->cameras(); }
  /// The world as it is now, at that time: the time of the last tick, or one before the next. As many cameras as the
  /// options say. The picture lasts until the next call.
  Expected<const sim::Picture*> draw(std::span<const std::string> cameras, SimTime now);

 private:
  struct Tile {
    int left = 0, top = 0, width = 0, height = 0;
    View* view = nullptr;
  };
  explicit Frames(const FrameOptions& options);
  Status open(const ViewMaker& make);
  Expected<View*> view_of(const ViewMaker& make, int width, int height);
  void write_caption(SimTime now);

  FrameOptions options_;
  std::vector<std::unique_ptr<View>> views_;  ///< one for each size of a tile
  std::vector<std::pair<int, int>> sizes_;    ///< theirs
  std::vector<Tile> tiles_;
  int caption_top_ = 0;              ///< the caption is between that and the lower edge
  std::unique_ptr<sim::Font> font_;  ///< of the caption
  sim::Picture picture_;
};

/// "field,follow-robot1"; empty names are left out.
std::vector<std::string> camera_names(const std::string& text);

/// Where tiles of a picture of that size are: left, top, width, height of each. The first is the largest.
std::vector<std::array<int, 4>> tile_places(std::size_t count, int width, int height);

}  // namespace cxlab::lab
