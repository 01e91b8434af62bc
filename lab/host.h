#pragma once
// The program around a run: who sees its lines and its progress, and who may stop it.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "cx/engine/limits.h"
#include "cx/node/log.h"

namespace cxlab::lab {

/// How far a sweep has come.
struct GamesProgress {
  std::size_t done = 0, total = 0;  ///< games; those that are kept are done
  std::size_t playing = 0;
  std::size_t incomplete = 0;            ///< of those that are done: failed or crashed
  std::optional<double> seconds_left{};  ///< of wall time; none before the first game has ended
  bool may_end_early = false;            ///< before all games are played
};

class ProgressSink {
 public:
  virtual ~ProgressSink() = default;
  /// `done` of `total` simulated seconds have been played.
  virtual void progress(double done, double total) = 0;
  /// A sweep goes on; called several times a second.
  virtual void sweep_progress(const GamesProgress&) {}
  /// One game of a sweep has ended. `remarkable`: it was not completed, or has a warning that is new for its strategy.
  virtual void game_ended(std::string_view line, const GamesProgress&, [[maybe_unused]] bool remarkable) { note(line); }
  /// One line for a person: the folder of the run, files that were taken from copies.
  virtual void note(std::string_view text) = 0;
  /// A note about something that was lost, which is shown also where notes are not.
  virtual void warn(std::string_view text) { note(text); }
};

/// All may be none.
struct Host {
  cx::LogSink* log = nullptr;
  ProgressSink* progress = nullptr;
  const std::atomic<bool>* stop = nullptr;      ///< once set, what is going on ends at its next tick
  const std::atomic<bool>* stop_now = nullptr;  ///< set later: rules that still act end in the middle of the tick
  std::atomic<bool>* completing = nullptr;      ///< set while a file is completed, which a stop does not cut short
  Limits most{};                                ///< for the rules of an episode
  /// Before untrusted rules run, this process gives up for good what they do not need (cx/wall/wall.h). It plays one
  /// run, and cannot open other files, sockets or programs afterwards.
  bool confine = false;

  Limits limits() const {
    Limits limits = most;
    limits.stop = stop_now;
    return limits;
  }

  /// Does `work`, which completes a file.
  template <class Work>
  auto complete(Work work) const {
    if (completing) *completing = true;
    auto done = work();
    if (completing) *completing = false;
    return done;
  }
  bool stopped() const { return stop && stop->load(std::memory_order_relaxed); }
  void show(double done, double total) const {
    if (progress) progress->progress(done, total);
  }
  void show_games(std::size_t done, std::size_t total, std::size_t playing) const {
    if (progress) progress->sweep_progress({.done = done, .total = total, .playing = playing});
  }
  void note(std::string_view text) const {
    if (progress) progress->note(text);
  }
  void warn(std::string_view text) const {
    if (progress) progress->warn(text);
  }
};

}  // namespace cxlab::lab
