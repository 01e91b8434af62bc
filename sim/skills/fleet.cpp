#include "sim/skills/fleet.h"

#include <algorithm>
#include <utility>

namespace cxlab::sim {
namespace {

constexpr double kPlaceRadius = 0.75;  ///< m: a zone's machine leaves room within that distance of its centre

}  // namespace

Fleet::Fleet(const WorldView& world, Places places)
    : world_(world), traffic_(world.plan()), places_(std::move(places)) {
  for (auto& [name, pose] : places_)
    if (const auto free = traffic_.standing_place(point_of(pose), kPlaceRadius)) {
      pose.x = free->x;
      pose.y = free->y;
    }
}

Expected<std::unique_ptr<Fleet>> Fleet::create(const WorldView& world, RobotBodies& bodies, Places places, bus::Bus& bus,
                                               RecordSink& sink) {
  std::unique_ptr<Fleet> fleet(new Fleet(world, std::move(places)));
  for (std::size_t i = 0; i < world.plan().robots.size(); ++i)
    fleet->skills_.push_back(
        std::make_unique<PhysicsSkills>(static_cast<RobotId>(i), world, bodies, fleet->traffic_));
  if (Status s = fleet->open(bus, sink); !s) return s.error();
  return fleet;
}

Expected<std::unique_ptr<Fleet>> Fleet::create(const WorldView& world, RobotBook& book, const TimedSkillsConfig& config,
                                               std::uint64_t seed, Places places, bus::Bus& bus, RecordSink& sink) {
  if (Status s = validate(config); !s) return s.error();
  std::unique_ptr<Fleet> fleet(new Fleet(world, std::move(places)));
  fleet->durations_.emplace(seed, "durations");
  fleet->faults_.emplace(seed, "faults");
  for (std::size_t i = 0; i < world.plan().robots.size(); ++i)
    fleet->skills_.push_back(std::make_unique<TimedSkills>(static_cast<RobotId>(i), world, book, fleet->traffic_, config,
                                                           *fleet->durations_, *fleet->faults_));
  if (Status s = fleet->open(bus, sink); !s) return s.error();
  return fleet;
}

Status Fleet::open(bus::Bus& bus, RecordSink& sink) {
  for (std::size_t i = 0; i < skills_.size(); ++i) {
    auto server = SkillServer::create(static_cast<RobotId>(i), world_.plan(), places_, *skills_[i], bus, sink);
    if (!server) return server.error();
    servers_.push_back(*std::move(server));
  }
  return {};
}

Status Fleet::sense(SimTime now) {
  traffic_.settle(now);
  for (auto& server : servers_) server->sense(now);
  return {};
}

Status Fleet::act(SimTime now) {
  for (auto& server : servers_) server->take(now);
  traffic_.plan(now);
  for (auto& skills : skills_) skills->act(now);
  for (auto& server : servers_) server->report_phase(now);
  return {};
}

SimTime Fleet::next_due() const {
  SimTime next = traffic_.next_due();
  for (const auto& skills : skills_) next = std::min(next, skills->next_due());
  return next;
}

std::vector<RobotStats> Fleet::stats() const {
  std::vector<RobotStats> stats;
  for (const auto& server : servers_) stats.push_back(server->stats(world_.now()));
  return stats;
}

}  // namespace cxlab::sim
