#pragma once
// A run as an MCAP file of ROS 2 messages (docs/reference/export.md lists its topics).

#include <memory>
#include <vector>

#include "cx/base/scratch_folder.h"
#include "lab/export/bus_channels.h"
#include "lab/export/picture_channel.h"
#include "lab/export/ros_bag.h"
#include "lab/export/run_pass.h"
#include "lab/export/scene_channels.h"
#include "lab/export/story_channels.h"

namespace cxlab::lab {

class McapExport {
 public:
  /// Begins the file.
  static Expected<std::unique_ptr<McapExport>> create(const Run& run, const Stretch& stretch,
                                                      const PictureChoice& pictures, const std::filesystem::path& file);
  /// Who listens to the pass over the run.
  std::vector<PassListener*> listeners();
  RosBag& bag() { return bag_; }
  /// Completes the file.
  Status close();

 private:
  explicit McapExport(RosBag bag) : bag_(std::move(bag)) {}

  RosBag bag_;
  std::unique_ptr<ScratchFolder> definitions_;  ///< those that the run read
  std::unique_ptr<BusChannels> bus_;
  std::unique_ptr<SceneChannels> scene_;  ///< none: the run has no scene
  std::unique_ptr<StoryChannels> story_;
  std::unique_ptr<PictureChannel> pictures_;  ///< none: the bag has no pictures
};

}  // namespace cxlab::lab
