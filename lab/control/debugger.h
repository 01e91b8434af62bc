#pragma once
// Stops a run where a person wants, and answers what the person asks: the other side of `cxlab attach`.
//
// A recorded run is played again for the same commands, and time goes back as well. What is known of a place that was
// passed tells where it is; only a question about it plays the run again, at full speed up to its tick, and there from
// firing to firing. What a person evaluates is undone in the same way.
//
// A request is a line of JSON, {"id": 3, "line": "facts order"} or {"id": 4, "complete": "fac"}; its answer has the
// same id: {"id": 3, "ok": true, "text": "...", "goes_on": false}, {"id": 4, "words": ["facts"]}. Events have no id:
// {"event": "hello", "text": "..."} for one who comes, "stopped", "log" with t, level, logger and text, and "end".

#include <atomic>
#include <compare>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "cx/executive/environment.h"
#include "cx/executive/run_control.h"
#include "cx/explain/pattern.h"
#include "cx/inspect/inspector.h"
#include "cx/node/log.h"
#include "lab/control/server.h"

namespace cxlab::lab {

class Debugger final : public cx::RunControl, public cx::LogSink {
 public:
  struct Options {
    bool begin_stopped = false;
    bool recorded = false;                              ///< the run has ended, and is played again
    std::string address;                                ///< for `note`
    cx::LogSink* log = nullptr;                         ///< takes each line too; may be none
    std::function<bool()> over = [] { return false; };  ///< whether the run shall end, also while it is stopped
    std::function<void(std::string_view)> note = [](std::string_view) {};  ///< for the person who started the run
    std::function<void(bool)> waits = [](bool) {};                         ///< called when a wait begins and ends
  };
  Debugger(ControlLines& lines, Options options) : lines_(lines), options_(std::move(options)) {}

  using Inspect = std::function<inspect::Inspector(cx::Environment&)>;
  /// Lines about what there is to see: about the entity of that name, those of that kind, or all.
  using Look = std::function<Expected<std::string>(const std::string& what)>;
  /// The environments of the run, asked for at each stop, what is known of them, and what there is to see.
  void watch(std::function<std::vector<cx::Environment*>()> environments, Inspect inspect, Look look) {
    environments_ = std::move(environments);
    inspect_ = std::move(inspect);
    look_ = std::move(look);
  }
  /// The run has ended: says so to those who are attached.
  void end(std::string_view how);

  // --- A recorded run
  /// It is played from its start, once more.
  void begin_again();
  /// It has been played to its end: the person looks and asks there, until it is to be played again or they leave.
  void stay_at_end(SimTime t, const Status& how);
  /// Set while the rest of what is played is of no use: the person wants to be somewhere before it, or has left.
  const std::atomic<bool>& gives_up() const { return gives_up_; }
  bool has_left() const { return left_; }

  Status stop_at(cx::Environment& environment, const cx::ControlPlace& place) override;
  bool before_each_firing() const override;
  void line(const cx::LogLine& line) override;

 private:
  struct BreakPoint {
    enum class Kind { kTime, kRule, kFact };
    int number = 0;
    Kind kind = Kind::kTime;
    std::string text;  // as it was asked for
    SimTime time{};
    std::string rule = {};
    std::optional<explain::Pattern> pattern = {};
    std::set<const cx::Environment*> held = {};  // where the pattern held when it was looked at last
    bool passed = false;                         // the time
    bool once = false;                           // of `until`
  };
  /// Where the recorded run came by: a tick, or the beginning of a run of the rules. Each pass sees the same ones.
  struct Visit {
    cx::ControlPlace place;
    std::uint32_t environment = 0;  // in `environment_names_`
    std::uint64_t next = 0;         // record of the environment that came next
  };
  /// A place: a visit, and how many rules have fired since where it begins a run of the rules; else as the visit's.
  struct Target {
    std::size_t visit;
    std::int64_t fired;
    auto operator<=>(const Target&) const = default;
  };
  struct Answer {
    bool ok = true;
    std::string text;
    bool goes_on = false;
  };
  struct Command;
  static const std::vector<Command>& commands();
  static std::string help(const std::string& command);

  // --- Stops (debugger.cpp)
  std::optional<std::string> reason_to_stop(cx::Environment& environment, const cx::ControlPlace& place);
  static bool holds(const BreakPoint& fact, const cx::Environment& environment);
  bool is_met(BreakPoint& point, cx::Environment& environment, const cx::ControlPlace& place);
  void stay(cx::Environment& environment);
  void answer(const ControlLines::Line& line);
  void go_to(Target target);
  Answer show(Target target);
  std::optional<std::string> text_of(Target target) const;
  bool is_behind(Target target) const;
  Target here() const;
  std::uint64_t end_here(cx::Environment& environment) const;
  bool passes_by(cx::Environment& environment, const cx::ControlPlace& place);
  void settle_breaks();
  std::optional<Target> before_firing(std::int64_t n) const;
  std::optional<Target> before_record(cx::Environment& environment, std::uint64_t n) const;
  std::optional<std::uint32_t> number_of(const std::string& environment) const;
  std::string where() const;

  // --- What a person asks (commands.cpp)
  Answer carry_out(const std::string& line);
  static bool asks_about_place(const std::string& line);
  std::vector<std::string> completions(const std::string& begun);
  Expected<cx::Environment*> looked_at() const;
  Answer act(cx::ControlAct::Verb verb, const std::string& text);
  Answer go_on();
  Answer set_break(const std::string& what, bool once);
  static std::optional<SimTime> time_in(const std::string& text);
  Status check_rule(const std::string& rule) const;
  Expected<explain::Pattern> pattern_of(const std::string& text) const;
  Answer back(const std::string& count);
  Answer back_until(const std::string& what);
  Answer go_to_time(const std::string& time);
  static Answer only_when_recorded();

  ControlLines& lines_;
  Options options_;
  Inspect inspect_;
  Look look_;
  std::function<std::vector<cx::Environment*>()> environments_ = [] { return std::vector<cx::Environment*>(); };
  // Where the run is
  cx::Environment* here_ = nullptr;  // while `stop_at` is at work
  cx::ControlPlace place_;
  bool stopped_ = false;
  bool noted_ = false;
  // What it goes on to
  bool pause_ = options_.begin_stopped;
  std::int64_t ticks_ = 0, steps_ = 0;
  std::vector<BreakPoint> breaks_;
  int last_break_ = 0;
  std::string selected_;  // the environment that counts; empty: each
  std::deque<std::string> log_;
  // A recorded run
  static constexpr Target kEnd{static_cast<std::size_t>(-1), -1};
  std::vector<Visit> visits_;  // of all passes
  std::size_t passed_ = 0;     // of them, in this pass
  std::vector<std::string> environment_names_;
  std::optional<Target> target_;            // to be played up to
  std::optional<Target> shown_;             // where the person is, while the run is still at another place
  std::optional<ControlLines::Line> then_;  // is answered there
  std::atomic<bool> gives_up_ = false;
  bool left_ = false, at_end_ = false;
  bool changed_ = false;  // by what a person evaluated
};

/// The rule that fires next in that environment; none if it has none on the agenda.
std::optional<ActivationInfo> next_activation(const RuleEngine& engine);

}  // namespace cxlab::lab
