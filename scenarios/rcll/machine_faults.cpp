#include "scenarios/rcll/machine_faults.h"

#include <algorithm>
#include <string>

namespace cxlab::rcll {

Expected<std::unique_ptr<MachineFaults>> MachineFaults::make(std::span<const sim::Fault> faults, std::uint64_t seed,
                                                             const std::vector<std::unique_ptr<Machine>>& machines,
                                                             sim::World& world, RecordSink& sink) {
  std::unique_ptr<MachineFaults> made(new MachineFaults(world, sink));
  std::vector<std::string> names;
  for (const auto& machine : machines) names.push_back(machine->name());
  for (const sim::Fault& fault : faults) {
    if (fault.machine.empty()) continue;
    const auto at = std::ranges::find(names, fault.machine);
    if (at == names.end()) {
      return input_error("machine: no machine '" + fault.machine + "'" + did_you_mean(fault.machine, names),
                         fault.origin);
    }
    made->entries_.push_back(
        {sim::FaultTimer(fault, seed, fault.machine), machines[static_cast<std::size_t>(at - names.begin())].get()});
  }
  return made;
}

Status MachineFaults::act(SimTime now) {
  for (Entry& entry : entries_) {
    if (now < entry.timer.due()) continue;
    const sim::Fault& fault = entry.timer.fault();
    entry.timer.struck(now);
    bool acted = true;
    if (fault.kind == sim::FaultKind::kMachineDown)
      entry.machine->add_down({now, now + fault.duration});
    else
      acted = entry.machine->fail(now, world_, "a fault of the scenario");
    RecordData data;
    data.begin()
        .field("fault", sim::to_string(fault.kind))
        .field("number", static_cast<std::int64_t>(fault.number))
        .field("machine", fault.machine)
        .field("acted", acted);
    sink_.write(sink_.open_stream("faults"), now, RecordKind::kControl, data);
  }
  return {};
}

SimTime MachineFaults::next_due() const {
  SimTime due = kNever;
  for (const Entry& entry : entries_) due = std::min(due, entry.timer.due());
  return due;
}

}  // namespace cxlab::rcll
