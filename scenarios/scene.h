#pragma once
// What there is to see in an episode's world, the same for all kinds of worlds and tiers: a list of entities.
//
//   Scene scene = episode.scene();                                       // now
//   auto reader = SceneReader::open(run / "scene.bin");                  // of a recorded run (scenarios/scene_log.h)
//   for (const Entity& entity : scene.entities) ... scene.in_world(entity).position ...
//
// A stage lists its entities with functions that call `SceneList::put` (Stage::scenes).

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/time.h"
#include "sim/pose3.h"

namespace cxlab {

/// One number for each entity of an episode, never used again. The world's are those that it gives them; those of nodes
/// beside it come after `kMostEntityNumbers`.
using EntityId = std::uint32_t;
inline constexpr EntityId kMostEntityNumbers = 1U << 20;

struct Entity {
  EntityId id = 0;
  std::string kind;   ///< "robot", "machine", "piece"; words of the world, in its docs
  std::string name;   ///< "robot1"
  std::string state;  ///< what it does or is; words of the world
  std::string look;   ///< solids for pictures, see `solids_of`
  sim::Pose3 pose;    ///< seen from its carrier, else from the world; of the middle of its underside
  std::optional<EntityId> carried_by;
  std::string place;  ///< where on its carrier: "gripper", "belt"; may be empty
  friend bool operator==(const Entity& a, const Entity& b);
};

struct Scene {
  SimTime t{};
  std::vector<Entity> entities;  ///< by id

  const Entity* find(EntityId id) const;            ///< nullptr if there is none
  const Entity* find(std::string_view name) const;  ///< likewise; the first of that name
  sim::Pose3 in_world(const Entity& entity) const;
};

/// A part of an entity's look: upright in its frame, `at` is the middle of its underside.
struct Solid {
  enum class Shape : std::uint8_t { kBox, kCylinder };
  Shape shape{};
  std::array<double, 3> size{};  ///< along x, y, z; m
  std::array<double, 3> at{};
  std::uint32_t colour = 0;  ///< 0xrrggbb
  bool blinks = false;       ///< shines at each whole and half second for a quarter, else it is dark
  friend bool operator==(const Solid&, const Solid&) = default;
};
/// "box 0.35 0.7 0.86 0 0 0 #ccced4; cylinder 0.06 0.06 0.04 -0.12 0.3 1.06 #ff0d0d blinks": what pictures are made of,
/// in whatever program.
std::string look_of(std::span<const Solid> solids);
/// The opposite of `look_of`.
Expected<std::vector<Solid>> solids_of(std::string_view look);

/// What a stage says of one entity. Texts and points need to last during the call only.
struct EntityView {
  EntityId number = 0;          ///< 1 to kMostEntityNumbers - 1 (others are left out), unique in the function
  std::string_view kind, name;  ///< those of a number never change
  std::string_view state = {}, look = {};
  EntityId carried_by = 0;  ///< number of its carrier; 0: none
  std::string_view place = {};
  sim::Pose3 pose = {};        ///< seen from its carrier, else from the world
  bool fixed = false;          ///< its pose never changes
  std::uint32_t revision = 0;  ///< another number when something has changed (`SceneList::keep`); 0: unknown
  /// Where an entity that moves by itself will be, in a world that jumps from tick to tick. Then `pose` is not used.
  /// Each way has another number.
  std::uint64_t way_number = 0;
  std::span<const sim::WayPoint> way = {};
};

/// A pose in whole millimetres and milliradians: position, then rotation.
using RoundedPose = std::array<std::int32_t, 6>;
RoundedPose rounded(const sim::Pose3& pose);

class SceneList;
/// Lists what there is to see now.
using SceneLister = std::function<void(SceneList&)>;

/// The entities at an instant, as stages list them and files keep them: poses are rounded.
class SceneList {
 public:
  struct Track {
    EntityId id = 0;
    std::string kind, name, state, look, place;
    EntityId carried_by = 0;  ///< id; 0: none
    RoundedPose pose{};       ///< not used on a way
    struct Point {
      SimTime t{};  ///< whole milliseconds
      RoundedPose pose{};
      friend bool operator==(const Point&, const Point&) = default;
    };
    std::vector<Point> way;

    // Since the list was asked for before.
    enum Change : std::uint8_t { kPose = 1, kState = 2, kLook = 4, kCarrier = 8, kWay = 16, kNew = 32 };
    std::uint8_t changed = 0;
    RoundedPose before{};  ///< the pose, then
    std::uint64_t way_number = 0;
    std::uint32_t seen = 0, revision = 0;

    sim::Pose3 pose_at(SimTime t) const;
    Entity at(SimTime t) const;
  };

  // --- For functions that list entities
  /// Texts of more than kLongestText bytes are cut. Beyond kMostEntities entities those that come last are left out.
  void put(const EntityView& entity);
  /// It is still there, as `put` has taken it with that revision, and so are all of the `count` that were put from it
  /// on. False: it has not, `put` it.
  bool keep(EntityId number, std::uint32_t revision, std::size_t count = 1);
  /// Whether `put` has taken that way already, and needs no points.
  bool knows_way(EntityId number, std::uint64_t way_number) const;
  static constexpr std::size_t kMostEntities = 2000, kLongestText = 4000;

  // --- For those who ask
  /// Lets all functions list what there is now. Afterwards tracks know what has changed.
  void update(std::span<const SceneLister> listers);
  std::vector<Track>& tracks() { return tracks_; }
  const std::vector<Track>& tracks() const { return tracks_; }
  /// The entities that were removed with the last `update`.
  const std::vector<EntityId>& gone() const { return gone_; }
  Scene at(SimTime t) const;

 private:
  std::size_t position_of(EntityId id) const;

  std::vector<Track> tracks_;
  std::vector<EntityId> gone_;
  EntityId layer_ = 0;    // added to numbers
  std::size_t next_ = 0;  // where the next one is expected
  std::uint32_t round_ = 0;
};

}  // namespace cxlab
