// The times that the points of a moment may have.

#include <algorithm>
#include <cmath>
#include <tuple>

#include "planner/happenings/linear_program.h"
#include "planner/happenings/moment.h"

namespace cxlab::planner {

namespace {

constexpr double kPositive = 1e-6;  ///< the least value that is asked for where one is to be positive

}  // namespace

/// Forgets the points that nothing can depend on any more, and looks whether there are times at all.
bool Moments::tidy(Moment& moment) const {
  std::vector<TimedDemand> demands;
  for (bool changed = true; changed;) {
    demands = std::move(moment.demands);
    moment.demands.clear();
    for (TimedDemand& each : demands)
      if (!demand(moment, each)) return false;
    changed = moment.demands.size() < demands.size();
  }
  for (std::size_t i = moment.varying.size(); i-- > 0;) {
    auto [number, value] = moment.varying[i];
    simplify(moment.zone, value);
    set_number(moment, number, std::move(value));
  }
  if (!moment.demands.empty() && !solve(moment, -1)) return false;
  std::erase_if(moment.recent, [&](const Moment::Recent& recent) {
    return moment.zone.least(recent.point, moment.now) >= options_.separation;
  });
  if (options_.keep_everything) return true;
  std::vector<int> kept;
  ById<int> place(static_cast<std::size_t>(moment.zone.points()), -1);
  const auto keep = [&](int& point) {
    if (point < 0) return;
    if (place[point] < 0) {
      place[point] = static_cast<int>(kept.size());
      kept.push_back(point);
    }
    point = place[point];
  };
  const bool from_start = options_.keep_origin || moment.next_event < static_cast<int>(task_.events.size()) ||
                          !moment.varying.empty() || !moment.demands.empty();
  if (!from_start) moment.origin = -1;
  keep(moment.origin);
  keep(moment.now);
  for (Moment::Running& running : moment.running) {
    keep(running.end);
    if (!reads_duration_[running.action]) running.start = -1;
    keep(running.start);
  }
  std::ranges::sort(moment.recent, {},
                    [](const Moment::Recent& recent) { return std::tie(recent.action, recent.at_end, recent.fired); });
  for (Moment::Recent& recent : moment.recent) keep(recent.point);
  const auto keep_all = [&](TimedNumber& value) {
    for (auto& entry : value.weights) keep(entry.first);
    std::ranges::sort(value.weights);
  };
  for (auto& entry : moment.varying) keep_all(entry.second);
  for (TimedDemand& each : moment.demands) keep_all(each.value);
  moment.zone.keep(kept);
  return true;
}

/// Times after the origin in seconds, that of point `least` as early as it can be; none if there are none.
std::optional<ById<double>> Moments::solve(const Moment& moment, int least) const {
  const int points = moment.zone.points();
  std::vector<LinearRow> rows;
  const auto row = [&] { return LinearRow{std::vector<double>(static_cast<std::size_t>(points), 0), 0}; };
  for (int from = 0; from < points; ++from)
    for (int to = 0; to < points; ++to) {
      if (from == to || moment.zone.most(from, to) >= Zone::kAny) continue;
      LinearRow made = row();
      if (from != moment.origin) made.coefficients[static_cast<std::size_t>(from)] = -1;
      if (to != moment.origin) made.coefficients[static_cast<std::size_t>(to)] = 1;
      made.bound = in_seconds(moment.zone.most(from, to));
      rows.push_back(std::move(made));
    }
  for (const TimedDemand& demand : moment.demands) {
    LinearRow made = row();
    for (const auto& [point, weight] : demand.value.weights)
      if (point != moment.origin) made.coefficients[static_cast<std::size_t>(point)] = -weight;
    made.bound = demand.value.constant;
    if (demand.kind == GroundComparison::Kind::kPositive && !options_.relaxed) made.bound -= kPositive;
    rows.push_back(made);
    if (demand.kind != GroundComparison::Kind::kZero) continue;
    for (double& each : made.coefficients) each = -each;
    made.bound = -made.bound;
    rows.push_back(std::move(made));
  }
  std::vector<double> objective(static_cast<std::size_t>(points), 0);
  if (least >= 0 && least != moment.origin) objective[static_cast<std::size_t>(least)] = 1;
  std::int64_t work = 0;
  std::optional<std::vector<double>> found = minimize(rows, objective, &work);
  budget_.spend(Work::kTimes, work);
  return found ? std::optional(ById<double>(*std::move(found))) : std::nullopt;
}

bool Moments::fix(Moment& moment, int point, Micros time) const {
  if (!moment.zone.require(moment.origin, point, time) || !moment.zone.require(point, moment.origin, -time))
    return false;
  const std::vector<TimedDemand> demands = std::move(moment.demands);
  moment.demands.clear();
  for (const TimedDemand& each : demands)
    if (!demand(moment, each)) return false;
  return moment.demands.empty() || solve(moment, -1);
}

std::optional<ById<Micros>> Moments::times(const Moment& moment, int last) const {
  Moment fixed = moment;
  std::vector<int> order = {last};
  for (int point = 0; point < moment.zone.points(); ++point) order.push_back(point);
  for (const int point : order) {
    if (fixed.demands.empty()) break;
    const std::optional<ById<double>> found = solve(fixed, point);
    if (!found) return std::nullopt;
    const double exact = (*found)[point] * static_cast<double>(kMicrosPerSecond);
    bool placed = false;
    for (const double time : {std::ceil(exact - 1e-3), std::round(exact), std::floor(exact), std::ceil(exact) + 1}) {
      Moment next = fixed;
      if (placed || !fix(next, point, static_cast<Micros>(time))) continue;
      fixed = std::move(next);
      placed = true;
    }
    if (!placed) return std::nullopt;
  }
  ById<Micros> earliest;
  for (int point = 0; point < fixed.zone.points(); ++point) earliest.push_back(fixed.zone.least(fixed.origin, point));
  return earliest;
}

}  // namespace cxlab::planner
