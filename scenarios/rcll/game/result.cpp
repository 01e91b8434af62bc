#include "scenarios/rcll/game/result.h"
#include "cx/base/json.h"

#include <algorithm>
#include <cstdio>

namespace cxlab::rcll {

namespace {

Json team_json(const Score& score) {
  Json kinds = Json::object();
  for (std::size_t kind = 0; kind < kPointKinds; ++kind)
    kinds[std::string(to_string(static_cast<PointKind>(kind)))] = score.by_kind[kind];
  return {{"points", score.total()}, {"by_kind", std::move(kinds)}};
}

/// The simulated time of something that happened or, if the game is not paused from now on, will happen.
SimTime simulated(const Factory& factory, SimTime time) {
  const sim::WorldView& floor = factory.floor();
  return time > floor.floor_time() ? floor.now() + (time - floor.floor_time()) : floor.simulated(time);
}

Json order_json(const OrderState& state, SimTime ordered, std::optional<SimTime> delivered, Team team) {
  const auto index = static_cast<std::size_t>(team);
  return {{"id", state.order.id},
          {"complexity", to_string(state.order.complexity)},
          {"ordered", to_seconds(ordered)},
          {"delivered_at", delivered ? Json(to_seconds(*delivered)) : Json(nullptr)},
          {"correct", state.delivered[index] > 0},
          {"points", state.points[index]}};
}

Json delivery_json(const Delivery& d, SimTime at) {
  return {{"order", d.order},     {"team", to_string(d.team)}, {"time", to_seconds(at)},
          {"correct", d.correct}, {"late_s", d.late_s},        {"points", d.points}};
}

Json robot_json(const sim::RobotStats& s, const Maintenance::Robot& duty, int contacts) {
  return {{"name", s.name},
          {"busy_s", s.busy_s},
          {"drive_s", s.drive_s},
          {"wait_s", s.wait_s},
          {"skills", s.skills},
          {"failures", s.failures},
          {"contacts", contacts},
          {"state", to_string(duty.duty)},
          {"maintenances", duty.cycles}};
}

template <class... Values>
std::string line(const char* format, Values... values) {
  char text[256];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

}  // namespace

void report_teams(const Factory& factory, Result& result) {
  Json teams = Json::object();
  for (const Team team : kTeams) {
    const Score& score = factory.referee().score(team);
    teams[std::string(to_string(team))] = team_json(score);
    result.score_board +=
        line("%-8s %4lld points ", std::string(to_string(team)).c_str(), static_cast<long long>(score.total()));
    for (std::size_t kind = 0; kind < kPointKinds; ++kind)
      if (score.by_kind[kind] != 0)
        result.score_board +=
            "  " + std::string(to_string(static_cast<PointKind>(kind))) + ' ' + std::to_string(score.by_kind[kind]);
    result.score_board += '\n';
  }
  result.set("teams", json_text(teams));
}

void report_orders(const Factory& factory, Result& result) {
  const GameReferee& game = factory.referee();
  Json orders = Json::array(), deliveries = Json::array();
  for (const OrderState& state : game.orders())
    for (const Team team : factory.teams())
      if (!state.order.overtime || state.released) {
        const auto& delivered = state.delivered_at[static_cast<std::size_t>(team)];
        orders.push_back(
            order_json(state, simulated(factory, state.released.value_or(factory.clock().at(state.order.activate_at))),
                       delivered ? std::optional(simulated(factory, *delivered)) : std::nullopt, team));
        if (factory.teams().size() > 1) orders.back()["team"] = to_string(team);
      }
  for (const Delivery& d : game.deliveries()) deliveries.push_back(delivery_json(d, simulated(factory, d.at)));
  if (!orders.empty()) {
    for (const Team team : factory.teams()) {
      const auto counts = [&](const Delivery& d) { return d.correct && d.team == team; };
      if (factory.teams().size() > 1) result.score_board += std::string(to_string(team)) + ": ";
      result.score_board +=
          line("%ld of %zu orders delivered\n", static_cast<long>(std::ranges::count_if(game.deliveries(), counts)),
               orders.size() / factory.teams().size());
    }
  }
  result.set("orders", json_text(orders));
  result.set("deliveries", json_text(deliveries));
}

void report_robots(std::span<const sim::RobotStats> robots, std::span<const Maintenance::Robot> duties,
                   const sim::World& floor, Result& result) {
  Json list = Json::array();
  const double end = std::max(1e-9, to_seconds(floor.floor_time()));
  std::string failed;
  int skills = 0;
  for (std::size_t i = 0; i < robots.size(); ++i) {
    const sim::RobotStats& s = robots[i];
    const int contacts = static_cast<int>(floor.robot(static_cast<sim::RobotId>(i)).robot_contacts);
    list.push_back(robot_json(s, duties[i], contacts));
    result.score_board +=
        line("%-8s at work %3.0f %%, driving %3.0f %%, %d skills, %d failed, %d contacts", s.name.c_str(),
             100 * s.busy_s / end, 100 * s.drive_s / end, s.skills, s.failures, contacts);
    if (duties[i].cycles > 0) result.score_board += line(", %d in maintenance", duties[i].cycles);
    if (duties[i].duty == RobotDuty::kDisqualified) result.score_board += ", disqualified";
    result.score_board += '\n';
    if (s.failures > 0)
      failed +=
          (failed.empty() ? "" : ", ") + s.name + ' ' + std::to_string(s.failures) + " of " + std::to_string(s.skills);
    skills += s.skills;
  }
  if (!failed.empty()) result.tallies.push_back("skills failed: " + failed);
  constexpr double kLongEnough = 60;  // s; before that an agent may still look around
  if (skills == 0 && !robots.empty() && end >= kLongEnough)
    result.warnings.push_back("no robot was given a skill in the whole game");
  result.set("robots", json_text(list));
}

std::string sample_teams() {
  Json teams = Json::object();
  for (const Team team : kTeams) teams[std::string(to_string(team))] = team_json({});
  return json_text(teams);
}

std::string sample_orders() { return json_text(Json::array({order_json({}, {}, {}, Team::kCyan)})); }
std::string sample_deliveries() { return json_text(Json::array({delivery_json({}, {})})); }
std::string sample_robots() { return json_text(Json::array({robot_json({}, {}, 0)})); }

}  // namespace cxlab::rcll
