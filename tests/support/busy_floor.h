#pragma once
// A drawn field on which every robot always has something to do: a client on the bus sends goals, cancels some, and
// watches. Bases appear at the base stations as they are taken; what is placed leaves play.

#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "cx/base/random.h"
#include "cx/bus/bus.h"
#include "scenarios/rcll/game/floor_plan.h"
#include "sim/ledger/ledger_world.h"
#include "sim/mujoco/mujoco_world.h"
#include "sim/skills/fleet.h"
#include "tests/support/files.h"
#include "tests/support/records.h"

namespace cxlab::sim {

inline FloorPlan drawn_floor(std::uint64_t seed, int robots = 3) {
  RandomStream random(seed, "layout");
  return rcll::make_floor_plan(rcll::draw_layout(random, false), {rcll::Team::kCyan}, robots);
}

class BusyFloor {
 public:
  struct Report {
    int drives = 0, picks = 0, places = 0, cancels = 0;
    int failures = 0;
    double longest_s = 0;
    double two_drive_s = 0;
    double handling_s = 0;  ///< of picks and places that began where they work
    int handled = 0;
    std::vector<std::string> trouble;
  };

  BusyFloor(World& world, std::uint64_t seed, double cancel_chance)
      : world_(world), random_(seed, "test"), cancel_chance_(cancel_chance), bus(registry, sink) {
    EXPECT_TRUE(registry.add_packages_in(interfaces_dir()));
  }

  /// After the fleet has joined.
  void connect() {
    node_ = bus.join(bus::ParticipantKind::kNode, bus::NodeName{"tester", "/", {}}, sink.open_stream("node/tester"));
    const auto& robots = world_.plan().robots;
    crew_.resize(robots.size());
    for (std::size_t i = 0; i < robots.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        const auto type = registry.action(kTypes[k]);
        ASSERT_TRUE(type);
        types_[k] = *type;
        const auto client = bus.create_action_client(
            node_, "/" + robots[i].name + "/" + std::string(to_string(static_cast<SkillKind>(k))), **type,
            {[this, i](const bus::Delivery& d) { answered(i, d); }, [this, i](const bus::Delivery& d) { heard(i, d); },
             [this, i](const bus::Delivery& d) { ended(i, d); }, [](const bus::Delivery&) {}});
        ASSERT_TRUE(client) << client.error().text();
        crew_[i].clients[k] = *client;
      }
    const auto blocked = rcll::unreachable_spots(world_.plan(), FloorMap::kClearance);
    for (std::size_t i = 0; i < world_.plan().spots.size(); ++i)
      if (std::ranges::find(blocked, static_cast<SpotId>(i)) == blocked.end()) spots_.push_back(static_cast<SpotId>(i));
  }

  void stock() {
    const FloorPlan& plan = world_.plan();
    for (std::size_t i = 0; i < plan.spots.size(); ++i) {
      const Spot& spot = plan.spots[i];
      const Station& station = plan.station(spot.station);
      if (station.kind == "BS" && spot.kind == SpotKind::kBeltOutput && !world_.at(static_cast<SpotId>(i)) &&
          !wanted(static_cast<SpotId>(i)))
        static_cast<void>(world_.dispense(spot.station, spot.rest_in_station.x(), any_product()));
      if (spot.kind == SpotKind::kShelf && world_.now() == SimTime{})
        static_cast<void>(world_.dispense(static_cast<SpotId>(i), Stack{4, {}, 1}));
    }
  }

  void act() {
    now_ = world_.floor_time();
    bus.deliver(node_);
    for (const PieceId piece : placed_)
      if (world_.find(piece)) world_.retire(piece, Holder::kGate);
    placed_.clear();
    for (std::size_t i = 0; i < crew_.size(); ++i) command(i);
    int driving = 0;
    for (const Member& m : crew_) driving += m.busy && m.phase == "drive";
    if (driving >= 2 && last_ < now_) report.two_drive_s += to_seconds(now_ - last_);
    last_ = now_;
  }
  SimTime next_due() const {
    SimTime next = kNever;
    for (const Member& m : crew_)
      if (!m.busy)
        next = std::min(next, m.idle_until);
      else if (m.cancel_at > now_)
        next = std::min(next, m.cancel_at);
    return world_.clock().when(next);
  }

 private:
  static constexpr const char* kTypes[] = {"cxlab_skills/action/DriveTo", "cxlab_skills/action/Pick",
                                           "cxlab_skills/action/Place"};
  struct Member {
    std::array<bus::EndpointId, 3> clients{};
    bool busy = false;
    SkillKind kind{};
    std::string target;
    std::string phase;
    std::optional<SpotId> spot;
    std::optional<PieceId> piece;
    bus::GoalId goal{};
    SimTime since{}, idle_until{}, cancel_at = kNever, handling_since{};
  };

  bool wanted(SpotId spot) const {
    return std::ranges::any_of(
        crew_, [&](const Member& m) { return m.busy && m.spot == spot && m.kind == SkillKind::kPlace; });
  }
  bool claimed(SpotId spot) const {
    return std::ranges::any_of(crew_, [&](const Member& m) { return m.busy && m.spot == spot; });
  }

  /// From a bare base to a C3.
  Stack any_product() {
    Stack stack{static_cast<std::uint8_t>(1 + random_.below(3)), {}, 0};
    const std::uint64_t rings = random_.below(4);
    for (std::uint64_t k = 0; k < rings; ++k) stack.rings[k] = static_cast<std::uint8_t>(1 + random_.below(4));
    stack.cap = static_cast<std::uint8_t>(random_.below(3));
    return stack;
  }

  void command(std::size_t i) {
    Member& m = crew_[i];
    if (m.busy) {
      if (now_ >= m.cancel_at && m.goal != bus::GoalId{}) {
        bus.cancel_goal(m.clients[static_cast<std::size_t>(m.kind)], m.goal);
        m.cancel_at = kNever;
        ++report.cancels;
      }
      return;
    }
    if (now_ < m.idle_until) return;
    const auto held = world_.robot(static_cast<RobotId>(i)).held;
    std::vector<SpotId> choices;
    m.kind = held ? SkillKind::kPlace : SkillKind::kPick;
    for (const SpotId id : spots_) {
      const Spot& spot = world_.plan().spot(id);
      const bool base_station = world_.plan().station(spot.station).kind == "BS";
      // Every robot may want the base station; elsewhere two would spoil each other's place.
      if (m.kind == SkillKind::kPick && world_.at(id) && (base_station || !claimed(id))) choices.push_back(id);
      if (m.kind == SkillKind::kPlace && spot.kind != SpotKind::kBeltOutput && !base_station && !world_.at(id) &&
          !claimed(id))
        choices.push_back(id);
    }
    if (choices.empty() || random_.chance(0.1)) {
      m.kind = SkillKind::kDriveTo;
      choices = spots_;
    }
    if (m.kind == SkillKind::kPick && random_.chance(0.4))
      std::erase_if(choices,
                    [&](SpotId id) { return world_.plan().station(world_.plan().spot(id).station).kind != "BS"; });
    if (choices.empty()) return;
    m.spot = choices[random_.below(choices.size())];
    m.target = world_.plan().spot(*m.spot).name;
    m.piece = held;
    m.busy = true;
    m.phase.clear();
    m.since = now_;
    m.goal = {};
    m.cancel_at = random_.chance(cancel_chance_) ? now_ + from_seconds(random_.uniform(0.1, 20)) : kNever;
    auto message = std::make_shared<bus::Message>(*types_[static_cast<std::size_t>(m.kind)]->goal);
    message->view().set("target", m.target);
    m.goal = bus.send_goal(m.clients[static_cast<std::size_t>(m.kind)], std::move(message));
  }

  void answered(std::size_t i, const bus::Delivery& d) {
    if (!d.accepted) trouble(i, "was refused");
  }
  void heard(std::size_t i, const bus::Delivery& d) {
    Member& m = crew_[i];
    m.phase = d.message->view().text("phase");
    if (m.phase == "align" || m.phase == "handle") m.handling_since = now_;
  }
  void ended(std::size_t i, const bus::Delivery& d) {
    Member& m = crew_[i];
    const bus::MessageView result = d.message->view();
    const double took = to_seconds(now_ - m.since);
    report.longest_s = std::max(report.longest_s, took);
    const bool done = d.status == bus::GoalStatus::kSucceeded;
    if (done && result.integer("success") == 0) trouble(i, "succeeded without success");
    if (m.kind == SkillKind::kDriveTo) ++report.drives;
    if (m.kind == SkillKind::kPick) ++report.picks;
    if (m.kind == SkillKind::kPlace) ++report.places;
    const auto code = result.integer("error_code");
    if (done && m.kind != SkillKind::kDriveTo) {
      report.handling_s += to_seconds(now_ - m.handling_since);
      ++report.handled;
    }
    const bool held = world_.robot(static_cast<RobotId>(i)).held.has_value();
    if (done && m.kind == SkillKind::kPick && !held) trouble(i, "picked nothing");
    if (done && m.kind == SkillKind::kPlace) placed_.push_back(*m.piece);
    // Another robot may have emptied the place on the way (202); everything else is trouble.
    if (code != 0 && code != 202) {
      ++report.failures;
      trouble(i,
              std::to_string(code) + " " + result.text("error") + " in " + m.phase + " after " + std::to_string(took));
    }
    if (took > 120) trouble(i, "took " + std::to_string(took) + " s");
    m.busy = false;
    m.spot.reset();
    m.idle_until = now_ + from_seconds(random_.chance(0.1) ? random_.uniform(1, 15) : random_.uniform(0, 0.3));
  }
  void trouble(std::size_t i, const std::string& what) {
    const Member& m = crew_[i];
    report.trouble.push_back(std::to_string(to_seconds(now_)) + " s: robot" + std::to_string(i + 1) + " " +
                             std::string(to_string(m.kind)) + " " + m.target + ": " + what);
  }

  World& world_;
  RandomStream random_;
  double cancel_chance_;
  std::array<const bus::ActionType*, 3> types_{};
  bus::ParticipantId node_{};
  std::vector<Member> crew_;
  std::vector<SpotId> spots_;
  std::vector<PieceId> placed_;
  SimTime now_{}, last_{};

 public:
  CountedRecords sink;
  bus::Registry registry;
  bus::Bus bus;
  Report report;
};

}  // namespace cxlab::sim
