#include "scenarios/rcll/rules/pauses.h"

#include <algorithm>
#include <functional>
#include <utility>

namespace cxlab::rcll {

Pauses::Pauses(std::vector<PauseConfig> listed, const GameReferee& referee, sim::World& world, EventLog& events)
    : listed_(std::move(listed)), referee_(referee), world_(world), events_(events) {
  std::ranges::sort(listed_, std::ranges::greater(), &PauseConfig::at);
}

std::string Pauses::request(std::string_view state, std::string by, std::span<const RecordRef> causes) {
  const auto wanted = named<GameState>(state);
  if (!wanted) return "state: " + found_text(std::string(state), "RUNNING or PAUSED");
  if (referee_.phase() == Phase::kPostGame) return "the game is over";
  requests_.push_back({*wanted, std::move(by), {causes.begin(), causes.end()}});
  return {};
}

void Pauses::judge(SimTime now) {
  for (const Request& request : std::exchange(requests_, {}))
    if (request.state != state()) set(request.state, "request", &request, now);
  if (world_.halted()) {
    if (now >= ends_at_) set(GameState::kRunning, "scenario", nullptr, now);
  } else if (referee_.phase() == Phase::kProduction && world_.floor_time() >= next_begin()) {
    ends_at_ = now + from_seconds(listed_.back().seconds);
    listed_.pop_back();
    set(GameState::kPaused, "scenario", nullptr, now);
  }
}

void Pauses::set(GameState state, std::string_view cause, const Request* request, SimTime now) {
  if (state == GameState::kPaused) {
    world_.halt();
  } else {
    world_.go_on();
    ends_at_ = kNever;
  }
  PauseChanged event{.state = state, .cause = std::string(cause), .by = {}};
  if (request) event.by = request->by;
  event.game_time = referee_.clock().game_time(world_.floor_time());
  events_.write_simulated(now, std::move(event),
                          request ? std::span<const RecordRef>(request->causes) : std::span<const RecordRef>());
}

SimTime Pauses::next_begin() const { return listed_.empty() ? kNever : referee_.clock().at(listed_.back().at); }

SimTime Pauses::next_due() const {
  if (!requests_.empty()) return world_.now();
  return world_.halted() ? ends_at_ : world_.clock().when(next_begin());
}

}  // namespace cxlab::rcll
