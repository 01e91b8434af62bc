#include "scenarios/rcll/rules/machines.h"

#include <algorithm>
#include <chrono>

#include "scenarios/rcll/rules/layout.h"
#include "scenarios/rcll/rules/storage_station.h"

namespace cxlab::rcll {
namespace {

using std::chrono::milliseconds;

constexpr SimTime kDispenseTime = milliseconds(1100);
constexpr SimTime kCapTime = milliseconds(17500);
constexpr SimTime kRingTime = milliseconds(17308);
constexpr SimTime kGateTimes[]{milliseconds(3746), milliseconds(4746), milliseconds(3983)};
constexpr int kMaxPayments = 3;

}  // namespace

// --- BaseStation

Machine::Refusal BaseStation::check(const Instruction& instruction) {
  if (instruction.side != "INPUT" && instruction.side != "OUTPUT")
    return {InstructError::kInvalid, "side: " + found_text(instruction.side, "INPUT or OUTPUT"), true};
  const auto base = named<BaseColor>(instruction.base_color);
  if (!base || *base == BaseColor::kClear)
    return {InstructError::kInvalid,
            "base_color: " + found_text(instruction.base_color, "BASE_RED, BASE_BLACK or BASE_SILVER"), true};
  return {};
}

void BaseStation::proceed(SimTime now, sim::World& world) {
  if (state() == MachineState::kPrepared) {
    enter(MachineState::kProcessing, now);
    send(Command::kOperate, now, world, kDispenseTime);
  } else if (state() == MachineState::kProcessing) {
    enter(MachineState::kProcessed, now);
    send(instruction().side == "INPUT" ? Command::kToInput : Command::kToOutput, now, world);
  } else {
    present(now, world);
  }
}

bool BaseStation::operate(SimTime now, sim::World& world, const sim::Piece*) {
  sim::Stack stack;
  stack.base = static_cast<std::uint8_t>(*named<BaseColor>(instruction().base_color));
  return dispense(now, world, stack).has_value();  // while something lies there: again
}

sim::SpotId BaseStation::ready_spot() const { return instruction().side == "INPUT" ? input_ : output_; }

// --- CapStation

CapStation::CapStation(sim::StationId id, Team team, MachineContext& context, const sim::FloorPlan& plan)
    : Machine(id, team, context, plan), shelf_cap_(shelf_cap(name())) {
  shelf_ = {*plan.find_spot(name() + "-SHELF-LEFT"), *plan.find_spot(name() + "-SHELF-MIDDLE"),
            *plan.find_spot(name() + "-SHELF-RIGHT")};
}

Machine::Refusal CapStation::check(const Instruction& instruction) {
  if (instruction.operation == "RETRIEVE_CAP") {
    if (cap_buffered()) return {InstructError::kInvalid, "RETRIEVE_CAP while a cap is buffered", true};
  } else if (instruction.operation == "MOUNT_CAP") {
    if (!cap_buffered()) return {InstructError::kInvalid, "MOUNT_CAP while no cap is buffered", true};
  } else {
    return {InstructError::kInvalid, "operation: " + found_text(instruction.operation, "RETRIEVE_CAP or MOUNT_CAP"),
            true};
  }
  return {};
}

void CapStation::observe(SimTime now, sim::World& world) {
  const bool empty = std::ranges::all_of(shelf_, [&](sim::SpotId slot) { return world.at(slot) == nullptr; });
  if (!empty) {
    refill_at_ = kNever;
    return;
  }
  if (refill_at_ == kNever) refill_at_ = now + context_.shelf_refill;
  if (now < refill_at_) return;
  sim::Stack carrier;
  carrier.base = static_cast<std::uint8_t>(BaseColor::kClear);
  carrier.cap = static_cast<std::uint8_t>(shelf_cap_);
  // A slot that something else takes up stays empty until the next refill.
  for (const sim::SpotId slot : shelf_)
    if (took(world.dispense(slot, carrier), now)) refill_at_ = kNever;
}

void CapStation::proceed(SimTime now, sim::World& world) {
  const bool retrieves = instruction().operation == "RETRIEVE_CAP";
  if (state() == MachineState::kPrepared) {
    enter(MachineState::kProcessing, now);
    send(Command::kOperate, now, world, kCapTime);
  } else if (state() == MachineState::kProcessing) {
    buffered_cap_ = retrieves ? taken_cap_ : 0;
    post(retrieves ? MachineEvent::Kind::kCapRetrieved : MachineEvent::Kind::kMounted, now, worked_on_);
    enter(MachineState::kProcessed, now);
    send(Command::kToOutput, now, world);
  } else {
    present(now, world);
  }
}

bool CapStation::operate(SimTime now, sim::World& world, const sim::Piece* piece) {
  if (piece == nullptr) return false;  // taken away: stuck
  const sim::PieceId id = piece->id;
  if (instruction().operation == "RETRIEVE_CAP") {
    if (piece->stack.cap == 0) {
      break_down(now, world, InstructError::kInvalid, "RETRIEVE_CAP from a workpiece without a cap");
      return false;
    }
    taken_cap_ = piece->stack.cap;
    world.unmount_cap(id);
  } else {
    if (piece->stack.cap != 0) {
      break_down(now, world, InstructError::kInvalid, "MOUNT_CAP on a workpiece that has a cap");
      return false;
    }
    world.mount(id, sim::Part::kCap, buffered_cap_);
  }
  worked_on_ = *world.find(id);
  return true;
}

// --- RingStation

Machine::Refusal RingStation::check(const Instruction& instruction) {
  const auto mounted = rings_of(name().substr(2));
  const auto ring = named<RingColor>(instruction.ring_color);
  if (!ring || std::ranges::find(mounted, *ring) == mounted.end())
    return {InstructError::kInvalid,
            "ring_color: " + found_text(instruction.ring_color, std::string(to_string(mounted[0])) + " or " +
                                                                    std::string(to_string(mounted[1]))),
            true};
  if (is_paid(instruction)) return {};
  const Count count{paid_, used_};
  // The referee box asks for payments once; asked again for the same it only waits.
  if (context_.rules.unpaid_again_waits && count == refused_at_) return {};
  refused_at_ = count;
  return unpaid(instruction);
}

int RingStation::price(const Instruction& instruction) const {
  return context_.schedule->price(*named<RingColor>(instruction.ring_color));
}

Machine::Refusal RingStation::unpaid(const Instruction& instruction) const {
  return {InstructError::kInvalid,
          instruction.ring_color + " costs " + std::to_string(price(instruction)) + " payments, " +
              std::to_string(loaded_with()) + " lie on the slide",
          true};
}

Machine::Refusal RingStation::lacks() const { return waits_for_payment_ ? unpaid(instruction()) : Machine::lacks(); }

void RingStation::begin(SimTime now, sim::World& world) {
  waits_for_payment_ = !is_paid(instruction());
  if (!waits_for_payment_) Machine::begin(now, world);
}

void RingStation::observe(SimTime now, sim::World& world) {
  const auto slid = world.slid(id());
  const int count = static_cast<int>(slid.size());
  if (seen_ < 0) seen_ = count;  // what was paid before production counts for nothing
  // A base of the other team is taken away by the rulebook.
  const auto is_foreign = [&](std::optional<sim::RobotId> robot) {
    return context_.rules.by_hand && robot && team_of(world.plan().robot(*robot)) != team();
  };
  for (; seen_ < count; ++seen_) {
    if (is_foreign(slid[static_cast<std::size_t>(seen_)])) continue;
    const bool full = loaded_with() == kMaxPayments;
    // The referee box sees DOWN alone and not the BROKEN that it hides.
    const bool hidden = state() != MachineState::kBroken && context_.rules.down_hides_broken;
    if (broken() && (full || !hidden)) continue;
    if (full) {
      break_down(now, world, InstructError::kBroken, "a fourth unused payment on its slide");
    } else {
      ++paid_;
      post(MachineEvent::Kind::kPayment, now);
    }
  }
}

void RingStation::proceed(SimTime now, sim::World& world) {
  if (waits_for_payment_) {
    if (is_paid(instruction())) begin(now, world);
  } else if (state() == MachineState::kPrepared) {
    used_ += price(instruction());
    enter(MachineState::kProcessing, now);
    send(Command::kOperate, now, world, kRingTime);
  } else if (state() == MachineState::kProcessing) {
    post(MachineEvent::Kind::kMounted, now, worked_on_).payments = price(instruction());
    enter(MachineState::kProcessed, now);
    send(Command::kToOutput, now, world);
  } else {
    present(now, world);
  }
}

bool RingStation::operate(SimTime now, sim::World& world, const sim::Piece* piece) {
  if (piece == nullptr) return false;  // taken away: stuck
  const sim::PieceId id = piece->id;
  if (piece->stack.cap != 0 || piece->stack.rings.back() != 0) {
    break_down(now, world, InstructError::kInvalid,
               piece->stack.cap != 0 ? "a ring on a workpiece that has a cap" : "a fourth ring on a workpiece");
    return false;
  }
  world.mount(id, sim::Part::kRing, static_cast<std::uint8_t>(*named<RingColor>(instruction().ring_color)));
  worked_on_ = *world.find(id);
  return true;
}

// --- DeliveryStation

const Order* DeliveryStation::order() const {
  const auto& orders = context_.schedule->orders;
  const auto at = std::ranges::find(orders, instruction().order_id, &Order::id);
  return at == orders.end() ? nullptr : &*at;
}

Machine::Refusal DeliveryStation::check(const Instruction& instruction) {
  const auto known = [&](const Order& order) { return order.id == instruction.order_id; };
  if (instruction.order_id != 0 && std::ranges::none_of(context_.schedule->orders, known))
    return {InstructError::kInvalid, "order_id: no order " + std::to_string(instruction.order_id), true};
  return {};
}

void DeliveryStation::proceed(SimTime now, sim::World& world) {
  if (state() == MachineState::kPrepared) {
    if (now < proceed_due()) return;
    enter(MachineState::kProcessing, now);
    send(Command::kTakeIn, now, world, kGateTimes[order() == nullptr ? 0 : order()->delivery_gate - 1]);
  } else if (state() == MachineState::kProcessing) {
    post(MachineEvent::Kind::kDelivery, now, worked_on_).order_id = instruction().order_id;
    enter(MachineState::kProcessed, now);
    finish_job();
  } else {
    enter(MachineState::kWaitIdle, now);
  }
}

bool DeliveryStation::operate(SimTime, sim::World& world, const sim::Piece* piece) {
  worked_on_ = *piece;
  world.retire(worked_on_.id, sim::Holder::kGate);
  return true;
}

SimTime DeliveryStation::proceed_due() const {
  const bool waits = state() == MachineState::kPrepared && order() != nullptr;
  return waits ? context_.clock.at(order()->delivery_begin) : SimTime::zero();
}

bool DeliveryStation::may_wait() const {
  return context_.rules.delivery_may_wait && state() == MachineState::kPrepared;
}

// --- All of them

Machines make_machines(const sim::FloorPlan& plan, MachineContext& context) {
  std::vector<std::unique_ptr<Machine>> machines;
  for (std::size_t i = 0; i < plan.stations.size(); ++i) {
    const auto id = static_cast<sim::StationId>(i);
    const sim::Station& station = plan.stations[i];
    const Team team = team_of(station);
    if (station.kind == "BS")
      machines.push_back(std::make_unique<BaseStation>(id, team, context, plan));
    else if (station.kind == "CS")
      machines.push_back(std::make_unique<CapStation>(id, team, context, plan));
    else if (station.kind == "RS")
      machines.push_back(std::make_unique<RingStation>(id, team, context, plan));
    else if (station.kind == "SS")
      machines.push_back(std::make_unique<StorageStation>(id, team, context, plan));
    else
      machines.push_back(std::make_unique<DeliveryStation>(id, team, context, plan));
  }
  return machines;
}

Machine* find_machine(const Machines& machines, std::string_view name) {
  const auto at = std::ranges::find_if(machines, [&](const auto& machine) { return machine->name() == name; });
  return at == machines.end() ? nullptr : at->get();
}

std::string unknown_machine(const Machines& machines, const std::string& name) {
  std::vector<std::string> names;
  for (const auto& machine : machines) names.push_back(machine->name());
  return "no machine '" + name + "'" + did_you_mean(name, names);
}

}  // namespace cxlab::rcll
