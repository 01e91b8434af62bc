#pragma once
// When a game is paused: as the scenario lists it, or as somebody asks. Then the floor is halted (sim/world.h): the
// time of the game stands, and all that goes by it.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/record_sink.h"
#include "scenarios/rcll/rules/config.h"
#include "scenarios/rcll/rules/event_log.h"
#include "scenarios/rcll/rules/referee.h"
#include "sim/world.h"

namespace cxlab::rcll {

class Pauses {
 public:
  /// All but the list outlive it.
  Pauses(std::vector<PauseConfig> listed, const GameReferee& referee, sim::World& world, EventLog& events);

  /// Asks for a state, which comes with the next `judge`. `by`: who asks. What speaks against it, else empty.
  std::string request(std::string_view state, std::string by, std::span<const RecordRef> causes = {});
  /// Pauses the game or lets it go on, after the referee has judged.
  void judge(SimTime now);
  SimTime next_due() const;  ///< simulated time

  GameState state() const { return world_.halted() ? GameState::kPaused : GameState::kRunning; }

 private:
  struct Request {
    GameState state{};
    std::string by;
    std::vector<RecordRef> causes;
  };
  void set(GameState state, std::string_view cause, const Request* request, SimTime now);
  /// When the next listed pause begins, by the floor's clock.
  SimTime next_begin() const;

  std::vector<PauseConfig> listed_;  ///< those to come, the last first
  const GameReferee& referee_;
  sim::World& world_;
  EventLog& events_;
  std::vector<Request> requests_;
  SimTime ends_at_ = kNever;  ///< simulated time; of a listed pause
};

}  // namespace cxlab::rcll
