#include "scenarios/rcll/rules/machine.h"

#include <algorithm>
#include <utility>

namespace cxlab::rcll {
namespace {

constexpr SimTime kBrokenTime = std::chrono::seconds(30);
constexpr SimTime kWaitIdleTime = std::chrono::seconds(5);
constexpr SimTime kStuckTime = std::chrono::seconds(20);
constexpr SimTime kStuckWarning = std::chrono::seconds(10);

bool working(MachineState state) {
  return state == MachineState::kPrepared || state == MachineState::kProcessing || state == MachineState::kProcessed;
}

}  // namespace

sim::Lights lights_of(MachineState state) {
  using sim::Light;
  switch (state) {
    case MachineState::kIdle: return {Light::kOff, Light::kOff, Light::kOn};
    case MachineState::kPrepared: return {Light::kOff, Light::kOff, Light::kBlink};
    case MachineState::kProcessing:
    case MachineState::kProcessed: return {Light::kOff, Light::kOn, Light::kOn};
    case MachineState::kReadyAtOutput: return {Light::kOff, Light::kOn, Light::kBlink};
    case MachineState::kWaitIdle: return {Light::kOff, Light::kBlink, Light::kBlink};
    case MachineState::kBroken: return {Light::kBlink, Light::kBlink, Light::kOff};
    case MachineState::kDown: return {Light::kOn, Light::kOff, Light::kOff};
  }
  return {};
}

sim::Lights lights_of(const Exploration::Finding& finding) {
  using sim::Light;
  using Guess = Exploration::Guess;
  if (finding.zone == Guess::kOpen) return {Light::kOff, Light::kOn, Light::kOff};
  if (finding.zone == Guess::kWrong) return {Light::kOn, Light::kOn, Light::kOff};
  return {finding.rotation == Guess::kWrong ? Light::kOn : Light::kOff, Light::kBlink, Light::kOff};
}

Machine::Machine(sim::StationId id, Team team, MachineContext& context, const sim::FloorPlan& plan)
    : context_(context), id_(id), name_(plan.station(id).name), team_(team) {
  input_ = plan.find_spot(name_ + "-INPUT").value_or(sim::SpotId{-1});
  output_ = plan.find_spot(name_ + "-OUTPUT").value_or(sim::SpotId{-1});
}

Machine::Answer Machine::instruct(const Instruction& instruction, SimTime now, sim::World& world) {
  if (context_.clock.phase(now) != Phase::kProduction)
    return {InstructError::kNotReady, "the game is in phase " + std::string(to_string(context_.clock.phase(now)))};
  if (last_step_ != now) step(now, world);  // what is due comes first: a payment, the end of a wait, a down time
  if (instruction.operation == "RESET") {
    if (broken()) return {InstructError::kNotReady, name_ + " is BROKEN already"};
    break_down(now, world, InstructError::kBroken, "reset by its team");
    return {InstructError::kNone, {}, true};
  }
  if (context_.exploration && !context_.exploration->knows(id_, now))
    return {InstructError::kNotReady, name_ + " is not reported right, and exploration goes on"};
  if (state_ != MachineState::kIdle) {
    std::string text = name_ + " is " + std::string(to_string(state_)) + ", not IDLE";
    const bool busy = working(state_) || state_ == MachineState::kReadyAtOutput || state_ == MachineState::kWaitIdle;
    if (context_.rules.second_prepare_breaks && busy)
      break_down(now, world, InstructError::kBroken, "instructed while " + std::string(to_string(state_)));
    return {InstructError::kNotReady, std::move(text)};
  }
  if (const Refusal refusal = check(instruction); refusal.error != InstructError::kNone) {
    if (refusal.breaks) break_down(now, world, refusal.error, refusal.text);
    return {refusal.error, refusal.text};
  }
  if (done_at_once(instruction)) return {InstructError::kNone, {}, true};
  instruction_ = instruction;
  job_ = {job_.number + 1, true, InstructError::kNone, {}};
  enter(MachineState::kPrepared, now);
  begin(now, world);
  return {};
}

bool Machine::fail(SimTime now, sim::World& world, const std::string& reason) {
  if (broken() || context_.clock.phase(now) != Phase::kProduction) return false;
  break_down(now, world, InstructError::kBroken, reason);
  return true;
}

bool Machine::repair(SimTime now) {
  if (state_ != MachineState::kBroken) return false;
  clear();
  enter(MachineState::kIdle, now);
  return true;
}

bool Machine::may_be_stuck(SimTime now) const {
  return working(state_) && in_phase(now) > kStuckWarning && !may_wait();
}

bool Machine::broken() const {
  return state_ == MachineState::kBroken || (state_ == MachineState::kDown && before_down_ == MachineState::kBroken);
}

void Machine::step(SimTime now, sim::World& world) {
  last_step_ = now;
  look_again_ = false;
  if (context_.clock.phase(now) == Phase::kProduction) {
    observe(now, world);
    if (!hardware_stands()) run_hardware(now, world);
    const bool was_down = state_ == MachineState::kDown;
    follow_down_times(now, world);
    // The state that DOWN had hidden is seen once before it goes on.
    look_again_ = was_down && state_ != MachineState::kDown;
    if (!look_again_) change_state(now, world);
  } else if (context_.clock.phase(now) == Phase::kPostGame && belt_.wanted) {
    stop_belt(world);
  }
  show_lights(now, world);
}

void Machine::change_state(SimTime now, sim::World& world) {
  if (in_phase(now) >= kBrokenTime) repair(now);
  if (state_ == MachineState::kWaitIdle && in_phase(now) >= kWaitIdleTime) enter(MachineState::kIdle, now);
  if (state_ == MachineState::kReadyAtOutput && world.at(ready_spot()) == nullptr) enter(MachineState::kWaitIdle, now);
  if (!working(state_)) return;
  if (hardware_.command == Command::kNone) proceed(now, world);
  if (working(state_) && in_phase(now) > kStuckTime && !may_wait()) {
    const Refusal missing = lacks();
    break_down(now, world, missing.error, "stuck for 20 s in " + std::string(to_string(state_)) + ": " + missing.text);
  }
}

SimTime Machine::next_due() const {
  if (context_.clock.phase(last_step_) == Phase::kPostGame) return kNever;
  SimTime due = kNever;
  const auto at = [&](SimTime t) {
    if (t > last_step_) due = std::min(due, t);
  };
  at(observe_due());
  for (const DownPeriod& period : downs_) {
    at(period.begin);
    at(period.end);
  }
  if (context_.exploration) at(context_.exploration->end());
  at(context_.clock.production_begin);
  at(context_.clock.production_end);
  if (state_ == MachineState::kBroken) at(phase_start_ + kBrokenTime);
  if (state_ == MachineState::kWaitIdle) at(phase_start_ + kWaitIdleTime);
  if (hardware_.command != Command::kNone && !hardware_stands()) at(hardware_due());
  if (working(state_)) {
    if (hardware_.command == Command::kNone) at(proceed_due());
    if (!may_wait()) at(phase_start_ + kStuckTime + SimTime{1});
    if (phase_start_ == last_step_) due = std::min(due, last_step_);
  }
  return look_again_ ? std::min(due, last_step_) : due;
}

void Machine::enter(MachineState state, SimTime now) {
  state_ = state;
  phase_start_ = now;
  post(MachineEvent::Kind::kState, now).state = state;
}

MachineEvent& Machine::post(MachineEvent::Kind kind, SimTime now) {
  MachineEvent& event = context_.events.emplace_back();
  event.kind = kind;
  event.machine = id_;
  event.at = now;
  return event;
}

MachineEvent& Machine::post(MachineEvent::Kind kind, SimTime now, const sim::Piece& piece) {
  MachineEvent& event = post(kind, now);
  event.piece = piece.id;
  event.stack = piece.stack;
  return event;
}

void Machine::break_down(SimTime now, sim::World& world, InstructError error, std::string reason) {
  std::vector<sim::PieceId> on_machine;
  for (const sim::Piece& piece : world.pieces())
    if (piece.is_with(sim::Holder::kBelt, id_)) on_machine.push_back(piece.id);
  MachineEvent& event = post(MachineEvent::Kind::kBroke, now);
  event.cap_buffered = cap_buffered();
  event.unused_payments = cap_buffered() ? 0 : loaded_with();
  event.no_workpiece = error == InstructError::kNoWorkpiece && on_machine.empty() &&
                       (hardware_.command == Command::kToMiddle || hardware_.command == Command::kTakeIn);
  event.reason = reason;
  hardware_.command = Command::kNone;
  stop_belt(world);
  for (const sim::PieceId piece : on_machine) world.retire(piece, sim::Holder::kFloor);
  if (job_.open) job_ = {job_.number, false, error, name_ + " is BROKEN: " + reason};
  enter(MachineState::kBroken, now);
}

std::optional<sim::PieceId> Machine::dispense(SimTime now, sim::World& world, const sim::Stack& stack) {
  return took(world.dispense(id_, sim::kMachine.processing_x, stack), now);
}

std::optional<sim::PieceId> Machine::took(const Expected<sim::PieceId>& piece, SimTime now) {
  const bool none = !piece && piece.error().code == "no_spare_piece";
  if (none && !std::exchange(no_spare_, none)) post(MachineEvent::Kind::kNoSpare, now);
  no_spare_ = none;
  return piece ? std::optional(*piece) : std::nullopt;
}

void Machine::present(SimTime now, const sim::World& world) {
  if (world.at(ready_spot()) == nullptr) return;
  enter(MachineState::kReadyAtOutput, now);
  finish_job();
}

// --- Hardware

void Machine::send(Command command, SimTime now, sim::World& world, SimTime time) {
  hardware_ = {command, now, time, kNever};
  if (command == Command::kToMiddle || command == Command::kTakeIn) bring_to_middle(world);
  if (command == Command::kToOutput) run_belt(world, kOutSpeed, -sim::kMachine.belt_rest_x);
  if (command == Command::kToInput) run_belt(world, -kOutSpeed, sim::kMachine.belt_rest_x);
}

void Machine::run_hardware(SimTime now, sim::World& world) {
  const SimTime elapsed = now - hardware_.since;
  bool done = false;
  switch (hardware_.command) {
    case Command::kNone: return;
    case Command::kToMiddle: done = bring_to_middle(world) && elapsed >= kBeltInTime; break;
    case Command::kToInput:
    case Command::kToOutput: done = elapsed >= kBeltOutTime && !world.belt_running(id_); break;
    case Command::kTakeIn:
      if (!bring_to_middle(world))
        hardware_.arrived = kNever;
      else if (hardware_.arrived == kNever)
        hardware_.arrived = std::max(elapsed, kBeltInTime);
      [[fallthrough]];
    case Command::kOperate:
      done = now >= hardware_due() && operate(now, world, world.on_belt(id_, sim::kMachine.processing_x));
      break;
  }
  if (done) hardware_.command = Command::kNone;
}

SimTime Machine::hardware_due() const {
  switch (hardware_.command) {
    case Command::kNone: return kNever;
    case Command::kToMiddle: return hardware_.since + kBeltInTime;
    case Command::kToInput:
    case Command::kToOutput: return hardware_.since + kBeltOutTime;
    case Command::kOperate: return hardware_.since + hardware_.time;
    case Command::kTakeIn:
      if (hardware_.arrived == kNever) return kNever;
      return hardware_.since + hardware_.arrived + hardware_.time - kBeltInTime;
  }
  return kNever;
}

bool Machine::bring_to_middle(sim::World& world) {
  if (world.belt_running(id_)) return false;
  if (world.on_belt(id_, sim::kMachine.processing_x) != nullptr) {
    belt_.wanted = false;
    return true;
  }
  run_belt(world, kInSpeed, sim::kMachine.processing_x);
  return false;
}

void Machine::run_belt(sim::World& world, double speed, double stop_x) {
  belt_ = {speed, stop_x, true};
  world.run_belt(id_, speed, stop_x);
}

void Machine::stop_belt(sim::World& world) {
  belt_.wanted = false;
  world.stop_belt(id_);
}

// --- Down times

void Machine::follow_down_times(SimTime now, sim::World& world) {
  const bool down =
      std::ranges::any_of(downs_, [&](const DownPeriod& period) { return now >= period.begin && now < period.end; });
  if (down == (state_ == MachineState::kDown)) return;
  if (down) {
    before_down_ = std::exchange(state_, MachineState::kDown);
    down_since_ = now;
    if (context_.rules.down_stops_work) {
      belt_.wanted = world.belt_running(id_);  // one that a piece has stopped stays still afterwards
      if (belt_.wanted) world.stop_belt(id_);
    }
  } else {
    const SimTime duration = now - down_since_;
    state_ = before_down_;
    if (working(state_)) phase_start_ += duration;
    if (context_.rules.down_stops_work) {
      hardware_.since += duration;
      if (belt_.wanted) world.run_belt(id_, belt_.speed, belt_.stop_x);
    }
  }
  post(MachineEvent::Kind::kState, now).state = state_;
}

void Machine::show_lights(SimTime now, sim::World& world) {
  using sim::Light;
  sim::Lights shown = lights_of(state_);
  const bool shows_report = state_ == MachineState::kIdle || context_.rules.report_hides_broken;
  if (shows_report && context_.exploration && !context_.exploration->knows(id_, now))
    shown = lights_of(context_.exploration->finding(id_));
  if (context_.clock.phase(now) == Phase::kSetup) shown = {Light::kOn, Light::kOn, Light::kOn};
  if (context_.clock.phase(now) == Phase::kPostGame) shown = {Light::kBlink, Light::kOff, Light::kOff};
  if (!(world.lights(id_) == shown)) world.set_lights(id_, shown);
}

}  // namespace cxlab::rcll
