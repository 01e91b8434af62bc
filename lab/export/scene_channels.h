#pragma once
// The scene as topics of a bag: the pose of each entity under /tf and /tf_static, its solids and state as markers of
// /cxlab/scene/KIND.

#include <map>
#include <set>
#include <string>

#include "lab/export/ros_bag.h"
#include "lab/export/run_pass.h"
#include "scenarios/scene.h"

namespace cxlab::lab {

/// The names of entities as frames of tf: unique, and the same for the whole run.
class FrameNames {
 public:
  const std::string& of(const Entity& entity);

 private:
  std::map<EntityId, std::string> names_;
  std::set<std::string> used_{"map"};
};

class SceneChannels final : public PassListener {
 public:
  /// Looks at the scenes of the stretch once, to learn what never moves.
  static Expected<SceneChannels> create(RosBag& bag, const Run& run, const Stretch& stretch);

  bool wants_scenes() const override { return true; }
  Status see(const Scene& scene) override;

 private:
  explicit SceneChannels(RosBag& bag) : bag_(bag) {}
  void put_poses(const Scene& scene);
  Status put_markers(const Scene& scene);

  RosBag& bag_;
  FrameNames frames_;
  std::set<EntityId> fixed_;  ///< there from the first scene to the last, in one pose
  bool first_ = true;
  SimTime poses_put_{};
  std::string last_poses_;
  std::map<std::string, std::string> last_markers_;  ///< by kind: what they were made of
};

}  // namespace cxlab::lab
