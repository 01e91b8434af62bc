#include "scenarios/rcll/rules/storage_station.h"

#include <utility>

namespace cxlab::rcll {
namespace {

constexpr SimTime kShelfTime = std::chrono::milliseconds(17500);

std::string text(const Storage::Slot& slot) {
  return "shelf " + std::to_string(slot.shelf) + ", slot " + std::to_string(slot.slot);
}

}  // namespace

StorageStation::StorageStation(sim::StationId id, Team team, MachineContext& context, const sim::FloorPlan& plan)
    : Machine(id, team, context, plan), random_(context.seed, "storage/" + name()) {}

Machine::Refusal StorageStation::check(const Instruction& instruction) {
  const auto refuse = [](std::string why) { return Refusal{InstructError::kInvalid, std::move(why), true}; };
  const std::string& operation = instruction.operation;
  if (operation != "STORE" && operation != "RETRIEVE" && operation != "CHANGE_INFO")
    return refuse("operation: " + found_text(operation, "STORE, RETRIEVE or CHANGE_INFO"));
  const Storage::Slot slot{instruction.shelf, instruction.slot};
  if (!Storage::exists(slot)) return refuse(text(slot) + ": shelves are 0 to 5, slots 0 to 7");
  const bool filled = storage_.at(slot).has_value();
  if (operation == "STORE" && filled) return refuse("STORE: " + text(slot) + " is filled");
  if (operation == "CHANGE_INFO")
    return filled ? Refusal{} : Refusal{InstructError::kInvalid, "CHANGE_INFO: " + text(slot) + " is empty"};
  if (operation == "RETRIEVE" && !filled) return refuse("RETRIEVE: " + text(slot) + " is empty");
  if (storage_.blocker(slot) && storage_.free_slots(slot).empty())
    return refuse(operation + ": a workpiece lies before " + text(slot) + ", and no other slot is free");
  return {};
}

bool StorageStation::done_at_once(const Instruction& instruction) {
  if (instruction.operation != "CHANGE_INFO") return false;
  storage_.at({instruction.shelf, instruction.slot})->description = instruction.description;
  return true;
}

void StorageStation::begin(SimTime now, sim::World& world) {
  if (stores()) Machine::begin(now, world);
}

void StorageStation::proceed(SimTime now, sim::World& world) {
  if (state() == MachineState::kPrepared) {
    enter(MachineState::kProcessing, now);
    send(Command::kOperate, now, world, kShelfTime);
  } else if (state() == MachineState::kProcessing) {
    // What lay in front was moved: the work itself is left.
    if (storage_.at(slot()).has_value() != stores()) {
      restart_phase(now);
      return send(Command::kOperate, now, world, kShelfTime);
    }
    MachineEvent& event = post(stores() ? MachineEvent::Kind::kStored : MachineEvent::Kind::kUnstored, now, worked_on_);
    event.slot = slot();
    event.at_start = !stores() && at_start_;
    enter(MachineState::kProcessed, now);
    if (stores())
      finish_job();
    else
      send(Command::kToOutput, now, world);
  } else if (stores()) {
    enter(MachineState::kWaitIdle, now);
  } else {
    present(now, world);
  }
}

bool StorageStation::operate(SimTime now, sim::World& world, const sim::Piece* piece) {
  if (const auto front = storage_.blocker(slot())) {
    const auto free = storage_.free_slots(slot());
    const Storage::Slot to = free[random_.below(free.size())];
    MachineEvent& event = post(MachineEvent::Kind::kRelocated, now);
    event.stack = storage_.at(*front)->stack;
    event.from = *front;
    event.slot = to;
    storage_.at(to) = std::exchange(storage_.at(*front), std::nullopt);
    return true;
  }
  if (stores()) {
    if (piece == nullptr) return false;  // taken away: stuck
    worked_on_ = *piece;
    storage_.at(slot()) = Storage::Content{worked_on_.stack, instruction().description, worked_on_.id};
    world.retire(worked_on_.id, sim::Holder::kStorage);
    return true;
  }
  const Storage::Content& kept = *storage_.at(slot());
  const auto out = kept.piece ? took(world.unstore(id(), sim::kMachine.processing_x, kept.stack, *kept.piece), now)
                              : dispense(now, world, kept.stack);
  if (!out) return false;  // while something lies there: again
  worked_on_ = *world.find(*out);
  at_start_ = !kept.piece;
  storage_.at(slot()).reset();
  return true;
}

}  // namespace cxlab::rcll
