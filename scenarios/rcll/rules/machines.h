#pragma once
// The kinds of machines; the storage station is in storage_station.h. Durations are those of the referee box's mock-up,
// which were taken from real machines.

#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "scenarios/rcll/rules/machine.h"

namespace cxlab::rcll {

/// Gives bases: a base drops on the belt after 1.1 s and goes to the side that the instruction names.
class BaseStation final : public Machine {
 public:
  using Machine::Machine;

 private:
  Refusal check(const Instruction& instruction) override;
  void begin(SimTime, sim::World&) override {}
  void proceed(SimTime now, sim::World& world) override;
  bool operate(SimTime now, sim::World& world, const sim::Piece* piece) override;
  sim::SpotId ready_spot() const override;
};

/// Takes caps off the carriers of its shelf (RETRIEVE_CAP, one cap is buffered) and puts them on products (MOUNT_CAP),
/// 17.5 s each. The shelf's three slots are filled at the start, and again `shelf_refill` after the last was taken.
class CapStation final : public Machine {
 public:
  CapStation(sim::StationId id, Team team, MachineContext& context, const sim::FloorPlan& plan);
  int loaded_with() const override { return cap_buffered() ? 1 : 0; }

 private:
  Refusal check(const Instruction& instruction) override;
  void observe(SimTime now, sim::World& world) override;
  void proceed(SimTime now, sim::World& world) override;
  bool operate(SimTime now, sim::World& world, const sim::Piece* piece) override;
  SimTime observe_due() const override { return refill_at_; }
  void clear() override { buffered_cap_ = 0; }
  bool cap_buffered() const override { return buffered_cap_ != 0; }

  std::array<sim::SpotId, 3> shelf_{};
  CapColor shelf_cap_;
  SimTime refill_at_{};  ///< kNever while something lies on the shelf; at first: as production begins
  std::uint8_t buffered_cap_ = 0;
  std::uint8_t taken_cap_ = 0;  ///< off the carrier inside, not buffered yet
};

/// Mounts rings of two colours, 17.308 s each, for as many bases on its slide as the colour's price. A fourth base that
/// is not used breaks it.
class RingStation final : public Machine {
 public:
  using Machine::Machine;
  int loaded_with() const override { return paid_ - used_; }

 private:
  Refusal check(const Instruction& instruction) override;
  void begin(SimTime now, sim::World& world) override;
  void observe(SimTime now, sim::World& world) override;
  void proceed(SimTime now, sim::World& world) override;
  bool operate(SimTime now, sim::World& world, const sim::Piece* piece) override;
  void clear() override { used_ = paid_; }
  Refusal lacks() const override;
  int price(const Instruction& instruction) const;  ///< of its ring
  Refusal unpaid(const Instruction& instruction) const;
  bool is_paid(const Instruction& instruction) const { return loaded_with() >= price(instruction); }

  struct Count {
    int paid = -1, used = -1;
    bool operator==(const Count&) const = default;
  };
  int paid_ = 0;              ///< bases that counted as payments
  int used_ = 0;              ///< of these, by rings or forgotten
  Count refused_at_;          ///< when an instruction was refused last for want of payments
  bool waits_for_payment_{};  ///< PREPARED, and the belt does not run yet
  int seen_ = -1;             ///< of those that have slid in; -1 before production
};

/// Takes products through gate 1, 2 or 3 once the order's window is open; order 0 is discarded at once. The product is
/// seen when it lies under the gate and leaves play when the gate has worked.
class DeliveryStation final : public Machine {
 public:
  using Machine::Machine;

 private:
  Refusal check(const Instruction& instruction) override;
  void begin(SimTime, sim::World&) override {}
  void proceed(SimTime now, sim::World& world) override;
  bool operate(SimTime now, sim::World& world, const sim::Piece* piece) override;
  SimTime proceed_due() const override;
  bool may_wait() const override;
  sim::SpotId ready_spot() const override { return input_; }
  const Order* order() const;  ///< of the instruction; nullptr = discard
};

using Machines = std::vector<std::unique_ptr<Machine>>;

/// All machines of the plan in its order.
Machines make_machines(const sim::FloorPlan& plan, MachineContext& context);
/// The machine of that name; nullptr if there is none.
Machine* find_machine(const Machines& machines, std::string_view name);
/// The error for an unknown name, with the nearest name.
std::string unknown_machine(const Machines& machines, const std::string& name);

}  // namespace cxlab::rcll
