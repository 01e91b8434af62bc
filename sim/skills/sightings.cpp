#include "sim/skills/sightings.h"

#include <cmath>
#include <utility>

#include "cx/bus/needed.h"
#include "sim/skills/explore.h"

namespace cxlab::sim {
namespace {

constexpr SimTime kLookPeriod{200'000'000}, kPostPeriod{5'000'000'000};

}  // namespace

Expected<std::unique_ptr<Sightings>> Sightings::create(const WorldView& world, const SkillServer::Places& zones,
                                                       std::span<const bus::ParticipantId> robots, bus::Bus& bus,
                                                       SimTime until) {
  auto type = bus::needed_message(bus.registry(), "cxlab_skills/msg/Sightings");
  if (!type) return type.error();
  std::unique_ptr<Sightings> sightings(new Sightings(world, bus, until));
  sightings->type_ = *type;
  const FloorPlan& plan = world.plan();
  sightings->zones_.resize(plan.stations.size());
  for (const auto& [name, place] : zones)
    if (const auto station = station_in_zone(plan, place.middle)) sightings->zones_[index_of(*station)] = name;
  for (std::size_t i = 0; i < robots.size(); ++i) {
    auto topic = bus.advertise(robots[i], "/" + plan.robots[i].name + "/sightings", **type);
    if (!topic) return topic.error();
    sightings->robots_.push_back({*topic, std::vector<Seen>(plan.stations.size())});
  }
  return sightings;
}

void Sightings::look(SimTime now) {
  if (now < next_) return;
  next_ = now + kLookPeriod <= until_ ? now + kLookPeriod : kNever;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    Robot& robot = robots_[i];
    if (world_.is_off_field(static_cast<RobotId>(i))) continue;
    if (!look(world_.robot(static_cast<RobotId>(i)), robot.seen) && now < robot.post_at) continue;
    robot.post_at = now + kPostPeriod;
    post(robot);
  }
}

bool Sightings::look(const RobotState& state, std::vector<Seen>& seen) const {
  const FloorPlan& plan = world_.plan();
  const bool reads = std::abs(state.omega) <= kReadingTurn;
  bool news = false;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const auto station = static_cast<StationId>(i);
    if (seen[i] == Seen::kMarker) continue;
    if (reads && reads_marker(plan, state.pose_in_world, station))
      seen[i] = Seen::kMarker;
    else if (seen[i] == Seen::kNothing && sees_body(plan, state.pose_in_world.position(), station))
      seen[i] = Seen::kBody;
    else
      continue;
    news = true;
  }
  return news;
}

void Sightings::post(const Robot& robot) const {
  auto message = std::make_shared<bus::Message>(*type_);
  for (std::size_t i = 0; i < robot.seen.size(); ++i) {
    if (robot.seen[i] == Seen::kNothing) continue;
    const bus::MessageView sighting = message->view().append("machines");
    sighting.set("zone", zones_[i]);
    if (robot.seen[i] == Seen::kBody) continue;
    const Station& station = world_.plan().stations[i];
    sighting.set("machine", station.name).set("rotation", whole_degrees(station.pose_in_world.yaw));
  }
  bus_.publish(robot.topic, std::move(message));
}

}  // namespace cxlab::sim
