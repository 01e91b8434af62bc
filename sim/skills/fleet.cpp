#include "sim/skills/fleet.h"

#include <algorithm>
#include <string>
#include <utility>

#include "sim/skills/faulty_skills.h"

namespace cxlab::sim {
namespace {

constexpr double kPlaceRadius = 0.75;  ///< m: a zone's machine leaves room within that distance of its centre

}  // namespace

Fleet::Fleet(const WorldView& world, const Places& places, RecordSink& sink)
    : world_(world), records_(world, sink), traffic_(world.plan()) {
  for (const auto& [name, pose] : places) {
    const Vec2 stand = traffic_.standing_place(pose.position(), kPlaceRadius).value_or(pose.position());
    places_[name] = {{stand.x(), stand.y(), pose.yaw}, pose.position()};
  }
}

Expected<std::unique_ptr<Fleet>> Fleet::create(const WorldView& world, RobotBodies& bodies, const Places& places,
                                               bus::Bus& bus, RecordSink& sink, FleetFaults faults) {
  std::unique_ptr<Fleet> fleet(new Fleet(world, places, sink));
  for (std::size_t i = 0; i < world.plan().robots.size(); ++i)
    fleet->skills_.push_back(std::make_unique<PhysicsSkills>(static_cast<RobotId>(i), world, bodies, fleet->traffic_));
  if (Status s = fleet->open(bus, faults); !s) return s.error();
  return fleet;
}

Expected<std::unique_ptr<Fleet>> Fleet::create(const WorldView& world, RobotBook& book, const TimedSkillsConfig& config,
                                               std::uint64_t seed, const Places& places, bus::Bus& bus,
                                               RecordSink& sink, FleetFaults faults) {
  if (Status s = validate(config); !s) return s.error();
  std::unique_ptr<Fleet> fleet(new Fleet(world, places, sink));
  for (std::size_t i = 0; i < world.plan().robots.size(); ++i)
    fleet->skills_.push_back(
        std::make_unique<TimedSkills>(static_cast<RobotId>(i), world, book, fleet->traffic_, config, seed));
  if (Status s = fleet->open(bus, faults); !s) return s.error();
  return fleet;
}

Status Fleet::open(bus::Bus& bus, const FleetFaults& faults) {
  std::vector<std::string> names;
  for (const RobotStart& robot : world_.plan().robots) names.push_back(robot.name);
  for (const Fault& fault : faults.faults)
    if (fault.machine.empty() && names.empty())
      return input_error(std::string(to_string(fault.kind)) + ": there are no robots", fault.origin);
    else if (!fault.robot.empty() && std::ranges::find(names, fault.robot) == names.end())
      return input_error("robot: no robot '" + fault.robot + "'" + did_you_mean(fault.robot, names), fault.origin);
  if (!faults.faults.empty())
    for (std::size_t i = 0; i < skills_.size(); ++i)
      skills_[i] = std::make_unique<FaultySkills>(std::move(skills_[i]), static_cast<RobotId>(i), world_, traffic_,
                                                  faults.faults, faults.seed, records_);
  for (std::size_t i = 0; i < skills_.size(); ++i) {
    auto server = SkillServer::create(static_cast<RobotId>(i), world_.plan(), places_, *skills_[i], bus, records_);
    if (!server) return server.error();
    servers_.push_back(*std::move(server));
  }
  return {};
}

Status Fleet::watch(bus::Bus& bus, SimTime until) {
  std::vector<bus::ParticipantId> nodes;
  for (const auto& server : servers_) nodes.push_back(server->node());
  auto sightings = Sightings::create(world_, places_, nodes, bus, until);
  if (!sightings) return sightings.error();
  sightings_ = *std::move(sightings);
  return {};
}

void Fleet::ask_whether_known(const std::function<bool(RobotId, StationId)>& knows) {
  for (std::size_t i = 0; i < servers_.size(); ++i)
    servers_[i]->ask_whether_known([knows, robot = static_cast<RobotId>(i)](StationId s) { return knows(robot, s); });
}

Status Fleet::sense(SimTime) {
  const SimTime now = world_.floor_time();
  traffic_.settle(now);
  for (std::size_t i = 0; i < servers_.size(); ++i)
    if (const auto robot = static_cast<RobotId>(i); servers_[i]->off_field() != world_.is_off_field(robot)) {
      traffic_.set_down(robot, world_.robot(robot).pose_in_world, now);
      servers_[i]->set_off_field(world_.is_off_field(robot), now);
    }
  if (world_.halted()) return {};
  if (sightings_) sightings_->look(now);
  for (auto& server : servers_) server->sense(now);
  return {};
}

Status Fleet::act(SimTime) {
  const SimTime now = world_.floor_time();
  if (std::exchange(halted_, world_.halted()) && !halted_)
    for (auto& skills : skills_) skills->resume(now);
  for (auto& server : servers_) server->take(now);
  if (halted_) return {};
  traffic_.plan(now);
  for (auto& skills : skills_) skills->act(now);
  for (auto& server : servers_) server->report_phase(now);
  return {};
}

SimTime Fleet::next_due() const {
  for (std::size_t i = 0; i < servers_.size(); ++i)
    if (servers_[i]->off_field() != world_.is_off_field(static_cast<RobotId>(i))) return world_.now();
  if (world_.halted()) return kNever;
  SimTime next = std::min(traffic_.next_due(), sightings_ ? sightings_->next_due() : kNever);
  for (const auto& skills : skills_) next = std::min(next, skills->next_due());
  return world_.clock().when(next);
}

std::vector<RobotStats> Fleet::stats() const {
  std::vector<RobotStats> stats;
  for (const auto& server : servers_) stats.push_back(server->stats(world_.floor_time()));
  return stats;
}

}  // namespace cxlab::sim
