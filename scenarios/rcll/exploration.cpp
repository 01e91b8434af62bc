#include "scenarios/rcll/exploration.h"

#include <algorithm>

namespace cxlab::rcll {

Exploration::Exploration(const sim::FloorPlan& plan, const GameClock& clock, bool on)
    : plan_(plan), clock_(clock), on_(on), findings_(plan.stations.size()) {}

std::vector<std::int64_t> Exploration::report(Team team, const MachineReport& entry, SimTime now) {
  if (over(now) || now < clock_.production_begin) return {};
  int& entries = entries_[static_cast<std::size_t>(team)];
  if (entries == kMostEntries) return {};
  ++entries;
  ++changes_;
  if (entry.name.empty()) return report_type(team, entry);
  const auto machine = plan_.find_station(entry.name);
  if (!machine || team_of(plan_.station(*machine)) != team) return {};
  return report_machine(*machine, entry);
}

std::vector<std::int64_t> Exploration::report_machine(sim::StationId machine, const MachineReport& entry) {
  const sim::Station& station = plan_.station(machine);
  Finding& finding = findings_[index_of(machine)];
  std::vector<std::int64_t> points;
  const auto judge = [&](Guess& guess, bool right) {
    if (guess != Guess::kOpen) return;
    guess = right ? Guess::kRight : Guess::kWrong;
    points.push_back(right ? 1 : -1);
  };
  if (!entry.zone.empty()) judge(finding.zone, entry.zone == to_string(zone_of(station)));
  if (entry.rotation && finding.zone == Guess::kRight) judge(finding.rotation, *entry.rotation == rotation_of(station));
  return points;
}

std::vector<std::int64_t> Exploration::report_type(Team team, const MachineReport& entry) {
  const auto of_type = [&](const sim::Station& s) { return s.kind == entry.type && team_of(s) == team; };
  const auto said = [&](const TypeFeedback& f) { return f.team == team && f.type == entry.type; };
  // What was said of a zone before counts, and each report uses one of that type up.
  if (std::ranges::any_of(feedback_, [&](const TypeFeedback& f) { return said(f) && f.zone == entry.zone; })) return {};
  if (std::ranges::count_if(feedback_, said) >= std::ranges::count_if(plan_.stations, of_type)) return {};
  const auto there = std::ranges::find_if(
      plan_.stations, [&](const sim::Station& s) { return of_type(s) && to_string(zone_of(s)) == entry.zone; });
  const bool right = there != plan_.stations.end();
  feedback_.push_back({team, entry.type, entry.zone, right ? there->name : ""});
  return right ? std::vector<std::int64_t>{} : std::vector<std::int64_t>{-1};
}

std::vector<std::string> Exploration::reported(Team team) const {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < findings_.size(); ++i)
    if (findings_[i].complete() && team_of(plan_.stations[i]) == team) names.push_back(plan_.stations[i].name);
  return names;
}

}  // namespace cxlab::rcll
