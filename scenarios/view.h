#pragma once
// Pictures of a world, whatever its kind.

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/time.h"
#include "sim/coloured_text.h"
#include "sim/picture.h"

namespace cxlab {

class View {
 public:
  virtual ~View() = default;
  /// The world as it is now. The picture is the view's own and lasts until the next call. A camera that does not exist
  /// is kInput; the error lists those that do.
  virtual Expected<const sim::Picture*> draw(std::string_view camera) = 0;
  /// The first is the default. A view may have others beside these, which are drawn where nobody names one.
  virtual std::vector<std::string> cameras() const = 0;
  /// The next pictures show that time: the one of the last tick, or one before the next. It is for worlds that know
  /// between ticks where things are.
  virtual void set_time(SimTime) {}
  /// What stands first in the caption below pictures: "11:40 PRODUCTION", "CYAN 317". Empty: nothing.
  virtual std::vector<sim::ColouredText> headline() { return {}; }
};

/// Makes a view of a world for pictures of that size; a view may choose a smaller one.
using ViewMaker = std::function<Expected<std::unique_ptr<View>>(int width, int height)>;

struct Stage;
/// All views of a stage as one. A camera whose name an earlier view has gets a number: canvas, canvas2. kInput where
/// there is nothing to look at.
Expected<std::unique_ptr<View>> view_of(const Stage& stage, int width, int height);

}  // namespace cxlab
