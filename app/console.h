#pragma once
// What a person sees on stderr while a command works: log lines and one line of progress. stdout carries the answer
// only.

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstddef>
#include <memory>
#include <set>
#include <string>
#include <string_view>

#include "cx/base/time.h"
#include "cx/inspect/text.h"
#include "cx/node/log_output.h"
#include "lab/host.h"

namespace cxlab::app {

inline constexpr std::string_view kRed = "1;31", kYellow = "33";

/// From here on SIGINT and SIGTERM end the process with their exit code and a line on stderr.
void end_at_signals();

/// Progress is a line that is redrawn on a terminal, and printed every 10 s elsewhere.
class Console final : public lab::ProgressSink, public cx::LogSink {
 public:
  explicit Console(bool quiet);
  ~Console() override;
  /// Takes lines and progress here. From the first call on SIGINT and SIGTERM ask for a stop instead of ending the
  /// process: at the end of the tick; after 0.4 s in the middle of what rules do; after 0.9 s, or with a second signal,
  /// the process ends wherever it is, but completes a film. And memory is limited: to `--memory` for rules, which end
  /// with their name; to 1 GB more for all else.
  lab::Host host();

  void progress(double done, double total) override;
  void sweep_progress(const lab::GamesProgress& games) override;
  void game_ended(std::string_view line, const lab::GamesProgress& games, bool remarkable) override;
  /// The progress of something other than a run or sweep: the share that is done, and a line for a person.
  void share_done(double share, const std::string& text);
  /// A line for each game of a sweep, not only for those that are remarkable and now and then.
  void show_all_games() { all_games_ = true; }
  void note(std::string_view text) override;
  void warn(std::string_view text) override;
  void line(const cx::LogLine& line) override;
  /// Takes the line of progress away, so that other output can be printed.
  void clear();
  bool quiet() const { return quiet_; }
  /// Whether a line of the log has shown this error.
  bool has_shown(const std::string& error) const { return errors_.contains(error); }

 private:
  using Clock = std::chrono::steady_clock;
  /// Whether it is time for another line of progress, which is then the last one.
  bool is_due();
  /// Draws the line of progress again, after a bar.
  void draw(double share, const std::string& text);

  bool quiet_, terminal_, drawn_ = false, all_games_ = false;
  Clock::time_point start_, last_;
  std::unique_ptr<cx::LogSink> log_;  // where lines are printed
  std::set<std::string> errors_;      // of the log
};

/// The text for stderr in this colour ("31" is red); as it is where that is no terminal, or $NO_COLOR is set.
std::string coloured(std::string_view text, std::string_view colour);
/// The text with control characters as \x1b, so that texts of others cannot move the cursor or rename the terminal. In
/// JSON they become JSON escapes, so that it means the same.
std::string printable(std::string_view text);
/// From here on all that is written to stdout is printable in this sense; false where that cannot be.
bool make_answers_printable();
/// Declares `--memory`, `--disk` and `--steps`, which hold for the whole process.
void add_limit_options(CLI::App& command);
/// The number of the signal that asked for a stop, 0 if none.
int signal_that_came();
/// 0 if no signal asked for a stop; else reports that one did, and what there is all the same, and gives the exit code.
int interrupted(const std::string& what_there_is);
using inspect::seconds_text;
/// Columns of the terminal to which answers are written; without one, as many as tables have in a file.
std::size_t line_width();
/// Simulated time as m:ss.
std::string clock_text(double seconds);

}  // namespace cxlab::app
