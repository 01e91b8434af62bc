#pragma once
// What pictures tell of a game: time, points, orders that have been published. Of a game that is played it is read from
// the referee, of a recorded one from its journal.

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "scenarios/rcll/game/factory.h"
#include "scenarios/rcll/rules/clock.h"
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

struct Board {
  std::vector<Team> teams;  ///< that play
  std::string phase;
  double game_time = 0;  ///< s, of the phase
  std::array<std::int64_t, 2> points{};
  std::vector<BoardOrder> orders;
  bool paused = false;
  friend bool operator==(const Board&, const Board&) = default;
};

Board board_of(const Factory& game);

class RecordedBoard {
 public:
  RecordedBoard(const GameClock& clock, std::vector<Team> teams) : clock_(clock), teams_(std::move(teams)) {}
  /// From the referee's records in a journal.
  static Expected<RecordedBoard> load(const GameClock& clock, std::vector<Team> teams,
                                      const std::filesystem::path& journal);
  /// Events come in order of time.
  void take(SimTime t, Event event) { events_.emplace_back(t, std::move(event)); }
  /// As it was at the end of that tick.
  Board at(SimTime now) const;

 private:
  GameClock clock_;
  std::vector<Team> teams_;
  std::vector<std::pair<SimTime, Event>> events_;
};

/// Time, phase and points, and a card for each order: its number, complexity and gate ("G2"), "vs" when it is
/// competitive, and its window, beside its product. One that waits for its window is grey, one that is late is red;
/// each team that has delivered it has a tick in its colour.
sim::Legend legend_of(const Board& board);

}  // namespace cxlab::rcll
