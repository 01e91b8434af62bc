#pragma once
// An episode that stops where its rules leave a choice to the caller (package cxlab_choices;
// docs/reference/learning.md).
//
//   auto episode = ChoiceEpisode::load(options, *std::move(scenario), {});
//   while (auto open = (*episode)->next_choice(); open && *open)
//     (*episode)->choose((*open)->preferred);
//   lab::Played played = (*episode)->session().close();
//
// Each choice goes over the bus like a message of a seat (scenarios/seat.h), so the run replays without the caller.

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "lab/session.h"
#include "scenarios/seat.h"

namespace cxlab::lab {

/// As the message cxlab_msgs/msg/Choice.
struct Choice {
  std::int64_t id = 0;
  std::string kind;  ///< what is chosen
  std::string who;   ///< for whom; empty: the team
  std::vector<std::string> options;
  std::vector<bool> allowed;      ///< of each option
  std::int64_t preferred = 0;     ///< what the rules would choose
  std::vector<double> situation;  ///< features of the situation
  std::vector<double> features;   ///< of the options, one after the other
};

struct ChoiceTopic {
  std::string name = "/choices";  ///< of the agent that asks; answers go to NAME/made
  std::string seat = "chooser";   ///< name of the node that answers
};

class ChoiceEpisode {
 public:
  /// As `Session::load`, with a seat more.
  static Expected<std::unique_ptr<ChoiceEpisode>> load(PlayOptions options, Scenario scenario, ChoiceTopic topic = {},
                                                       const Host& host = {});

  /// Plays on until rules ask, and returns the choice that was asked for first and not answered; none: the run is over,
  /// or `pause`, which is asked after each tick, said so.
  Expected<const Choice*> next_choice(const std::function<bool()>& pause = {});
  /// The answer to that choice. A usage error if that option does not exist or may not be chosen.
  Status choose(std::int64_t option);
  Session& session() { return *session_; }

  /// Plays each of them on to its next choice, in so many threads at once; `pause` is asked by all of them. The error
  /// of the first that has one; the others are played on all the same.
  static Status play_on(std::span<ChoiceEpisode* const> episodes, std::size_t threads,
                        const std::function<bool()>& pause = {});

 private:
  class Chooser;
  ChoiceEpisode() = default;

  Chooser* chooser_ = nullptr;  // owned by the session
  std::unique_ptr<Session> session_;
};

}  // namespace cxlab::lab
