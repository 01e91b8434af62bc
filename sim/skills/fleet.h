#pragma once
// All robots of a floor with their skill servers and the traffic between them: one server of an episode. Skills,
// traffic and faults go by the floor's clock. While the floor is halted goals are taken and begin when it goes on.

#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "cx/run/parts.h"
#include "sim/faults/fault.h"
#include "sim/floor_records.h"
#include "sim/skills/physics_skills.h"
#include "sim/skills/sightings.h"
#include "sim/skills/skill_server.h"
#include "sim/skills/timed_skills.h"
#include "sim/traffic/traffic.h"

namespace cxlab::sim {

/// The faults of robots and their skills, and the seed of their chance. The fleet reads them when it is made.
struct FleetFaults {
  std::span<const Fault> faults;
  std::uint64_t seed = 0;
};

class Fleet final : public Server {
 public:
  using Places = std::map<std::string, Pose2, std::less<>>;

  /// Physics tier. World, bodies, bus and sink outlive it. `places`: zones, which skills accept besides spots, by their
  /// middle; a robot goes to the free standing place nearest to that pose, at most 0.75 m from it. Fails when the bus
  /// lacks cxlab_skills.
  static Expected<std::unique_ptr<Fleet>> create(const WorldView& world, RobotBodies& bodies, const Places& places,
                                                 bus::Bus& bus, RecordSink& sink, FleetFaults faults = {});
  /// Timed tier; draws from the streams "durations/<robot>" and "failures/<robot>" of `seed`.
  static Expected<std::unique_ptr<Fleet>> create(const WorldView& world, RobotBook& book,
                                                 const TimedSkillsConfig& config, std::uint64_t seed,
                                                 const Places& places, bus::Bus& bus, RecordSink& sink,
                                                 FleetFaults faults = {});

  /// Until that time robots tell what they see of machines.
  Status watch(bus::Bus& bus, SimTime until);
  /// Whether the robot has read a marker of the station, since somebody watches.
  bool has_read(RobotId robot, StationId station) const { return sightings_ && sightings_->has_read(robot, station); }
  /// Robots cannot go to spots of other stations than those that they know.
  void ask_whether_known(const std::function<bool(RobotId, StationId)>& knows);

  Status sense(SimTime now) override;
  Status act(SimTime now) override;
  SimTime next_due() const override;

  std::vector<RobotStats> stats() const;
  /// As `SkillServer::doing`.
  const std::string& doing(RobotId robot) const { return servers_[index_of(robot)]->doing(); }

 private:
  Fleet(const WorldView& world, const Places& places, RecordSink& sink);
  Status open(bus::Bus& bus, const FleetFaults& faults);

  const WorldView& world_;
  FloorRecords records_;
  Traffic traffic_;
  SkillServer::Places places_;
  std::vector<std::unique_ptr<RobotSkills>> skills_;
  std::vector<std::unique_ptr<SkillServer>> servers_;
  std::unique_ptr<Sightings> sightings_;  ///< null: nobody watches
  bool halted_ = false;                   ///< at the last `act`
};

}  // namespace cxlab::sim
