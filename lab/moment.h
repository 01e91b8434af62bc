#pragma once
// Any instant of a recorded run: its rules are played again up to there, without world and servers.
//
//   auto moment = Moment::open(run, host);
//   if (Status s = (*moment)->seek(from_seconds(312.4)); s)
//     for (inspect::Inspector& one : *(*moment)->inspectors()) ...

#include <algorithm>
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

/// The message for a name that no environment of a run has: it lists those that the run has.
std::string no_environment(const std::string& name, const std::vector<std::string>& known);

class Moment {
 public:
  struct Options {
    bool timelines = true;                                                ///< keeps the records of all environments
    Counting counting = Counting::kNothing;                               ///< kUse for `RuleUse::activated`
    cx::RunControl* control = nullptr;                                    ///< stops it on the way; may be none
    std::function<void(const cx::Environment&)> on_environment_end = {};  ///< `cx::RunSettings::on_environment_end`
  };
  /// Reads the run; nothing is played yet. The run outlives it.
  static Expected<std::unique_ptr<Moment>> open(const Run& run, const Host& host, Options options);
  static Expected<std::unique_ptr<Moment>> open(const Run& run, const Host& host) { return open(run, host, Options{}); }
  ~Moment();
  Moment(const Moment&) = delete;
  Moment& operator=(const Moment&) = delete;

  /// Goes to the last tick that is not after `t`; without it to the end of the run, or of what was recorded. A time
  /// after the end (`Run::reaches`) is a usage error; in a run that ended, but whose log is cut off before that time,
  /// it is the end of the log (`cut_off`). To go back it plays from the start again: environments and inspectors of
  /// before are gone then. This process gives up its rights before the first rule runs (lab/confine.h).
  Status seek(std::optional<SimTime> t);
  /// Goes back to the start.
  Status rewind();
  /// The time of the last tick that was played.
  SimTime t() const;
  /// The end of the run, or of what its log has: nothing after it can be played.
  SimTime end() const;
  /// When the next tick comes; `kNever` after the last.
  SimTime next_tick() const { return replay_.episode->over() ? kNever : replay_.episode->next_tick(); }
  /// The log ends before the time that was asked for, or before the end of the run.
  bool cut_off() const { return cut_off_; }
  /// The host asked for a stop, so that the time was not reached.
  bool stopped() const { return stopped_; }

  /// What there was to see in the run's world; an error in runs without a scene.
  Expected<Run::SceneAt> scene() const { return run_.scene(t()); }
  Episode& episode() { return *replay_.episode; }
  inspect::Inspector inspector(cx::Environment& environment) {
    return inspector_of(environment, episode(), timelines_);
  }
  /// The environments that streams, the log or their manager call so, or all; an error that lists them if there is
  /// none.
  Expected<std::vector<cx::Environment*>> environments(const std::string& name = {});
  Expected<std::vector<inspect::Inspector>> inspectors(const std::string& name = {});

  /// Is called when a tick is over.
  std::function<void()> after_tick = [] {};

 private:
  friend struct TwoMoments;
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

/// Two runs, compared at one time.
struct TwoMoments {
  std::unique_ptr<Moment> a, b;

  /// This process gives up only what neither of them needs.
  static Expected<TwoMoments> open(const Run& a, const Run& b, const Host& host);
  /// The end of the run that ends first: what the other one does later is no difference.
  SimTime end() const { return std::min(a->end(), b->end()); }
  /// Both go to `t`, without it to `end`.
  Status seek(std::optional<SimTime> t);
  bool stopped() const { return a->stopped() || b->stopped(); }
  SimTime t() const { return std::min(a->t(), b->t()); }

  struct Environments {
    std::vector<std::pair<inspect::Inspector, inspect::Inspector>> both;  ///< of one name
    std::vector<std::string> only_in_a, only_in_b;
  };
  /// The environments of that name in both runs, or all; an error if the runs have none in common.
  Expected<Environments> environments(const std::string& name = {});
};

}  // namespace cxlab::lab
