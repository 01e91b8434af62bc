#pragma once
// The storage station: STORE takes a workpiece in, RETRIEVE brings one out, 17.5 s each. A workpiece in front of the
// slot is first moved to another free one, chosen at random, in another 17.5 s.

#include "cx/base/random.h"
#include "scenarios/rcll/rules/machine.h"
#include "scenarios/rcll/rules/storage.h"

namespace cxlab::rcll {

class StorageStation final : public Machine {
 public:
  StorageStation(sim::StationId id, Team team, MachineContext& context, const sim::FloorPlan& plan);
  const Storage& storage() const { return storage_; }

 private:
  Refusal check(const Instruction& instruction) override;
  bool done_at_once(const Instruction& instruction) override;
  void begin(SimTime now, sim::World& world) override;
  void proceed(SimTime now, sim::World& world) override;
  bool operate(SimTime now, sim::World& world, const sim::Piece* piece) override;
  Storage::Slot slot() const { return {instruction().shelf, instruction().slot}; }
  bool stores() const { return instruction().operation == "STORE"; }

  Storage storage_ = Storage::at_start();
  bool at_start_ = false;  ///< what it brings out lay there as the game began
  RandomStream random_;
};

}  // namespace cxlab::rcll
