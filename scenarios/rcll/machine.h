#pragma once
// A machine of the league: its state, its clock, its belt. The kinds are in machines.h.
//
//   IDLE -instruct-> PREPARED -> PROCESSING -> PROCESSED -> READY-AT-OUTPUT -taken-> WAIT-IDLE -5 s-> IDLE
//   any -> BROKEN -30 s-> IDLE      any but BROKEN -> DOWN -> as before
//
// A machine works in the act phase of a tick: it looks at the world, changes its state, and moves matter by the verbs
// of `sim::World`. What it did waits as events for the referee.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cx/base/time.h"
#include "scenarios/rcll/clock.h"
#include "scenarios/rcll/config.h"
#include "scenarios/rcll/orders.h"
#include "scenarios/rcll/types.h"
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

/// Why an instruction ended; numbers as in the league's AgentTask where it has one.
enum class InstructError : std::uint16_t {
  kNone = 0,
  kBroken = 1,  ///< the machine broke for a reason outside of the instruction (reset, payments)
  kWrongTeam = 101,
  kInvalid =
      103,  ///< something is missing, unknown or impossible; where the league demands it the machine is now BROKEN
  kNotSupported = 104,
  kNoWorkpiece = 202,  ///< no workpiece came, or it got stuck: the machine is now BROKEN
  kNoMachine = 203,
  kNotReady = 209,  ///< machine not idle, or game not in production
};

/// What an agent asks of a machine; unused fields stay empty.
struct Instruction {
  std::string operation;   ///< CS: RETRIEVE_CAP, MOUNT_CAP; any: RESET
  std::string side;        ///< BS: INPUT, OUTPUT
  std::string base_color;  ///< BS: BASE_RED, BASE_BLACK, BASE_SILVER
  std::string ring_color;  ///< RS
  int order_id = 0;        ///< DS: 0 discards
};

/// The last instruction that the machine accepted.
struct Job {
  std::uint32_t number = 0;  ///< from 1
  bool open = false;         ///< still being carried out
  InstructError error = InstructError::kNone;
  std::string text;  ///< of the error
};

struct MachineEvent {
  enum class Kind : std::uint8_t { kState, kPayment, kCapRetrieved, kDelivery, kBroke };
  Kind kind{};
  sim::StationId machine{};
  SimTime at{};
  MachineState state{};       ///< kState
  int order_id = 0;           ///< kDelivery
  sim::PieceId piece{};       ///< kDelivery, kCapRetrieved
  sim::Stack stack;           ///< kDelivery
  int unused_payments = 0;    ///< kBroke
  bool cap_buffered = false;  ///< kBroke
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
  const std::vector<Order>* orders = nullptr;
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

  /// Accepts an instruction (error kNone: see `job`; RESET is done at once), or rejects it with the reason. A rejection
  /// may leave the machine BROKEN.
  struct Answer {
    InstructError error = InstructError::kNone;
    std::string text;
  };
  Answer instruct(const Instruction& instruction, SimTime now, sim::World& world);
  /// Looks, changes state, acts. Every tick.
  void step(SimTime now, sim::World& world);
  /// The next time at which it does something by itself, after the last step.
  SimTime next_due() const;

  sim::StationId id() const { return id_; }
  const std::string& name() const { return name_; }
  Team team() const { return team_; }
  MachineState state() const { return state_; }
  const Job& job() const { return job_; }
  const Instruction& instruction() const { return instruction_; }  ///< of the job
  /// Unused payments, or 1 when a cap is buffered.
  virtual int loaded_with() const { return 0; }

 protected:
  /// Reads and checks an instruction: empty = accepted. `breaks`: the machine is BROKEN by it.
  struct Refusal {
    InstructError error = InstructError::kNone;
    std::string text;
    bool breaks = false;
  };
  virtual Refusal check(const Instruction& instruction) const = 0;
  /// Looks after what goes on in any state (payments, shelf).
  virtual void observe(SimTime, sim::World&) {}
  /// PREPARED, PROCESSING, PROCESSED.
  virtual void work(SimTime, sim::World&) {}
  /// When `work` wants to be called, counted from the start of the phase; never = only when the world changes.
  virtual SimTime work_after() const { return kNever; }
  virtual SimTime observe_due() const { return kNever; }
  /// Whether the current phase may last longer than the 20 s after which a machine counts as stuck.
  virtual bool may_wait() const { return false; }
  /// Forgets payments and caps.
  virtual void clear() {}
  virtual sim::SpotId ready_spot() const { return output_; }

  void enter(MachineState state, SimTime now);
  void break_down(SimTime now, sim::World& world, InstructError error, std::string reason);
  void finish_job() { job_.open = false; }
  void run_belt(sim::World& world, double speed, double stop_x);
  void stop_belt(sim::World& world);
  /// Runs the belt inwards until a workpiece lies in the middle; true once it does.
  bool bring_to_middle(sim::World& world);
  /// Whether a workpiece lies at the side where the robot takes it, and the belt has come to rest.
  bool ready(const sim::World& world) const;
  MachineEvent& post(MachineEvent::Kind kind, SimTime now);
  SimTime in_phase(SimTime now) const { return now - phase_start_; }
  SimTime phase_start() const { return phase_start_; }
  virtual bool cap_buffered() const { return false; }

  MachineContext& context_;
  sim::SpotId input_{}, output_{};

 private:
  void enter_down(SimTime now, sim::World& world);
  void leave_down(SimTime now, sim::World& world);
  void show_lights(SimTime now, sim::World& world);

  sim::StationId id_;
  std::string name_;
  Team team_;
  MachineState state_ = MachineState::kIdle, before_down_ = MachineState::kIdle;
  SimTime phase_start_{}, last_step_{}, down_since_{};
  std::vector<DownPeriod> downs_;
  Job job_;
  Instruction instruction_;
  struct {
    double speed = 0, stop_x = 0;
    bool wanted = false;
  } belt_;
};

}  // namespace cxlab::rcll
