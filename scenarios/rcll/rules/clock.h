#pragma once
// Phases of a game. All times here are those of the floor's clock, which stands while the game is paused
// (sim/floor_clock.h maps simulated time to it).

#include <algorithm>
#include <cstdint>

#include "cx/base/time.h"
#include "scenarios/rcll/rules/types.h"

namespace cxlab::rcll {

enum class Phase : std::uint8_t { kSetup, kProduction, kPostGame };
template <>
inline constexpr std::array<std::string_view, 3> kNames<Phase>{"SETUP", "PRODUCTION", "POST_GAME"};

/// The state of a game, as in the referee box, which has INIT and WAIT_START before it begins.
enum class GameState : std::uint8_t { kRunning, kPaused };
template <>
inline constexpr std::array<std::string_view, 2> kNames<GameState>{"RUNNING", "PAUSED"};

/// Set-up, then production; each starts the game's time again. Production ends before `production_end`. The referee
/// moves both: for overtime, and when a controller says so.
struct GameClock {
  SimTime production_begin{};
  SimTime production_end = from_seconds(1200);
  SimTime overtime = from_seconds(300);  ///< so long production goes on when the teams are even; 0 = not at all

  static GameClock of(double setup_s, double production_s, double overtime_s = 300) {
    return {from_seconds(setup_s), from_seconds(setup_s) + from_seconds(production_s), from_seconds(overtime_s)};
  }
  /// Production begins at that time and lasts as long as it was to last.
  void begin_production(SimTime at) {
    production_end += at - production_begin;
    production_begin = at;
  }
  Phase phase(SimTime now) const {
    if (now < production_begin) return Phase::kSetup;
    return now < production_end ? Phase::kProduction : Phase::kPostGame;
  }
  /// s of the current phase; after the game the length of production.
  double game_time(SimTime now) const {
    if (now < production_begin) return to_seconds(now);
    return to_seconds(std::min(now, production_end) - production_begin);
  }
  /// That second of production.
  SimTime at(double production_s) const { return production_begin + from_seconds(production_s); }
};

}  // namespace cxlab::rcll
