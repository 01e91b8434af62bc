#pragma once
// What the scenario's faults do to machines, to what lies on them, and to instructions on their way to them.

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/record_sink.h"
#include "scenarios/rcll/rules/machine.h"
#include "sim/faults/fault.h"
#include "sim/world.h"

namespace cxlab::rcll {

/// After which an instruction that was lost is aborted.
inline constexpr SimTime kNoAnswerTime = std::chrono::seconds(10);

class MachineFaults {
 public:
  /// Strikes are written to the stream "faults". Both outlive it.
  MachineFaults(sim::World& world, RecordSink& sink) : world_(world), sink_(sink) {}

  /// Takes those of `faults` that are about machines; fails on one of an unknown machine. The machines outlive it.
  Status take(std::span<const sim::Fault> faults, std::uint64_t seed,
              const std::vector<std::unique_ptr<Machine>>& machines, std::span<const Team> teams);
  /// Strikes what is due.
  void strike(SimTime now);
  SimTime next_due() const;

  /// What becomes of an instruction on its way.
  struct Passage {
    SimTime delay{};
    bool lost = false;
  };
  Passage instruct(const Machine& machine, SimTime now);

 private:
  struct Fault {
    sim::FaultTimer timer;
    Machine* machine = nullptr;
    SimTime lies_since = kNever;  ///< a piece that is to be taken
  };
  /// What lies at the spots of the machine.
  std::vector<sim::SpotId> taken_spots(const Machine& machine) const;
  /// False where there is nothing to strike yet.
  bool act(Fault& fault, SimTime now);
  RecordData& begin(const Fault& fault);
  void write(SimTime now) { sink_.write(sink_.open_stream("faults"), now, RecordKind::kControl, data_); }

  sim::World& world_;
  RecordSink& sink_;
  std::vector<Fault> faults_;
  RecordData data_;
};

}  // namespace cxlab::rcll
