#pragma once
// The first 180 s of production: a team reports where its machines stand. A machine that is reported correctly is
// published to the team and may be instructed. A wrong report costs points. Afterwards all machines are known.
//
// The first reported zone and the first rotation of a machine count. A right zone gives +1, a wrong one -1; a right
// rotation +1, a wrong one -1, and nothing if the zone is wrong. An entry without a name says that a machine of that
// type stands in a zone. If it is right, the team learns the name; if it is wrong, it costs 1.
//
// The referee box lets a team report as many machines of a type as it has. A machine of either team that an entry
// names, or that stands where an entry says, is one of them; so is each wrong entry of a type. The rulebook allows
// fourteen entries, and as many of a type as the team has such machines; those of the other team do not count.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "scenarios/rcll/rules/clock.h"
#include "scenarios/rcll/rules/layout.h"
#include "sim/world.h"

namespace cxlab::rcll {

/// One entry of a team's report; what it leaves open stays empty.
struct MachineReport {
  std::string name;  ///< "C-CS1"
  std::string type;  ///< "CS"
  std::string zone;  ///< "C_Z23"
  std::optional<int> rotation;
};

/// What a report of a type was worth knowing.
struct TypeFeedback {
  Team team{};  ///< whose report it was
  std::string type, zone;
  std::string name;  ///< of the machine there; empty = none of that type
};

class Exploration {
 public:
  static constexpr double kLength = 180;   ///< s of production
  static constexpr int kMostEntries = 14;  ///< of a team, by the rulebook; those that say nothing new do not count

  enum class Guess : std::uint8_t { kOpen, kRight, kWrong };
  struct Finding {
    Guess zone = Guess::kOpen, rotation = Guess::kOpen;
    bool complete() const { return zone == Guess::kRight && rotation == Guess::kRight; }
  };

  /// Without `on` all machines are known from the start. `by_type`: as the referee box judges. The clock outlives it.
  Exploration(const sim::FloorPlan& plan, const GameClock& clock, bool on, bool by_type);

  /// Judges an entry; what it earns, point by point (each 1 or -1).
  std::vector<std::int64_t> report(Team team, const MachineReport& entry, SimTime now);

  /// The fault of an entry that names no machine of the team, type or zone, and is not judged; else empty.
  std::string nonsense(Team team, const MachineReport& entry) const;

  bool over(SimTime now) const { return !on_ || now > clock_.at(kLength); }
  /// Whether its team may know where the machine stands.
  bool knows(sim::StationId machine, SimTime now) const { return over(now) || finding(machine).complete(); }
  const Finding& finding(sim::StationId machine) const { return findings_[index_of(machine)]; }
  std::span<const TypeFeedback> type_feedback() const { return feedback_; }
  /// Names of the machines that the team has reported right.
  std::vector<std::string> reported(Team team) const;
  /// Grows with each entry that was judged.
  std::uint64_t changes() const { return changes_; }
  /// The first moment after the period; kNever without one.
  SimTime end() const { return on_ ? clock_.at(kLength) + SimTime{1} : kNever; }

 private:
  /// A machine that a team has reported, as the referee box counts them.
  struct Reported {
    Team team{};
    std::string type;
    std::string name;  ///< empty: a wrong entry of that type
  };
  std::vector<std::int64_t> report_machine(sim::StationId machine, const MachineReport& entry);
  std::vector<std::int64_t> report_type(Team team, const MachineReport& entry);

  std::ptrdiff_t machines_of(Team team, const std::string& type) const;
  /// Whether the team may still report that machine; if so it is reported.
  bool count(Team team, const std::string& type, const std::string& name);

  const sim::FloorPlan& plan_;
  const GameClock& clock_;
  bool on_, by_type_;
  std::vector<Finding> findings_;  ///< by station
  std::vector<TypeFeedback> feedback_;
  std::vector<Reported> reported_;
  std::array<int, 2> entries_{};  ///< by team
  std::uint64_t changes_ = 0;
};

}  // namespace cxlab::rcll
