#pragma once
// A floor plan as a MuJoCo model, put together from the parts in models/. Every name is looked up here, once.

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <mujoco/mujoco.h>

#include "cx/base/expected.h"
#include "sim/world.h"

namespace cxlab::sim {

struct ModelOptions {
  std::filesystem::path models;  ///< the folder with factory.xml and the parts
  double step = 0.01;            ///< s
  int pieces = 60;               ///< bodies in the pool: how many pieces can be in play at once
};

/// What a geom is for, when it touches something.
enum class GeomRole : std::uint8_t {
  kNone,
  kFloor,
  kFieldWall,
  kMachineBody,
  kBelt,
  kShelf,
  kSlide,
  kHull,
  kFingerLeft,
  kFingerRight,
  kPieceBase,
  kPiecePart
};
/// Role and whose it is: station, robot or body of the pool.
struct GeomUse {
  GeomRole role = GeomRole::kNone;
  int index = -1;
};

/// The joints of a robot, and its actuators, in this order.
enum RobotAxis {
  kAxisX,
  kAxisY,
  kAxisYaw,
  kAxisForward,
  kAxisLeft,
  kAxisUp,
  kAxisFingerLeft,
  kAxisFingerRight,
  kRobotAxes
};
/// The slots of a piece, in this order.
enum PieceSlot { kSlotBase, kSlotRing1, kSlotRing2, kSlotRing3, kSlotCap, kPieceSlots };

struct StationIds {
  int belt = -1;                          ///< geom; -1 without belt
  std::array<int, 3> lights{-1, -1, -1};  ///< geoms: red, yellow, green
};
struct RobotIds {
  std::array<int, kRobotAxes> qpos{}, dof{}, actuator{};
};
struct PieceIds {
  int body = -1, qpos = -1, dof = -1;
  std::array<int, kPieceSlots> geoms{};
};

struct MjDeleter {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* data) const { mj_deleteData(data); }
};

/// Owned by one world: fields of the model are written at run time.
struct FactoryModel {
  std::unique_ptr<mjModel, MjDeleter> model;
  std::vector<std::filesystem::path> files;  ///< every file that was read
  std::vector<StationIds> stations;
  std::vector<RobotIds> robots;
  std::vector<PieceIds> pieces;
  std::vector<GeomUse> geoms;  ///< by geom id
  /// Materials by number of the colour, -1 where there is none; [0] is unused.
  std::vector<int> base_materials, ring_materials, cap_materials;
};

/// Fails with file and line for wrong MJCF and for parts that lack a name that is needed.
Expected<FactoryModel> build_factory(const FloorPlan& plan, const ModelOptions& options);

}  // namespace cxlab::sim
