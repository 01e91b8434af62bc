#pragma once
// A factory floor as a book: who holds which piece, where each belt and robot is at a time. No physics; what happens by
// itself (a piece arrives at the end of a belt) has a time that is known in advance, so that an episode can jump to it.

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "sim/world.h"

namespace cxlab::sim {

class LedgerWorld final : public World, public RobotBook {
 public:
  /// All robots stand at their start poses, nothing is in play.
  explicit LedgerWorld(FloorPlan plan);

  // WorldView
  SimTime now() const override { return now_; }
  const FloorPlan& plan() const override { return plan_; }
  std::span<const Piece> pieces() const override { return pieces_; }
  const Piece* find(PieceId id) const override;
  RobotState robot(RobotId id) const override;
  bool belt_running(StationId id) const override { return belt(id).speed != 0; }
  const Piece* at(SpotId spot) const override;
  const Piece* on_belt(StationId id, double x) const override;
  int slide_count(StationId id) const override { return slide_counts_[static_cast<std::size_t>(id)]; }
  std::span<const HolderChange> changes() const override { return changes_; }

  // World
  /// Any length of time; what happens within it happens at its own time.
  Status advance(SimTime tick) override;
  SimTime next_event() const override;
  Expected<PieceId> dispense(StationId station, double x_on_belt, const Stack& stack) override;
  Expected<PieceId> dispense(SpotId shelf, const Stack& stack) override;
  void run_belt(StationId station, double speed, double stop_x) override;
  void stop_belt(StationId station) override;
  void mount(PieceId piece, Part part, std::uint8_t colour) override;
  void unmount_cap(PieceId piece) override;
  void retire(PieceId piece, Holder to) override;
  void set_lights(StationId station, const Lights& lights) override;
  Lights lights(StationId station) const override { return lights_[static_cast<std::size_t>(station)]; }

  // RobotBook
  void move_along(RobotId robot, std::span<const Pose2> path, SimTime departure, SimTime arrival) override;
  void stop(RobotId robot) override;
  Status grasp(RobotId robot, SpotId from) override;
  Status release(RobotId robot, SpotId to) override;
  void drop(RobotId robot) override;

 private:
  struct Belt {
    double speed = 0;  ///< m/s, + = towards the input; 0 = stands
    double stop_x = 0;
    SimTime arrival = kNever;  ///< of the first piece at stop_x or over the end
  };
  struct Motion {
    std::vector<Pose2> path;      ///< its first point is where the robot was at departure
    std::vector<double> reached;  ///< metres driven at each point of the path
    SimTime departure{}, arrival{};
  };

  const Belt& belt(StationId id) const { return belts_[static_cast<std::size_t>(id)]; }
  Belt& belt(StationId id) { return belts_[static_cast<std::size_t>(id)]; }
  Piece* find_piece(PieceId id);
  Piece* held_by(RobotId robot);
  const Piece* held_by(RobotId robot) const { return const_cast<LedgerWorld*>(this)->held_by(robot); }
  Pose2 pose_at(RobotId robot, SimTime t) const;
  Vec3 gripper_in_world(RobotId robot) const;
  double x_on_belt(const Piece& piece) const;
  Expected<PieceId> add(const Stack& stack, Holder holder, int index, const Vec3& position, int from_index);
  void pass(Piece& piece, Holder to, int index, const Vec3& position, std::vector<HolderChange>& changes);
  void remove(PieceId id);
  void plan_arrival(StationId id);
  void carry(StationId id, SimTime duration);
  void arrive(StationId id);
  void carry_held_pieces();

  FloorPlan plan_;
  SimTime now_{};
  std::vector<Piece> pieces_;
  std::int32_t last_id_ = 0;
  std::vector<Belt> belts_;
  std::vector<Lights> lights_;
  std::vector<int> slide_counts_;
  std::vector<Motion> motions_;
  std::vector<HolderChange> changes_;  ///< what a reader sees: verbs before the last advance, then that advance
  std::vector<HolderChange> booked_;   ///< of verbs since
};

}  // namespace cxlab::sim
