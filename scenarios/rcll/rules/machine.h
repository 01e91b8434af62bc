#pragma once
// A machine of the league. The kinds are in machines.h.
//
//   IDLE -instruct-> PREPARED -> PROCESSING -> PROCESSED -> READY-AT-OUTPUT -taken-> WAIT-IDLE -5 s-> IDLE
//   any -> BROKEN -30 s-> IDLE      any -> DOWN -> as before
//
// As in the referee box, its state and its hardware are two things: the state sends the hardware one command at a time
// and goes on when that is done. In a down time the state is DOWN; the hardware ends its command all the same (with the
// rulebook it stands still), and the state follows when the down time ends. WAIT-IDLE and BROKEN go on meanwhile.
//
// A machine works in the act phase of a tick: the hardware moves matter by the verbs of `sim::World`, then the state
// changes. What it did waits as events for the referee.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cx/base/time.h"
#include "scenarios/rcll/rules/clock.h"
#include "scenarios/rcll/rules/config.h"
#include "scenarios/rcll/rules/exploration.h"
#include "scenarios/rcll/rules/orders.h"
#include "scenarios/rcll/rules/storage.h"
#include "scenarios/rcll/rules/types.h"
#include "sim/world.h"

namespace cxlab::rcll {

enum class MachineState : std::uint8_t {
  kIdle,
  kPrepared,
  kProcessing,
  kProcessed,
  kReadyAtOutput,
  kWaitIdle,
  kBroken,
  kDown
};
template <>
inline constexpr std::array<std::string_view, 8> kNames<MachineState>{
    "IDLE", "PREPARED", "PROCESSING", "PROCESSED", "READY-AT-OUTPUT", "WAIT-IDLE", "BROKEN", "DOWN"};
/// What the signal lights show in that state.
sim::Lights lights_of(MachineState state);
/// What those of an idle machine show while its team explores.
sim::Lights lights_of(const Exploration::Finding& finding);

/// Why an instruction ended; numbers as in the league's AgentTask where it has one.
enum class InstructError : std::uint16_t {
  kNone = 0,
  kBroken = 1,    ///< the machine broke for a reason outside of the instruction (reset, payments)
  kNoAnswer = 2,  ///< the instruction was lost on its way
  kWrongTeam = 101,
  kInvalid =
      103,  ///< something is missing, unknown or impossible; where the league demands it the machine is now BROKEN
  kNoWorkpiece = 202,  ///< no workpiece came, or it got stuck: the machine is now BROKEN
  kNoMachine = 203,
  kNotReady = 209,  ///< machine not idle, or game not in production
};

/// What an agent asks of a machine; unused fields stay empty.
struct Instruction {
  std::string operation = {};    ///< CS: RETRIEVE_CAP, MOUNT_CAP; SS: STORE, RETRIEVE, CHANGE_INFO; any: RESET
  std::string side = {};         ///< BS: INPUT, OUTPUT
  std::string base_color = {};   ///< BS: BASE_RED, BASE_BLACK, BASE_SILVER
  std::string ring_color = {};   ///< RS: one of the two that it mounts
  int order_id = 0;              ///< DS: 0 discards
  int shelf = 0;                 ///< SS: 0..5
  int slot = 0;                  ///< SS: 0..7
  std::string description = {};  ///< SS, STORE and CHANGE_INFO: what the team says of the workpiece
};

/// The last instruction that the machine accepted.
struct Job {
  std::uint32_t number = 0;  ///< from 1
  bool open = false;         ///< still being carried out
  InstructError error = InstructError::kNone;
  std::string text;  ///< of the error
};

struct MachineEvent {
  enum class Kind : std::uint8_t {
    kState,
    kPayment,
    kCapRetrieved,
    kMounted,
    kStored,
    kUnstored,
    kRelocated,
    kDelivery,
    kBroke,
    kNoSpare  ///< all pieces of the game are in play: nothing can come out
  };
  Kind kind{};
  sim::StationId machine{};
  SimTime at{};
  MachineState state{};       ///< kState
  int order_id = 0;           ///< kDelivery
  sim::PieceId piece{};       ///< kDelivery, kCapRetrieved, kMounted, kStored, kUnstored
  sim::Stack stack;           ///< the same: what the piece is now; kRelocated
  int payments = 0;           ///< kMounted: that it cost
  Storage::Slot slot, from;   ///< kStored, kUnstored, kRelocated; `from`: kRelocated
  bool at_start = false;      ///< kUnstored: it lay there as the game began
  int unused_payments = 0;    ///< kBroke
  bool cap_buffered = false;  ///< kBroke
  bool no_workpiece = false;  ///< kBroke: no workpiece ever came to a machine that was told to take one in
  std::string reason;         ///< kBroke
};

/// A time in which the machine does nothing; what it was doing takes that much longer.
struct DownPeriod {
  SimTime begin = kNever, end = kNever;
};

// Belts, seen in the machine's frame, which looks from output to input: from the input to the middle, and from the
// middle to the output.
inline constexpr SimTime kBeltInTime = std::chrono::milliseconds(1538);
inline constexpr SimTime kBeltOutTime = std::chrono::milliseconds(2656);
inline constexpr double kInSpeed = -sim::kMachine.belt_rest_x / 1.538;   ///< m/s
inline constexpr double kOutSpeed = -sim::kMachine.belt_rest_x / 2.656;  ///< m/s

/// What the machines of a game share; outlives them.
struct MachineContext {
  GameClock clock;
  RuleChoices rules;
  SimTime shelf_refill = from_seconds(20);
  const Schedule* schedule = nullptr;
  const Exploration* exploration = nullptr;  ///< null: all machines are known
  std::uint64_t seed = 0;
  std::vector<MachineEvent> events;  ///< in order of time; the referee takes them away
};

class Machine {
 public:
  Machine(sim::StationId id, Team team, MachineContext& context, const sim::FloorPlan& plan);
  virtual ~Machine() = default;

  void add_down(DownPeriod down) { downs_.push_back(down); }
  /// Breaks for a reason of its own. False, and nothing happens, when it is BROKEN already or the game is not in
  /// production.
  bool fail(SimTime now, sim::World& world, const std::string& reason);
  /// A BROKEN machine is IDLE at once. False, and nothing happens, when it is not BROKEN.
  bool repair(SimTime now);

  /// Accepts an instruction (error kNone: see `job`; RESET and CHANGE_INFO are done at once), or rejects it with the
  /// reason. A rejection may leave the machine BROKEN.
  struct Answer {
    InstructError error = InstructError::kNone;
    std::string text;
    bool done = false;  ///< nothing is left to wait for
  };
  Answer instruct(const Instruction& instruction, SimTime now, sim::World& world);
  /// Looks, works, changes state. Every tick.
  void step(SimTime now, sim::World& world);
  /// The next time at which it does something by itself, after the last step.
  SimTime next_due() const;

  sim::StationId id() const { return id_; }
  const std::string& name() const { return name_; }
  Team team() const { return team_; }
  MachineState state() const { return state_; }
  /// It works for 10 s in the same state; after 20 s it counts as stuck and breaks.
  bool may_be_stuck(SimTime now) const;
  const Job& job() const { return job_; }
  const Instruction& instruction() const { return instruction_; }  ///< of the job
  /// Unused payments, or 1 when a cap is buffered. A BROKEN machine forgets them when it is IDLE again.
  virtual int loaded_with() const { return 0; }

 protected:
  /// Reads and checks an instruction: empty = accepted. `breaks`: the machine is BROKEN by it.
  struct Refusal {
    InstructError error = InstructError::kNone;
    std::string text;
    bool breaks = false;
  };
  virtual Refusal check(const Instruction& instruction) = 0;
  /// Whether the instruction asks for no work: it is done at once, without a change of state.
  virtual bool done_at_once(const Instruction&) { return false; }
  /// An instruction was accepted: the machine is PREPARED. Most take the workpiece in.
  virtual void begin(SimTime now, sim::World& world) { send(Command::kToMiddle, now, world); }
  /// Looks after what goes on in any state (payments, shelf).
  virtual void observe(SimTime, sim::World&) {}
  /// PREPARED, PROCESSING, PROCESSED: the state goes on, if it can. Called when the hardware has done its command.
  virtual void proceed(SimTime now, sim::World& world) = 0;
  /// The hardware's own work, when its time has passed. False = it does not succeed yet. What lies under the tool is
  /// `piece`, nullptr for nothing.
  virtual bool operate(SimTime, sim::World&, const sim::Piece*) { return true; }
  virtual SimTime observe_due() const { return kNever; }
  /// When `proceed` has something to do in a phase without a command; never = only when the world changes.
  virtual SimTime proceed_due() const { return kNever; }
  /// What the machine lacks when it is stuck: the error of its instruction.
  virtual Refusal lacks() const { return {InstructError::kNoWorkpiece, "no workpiece where it was expected"}; }
  /// Whether the current phase may last longer than the 20 s after which a machine counts as stuck.
  virtual bool may_wait() const { return false; }
  /// Forgets payments and caps.
  virtual void clear() {}
  virtual bool cap_buffered() const { return false; }
  virtual sim::SpotId ready_spot() const { return output_; }
  bool broken() const;  ///< also when DOWN hides it

  /// What the hardware can be told.
  enum class Command : std::uint8_t {
    kNone,
    kToMiddle,  ///< belt inwards until a workpiece lies in the middle
    kToInput,   ///< belt towards the input
    kToOutput,  ///< belt towards the output
    kOperate,   ///< `operate`, after a time
    kTakeIn,    ///< kToMiddle, then kOperate: its time counts from the moment at which the workpiece could come first
  };
  /// Sends a command; `time`: of kOperate and kTakeIn.
  void send(Command command, SimTime now, sim::World& world, SimTime time = {});
  void enter(MachineState state, SimTime now);
  /// The same state with another command: the time after which it counts as stuck begins again.
  void restart_phase(SimTime now) { phase_start_ = now; }
  /// READY-AT-OUTPUT if the workpiece has come to rest there; the job is done.
  void present(SimTime now, const sim::World& world);
  void break_down(SimTime now, sim::World& world, InstructError error, std::string reason);
  void finish_job() { job_.open = false; }
  /// A new piece in the middle of the belt, or nothing yet.
  std::optional<sim::PieceId> dispense(SimTime now, sim::World& world, const sim::Stack& stack);
  /// Posts a missing spare piece once, until there is one again.
  std::optional<sim::PieceId> took(const Expected<sim::PieceId>& piece, SimTime now);
  MachineEvent& post(MachineEvent::Kind kind, SimTime now);
  MachineEvent& post(MachineEvent::Kind kind, SimTime now, const sim::Piece& piece);

  MachineContext& context_;
  sim::SpotId input_{}, output_{};
  sim::Piece worked_on_;  ///< by `operate`, as it was afterwards

 private:
  void run_hardware(SimTime now, sim::World& world);
  bool bring_to_middle(sim::World& world);
  void change_state(SimTime now, sim::World& world);
  bool hardware_stands() const { return state_ == MachineState::kDown && context_.rules.down_stops_work; }
  SimTime in_phase(SimTime now) const { return now - phase_start_; }
  SimTime hardware_due() const;
  void run_belt(sim::World& world, double speed, double stop_x);
  void stop_belt(sim::World& world);
  void follow_down_times(SimTime now, sim::World& world);
  void show_lights(SimTime now, sim::World& world);

  sim::StationId id_;
  std::string name_;
  Team team_;
  MachineState state_ = MachineState::kIdle, before_down_ = MachineState::kIdle;
  SimTime phase_start_{}, last_step_{}, down_since_{};
  bool look_again_ = false;  ///< at the next tick
  bool no_spare_ = false;    ///< it could not dispense at its last attempt
  std::vector<DownPeriod> downs_;
  Job job_;
  Instruction instruction_;
  struct {
    Command command = Command::kNone;  ///< in execution
    SimTime since{}, time{};
    SimTime arrived = kNever;  ///< kTakeIn: when the workpiece came to rest
  } hardware_;
  struct {
    double speed = 0, stop_x = 0;
    bool wanted = false;
  } belt_;
};

}  // namespace cxlab::rcll
