#pragma once
// A factory floor as a book: which holder has which piece, where each belt and robot is at a time. There is no physics.
// The time of what happens by itself (a piece arrives at the end of a belt) is known in advance: an episode jumps to
// it.

#include <cstdint>
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
  RobotState robot(RobotId id) const override;
  bool belt_running(StationId id) const override { return belts_[index_of(id)].speed != 0; }
  Pose3 pose_in_holder(const Piece& piece) const override;
  std::uint64_t way_number(RobotId id) const override;
  std::uint64_t way_number(const Piece& piece) const override;
  std::vector<WayPoint> way(RobotId id) const override;
  std::vector<WayPoint> way(const Piece& piece) const override;
  const Piece* at(SpotId spot) const override;
  const Piece* on_belt(StationId id, double x) const override;

  // World
  /// Any length of time; what happens within it happens at its own time.
  Status advance(SimTime tick) override;
  SimTime next_event() const override;
  using World::dispense;
  Expected<PieceId> dispense(SpotId shelf, const Stack& stack) override;
  void run_belt(StationId station, double speed, double stop_x) override;
  void stop_belt(StationId station) override { belts_[index_of(station)] = {}; }
  void mount(PieceId id, Part part, std::uint8_t colour) override { piece(id).stack.mount(part, colour); }
  void unmount_cap(PieceId id) override { piece(id).stack.cap = 0; }
  void retire(PieceId piece, Holder to) override;
  void set_lights(StationId station, const Lights& lights) override { lights_[index_of(station)] = lights; }
  Lights lights(StationId station) const override { return lights_[index_of(station)]; }

  void go_on() override;

  void set_down(RobotId robot, const Pose2& to) override { motions_[index_of(robot)] = {{to}, {0}, {}, {}, 0}; }

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
    SimTime arrival = kNever;  ///< by the floor's clock, of the first piece at stop_x or at the belt's end
    std::uint64_t way = 0;     ///< its number, while pieces move
  };
  struct Motion {
    std::vector<Pose2> path;      ///< its first point is where the robot was at departure
    std::vector<double> reached;  ///< metres driven at each point of the path
    SimTime departure{}, arrival{};
    std::uint64_t way = 0;  ///< its number; 0 = it stands
  };

  Expected<PieceId> bring_out(const Source& from, double x_on_belt, const Stack& stack) override;
  const Piece* held_by(RobotId robot) const;
  Pose2 pose_at(RobotId robot, SimTime t) const;
  Vec3 gripper_in_world(RobotId robot) const;
  double x_on_belt(const Piece& piece) const;
  void put(Piece& piece, Holder to, int to_index, const Vec3& position);
  void plan_arrival(StationId id);
  void carry(StationId id, SimTime duration);
  void arrive(StationId id);
  void carry_held_pieces();

  std::vector<Belt> belts_;      ///< by station
  std::vector<Lights> lights_;   ///< by station
  std::vector<Motion> motions_;  ///< by robot
  std::uint64_t ways_ = 0;       ///< how many there have been
};

}  // namespace cxlab::sim
