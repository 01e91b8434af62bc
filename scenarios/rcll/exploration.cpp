#include "scenarios/rcll/exploration.h"

#include <algorithm>

namespace cxlab::rcll {

Exploration::Exploration(const sim::FloorPlan& plan, const GameClock& clock, bool on)
    : plan_(plan), clock_(clock), on_(on), findings_(plan.stations.size()) {}

std::vector<std::int64_t> Exploration::report(Team team, const MachineReport& entry, SimTime now) {
  if (over(now) || now < clock_.production_begin) return {};
  int& entries = entries_[static_cast<std::size_t>(team)];
  if (entries == kMostEntries || !nonsense(team, entry).empty()) return {};
  const std::uint64_t before = changes_;
  std::vector<std::int64_t> points =
      entry.name.empty() ? report_type(team, entry) : report_machine(*plan_.find_station(entry.name), entry);
  if (changes_ != before) ++entries;
  return points;
}

std::string Exploration::nonsense(Team team, const MachineReport& entry) const {
  std::vector<std::string> names, types;
  for (const sim::Station& station : plan_.stations) {
    names.push_back(station.name);
    if (std::ranges::find(types, station.kind) == types.end()) types.push_back(station.kind);
  }
  const auto unknown = [](const std::string& what, const std::string& word, const std::vector<std::string>& words) {
    return "no " + what + " '" + word + "'" + did_you_mean(word, words);
  };
  if (entry.name.empty() && std::ranges::find(types, entry.type) == types.end())
    return unknown("type of machine", entry.type, types);
  if (!entry.name.empty()) {
    const auto machine = plan_.find_station(entry.name);
    if (!machine) return unknown("machine", entry.name, names);
    if (team_of(plan_.station(*machine)) != team)
      return entry.name + " is not a machine of " + std::string(to_string(team));
  }
  const bool says_zone = entry.name.empty() || !entry.zone.empty();
  if (says_zone && !zone_named(entry.zone)) return "no zone '" + entry.zone + "', they are C_Z11 to M_Z78";
  return {};
}

std::vector<std::int64_t> Exploration::report_machine(sim::StationId machine, const MachineReport& entry) {
  const sim::Station& station = plan_.station(machine);
  Finding& finding = findings_[index_of(machine)];
  std::vector<std::int64_t> points;
  const auto judge = [&](Guess& guess, bool right) {
    if (guess != Guess::kOpen) return;
    guess = right ? Guess::kRight : Guess::kWrong;
    ++changes_;
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
  ++changes_;
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
