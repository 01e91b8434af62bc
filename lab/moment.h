#pragma once
// Any instant of a recorded run: its rules are played again up to there, without world and servers.
//
//   auto moment = Moment::open(run, host);
//   if (Status s = moment->seek(from_seconds(312.4)); s) for (inspect::Inspector& one : *moment->inspectors()) ...

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/inspect/inspector.h"
#include "lab/host.h"
#include "lab/rules_replay.h"
#include "lab/run.h"

namespace cxlab::lab {

/// Answers about an environment of an episode whose journal these timelines observe.
inspect::Inspector inspector_of(cx::Environment& environment, Episode& episode, inspect::Timelines& timelines);

class Moment {
 public:
  struct Options {
    bool timelines = true;              ///< keeps the records of all environments
    bool count_activations = false;     ///< for `RuleUse::activated`
    cx::RunControl* control = nullptr;  ///< stops it on the way; may be none
  };
  /// Reads the run; nothing is played yet. The run outlives it.
  static Expected<std::unique_ptr<Moment>> open(const Run& run, const Host& host, Options options);
  static Expected<std::unique_ptr<Moment>> open(const Run& run, const Host& host) { return open(run, host, Options{}); }
  /// Two runs, to be played in this process, which gives up only what neither of them needs.
  using Two = std::pair<std::unique_ptr<Moment>, std::unique_ptr<Moment>>;
  static Expected<Two> open_two(const Run& a, const Run& b, const Host& host);
  ~Moment();
  Moment(const Moment&) = delete;
  Moment& operator=(const Moment&) = delete;

  /// Plays on up to the last tick that is not after `t`; without it up to the end of the run, or of what was recorded.
  /// A time after the end is a usage error; of a killed run it is the end of its log (`cut_off`). Time does not go back
  /// but with `rewind`.
  /// This process gives up its rights before the first rule runs (lab/confine.h).
  Status seek(std::optional<SimTime> t);
  /// Goes back to the start.
  Status rewind();
  /// Of the last tick that was played.
  SimTime t() const;
  /// Of the run, or of what its log has: nothing after it can be played.
  SimTime end() const;
  /// When the next tick comes; `kNever` after the last.
  SimTime next_tick() const { return replay_.episode->over() ? kNever : replay_.episode->next_tick(); }
  /// The log of a killed run ends before the time that was asked for.
  bool cut_off() const { return cut_off_; }
  /// The host asked for a stop, so that the time was not reached.
  bool stopped() const { return stopped_; }

  Episode& episode() { return *replay_.episode; }
  inspect::Inspector inspector(cx::Environment& environment) {
    return inspector_of(environment, episode(), timelines_);
  }
  /// Those of that name, as streams, the log or their manager know it, or all; an error that lists them if there is
  /// none.
  Expected<std::vector<cx::Environment*>> environments(const std::string& name = {});
  Expected<std::vector<inspect::Inspector>> inspectors(const std::string& name = {});

  /// Is called when a tick is over.
  std::function<void()> after_tick = [] {};

 private:
  Moment(const Run& run, const Host& host, Options options) : run_(run), host_(host), options_(options) {}
  void listen();
  void add_reach(Wall& wall);
  RulesReplay::Options replay_options() const;
  bool log_ends_early() const;
  Status play(SimTime end);

  const Run& run_;
  Host host_;
  Options options_;
  inspect::Timelines timelines_;  // outlives the episode, whose journal tells it what happens
  RulesReplay replay_;
  bool behind_wall_ = false, started_ = false, cut_off_ = false, stopped_ = false;
};

/// The error of `seek`, with the option that had the time where the time is wrong.
Error about_option(Error error, const std::string& option);

}  // namespace cxlab::lab
