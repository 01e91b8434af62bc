#pragma once
// Maintenance of robots: why a robot must leave the field, for how long, what that costs its team, and how it comes
// back. The rules are the same by referee box and rulebook: each robot has two maintenances in a game, the second costs
// 5 points, a third disqualifies it; so does one that lasts longer than 120 s and 15 s of grace.
//
// In a tick: `judge` decides, `act` carries robots off the field and back.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/record_sink.h"
#include "scenarios/rcll/rules/event_log.h"
#include "scenarios/rcll/rules/referee.h"
#include "scenarios/rcll/rules/types.h"
#include "sim/faults/fault.h"
#include "sim/world.h"

namespace cxlab::rcll {

enum class RobotDuty : std::uint8_t { kActive, kMaintenance, kDisqualified };
template <>
inline constexpr std::array<std::string_view, 3> kNames<RobotDuty>{"ACTIVE", "MAINTENANCE", "DISQUALIFIED"};

enum class MaintenanceCause : std::uint8_t { kRequest, kFault, kOutside, kBlocking, kPushing };
template <>
inline constexpr std::array<std::string_view, 5> kNames<MaintenanceCause>{"request", "fault", "outside", "blocking",
                                                                          "pushing"};

inline constexpr SimTime kMaintenanceTime = std::chrono::seconds(120);
inline constexpr SimTime kMaintenanceWarning = std::chrono::seconds(105);
inline constexpr SimTime kMaintenanceGrace = std::chrono::seconds(15);
inline constexpr SimTime kShortestMaintenance = std::chrono::seconds(1);  ///< its goal ends meanwhile
inline constexpr SimTime kBlockingTime = std::chrono::seconds(10);
inline constexpr int kMaintenances = 2;  ///< of a robot in a game

class Maintenance {
 public:
  struct Robot {
    sim::RobotId id{};
    Team team{};
    int number = 0;  ///< in its team, from 1
    RobotDuty duty = RobotDuty::kActive;
    int cycles = 0;  ///< maintenances so far
    // The current maintenance:
    SimTime since{}, needs{};  ///< its begin; how long people need
    bool asked_for = false;    ///< by the team, which must ask for its end, too
    bool asked_back = false;
    bool warned = false;
    SimTime blocking_since = kNever;
    sim::Vec2 velocity = sim::Vec2::Zero();  ///< at the last look, m/s in the world
  };

  /// People need `repair` at least. Strikes of faults go to `sink`. All outlive it.
  Maintenance(sim::World& world, GameReferee& referee, SimTime repair, EventLog& events, RecordSink& sink);

  /// Takes those of `faults` that send robots to maintenance; strikes are written to the stream "faults".
  void take(std::span<const sim::Fault> faults, std::uint64_t seed);
  /// A team asks for maintenance of a robot, or for its end; judged with the next tick.
  void request(Team team, const std::string& color, int number, bool maintenance, SimTime now);

  void judge(SimTime now);
  void act(SimTime now);
  SimTime next_due() const;

  const std::vector<Robot>& robots() const { return robots_; }
  /// The rest of the 120 s; 0 when it is not in maintenance.
  SimTime remaining(const Robot& robot, SimTime now) const;
  /// Grows with every change of a robot's duty.
  std::uint64_t changes() const { return changes_; }

 private:
  struct Request {
    Team team{};
    std::string color;
    int number = 0;
    bool maintenance = false;
    SimTime at{};
  };
  struct Fault {
    sim::FaultTimer timer;
    std::size_t robot = 0;
  };

  void grant(const Request& request, SimTime now);
  void begin(Robot& robot, MaintenanceCause cause, SimTime needs, SimTime now);
  void disqualify(Robot& robot, std::string_view reason, SimTime now);
  void watch(Robot& robot, SimTime now);
  bool wants_back(const Robot& robot, SimTime now) const;
  SimTime back_at(const Robot& robot) const;
  bool outside(const Robot& robot) const;
  bool blocks(const Robot& robot) const;
  bool pushes(const Robot& robot) const;
  std::optional<sim::Pose2> free_place(const Robot& robot) const;
  DutyChanged change_of(const Robot& robot, std::string_view state) const;

  sim::World& world_;
  GameReferee& referee_;
  SimTime repair_;
  EventLog& events_;
  RecordSink& sink_;
  std::vector<Robot> robots_;  ///< by id
  std::vector<Fault> faults_;
  std::vector<Request> requests_;
  std::uint64_t changes_ = 0;
  SimTime retry_at_ = kNever;  ///< of a robot whose places are taken
  RecordData data_;
};

}  // namespace cxlab::rcll
