#pragma once
// What there is to see of a game, in either tier (docs/reference/rcll.md, The scene): the field, walls, machines with
// their lights, robots, pieces.

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "scenarios/rcll/game/factory.h"
#include "scenarios/scene.h"
#include "sim/floor_pose.h"
#include "sim/skills/fleet.h"
#include "sim/world.h"

namespace cxlab::rcll {

/// The solids of a workpiece.
std::string piece_look(const sim::Stack& stack);

/// The floor that a scene shows, for pictures: the opposite of `GameScene::list`. What the scene lacks is as at the
/// start.
sim::FloorPose floor_pose_of(const Scene& scene, const sim::FloorPlan& plan);

class GameScene {
 public:
  /// All outlive it.
  GameScene(const sim::World& floor, const Factory& factory, const sim::Fleet& fleet);
  void list(SceneList& list);

 private:
  /// A text is made again only when its content has changed.
  struct MachineText {
    MachineState state{};
    sim::Lights lights;
    std::string text;
    const std::string* look = nullptr;
    std::uint32_t revision = 0;
    std::map<std::array<sim::Light, 3>, std::string> looks;  ///< by lights: those that were seen
  };
  struct PieceText {
    sim::Piece piece;  ///< as it was seen last
    std::uint64_t way = 0;
    std::uint32_t revision = 0;
    std::string name, text, look;
  };
  void list_field(SceneList& list) const;
  void list_machines(SceneList& list);
  void list_robots(SceneList& list);
  void list_pieces(SceneList& list);
  const PieceText& text_of(const sim::Piece& piece);

  const sim::World& floor_;
  const Factory& factory_;
  const sim::Fleet& fleet_;
  std::vector<std::string> walls_, robots_;  // looks
  std::vector<MachineText> machines_;        // by station
  std::vector<PieceText> pieces_;            // by number
  std::vector<sim::WayPoint> way_;
};

}  // namespace cxlab::rcll
