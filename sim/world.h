#pragma once
// A factory floor as everybody sees it: stations with spots, belts, pieces, robots. `sim/mujoco` simulates it,
// `sim/ledger` keeps a book of which holder has which piece. Nothing here knows the rules of a game.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/record_sink.h"
#include "cx/base/time.h"
#include "cx/run/parts.h"
#include "sim/floor_clock.h"
#include "sim/geometry.h"
#include "sim/pose.h"
#include "sim/pose3.h"

namespace cxlab::sim {

enum class PieceId : std::int32_t {};    ///< counted from 1 in order of dispensing, never used again
enum class RobotId : std::int32_t {};    ///< index into FloorPlan::robots
enum class StationId : std::int32_t {};  ///< index into FloorPlan::stations
enum class SpotId : std::int32_t {};     ///< index into FloorPlan::spots
/// An id as the index of a vector that has one element for each.
template <class Id>
constexpr std::size_t index_of(Id id) {
  return static_cast<std::size_t>(id);
}

enum class Part : std::uint8_t { kRing, kCap };
/// A product: one body with five slots. Colours are the numbers of the scenario's enums; 0 = slot empty.
struct Stack {
  std::uint8_t base = 0;
  std::array<std::uint8_t, 3> rings{};
  std::uint8_t cap = 0;
  /// Adds a ring, in the next free slot, or the cap. A fourth ring is a bug of the caller.
  void mount(Part part, std::uint8_t colour);
  friend bool operator==(const Stack&, const Stack&) = default;
};

/// Where a piece can be taken or put by a robot.
enum class SpotKind : std::uint8_t { kBeltInput, kBeltOutput, kShelf, kSlide };
struct Spot {
  std::string name;  ///< "C-CS1-INPUT", "C-CS1-OUTPUT", "C-CS1-SHELF-LEFT" (MIDDLE, RIGHT), "C-RS1-SLIDE"
  StationId station{};
  SpotKind kind{};
  Vec3 rest_in_station;  ///< centre of the underside of a piece that rests there
  Vec3 rest_in_world;
  Pose2 align_in_world;  ///< of a robot before and after it uses the spot: facing the machine, in line with the spot
  Pose2 work_in_world;   ///< of a robot that uses the spot
  /// The ground that a robot covers with its centre while it works there.
  Segment footprint() const { return {align_in_world.position(), work_in_world.position()}; }
};
/// A machine. Frame: x from output to input, y left of it, z up, origin on the floor under its centre.
struct Station {
  std::string name;  ///< "C-BS"
  std::string kind;  ///< "BS" "CS" "RS" "SS" "DS"
  Pose2 pose_in_world;
  bool has_belt = true;
};
struct RobotStart {
  std::string name;
  Pose2 pose_in_world;
};
/// What stands where, fixed for an episode.
struct FloorPlan {
  double min_x = -kField.half_length, max_x = kField.half_length, min_y = 0, max_y = kField.width;
  std::vector<Segment> walls;  ///< physical; the border closes the field to driving everywhere
  std::vector<Station> stations;
  std::vector<Spot> spots;
  std::vector<RobotStart> robots;

  /// From a point to the nearest machine or wall, in m; the border does not count.
  double clearance(const Vec2& p) const;
  std::optional<SpotId> find_spot(std::string_view name) const;
  std::optional<StationId> find_station(std::string_view name) const;
  const Spot& spot(SpotId id) const { return spots[index_of(id)]; }
  const Station& station(StationId id) const { return stations[index_of(id)]; }
  const RobotStart& robot(RobotId id) const { return robots[index_of(id)]; }
};
/// The spots that a station of that kind has, with the poses of docs/reference/models.md. `pose` is the station's.
std::vector<Spot> spots_of(const Station& station, StationId id);

enum class Holder : std::uint8_t { kDispenser, kGripper, kBelt, kSlot, kSlide, kFloor, kGate, kStorage, kCrew };
std::string_view to_string(Holder holder);  ///< "dispenser" ...

/// A piece in play.
struct Piece {
  PieceId id{};
  Stack stack;
  Holder holder{};
  int holder_index = -1;                  ///< robot, station or spot (slot, slide) by kind of holder
  Vec3 position_in_world = Vec3::Zero();  ///< of the underside's centre
  std::optional<RobotId> held_by;         ///< the last robot that held it and holds it no more
  /// The station that holds it: it lies on its belt, shelf or slide.
  std::optional<StationId> station(const FloorPlan& plan) const;
  template <class Id>
  bool is_with(Holder kind, Id which) const {
    return holder == kind && holder_index == static_cast<int>(which);
  }
};
/// One piece passed from one holder to another; the referee writes it down.
struct HolderChange {
  PieceId piece{};
  Holder from{}, to{};
  int from_index = -1, to_index = -1;
  Vec3 position_in_world = Vec3::Zero();
  SimTime at{};  ///< by the floor's clock
};

struct RobotState {
  Pose2 pose_in_world;
  double vx = 0, vy = 0, omega = 0;  ///< in the world, m/s, rad/s
  Vec3 gripper = Vec3::Zero();       ///< axes forward, left, up: distances from home (RobotGeometry)
  double finger_opening = 0;
  std::optional<PieceId> held;        ///< touched by both fingers and off every other support (or so booked)
  std::uint32_t touching = 0;         ///< robots that its hull touched within the last `advance`, as bits
  std::uint32_t robot_contacts = 0;   ///< new contacts with other robots since the start
  std::uint32_t static_contacts = 0;  ///< new contacts of the hull with machines or walls since the start
};

enum class Light : std::uint8_t { kOff, kOn, kBlink };
struct Lights {
  Light red = Light::kOff, yellow = Light::kOff, green = Light::kOff;
  friend bool operator==(const Lights&, const Lights&) = default;
};

/// What one can see. Referee, machines and skills read only this.
class WorldView {
 public:
  virtual ~WorldView() = default;
  SimTime now() const { return now_; }
  const FloorClock& clock() const { return clock_; }
  bool halted() const { return clock_.halted(); }
  /// The time that the floor's clock shows now.
  SimTime floor_time() const { return clock_.at(now_); }
  /// The simulated time of something that happened at that time of the floor's clock.
  SimTime simulated(SimTime floor) const { return floor == floor_time() ? now_ : clock_.when(floor); }
  const FloorPlan& plan() const { return plan_; }
  std::span<const Piece> pieces() const { return pieces_; }  ///< in play, by id
  const Piece* find(PieceId id) const;                       ///< nullptr when out of play
  virtual RobotState robot(RobotId id) const = 0;
  /// People have taken the robot off the field.
  bool is_off_field(RobotId id) const { return off_field_[index_of(id)]; }
  virtual bool belt_running(StationId id) const = 0;
  /// Seen from the robot or station that holds the piece, or from the world if none does.
  virtual Pose3 pose_in_holder(const Piece& piece) const;
  /// The number of a way that the world knows in advance, of a robot or of a piece on a belt that moves by itself. Each
  /// way has another number. 0 means that it stands, or that its motion results step by step.
  virtual std::uint64_t way_number(RobotId) const { return 0; }
  virtual std::uint64_t way_number(const Piece&) const { return 0; }
  /// The rest of that way, by simulated time. Poses of a piece are seen from its holder.
  virtual std::vector<WayPoint> way(RobotId) const { return {}; }
  virtual std::vector<WayPoint> way(const Piece&) const { return {}; }
  /// The piece that lies at that spot (within 10 mm along and 15 mm across on a belt, 40 mm on a shelf), not held.
  virtual const Piece* at(SpotId spot) const = 0;
  /// The piece on the station's belt nearest to `x` (station frame), within 10 mm, not held; nullptr if none.
  virtual const Piece* on_belt(StationId id, double x) const = 0;
  /// Payments: pieces that went past the mouth of this station's slide since the start, each of which is then out of
  /// play, by the robots that put them there.
  std::span<const std::optional<RobotId>> slid(StationId id) const { return slid_[index_of(id)]; }
  /// Holder changes by verbs called since the `advance` before the last one, then those within the last `advance`. A
  /// reader that looks once after each `advance` sees every change once, in order of time.
  std::span<const HolderChange> changes() const { return {changes_.data(), visible_changes_}; }

 protected:
  explicit WorldView(FloorPlan plan)
      : plan_(std::move(plan)), slid_(plan_.stations.size()), off_field_(plan_.robots.size()) {}

  Piece& piece(PieceId id);  ///< which is in play
  /// Where pieces that a station brings out come from.
  struct Source {
    StationId station{};
    std::optional<PieceId> stored = {};  ///< the piece that was retired to its storage; else a new one is dispensed
  };
  /// A piece that comes into play. The reference holds until the next `add_piece` or `remove`.
  Piece& add_piece(const Stack& stack, const Source& from, const Vec3& position, Holder to, int to_index);
  /// Gives the piece a new holder and notes the change with the piece's position.
  void pass(Piece& piece, Holder to, int to_index);
  void remove(PieceId id);
  // Around an `advance`.
  void begin_changes();
  void end_changes() { visible_changes_ = changes_.size(); }

  FloorPlan plan_;
  SimTime now_{};
  FloorClock clock_;
  std::vector<Piece> pieces_;
  std::vector<std::vector<std::optional<RobotId>>> slid_;  ///< by station
  std::vector<bool> off_field_;                            ///< by robot

 private:
  std::int32_t last_id_ = 0;
  std::vector<HolderChange> changes_;
  std::size_t visible_changes_ = 0;
};

/// The verbs of machines and of people: what the factory's own hardware does to matter, and where people carry robots.
/// Called in the act phase of a tick.
class World : public WorldView, public Simulation {
 public:
  using WorldView::WorldView;

  /// A new piece appears at the belt's processing point x (station frame), or on a shelf spot. Fails if the place is
  /// taken or no spare body is left.
  Expected<PieceId> dispense(StationId station, double x_on_belt, const Stack& stack) {
    return bring_out({station}, x_on_belt, stack);
  }
  virtual Expected<PieceId> dispense(SpotId shelf, const Stack& stack) = 0;
  /// Likewise, a piece that was retired to the station's storage comes back with its id.
  Expected<PieceId> unstore(StationId station, double x_on_belt, const Stack& stack, PieceId stored) {
    return bring_out({station, stored}, x_on_belt, stack);
  }
  /// Runs the belt at `speed` (m/s, + = towards the input) until a piece reaches `stop_x`, or until stopped.
  virtual void run_belt(StationId station, double speed, double stop_x) = 0;
  virtual void stop_belt(StationId station) = 0;
  /// Puts a ring (next free slot) or the cap on the piece.
  virtual void mount(PieceId piece, Part part, std::uint8_t colour) = 0;
  /// Takes the cap off.
  virtual void unmount_cap(PieceId piece) = 0;
  /// Takes the piece out of play (through a gate, by the referee); `to` is where it went.
  virtual void retire(PieceId piece, Holder to) = 0;
  virtual void set_lights(StationId station, const Lights& lights) = 0;
  virtual Lights lights(StationId station) const = 0;

  /// People take what the robot holds out of play, the robot off the field, and set it down there.
  void take_off_field(RobotId robot, const Pose2& to);
  /// People set the robot down on a free place of the field.
  void bring_back(RobotId robot, const Pose2& to);

  /// Belts and robots stand, and the floor's clock with them, until `go_on`. Robots brake as hard as they can. May be
  /// called in the judge phase of a tick.
  virtual void halt() { clock_.halt(now_); }
  virtual void go_on() { clock_.go_on(now_); }

 protected:
  virtual Expected<PieceId> bring_out(const Source& from, double x_on_belt, const Stack& stack) = 0;
  /// The robot stands there; it holds nothing.
  virtual void set_down(RobotId robot, const Pose2& to) = 0;
};

/// The nearest axes of a gripper that its strokes allow.
Vec3 within_strokes(const Vec3& axes);

/// Robots as bodies with motors: what a physics skill commands. Limits of speed and acceleration apply inside.
class RobotBodies {
 public:
  virtual ~RobotBodies() = default;
  /// Wanted velocity in the world frame; held until the next command.
  virtual void command_base(RobotId robot, double vx, double vy, double omega) = 0;
  /// Wanted gripper axes; the axes move at no more than 0.1 m/s.
  virtual void command_gripper(RobotId robot, const Vec3& axes) = 0;
  /// 0.035 = wide open, negative = squeeze (docs/reference/models.md).
  virtual void command_fingers(RobotId robot, double opening) = 0;
};

/// Robots as entries of a book: what a timed skill writes.
class RobotBook {
 public:
  virtual ~RobotBook() = default;
  /// The robot moves along the polyline at constant speed and is at its end at `arrival`, facing as there. Times are
  /// those of the floor's clock.
  virtual void move_along(RobotId robot, std::span<const Pose2> path, SimTime departure, SimTime arrival) = 0;
  virtual void stop(RobotId robot) = 0;                  ///< where it is now
  virtual Status grasp(RobotId robot, SpotId from) = 0;  ///< the piece there is now held
  /// The held piece now lies there (slide: counted, out of play).
  virtual Status release(RobotId robot, SpotId to) = 0;
  virtual void drop(RobotId robot) = 0;  ///< to the floor
};

}  // namespace cxlab::sim
