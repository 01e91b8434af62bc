#pragma once
// Pictures of a run, as a topic of a bag: /cxlab/camera/NAME.

#include <memory>
#include <string>

#include "cx/base/scratch_folder.h"
#include "lab/export/ros_bag.h"
#include "lab/export/run_pass.h"
#include "lab/shown_run.h"
#include "scenarios/view.h"

namespace cxlab::lab {

struct PictureChoice {
  SimTime every{};     ///< 0: no pictures
  std::string camera;  ///< empty: the view's first
  int width = 640, height = 480;
};

/// Plays the physics of the run again, up to each picture, or draws its scene.
class PictureChannel final : public PassListener {
 public:
  /// kInput where the run has nothing to look at or no such camera.
  static Expected<PictureChannel> create(RosBag& bag, const Run& run, const PictureChoice& choice);

  bool wants_scenes() const override { return true; }
  Status see(const Scene& scene) override;

 private:
  PictureChannel(RosBag& bag, ShownRun shown) : bag_(bag), shown_(std::move(shown)) {}

  RosBag& bag_;
  ShownRun shown_;
  std::unique_ptr<View> view_;
  std::unique_ptr<ScratchFolder> scratch_;
  std::string camera_;
  SimTime every_{}, next_ = SimTime::min();
};

}  // namespace cxlab::lab
