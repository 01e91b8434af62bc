#pragma once
// What a person sees on stderr while a run goes on: log lines and one line of progress. stdout carries the answer only.

#include <chrono>
#include <string>
#include <string_view>

namespace cxlab::app {

/// A progress line that is redrawn on a terminal, and printed every 10 s elsewhere.
class Progress {
 public:
  explicit Progress(bool quiet);
  ~Progress();
  /// `done` of `total` simulated seconds; `note` is short, e.g. the score.
  void show(double done, double total, std::string_view note);
  /// Takes the line away, so that other output can be printed.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;
  bool quiet_, terminal_, drawn_ = false;
  Clock::time_point start_, last_;
};

/// Simulated time as m:ss.
std::string clock_text(double seconds);
/// Largest resident size of this process so far, MB.
double peak_rss_mb();

}  // namespace cxlab::app
