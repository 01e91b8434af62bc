#include "scenarios/rcll/machines.h"

#include <algorithm>
#include <chrono>

namespace cxlab::rcll {
namespace {

using std::chrono::milliseconds;

constexpr SimTime kDispenseTime = milliseconds(1100);
constexpr SimTime kCapTime = milliseconds(17500);
constexpr SimTime kGateTimes[]{milliseconds(3746), milliseconds(4746), milliseconds(3983)};
constexpr int kMaxPayments = 3;

}  // namespace

// --- BaseStation

Machine::Refusal BaseStation::check(const Instruction& instruction) const {
  if (instruction.side != "INPUT" && instruction.side != "OUTPUT")
    return {InstructError::kInvalid, "side: found '" + instruction.side + "', expected INPUT or OUTPUT", true};
  const auto base = named<BaseColor>(instruction.base_color);
  if (!base || *base == BaseColor::kClear)
    return {InstructError::kInvalid,
            "base_color: found '" + instruction.base_color + "', expected BASE_RED, BASE_BLACK or BASE_SILVER", true};
  return {};
}

void BaseStation::work(SimTime now, sim::World& world) {
  const double direction = instruction().side == "INPUT" ? -1 : 1;
  if (state() == MachineState::kPrepared) {
    enter(MachineState::kProcessing, now);
  } else if (state() == MachineState::kProcessing && in_phase(now) >= kDispenseTime) {
    sim::Stack stack;
    stack.base = static_cast<std::uint8_t>(*named<BaseColor>(instruction().base_color));
    if (!world.dispense(id(), sim::kMachine.processing_x, stack))
      return;  // something lies there: try again until stuck
    run_belt(world, direction * kOutSpeed, -direction * sim::kMachine.belt_rest_x);
    enter(MachineState::kProcessed, now);
  } else if (state() == MachineState::kProcessed && in_phase(now) >= kBeltOutTime && ready(world)) {
    enter(MachineState::kReadyAtOutput, now);
    finish_job();
  }
}

SimTime BaseStation::work_after() const {
  if (state() == MachineState::kPrepared) return SimTime::zero();
  return state() == MachineState::kProcessing ? kDispenseTime : kBeltOutTime;
}

sim::SpotId BaseStation::ready_spot() const { return instruction().side == "INPUT" ? input_ : output_; }

// --- CapStation

CapStation::CapStation(sim::StationId id, Team team, MachineContext& context, const sim::FloorPlan& plan)
    : Machine(id, team, context, plan), shelf_cap_(shelf_cap(name())), refill_at_(context.clock.production_begin) {
  shelf_ = {*plan.find_spot(name() + "-SHELF-LEFT"), *plan.find_spot(name() + "-SHELF-MIDDLE"),
            *plan.find_spot(name() + "-SHELF-RIGHT")};
}

Machine::Refusal CapStation::check(const Instruction& instruction) const {
  if (instruction.operation == "RETRIEVE_CAP") {
    if (cap_buffered()) return {InstructError::kInvalid, "RETRIEVE_CAP while a cap is buffered", true};
  } else if (instruction.operation == "MOUNT_CAP") {
    if (!cap_buffered()) return {InstructError::kInvalid, "MOUNT_CAP while no cap is buffered", true};
  } else {
    return {InstructError::kInvalid,
            "operation: found '" + instruction.operation + "', expected RETRIEVE_CAP or MOUNT_CAP", true};
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
    if (world.dispense(slot, carrier)) refill_at_ = kNever;
}

void CapStation::work(SimTime now, sim::World& world) {
  if (state() == MachineState::kPrepared) {
    if (bring_to_middle(world) && in_phase(now) >= kBeltInTime) enter(MachineState::kProcessing, now);
  } else if (state() == MachineState::kProcessing && in_phase(now) >= kCapTime) {
    retrieve_or_mount(now, world);
  } else if (state() == MachineState::kProcessed && in_phase(now) >= kBeltOutTime && ready(world)) {
    enter(MachineState::kReadyAtOutput, now);
    finish_job();
  }
}

void CapStation::retrieve_or_mount(SimTime now, sim::World& world) {
  const sim::Piece* piece = world.on_belt(id(), sim::kMachine.processing_x);
  if (piece == nullptr) return;  // taken away: stuck
  const sim::PieceId id_of_piece = piece->id;
  if (instruction().operation == "RETRIEVE_CAP") {
    if (piece->stack.cap == 0)
      return break_down(now, world, InstructError::kInvalid, "RETRIEVE_CAP from a workpiece without a cap");
    buffered_cap_ = piece->stack.cap;
    world.unmount_cap(id_of_piece);
    post(MachineEvent::Kind::kCapRetrieved, now).piece = id_of_piece;
  } else {
    if (piece->stack.cap != 0)
      return break_down(now, world, InstructError::kInvalid, "MOUNT_CAP on a workpiece that has a cap");
    world.mount(id_of_piece, sim::Part::kCap, buffered_cap_);
    buffered_cap_ = 0;
  }
  run_belt(world, kOutSpeed, -sim::kMachine.belt_rest_x);
  enter(MachineState::kProcessed, now);
}

SimTime CapStation::work_after() const {
  if (state() == MachineState::kPrepared) return kBeltInTime;
  return state() == MachineState::kProcessing ? kCapTime : kBeltOutTime;
}

// --- RingStation, StorageStation

Machine::Refusal RingStation::check(const Instruction&) const {
  return {InstructError::kNotSupported, name() + ": mounting rings is not supported in this release", false};
}

void RingStation::observe(SimTime now, sim::World& world) {
  const int count = world.slide_count(id());
  if (seen_ < 0) seen_ = count;  // what was paid before production counts for nothing
  for (; seen_ < count; ++seen_) {
    if (state() == MachineState::kBroken) continue;
    ++payments_;
    post(MachineEvent::Kind::kPayment, now);
    if (payments_ > kMaxPayments)
      break_down(now, world, InstructError::kBroken, "a fourth unused payment on its slide");
  }
}

Machine::Refusal StorageStation::check(const Instruction&) const {
  return {InstructError::kNotSupported, name() + ": storage is not supported in this release", false};
}

// --- DeliveryStation

const Order* DeliveryStation::order() const {
  const auto at = std::ranges::find(*context_.orders, instruction().order_id, &Order::id);
  return at == context_.orders->end() ? nullptr : &*at;
}

Machine::Refusal DeliveryStation::check(const Instruction& instruction) const {
  const auto known = [&](const Order& order) { return order.id == instruction.order_id; };
  if (instruction.order_id != 0 && std::ranges::none_of(*context_.orders, known))
    return {InstructError::kInvalid, "order_id: no order " + std::to_string(instruction.order_id), true};
  return {};
}

void DeliveryStation::work(SimTime now, sim::World& world) {
  const SimTime gate_time = kGateTimes[order() == nullptr ? 0 : order()->delivery_gate - 1];
  if (state() == MachineState::kPrepared) {
    if (order() != nullptr && now < context_.clock.at(order()->delivery_begin)) return;
    bring_to_middle(world);
    arrived_after_ = kNever;
    enter(MachineState::kProcessing, now);
  } else if (state() == MachineState::kProcessing) {
    if (!bring_to_middle(world)) {
      arrived_after_ = kNever;
      return;
    }
    if (arrived_after_ == kNever) arrived_after_ = std::max(in_phase(now), kBeltInTime);
    if (in_phase(now) < arrived_after_ + gate_time - kBeltInTime) return;
    const sim::Piece product = *world.on_belt(id(), sim::kMachine.processing_x);
    MachineEvent& event = post(MachineEvent::Kind::kDelivery, now);
    event.order_id = instruction().order_id;
    event.piece = product.id;
    event.stack = product.stack;
    world.retire(product.id, sim::Holder::kGate);
    enter(MachineState::kProcessed, now);
    finish_job();
  } else {
    enter(MachineState::kWaitIdle, now);
  }
}

SimTime DeliveryStation::work_after() const {
  if (state() == MachineState::kPrepared && order() != nullptr) {
    // The window's start as a time in this phase; `next_due` adds the phase's start again.
    return context_.clock.at(order()->delivery_begin) - phase_start();
  }
  if (state() != MachineState::kProcessing) return SimTime::zero();
  const SimTime gate_time = kGateTimes[order() == nullptr ? 0 : order()->delivery_gate - 1];
  return arrived_after_ == kNever ? kNever : arrived_after_ + gate_time - kBeltInTime;
}

bool DeliveryStation::may_wait() const {
  return context_.rules.delivery_may_wait && state() == MachineState::kPrepared;
}

// --- All of them

std::vector<std::unique_ptr<Machine>> make_machines(const sim::FloorPlan& plan, MachineContext& context) {
  std::vector<std::unique_ptr<Machine>> machines;
  for (std::size_t i = 0; i < plan.stations.size(); ++i) {
    const auto id = static_cast<sim::StationId>(i);
    const sim::Station& station = plan.stations[i];
    const Team team = station.name.front() == 'C' ? Team::kCyan : Team::kMagenta;
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

}  // namespace cxlab::rcll
