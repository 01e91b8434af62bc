#pragma once
// Animated images that need no other program: GIF89a. Each frame has its own colours, at most 255, and only what
// differs from the frame before.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "sim/picture.h"

namespace cxlab::lab {

class GifEncoder {
 public:
  GifEncoder(int width, int height);

  /// Shows a picture of that size for that long, in hundredths of a second; the animation begins again after the last.
  void add(const sim::Picture& picture, int hundredths);
  /// Bytes so far.
  std::size_t size() const { return bytes_.size(); }
  /// The whole file; nothing is added afterwards.
  std::string take();

 private:
  void put_number(int number);
  void begin_frame(int hundredths);
  void lengthen_last_frame(int hundredths);

  int width_, height_;
  std::string bytes_;
  sim::Picture last_;
  std::size_t delay_at_ = 0;  ///< where the last frame says how long it lasts
  int delay_ = 0;
};

}  // namespace cxlab::lab
