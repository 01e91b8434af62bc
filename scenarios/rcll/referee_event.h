#pragma once
// The referee's records, read back from a journal (docs/journal.md): the only place that knows how they are spelt.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "cx/journal/journal_record.h"
#include "scenarios/rcll/clock.h"
#include "scenarios/rcll/types.h"
#include "sim/floor_clock.h"

namespace cxlab::rcll {

struct PhaseBegan {
  std::string phase;
};
/// A controller ended the phase before.
struct PhaseWasSet {
  std::string phase;
};
/// Overtime, or sudden death.
struct Prolonged {
  double until = 0;  ///< s of production
};
struct PauseChanged {
  bool paused = false;
};
struct OrderPublished {
  int id = 0;
  std::string complexity, product;
  double begin = 0, end = 0;  ///< s of production: the window
  int gate = 1, quantity = 1;
  bool competitive = false;
};
struct MachineChanged {
  std::string machine, state;
};
struct MachineBroke {
  std::string machine, reason;
};
struct InstructionHeard {
  std::string machine, operation, base_color, ring_color;
  int order = 0, code = 0;
};
/// A machine changed a workpiece, or took it out of the storage or into it.
struct WorkDone {
  enum class Kind : std::uint8_t { kCapRetrieved, kMounted, kStored, kUnstored };
  Kind kind{};
  std::string machine;
  int piece = 0;
  std::string product;  ///< as it is now
  int payments = 0;     ///< that a ring cost
};
struct PieceMoved {
  int piece = 0;
  std::string from, from_name, to, to_name;  ///< "gripper", "robot1"; names may be empty
};
struct PointsGiven {
  std::optional<Team> team;
  std::string kind;
  std::int64_t points = 0, total = 0;
  int order = 0;  ///< 0: of none
};
struct DutyChanged {
  std::string robot, state, cause;  ///< begin, warning, end, disqualified, refused
};
struct DeliveryJudged {
  int order = 0, piece = 0;
  std::optional<Team> team;
  std::string product, reason;
  bool correct = false;
  double late_s = 0;
  std::int64_t points = 0;
};
struct Discarded {
  int piece = 0;
};

using RefereeEvent =
    std::variant<PhaseBegan, PhaseWasSet, Prolonged, PauseChanged, OrderPublished, MachineChanged, MachineBroke,
                 InstructionHeard, WorkDone, PieceMoved, PointsGiven, DutyChanged, DeliveryJudged, Discarded>;

/// Nothing for what is not listed here.
std::optional<RefereeEvent> read_referee_event(const RecordValue& data);

/// A visitor of lambdas; give it `[](const auto&) {}` for all that they do not take.
template <class... Visitors>
struct Cases : Visitors... {
  using Visitors::operator()...;
};

/// The game's clock as the events move it.
struct RecordedClock {
  GameClock game;
  sim::FloorClock floor;
  void apply(SimTime t, const RefereeEvent& event);
  Phase phase(SimTime t) const { return game.phase(floor.at(t)); }
  /// s of the phase.
  double game_time(SimTime t) const { return game.game_time(floor.at(t)); }
  /// s of production, also before and after it.
  double production(SimTime t) const { return to_seconds(floor.at(t) - game.production_begin); }
  /// The simulated time of that second of production, if the game is not paused from now on.
  SimTime when(double production_s) const;
};

}  // namespace cxlab::rcll
