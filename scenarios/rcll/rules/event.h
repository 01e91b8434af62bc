#pragma once
// The typed events of a game, as the referee records them (docs/reference/journal.md). Only `write` and `read_event`
// know how a record spells an event, and both use the lists of fields below. Every part that reports on a game, during
// it or afterwards, reads these events.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "cx/base/record_sink.h"
#include "cx/journal/journal_record.h"
#include "scenarios/rcll/rules/clock.h"
#include "scenarios/rcll/rules/config.h"
#include "scenarios/rcll/rules/types.h"
#include "sim/floor_clock.h"

namespace cxlab::rcll {

// Each event has the word that `event` of its record is, and its fields in the order of writing: `io(key, field)`.
// `io.when(condition, key, field)` writes the field only then; one without a value is never written.

struct PhaseBegan {
  static constexpr std::array<std::string_view, 1> kWords{"phase"};
  Phase phase{};

  template <class Io>
  void fields(Io& io) {
    io("phase", phase);
  }
};
/// A controller ended the phase before.
struct PhaseWasSet {
  static constexpr std::array<std::string_view, 1> kWords{"set_phase"};
  Phase phase{};

  template <class Io>
  void fields(Io& io) {
    io("phase", phase);
  }
};
struct Prolonged {
  enum class Kind : std::uint8_t { kOvertime, kSuddenDeath };
  static constexpr std::array<std::string_view, 2> kWords{"overtime", "sudden death"};
  Kind kind{};
  double until = 0;  ///< s of production

  template <class Io>
  void fields(Io& io) {
    io("until", until);
  }
};
/// The game stands, or goes on.
struct PauseChanged {
  static constexpr std::array<std::string_view, 1> kWords{"state"};
  GameState state{};
  std::string cause;
  std::optional<std::string> by;  ///< who asked
  double game_time = 0;           ///< s of the phase

  template <class Io>
  void fields(Io& io) {
    io("state", state);
    io("cause", cause);
    io("by", by);
    io("game_time", game_time);
  }
};
struct OrderPublished {
  static constexpr std::array<std::string_view, 1> kWords{"order"};
  int id = 0;
  std::string complexity, product;
  double begin = 0, end = 0;  ///< s of production: the window
  int gate = 1, quantity = 1;
  bool competitive = false;

  template <class Io>
  void fields(Io& io) {
    io("order", id);
    io("complexity", complexity);
    io("product", product);
    io("begin", begin);
    io("end", end);
    io("gate", gate);
    io("quantity", quantity);
    io("competitive", competitive);
  }
};
/// A team said where a machine stands; without a machine it was denied.
struct MachineReported {
  static constexpr std::array<std::string_view, 1> kWords{"report"};
  std::optional<Team> team;
  std::optional<std::string> machine, type, zone;
  std::optional<int> rotation;  ///< -1: not said
  bool judged = false;
  std::string reason;  ///< why it is worth nothing

  template <class Io>
  void fields(Io& io) {
    io("team", team);
    io("machine", machine);
    io("type", type);
    io("zone", zone);
    io("rotation", rotation);
    io("judged", judged);
    io.when(!reason.empty(), "reason", reason);
  }
};
struct MachineChanged {
  static constexpr std::array<std::string_view, 1> kWords{"machine"};
  std::string machine, state;

  template <class Io>
  void fields(Io& io) {
    io("machine", machine);
    io("state", state);
  }
};
struct MachineBroke {
  static constexpr std::array<std::string_view, 1> kWords{"broken"};
  std::string machine, reason;

  template <class Io>
  void fields(Io& io) {
    io("machine", machine);
    io("reason", reason);
  }
};
struct InstructionHeard {
  static constexpr std::array<std::string_view, 1> kWords{"instruction"};
  std::string machine, operation, side, base_color, ring_color;
  std::optional<int> order;        ///< of a delivery station
  std::optional<int> shelf, slot;  ///< of a storage station
  int code = 0;                    ///< 0: it begins

  template <class Io>
  void fields(Io& io) {
    io("machine", machine);
    io.when(!operation.empty(), "operation", operation);
    io.when(!side.empty(), "side", side);
    io.when(!base_color.empty(), "base_color", base_color);
    io.when(!ring_color.empty(), "ring_color", ring_color);
    io("order", order);
    io("shelf", shelf);
    io("slot", slot);
    io("code", code);
  }
};
/// A machine changed a workpiece, or took it out of the storage or into it.
struct WorkDone {
  enum class Kind : std::uint8_t { kCapRetrieved, kMounted, kStored, kUnstored };
  static constexpr std::array<std::string_view, 4> kWords{"cap_retrieved", "mounted", "stored", "unstored"};
  Kind kind{};
  std::string machine;
  int piece = 0;
  std::string product;             ///< as it is now
  std::optional<int> payments;     ///< that a ring cost
  std::optional<int> shelf, slot;  ///< in the storage

  template <class Io>
  void fields(Io& io) {
    io("machine", machine);
    io("piece", piece);
    io("product", product);
    io("payments", payments);
    io("shelf", shelf);
    io("slot", slot);
  }
};
/// A workpiece of the storage has another place.
struct Relocated {
  static constexpr std::array<std::string_view, 1> kWords{"relocated"};
  std::string machine, product;
  int from_shelf = 0, from_slot = 0, shelf = 0, slot = 0;

  template <class Io>
  void fields(Io& io) {
    io("machine", machine);
    io("product", product);
    io("from_shelf", from_shelf);
    io("from_slot", from_slot);
    io("shelf", shelf);
    io("slot", slot);
  }
};
/// A machine should give a workpiece and has none.
struct NoSparePiece {
  static constexpr std::array<std::string_view, 1> kWords{"no_spare_piece"};
  std::string machine;

  template <class Io>
  void fields(Io& io) {
    io("machine", machine);
  }
};
struct PieceMoved {
  static constexpr std::array<std::string_view, 1> kWords{"piece"};
  int piece = 0;
  std::string from, from_name, to, to_name;  ///< "gripper", "robot1"; names may be empty
  std::array<double, 3> position{};          ///< m, in the world

  template <class Io>
  void fields(Io& io) {
    io("piece", piece);
    io("from", from);
    io.when(!from_name.empty(), "from_name", from_name);
    io("to", to);
    io.when(!to_name.empty(), "to_name", to_name);
    io("position", position);
  }
};
struct PointsGiven {
  static constexpr std::array<std::string_view, 1> kWords{"score"};
  std::optional<Team> team;
  std::string kind;
  std::int64_t points = 0, total = 0;
  int order = 0;  ///< 0: of none

  template <class Io>
  void fields(Io& io) {
    io("team", team);
    io("kind", kind);
    io("points", points);
    io("total", total);
    io.when(order != 0, "order", order);
  }
};
/// A robot leaves the field, is back, or may not come back; or a request is refused.
struct DutyChanged {
  static constexpr std::array<std::string_view, 1> kWords{"maintenance"};
  std::string state;  ///< begin, warning, end, disqualified, refused
  std::optional<Team> team;
  std::string robot, cause;
  std::optional<int> cycle;
  std::optional<double> remaining_s, duration_s;
  std::optional<int> number;  ///< of the robot in a request that is refused
  std::string reason;         ///< why it is

  template <class Io>
  void fields(Io& io) {
    io("state", state);
    io("team", team);
    io.when(!robot.empty(), "robot", robot);
    io.when(!cause.empty(), "cause", cause);
    io("cycle", cycle);
    io("remaining_s", remaining_s);
    io("duration_s", duration_s);
    io("number", number);
    io.when(!reason.empty(), "reason", reason);
  }
};
/// A product at a gate that waits for the word of a controller.
struct DeliveryUnconfirmed {
  static constexpr std::array<std::string_view, 1> kWords{"unconfirmed"};
  std::int64_t delivery = 0;
  int order = 0;
  std::optional<Team> team;
  int piece = 0;
  std::string product;

  template <class Io>
  void fields(Io& io) {
    io("delivery", delivery);
    io("order", order);
    io("team", team);
    io("piece", piece);
    io("product", product);
  }
};
struct DeliveryJudged {
  static constexpr std::array<std::string_view, 1> kWords{"delivery"};
  int order = 0;
  std::optional<Team> team;
  int piece = 0;
  std::string product;
  bool correct = false;
  std::int64_t points = 0;
  double late_s = 0;
  std::string reason;  ///< why it is not correct

  template <class Io>
  void fields(Io& io) {
    io("order", order);
    io("team", team);
    io("piece", piece);
    io("product", product);
    io("correct", correct);
    io("points", points);
    io.when(correct, "late_s", late_s);
    io.when(!correct, "reason", reason);
  }
};
/// A product came through the gate of no order.
struct Discarded {
  static constexpr std::array<std::string_view, 1> kWords{"discard"};
  int piece = 0;
  std::string product;

  template <class Io>
  void fields(Io& io) {
    io("piece", piece);
    io("product", product);
  }
};

using Event = std::variant<PhaseBegan, PhaseWasSet, Prolonged, PauseChanged, OrderPublished, MachineReported,
                           MachineChanged, MachineBroke, InstructionHeard, WorkDone, Relocated, NoSparePiece,
                           PieceMoved, PointsGiven, DutyChanged, DeliveryUnconfirmed, DeliveryJudged, Discarded>;

/// Fills `data` with the record of the event.
const RecordData& write(Event event, RecordData& data);
/// The event of a record of the referee; none for what is no event of a game. A field that is missing has its default.
std::optional<Event> read_event(const RecordValue& data);

/// A visitor of lambdas; give it `[](const auto&) {}` for all that they do not take.
template <class... Visitors>
struct Cases : Visitors... {
  using Visitors::operator()...;
};

/// The game's clock as the events move it.
struct RecordedClock {
  RecordedClock() = default;
  explicit RecordedClock(const WorldConfig& config)
      : game(GameClock::of(config.setup_s, config.production_s, config.overtime_s)) {}

  GameClock game;
  sim::FloorClock floor;
  void apply(SimTime t, const Event& event);
  Phase phase(SimTime t) const { return game.phase(floor.at(t)); }
  /// s of the phase.
  double game_time(SimTime t) const { return game.game_time(floor.at(t)); }
  /// s of production, also before and after it.
  double production(SimTime t) const { return to_seconds(floor.at(t) - game.production_begin); }
  /// The simulated time of that second of production, if the game is not paused from now on.
  SimTime when(double production_s) const;
};

}  // namespace cxlab::rcll
