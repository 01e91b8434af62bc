#include "scenarios/rcll/rules/exploration.h"

#include <algorithm>

namespace cxlab::rcll {

Exploration::Exploration(const sim::FloorPlan& plan, const GameClock& clock, bool on, bool by_type)
    : plan_(plan), clock_(clock), on_(on), by_type_(by_type), findings_(plan.stations.size()) {}

std::vector<std::int64_t> Exploration::report(Team team, const MachineReport& entry, SimTime now) {
  if (over(now) || now < clock_.production_begin) return {};
  const auto named = plan_.find_station(entry.name);
  if (by_type_ && named) {
    const sim::Station& station = plan_.station(*named);
    if (!count(team, station.kind, station.name)) return {};
  }
  int& entries = entries_[static_cast<std::size_t>(team)];
  if ((!by_type_ && entries == kMostEntries) || !nonsense(team, entry).empty()) return {};
  const std::uint64_t before = changes_;
  std::vector<std::int64_t> points = named ? report_machine(*named, entry) : report_type(team, entry);
  if (changes_ != before) ++entries;
  return points;
}

std::ptrdiff_t Exploration::machines_of(Team team, const std::string& type) const {
  return std::ranges::count_if(plan_.stations,
                               [&](const sim::Station& s) { return s.kind == type && team_of(s) == team; });
}

bool Exploration::count(Team team, const std::string& type, const std::string& name) {
  const auto of_type = [&](const Reported& r) { return r.team == team && r.type == type; };
  if (!name.empty() && std::ranges::any_of(reported_, [&](const Reported& r) { return of_type(r) && r.name == name; }))
    return true;
  if (std::ranges::count_if(reported_, of_type) >= machines_of(team, type)) return false;
  reported_.push_back({team, type, name});
  return true;
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
  const auto said = [&](const TypeFeedback& f) { return f.team == team && f.type == entry.type; };
  // An earlier report of the zone counts.
  if (std::ranges::any_of(feedback_, [&](const TypeFeedback& f) { return said(f) && f.zone == entry.zone; })) return {};
  const auto there = std::ranges::find_if(plan_.stations, [&](const sim::Station& s) {
    return s.kind == entry.type && (by_type_ || team_of(s) == team) && to_string(zone_of(s)) == entry.zone;
  });
  const std::string name = there != plan_.stations.end() ? there->name : "";
  if (by_type_ ? !count(team, entry.type, name)
               : std::ranges::count_if(feedback_, said) >= machines_of(team, entry.type))
    return {};
  ++changes_;
  feedback_.push_back({team, entry.type, entry.zone, name});
  return name.empty() ? std::vector<std::int64_t>{-1} : std::vector<std::int64_t>{};
}

std::vector<std::string> Exploration::reported(Team team) const {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < findings_.size(); ++i)
    if (findings_[i].complete() && team_of(plan_.stations[i]) == team) names.push_back(plan_.stations[i].name);
  return names;
}

}  // namespace cxlab::rcll
