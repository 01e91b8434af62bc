#pragma once
// All robots of a floor with their skill servers and the traffic between them: one server of an episode.

#include <memory>
#include <optional>
#include <vector>

#include "cx/base/random.h"
#include "sim/server.h"
#include "sim/skills/physics_skills.h"
#include "sim/skills/skill_server.h"
#include "sim/skills/timed_skills.h"
#include "sim/traffic/traffic.h"

namespace cxlab::sim {

class Fleet final : public Server {
 public:
  using Places = SkillServer::Places;

  /// Physics tier. World, bodies, bus and sink outlive it. `places`: names that drive_to takes beside spots; a robot goes
  /// to the free standing place nearest to that pose, at most 0.75 m from it. Fails when the bus lacks cxlab_skills.
  static Expected<std::unique_ptr<Fleet>> create(const WorldView& world, RobotBodies& bodies, Places places, bus::Bus& bus,
                                                 RecordSink& sink);
  /// Timed tier; draws from the streams "durations" and "faults" of `seed`.
  static Expected<std::unique_ptr<Fleet>> create(const WorldView& world, RobotBook& book, const TimedSkillsConfig& config,
                                                 std::uint64_t seed, Places places, bus::Bus& bus, RecordSink& sink);

  Status sense(SimTime now) override;
  Status act(SimTime now) override;
  SimTime next_due() const override;

  std::vector<RobotStats> stats() const;

 private:
  Fleet(const WorldView& world, Places places);
  Status open(bus::Bus& bus, RecordSink& sink);

  const WorldView& world_;
  Traffic traffic_;
  Places places_;
  std::optional<RandomStream> durations_, faults_;
  std::vector<std::unique_ptr<RobotSkills>> skills_;
  std::vector<std::unique_ptr<SkillServer>> servers_;
};

}  // namespace cxlab::sim
