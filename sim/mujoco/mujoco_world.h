#pragma once
// The factory floor in MuJoCo: pieces lie, slide and are gripped by contact; belts carry by surface velocity; robots
// are driven by their motors within their limits.

#include <memory>

#include "sim/mujoco/physics_gate.h"
#include "sim/world.h"

namespace cxlab::sim {

class MujocoWorld final : public World, public RobotBodies {
 public:
  /// Fails for wrong MJCF, with file and line. `tap` (may be null) is told of every write from the first on.
  static Expected<std::unique_ptr<MujocoWorld>> create(FloorPlan plan, const ModelOptions& options,
                                                       PhysicsTap* tap = nullptr);

  SimTime now() const override { return now_; }
  const FloorPlan& plan() const override { return plan_; }
  std::span<const Piece> pieces() const override { return pieces_; }
  const Piece* find(PieceId id) const override;
  RobotState robot(RobotId id) const override;
  bool belt_running(StationId id) const override { return belts_[at_index(id)].speed != 0; }
  const Piece* at(SpotId spot) const override;
  const Piece* on_belt(StationId id, double x) const override;
  int slide_count(StationId id) const override { return slide_counts_[at_index(id)]; }
  std::span<const HolderChange> changes() const override { return {changes_.data(), told_changes_}; }

  /// `tick` is a whole number of physics steps.
  Status advance(SimTime tick) override;
  SimTime next_event() const override { return now_; }
  Expected<PieceId> dispense(StationId station, double x_on_belt, const Stack& stack) override;
  Expected<PieceId> dispense(SpotId shelf, const Stack& stack) override;
  void run_belt(StationId station, double speed, double stop_x) override;
  void stop_belt(StationId station) override;
  void mount(PieceId piece, Part part, std::uint8_t colour) override;
  void unmount_cap(PieceId piece) override;
  void retire(PieceId piece, Holder to) override;
  void set_lights(StationId station, const Lights& lights) override;
  Lights lights(StationId station) const override { return gate_.lights(station); }

  void command_base(RobotId robot, double vx, double vy, double omega) override;
  void command_gripper(RobotId robot, const Vec3& axes) override;
  void command_fingers(RobotId robot, double opening) override;

  /// Hash of all physics up to the last tick; a replay of the tap's log ends in the same.
  std::uint64_t physics_hash() const { return gate_.hash(); }
  const PhysicsGate& gate() const { return gate_; }
  /// Every model file that was read.
  const std::vector<std::filesystem::path>& model_files() const { return gate_.factory().files; }

 private:
  struct Belt {
    double speed = 0;
    double stop_x = 0;
  };
  /// What a robot is told, and how far its ramps have come.
  struct Motion {
    double want_vx = 0, want_vy = 0, want_omega = 0;
    double vx = 0, vy = 0, omega = 0;
    Vec3 want_axes, axes;
    double want_opening = kRobot.fingers_open, opening = kRobot.fingers_open;
    std::uint32_t robot_contacts = 0, static_contacts = 0;
    std::uint64_t touching_robots = 0;  ///< by index, in the last step
    bool touching_static = false;
    int held_body = -1;
  };
  /// What is known of the piece in a body of the pool beyond `Piece`.
  struct Track {
    bool in_play = false;
    std::int64_t read_at = -1;            ///< step whose contacts the next five tell
    std::uint32_t left = 0, right = 0;    ///< robots whose finger touches it, as bits
    Holder support = Holder::kDispenser;  ///< kDispenser = touches no support
    int support_index = -1;
    bool touches_other = false;  ///< another piece
    Holder candidate = Holder::kDispenser;
    int candidate_index = -1, candidate_ticks = 0;
    double belt_x = 0;  ///< along the belt that runs below it, before the last step
    int belt = -1;
  };

  MujocoWorld(FloorPlan plan, FactoryModel factory, PhysicsTap* tap);

  template <class Id>
  static std::size_t at_index(Id id) {
    return static_cast<std::size_t>(id);
  }

  void drive(Motion& motion, const RobotIds& ids, double dt);
  void count_robot_contacts();
  void stop_arrived_belts();
  void read_piece_contacts();
  void note_support(Track& track, GeomUse other);
  void update_pieces();
  void update_holder(Piece& piece, Track& track);
  bool slid_in(const Piece& piece, const Track& track) const;
  void change_holder(Piece& piece, Holder to, int to_index);
  void take_out(PieceId id);
  Expected<PieceId> put_in_play(const Vec3& underside, const Stack& stack, StationId from, Holder to, int to_index);
  Piece* find_mutable(PieceId id);
  int body_of(PieceId id) const { return bodies_[static_cast<std::size_t>(id) - 1]; }
  Vec3 underside_of(int body) const;
  int nearest_shelf_spot(StationId station, const Vec3& in_station) const;
  int slide_spot(StationId station) const;

  FloorPlan plan_;
  PhysicsGate gate_;
  double step_;
  SimTime now_{};
  std::vector<Piece> pieces_;      ///< by id
  std::vector<int> bodies_;        ///< body of the pool by piece id - 1; -1 = out of play
  std::vector<Track> tracks_;      ///< by body of the pool
  std::vector<Motion> motions_;    ///< by robot
  std::vector<Belt> belts_;        ///< by station
  std::vector<int> slide_counts_;  ///< by station
  std::vector<HolderChange> changes_;
  std::size_t told_changes_ = 0;  ///< of them; the rest came by verbs and is told after the next `advance`
  std::vector<PieceId> slid_;     ///< of this tick
};

}  // namespace cxlab::sim
