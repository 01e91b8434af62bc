#pragma once
// Pictures of a MuJoCo world. Drawing works on a copy and moves nothing.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "sim/legend.h"
#include "sim/mujoco/gl_context.h"
#include "sim/mujoco/overlay.h"
#include "sim/mujoco/physics_gate.h"
#include "sim/picture.h"

namespace cxlab::sim {

class Renderer {
 public:
  /// For worlds of this plan. Fails with kResource where there is no OpenGL.
  static Expected<std::unique_ptr<Renderer>> create(const FloorPlan& plan, const PhysicsGate& world, int width = 640,
                                                    int height = 480);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// "field", obliquely from above, and "top", which show the whole field as large as the picture allows; "follow-" and
  /// a robot's name, from near behind it; the name of a robot (what it sees) or of a machine (its input side).
  std::vector<std::string> cameras() const;
  static bool shows_field(std::string_view camera);
  /// The world as it is now. Labels, and a legend, are drawn over pictures from above. The picture is the renderer's
  /// own and lasts until the next call. A camera that does not exist is kInput; the error lists those that do.
  Expected<const Picture*> draw(const PhysicsGate& world, std::string_view camera, const Legend& legend = {});
  /// What the last picture has over it.
  const Overlay& overlay() const { return overlay_; }
  /// Where points of the world are in it.
  Projection projection() const { return {scene_.camera[0], picture_.width, picture_.height}; }

 private:
  Renderer(const FloorPlan& plan, std::unique_ptr<GlContext> context, int width, int height);
  void set_up(const PhysicsGate& world);
  Status choose(const mjModel& model, std::string_view camera);
  void shine(const PhysicsGate& world);
  void lay_ground();
  void fit(const Box& free, bool from_above);

  std::unique_ptr<GlContext> context_;
  FloorPlan plan_;
  std::vector<int> robot_geoms_;                             ///< by robot: one in its middle
  std::vector<int> light_of_;                                ///< by geom: 3 * station + colour; -1 = none
  enum class Kind { kWhole, kFollowing, kMounted } kind_{};  ///< of the camera
  Overlay overlay_;
  std::unique_ptr<mjData, MjDeleter> copy_;
  mjvScene scene_;
  mjvOption option_;
  mjvCamera camera_;
  mjrContext gl_;
  std::vector<std::uint8_t> upside_down_;
  Picture picture_;
};

}  // namespace cxlab::sim
