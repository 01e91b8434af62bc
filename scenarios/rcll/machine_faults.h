#pragma once
// The faults of machines: breaks them and takes them down, in the act phase before the factory, so that the machine
// itself does so in the same tick.

#include <memory>
#include <span>
#include <vector>

#include "cx/base/record_sink.h"
#include "cx/run/parts.h"
#include "scenarios/rcll/machine.h"
#include "sim/faults/fault.h"

namespace cxlab::rcll {

class MachineFaults final : public Server {
 public:
  /// Takes those of `faults` that are about machines. Strikes are written to the stream "faults". A machine that does
  /// not exist is an error. Machines, world and sink outlive it.
  static Expected<std::unique_ptr<MachineFaults>> make(std::span<const sim::Fault> faults, std::uint64_t seed,
                                                       const std::vector<std::unique_ptr<Machine>>& machines,
                                                       sim::World& world, RecordSink& sink);

  Status sense(SimTime) override { return {}; }
  Status act(SimTime now) override;
  SimTime next_due() const override;

 private:
  struct Entry {
    sim::FaultTimer timer;
    Machine* machine = nullptr;
  };
  MachineFaults(sim::World& world, RecordSink& sink) : world_(world), sink_(sink) {}

  sim::World& world_;
  RecordSink& sink_;
  std::vector<Entry> entries_;
};

}  // namespace cxlab::rcll
