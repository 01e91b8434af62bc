#pragma once
// The facts of a game that pictures show: time, points, and published orders. The board reads them from the game's
// events, both of a running game (EventLog::listen) and of a recorded one.

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "scenarios/rcll/rules/config.h"
#include "scenarios/rcll/rules/event.h"
#include "scenarios/rcll/rules/types.h"
#include "sim/legend.h"

namespace cxlab::rcll {

struct BoardOrder {
  int id = 0;
  std::string complexity;
  sim::Stack product;
  double begin = 0, end = 0;  ///< s of production: the window
  int quantity = 1;
  int gate = 1;
  bool competitive = false;
  std::array<int, 2> delivered{};  ///< by team
  friend bool operator==(const BoardOrder&, const BoardOrder&) = default;
};

/// At one time.
struct Board {
  std::vector<Team> teams;  ///< that play
  std::string phase;
  double game_time = 0;  ///< s, of the phase
  std::array<std::int64_t, 2> points{};
  std::vector<BoardOrder> orders;  ///< by id
  bool paused = false;
  friend bool operator==(const Board&, const Board&) = default;
};

/// The board as far as the events tell it.
class BoardKeeper {
 public:
  explicit BoardKeeper(const WorldConfig& config) : clock_(config) { board_.teams = teams_of(config); }
  /// Events come in order.
  void apply(SimTime t, const Event& event);
  /// Without an event after the last one.
  Board at(SimTime now) const;

 private:
  RecordedClock clock_;
  Board board_;  // all but time and pause
};

/// The board of a recorded game, at any time.
class RecordedBoard {
 public:
  explicit RecordedBoard(const WorldConfig& config) : begin_(config) {}
  /// From the events in a journal.
  static Expected<RecordedBoard> load(const WorldConfig& config, const std::filesystem::path& journal);
  /// Events come in order of time.
  void take(SimTime t, Event event) { events_.emplace_back(t, std::move(event)); }
  /// As it was at the end of that tick.
  Board at(SimTime now) const;

 private:
  BoardKeeper begin_;
  std::vector<std::pair<SimTime, Event>> events_;
};

/// Time, phase and points.
std::vector<sim::ColouredText> headline_of(const Board& board);
/// A card for each order: its number, complexity and gate ("G2"), "vs" when it is
/// competitive, and its window, beside its product. One that waits for its window is grey, one that is late is red;
/// each team that has delivered it has a tick in its colour.
sim::Legend legend_of(const Board& board);

}  // namespace cxlab::rcll
