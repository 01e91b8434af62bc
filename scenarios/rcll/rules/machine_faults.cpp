#include "scenarios/rcll/rules/machine_faults.h"

#include <algorithm>

#include "scenarios/rcll/rules/machines.h"

namespace cxlab::rcll {

using sim::FaultKind;

namespace {

/// A piece is taken when it has lain so long: the machine has seen it.
constexpr SimTime kLies = std::chrono::seconds(1);

}  // namespace

Status MachineFaults::take(std::span<const sim::Fault> faults, std::uint64_t seed,
                           const std::vector<std::unique_ptr<Machine>>& machines, std::span<const Team> teams) {
  for (const sim::Fault& fault : faults) {
    if (fault.machine.empty()) continue;
    Machine* machine = find_machine(machines, fault.machine);
    if (machine == nullptr) return input_error("machine: " + unknown_machine(machines, fault.machine), fault.origin);
    if (sim::by_occasion(fault.kind) && std::ranges::find(teams, machine->team()) == teams.end())
      return input_error("machine: " + fault.machine +
                             " gets no instructions: " + std::string(to_string(machine->team())) + " does not play",
                         fault.origin);
    faults_.push_back({sim::FaultTimer(fault, seed, fault.machine), machine});
  }
  return {};
}

std::vector<sim::SpotId> MachineFaults::taken_spots(const Machine& machine) const {
  std::vector<sim::SpotId> spots;
  for (std::size_t i = 0; i < world_.plan().spots.size(); ++i) {
    const auto spot = static_cast<sim::SpotId>(i);
    if (world_.plan().spot(spot).station == machine.id() && world_.at(spot) != nullptr) spots.push_back(spot);
  }
  return spots;
}

RecordData& MachineFaults::begin(const Fault& fault) {
  const sim::Fault& what = fault.timer.fault();
  sim::begin_strike(data_, what).field("machine", fault.machine->name());
  if (what.duration != SimTime::zero()) data_.field("seconds", to_seconds(what.duration));
  return data_;
}

bool MachineFaults::act(Fault& fault, SimTime now) {
  const sim::Fault& what = fault.timer.fault();
  if (what.kind == FaultKind::kPieceTaken) {
    const std::vector<sim::SpotId> spots = taken_spots(*fault.machine);
    fault.lies_since = spots.empty() ? kNever : std::min(fault.lies_since, now);
    if (spots.empty() || now < fault.lies_since + kLies) return false;
    fault.lies_since = kNever;
    const sim::SpotId spot = spots[fault.timer.choose(spots.size())];
    const sim::PieceId piece = world_.at(spot)->id;
    begin(fault).field("spot", world_.plan().spot(spot).name).field("piece", static_cast<std::int64_t>(piece));
    world_.retire(piece, sim::Holder::kFloor);
  } else {
    const bool down = what.kind == FaultKind::kMachineDown;
    if (down) fault.machine->add_down({now, now + what.duration});
    const bool acted = down || fault.machine->fail(now, world_, "a fault of the scenario");
    begin(fault).field("acted", acted);
  }
  write(now);
  return true;
}

void MachineFaults::strike(SimTime now) {
  for (Fault& fault : faults_)
    if (!sim::by_occasion(fault.timer.fault().kind) && now >= fault.timer.due() && act(fault, now))
      fault.timer.struck(now);
}

SimTime MachineFaults::next_due() const {
  SimTime due = kNever;
  for (const Fault& fault : faults_) {
    const FaultKind kind = fault.timer.fault().kind;
    if (sim::by_occasion(kind)) continue;
    SimTime at = fault.timer.due();
    if (fault.lies_since != kNever)
      at = fault.lies_since + kLies;
    else if (kind == FaultKind::kPieceTaken && taken_spots(*fault.machine).empty())
      continue;
    due = std::min(due, at);
  }
  return due;
}

MachineFaults::Passage MachineFaults::instruct(const Machine& machine, SimTime now) {
  Passage passage;
  for (Fault& fault : faults_) {
    const sim::Fault& what = fault.timer.fault();
    if (fault.machine != &machine || !sim::by_occasion(what.kind) || !fault.timer.strikes_occasion(now)) continue;
    if (what.kind == FaultKind::kInstructionLost)
      passage.lost = true;
    else
      passage.delay += what.duration;
    begin(fault);
    write(now);
  }
  if (passage.lost) passage.delay = kNoAnswerTime;
  return passage;
}

}  // namespace cxlab::rcll
