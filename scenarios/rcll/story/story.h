#pragma once
// A recorded game in order: what each robot, machine and workpiece went through, read once from the records. The
// questions are asked of it.

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "scenarios/question.h"
#include "scenarios/rcll/game/game.h"
#include "scenarios/rcll/rules/event.h"
#include "sim/faults/fault.h"
#include "sim/world.h"

namespace cxlab::rcll {

struct Interval {
  SimTime from{}, to{};
  SimTime length() const { return to - from; }
  bool empty() const { return to <= from; }
};
Interval common(const Interval& a, const Interval& b);
/// What of `whole` none of the others covers; they may overlap, and are in order of their beginnings.
std::vector<Interval> without(const Interval& whole, const std::vector<Interval>& others);

/// A skill from its start to its end, or to the end of what is asked about.
struct SkillRun {
  std::string skill, target;
  std::vector<std::string> spots;  ///< that the target names: where from, where to
  Interval when;
  bool ended = false;
  int code = 0;  ///< 0: done
  std::string error;
  struct PhaseOf {
    Interval when;
    std::string name;
    std::string waits_for;  ///< the robot that is in the way; empty: not known
  };
  std::vector<PhaseOf> phases;
};

struct RobotStory {
  std::string name;
  Team team{};
  std::vector<SkillRun> skills;
  struct Away {
    Interval when;
    std::string cause;
    bool for_good = false;  ///< disqualified
  };
  std::vector<Away> off_field;
  struct Hold {
    Interval when;
    int piece = 0;
  };
  std::vector<Hold> holds;

  const SkillRun* skill_at(SimTime t) const;
  const Hold* hold_at(SimTime t) const;
};

/// A value from a time on.
template <class Value>
struct Since {
  SimTime t{};
  Value value{};
};
/// The value at that time, `before` where none has begun yet.
template <class Value>
Value value_at(const std::vector<Since<Value>>& values, SimTime t, Value before) {
  for (const Since<Value>& one : values) {
    if (one.t > t) break;
    before = one.value;
  }
  return before;
}

struct MachineStory {
  std::string name, kind;
  Team team{};
  std::vector<Since<std::string>> states;
  std::vector<Since<std::string>> breaks;  ///< why
  std::vector<Since<int>> payments;        ///< of a ring station: how many lie there
  std::vector<Since<bool>> cap;            ///< of a cap station: one is buffered
  std::vector<Since<InstructionHeard>> instructions;
  std::vector<Since<WorkDone>> works;
  std::vector<Since<int>> dispensed;  ///< numbers of pieces

  std::string state_at(SimTime t) const { return value_at(states, t, std::string("IDLE")); }
  /// The first time in that stretch at which a state begins.
  std::optional<SimTime> first(std::string_view state, const Interval& in) const;
  /// The last instruction that it took, up to that time.
  const InstructionHeard* instruction_at(SimTime t) const;
};

struct PieceStory {
  int number = 0;
  std::vector<Since<PieceMoved>> moves;
  std::vector<Since<WorkDone>> works;
  std::string product;  ///< "BASE_RED RING_BLUE", as far as it is known
  std::string origin;   ///< the machine that it came from
  std::optional<Since<DeliveryJudged>> delivery;
  std::optional<SimTime> discarded;
  std::optional<SimTime> taken;  ///< by a fault of the scenario

  SimTime begin() const { return moves.empty() ? SimTime{} : moves.front().t; }
};

struct Decision {
  SimTime t{};
  std::string by;                  ///< the environment
  std::optional<Team> team;        ///< whose robots that environment commands, as far as it is known
  std::vector<std::string> slots;  ///< as the rules made them
  /// "'begin order 1': 9.4 points ...".
  std::string text() const;
  bool names_order(int id) const;
  bool names(std::string_view word) const;
};

/// A fault of the scenario that has struck.
struct FaultStruck {
  SimTime t{};
  std::string kind, at;  ///< a robot or a machine
  SimTime until{};       ///< how long the scenario has it last; `t` for those that happen at once
};

class GameStory {
 public:
  static Expected<GameStory> read(const AskedRun& run);

  Game game;
  std::vector<Team> teams;
  sim::FloorPlan plan;
  RecordedClock clock;
  SimTime from{}, end{};  ///< what is asked about
  bool run_ended = false;

  std::vector<RobotStory> robots;      ///< of the teams that play
  std::vector<MachineStory> machines;  ///< the same
  std::vector<PieceStory> pieces;      ///< in order of their numbers
  std::vector<Decision> decisions;
  std::map<int, SimTime> published;  ///< orders
  std::vector<Since<DeliveryJudged>> deliveries;
  std::vector<Since<PointsGiven>> points;
  std::vector<Interval> pauses;
  std::vector<FaultStruck> faults;

  std::vector<Order> orders() const;  ///< of production, and that of overtime when it is published
  const RobotStory* robot(std::string_view name) const;
  const MachineStory* machine(std::string_view name) const;
  const PieceStory* piece(int number) const;
  /// The machine that a spot belongs to; nullptr of zones and of machines that do not play.
  const MachineStory* machine_at(std::string_view spot) const;
  const Decision* last_decision_about(std::string_view robot, SimTime t) const;
  /// The stretch of the game that is asked about.
  Interval asked() const { return {from, end}; }
  /// The robots whose skills are at that machine, without one of them.
  std::vector<const RobotStory*> robots_at(const MachineStory& machine, SimTime t, std::string_view but) const;
  /// A sentence where times of production are not those of the run; else empty.
  std::string about_times() const;

 private:
  void take(const JournalRecord& record);
  void take_fault(const JournalRecord& record);
  void take_skill(const JournalRecord& record);
  void take_decision(const JournalRecord& record);
  void take_event(SimTime t, const Event& event);
  void move(SimTime t, const PieceMoved& e);
  void note_work(SimTime t, const WorkDone& e);
  void finish();
  PieceStory& piece_of(int number);
  RobotStory* find_robot(std::string_view name);
  MachineStory* find_machine(std::string_view name);

  std::vector<sim::Fault> planned_;                      ///< of the scenario
  std::map<std::string, Team, std::less<>> commanders_;  ///< by environment
};

/// "red, yellow orange, grey": a product for people.
std::string product_text(std::string_view product);
/// "RING_BLUE" of a product and what it will be: what comes next; "delivery" when it is whole.
std::string next_part(std::string_view product, const Order& order);
/// The order could become of it: its base, rings and cap are those of the order, as far as they are there.
bool could_become(std::string_view product, const Order& order);

}  // namespace cxlab::rcll
