#pragma once
// What robots have seen of machines, wherever they were, on a topic for each robot: /robot1/sightings.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/bus/bus.h"
#include "sim/skills/skill_server.h"
#include "sim/world.h"

namespace cxlab::sim {

class Sightings {
 public:
  /// Robots look until that time. World and bus outlive it; `robots`: the node of each.
  static Expected<std::unique_ptr<Sightings>> create(const WorldView& world, const SkillServer::Places& zones,
                                                     std::span<const bus::ParticipantId> robots, bus::Bus& bus,
                                                     SimTime until);

  /// Posts what each robot has seen when there is something new, and from time to time for those who came later.
  void look(SimTime now);
  SimTime next_due() const { return next_; }
  /// Whether the robot has read a marker of the station.
  bool has_read(RobotId robot, StationId station) const {
    return robots_[index_of(robot)].seen[index_of(station)] == Seen::kMarker;
  }

 private:
  enum class Seen : std::uint8_t { kNothing, kBody, kMarker };
  struct Robot {
    bus::EndpointId topic{};
    std::vector<Seen> seen;  ///< by station
    SimTime post_at = kNever;
  };

  Sightings(const WorldView& world, bus::Bus& bus, SimTime until) : world_(world), bus_(bus), until_(until) {}
  /// Whether there was something new.
  bool look(const RobotState& state, std::vector<Seen>& seen) const;
  void post(const Robot& robot) const;

  const WorldView& world_;
  bus::Bus& bus_;
  SimTime until_, next_{};
  const bus::MessageType* type_ = nullptr;
  std::vector<std::string> zones_;  ///< by station
  std::vector<Robot> robots_;
};

}  // namespace cxlab::sim
