#pragma once
// The one way into a running physics world. Controls, fields of the model and the state are written here and nowhere
// else; each write goes to the log first, so that the same writes on the same model give the same physics.

#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include <xxhash.h>

#include "sim/mujoco/factory_model.h"
#include "sim/mujoco/physics_log.h"

namespace cxlab::sim {

/// Height of a piece's origin over its underside: the world counts in undersides, MuJoCo in origins.
inline constexpr double kPieceOrigin = kPiece.base_height / 2;

class PhysicsGate {
 public:
  /// All pieces parked, all belts still, robots at their starts. `log`, if any, takes every write.
  PhysicsGate(FactoryModel factory, const FloorPlan& plan, PhysicsLog* log = nullptr);

  /// Takes one step. Fails when the world diverges.
  Status step();
  std::int64_t steps() const { return steps_; }
  double time() const { return data_->time; }  ///< s
  /// Running hash of positions and velocities after every second step.
  std::uint64_t hash() const { return XXH3_64bits_digest(hash_.get()); }

  /// Carries out a write, one of a log as well.
  void write(const PhysicsWrite& write);
  /// Target of an actuator, rounded to kControlUnit; written when it changes.
  void control(int actuator, double value);
  void belt_speed(StationId station, double speed);
  // `body`: of the pool of pieces.
  void shape(std::size_t body, const Stack& stack);
  void place(std::size_t body, const Vec3& underside_in_world);
  void park(std::size_t body);
  void wake(std::size_t body);
  void carry(std::size_t body, bool on);
  void lights(StationId station, const Lights& lights);
  void set_down(RobotId robot, const Pose2& to);

  // --- A floor that is posed for a picture and takes no steps (sim/mujoco/posed_floor.h): nothing is logged
  void show_time(double seconds) { data_->time = seconds; }
  /// Where it stands, its gripper and its fingers.
  void show(RobotId robot, const RobotState& state);
  /// `body` is of the pool; its shape is written as ever.
  void show(std::size_t body, const Pose3& underside_in_world);

  const FactoryModel& factory() const { return factory_; }
  const mjModel& model() const { return *factory_.model; }
  const mjData& data() const { return *data_; }
  /// Whether MuJoCo moves that body of the pool, and looks for its contacts.
  bool is_awake(std::size_t body) const { return data_->body_awake[factory_.pieces[body].body] != 0; }
  const Lights& lights(StationId station) const { return lights_[index_of(station)]; }

 private:
  struct HashDeleter {
    void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
  };
  void apply_shape(const PieceIds& piece, const PhysicsWrite& write);
  void apply_slot(int geom, const std::vector<int>& materials, int colour, int contype);
  void move_base(const RobotIds& robot, const Pose2& to);
  void move_piece(const PieceIds& piece, const Vec3& origin, double gravity_compensation);

  FactoryModel factory_;
  std::unique_ptr<mjData, MjDeleter> data_;
  std::unique_ptr<XXH3_state_t, HashDeleter> hash_;
  PhysicsLog* log_;
  std::int64_t steps_ = 0;
  std::vector<std::int64_t> controls_;  ///< last written, in units
  std::vector<Lights> lights_;
  std::vector<int> woken_;          ///< bodies whose wake mark is taken back after the next step
  double piece_inverse_weight_[2];  ///< of a bare base, as compiled
};

/// Takes the writes of a log on a model of its own: the physics of a run without anything else.
class PhysicsReplay {
 public:
  /// `log` must outlive it.
  static Expected<PhysicsReplay> load(const FloorPlan& plan, const ModelOptions& options, std::string_view log);
  /// Steps until `steps` have been taken since the start.
  Status advance_to(std::int64_t steps);
  const PhysicsGate& gate() const { return *gate_; }
  std::uint64_t hash() const { return gate_->hash(); }
  const std::vector<std::filesystem::path>& files() const { return gate_->factory().files; }

 private:
  PhysicsReplay(std::unique_ptr<PhysicsGate> gate, std::string_view log) : gate_(std::move(gate)), reader_(log) {}
  Status read_next();

  std::unique_ptr<PhysicsGate> gate_;
  PhysicsLogReader reader_;
  std::optional<PhysicsWrite> next_;
};

}  // namespace cxlab::sim
