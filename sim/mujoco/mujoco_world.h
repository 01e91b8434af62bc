#pragma once
// The factory floor in MuJoCo: pieces lie, slide and are gripped by contact; belts carry by surface velocity; robots
// are driven by their motors within their limits.

#include <memory>
#include <optional>
#include <vector>

#include "sim/mujoco/contacts.h"
#include "sim/mujoco/physics_gate.h"
#include "sim/mujoco/robot_motors.h"
#include "sim/world.h"

namespace cxlab::sim {

class MujocoWorld final : public World, public RobotBodies {
 public:
  /// Fails for wrong MJCF, with file and line, and for measures that differ from sim/geometry.h. `log` (may be null)
  /// takes every write from the first on.
  static Expected<std::unique_ptr<MujocoWorld>> create(FloorPlan plan, const ModelOptions& options,
                                                       PhysicsLog* log = nullptr);

  RobotState robot(RobotId id) const override;
  bool belt_running(StationId id) const override { return belts_[index_of(id)].speed != 0; }
  Pose3 pose_in_holder(const Piece& piece) const override;
  const Piece* at(SpotId spot) const override;
  const Piece* on_belt(StationId id, double x) const override;

  /// `tick` is a whole number of physics steps.
  Status advance(SimTime tick) override;
  SimTime next_event() const override { return now_; }
  using World::dispense;
  Expected<PieceId> dispense(SpotId shelf, const Stack& stack) override;
  void run_belt(StationId station, double speed, double stop_x) override;
  void stop_belt(StationId station) override;
  void mount(PieceId piece, Part part, std::uint8_t colour) override;
  void unmount_cap(PieceId piece) override;
  void retire(PieceId piece, Holder to) override;
  void set_lights(StationId station, const Lights& lights) override;
  Lights lights(StationId station) const override { return gate_.lights(station); }
  void set_down(RobotId robot, const Pose2& to) override;
  void halt() override;
  void go_on() override;

  void command_base(RobotId robot, double vx, double vy, double omega) override {
    motors_.command_base(robot, {vx, vy}, omega);
  }
  void command_gripper(RobotId robot, const Vec3& axes) override { motors_.command_gripper(robot, axes); }
  void command_fingers(RobotId robot, double opening) override { motors_.command_fingers(robot, opening); }

  /// Hash of all physics up to the last tick; a replay of the log ends in the same.
  std::uint64_t physics_hash() const { return gate_.hash(); }
  const PhysicsGate& gate() const { return gate_; }
  /// Every model file that was read.
  const std::vector<std::filesystem::path>& model_files() const { return gate_.factory().files; }

 private:
  struct Belt {
    double speed = 0;
    double stop_x = 0;
  };
  /// A holder and which one: `Piece::holder` and `holder_index`.
  struct Place {
    Holder holder = Holder::kDispenser;
    int index = -1;
    friend bool operator==(const Place&, const Place&) = default;
  };
  /// A body of the pool, beyond what `Piece` knows of it.
  struct Body {
    bool in_play = false;
    Place seen;  ///< where contacts put it for the last `seen_ticks`, where that differs from its Piece
    int seen_ticks = 0;
    int belt = -1;         ///< station whose running belt it is on
    double belt_x = 0;     ///< along that belt, before the last step
    bool carried = false;  ///< a grip carries its weight
  };

  MujocoWorld(FloorPlan plan, FactoryModel factory, PhysicsLog* log);

  Expected<PieceId> bring_out(const Source& from, double x_on_belt, const Stack& stack) override;
  void stop_arrived_belts();
  void update_pieces();
  void update_holder(Piece& piece);
  void carry(const Piece& piece, bool gripped);
  Place place_of(const Piece& piece) const;
  bool slid_in(const Piece& piece) const;
  void take_out(PieceId id);
  Expected<PieceId> put_in_play(const Vec3& underside, const Stack& stack, const Source& from, Place to);
  std::size_t body_of(PieceId id) const { return bodies_of_pieces_[index_of(id) - 1]; }
  Vec3 underside_of(std::size_t body) const;
  Pose3 pose_of(std::size_t body) const;
  Vec3 in_station(StationId station, const Vec3& point) const;
  SpotId nearest_spot(StationId station, SpotKind kind, const Vec3& point) const;

  PhysicsGate gate_;
  Contacts contacts_;
  RobotMotors motors_;
  double step_;
  std::vector<std::size_t> bodies_of_pieces_;  ///< in the pool, by piece id - 1; also those out of play
  std::vector<Body> bodies_;                   ///< of the pool
  std::vector<std::optional<PieceId>> held_;   ///< by robot
  std::vector<Belt> belts_;                    ///< by station
};

}  // namespace cxlab::sim
