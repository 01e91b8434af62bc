#pragma once
// Stops a run where a person wants, and answers what the person asks: the other side of `cxlab attach`.
//
// A recorded run is played again for the same commands, and time goes back as well. The debugger notes the places that
// it passes, so it finds them without a replay. Only a question about a place plays the run again: at full speed up to
// its tick, and there from firing to firing. A replay also undoes what a person evaluates.
//
// A request is a line of JSON, {"id": 3, "line": "facts order"} or {"id": 4, "complete": "fac"}; its answer has the
// same id: {"id": 3, "ok": true, "text": "...", "goes_on": false}, {"id": 4, "words": ["facts"]}. Programs ask for
// JSON:
// {"id": 5, "ask": "facts", "env": "agent", "what": "order"} (lab/control/questions.cpp) is answered by
// {"id": 5, "ok": true, "answer": {...}}. Events have no id: {"event": "hello", "text": "..."} for a client that comes,
// "stopped", "log" with t, level, logger and text, and "end".

#include <atomic>
#include <chrono>
#include <compare>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/json.h"
#include "cx/executive/environment.h"
#include "cx/executive/run_control.h"
#include "cx/explain/evaluator.h"
#include "cx/explain/history.h"
#include "cx/explain/pattern.h"
#include "cx/explain/why_not.h"
#include "cx/inspect/inspector.h"
#include "cx/node/log.h"
#include "lab/control/server.h"
#include "lab/world_answer.h"

namespace cxlab::lab {

class Debugger final : public cx::RunControl, public cx::LogSink {
 public:
  struct Options {
    bool begin_stopped = false;
    bool recorded = false;                              ///< the run has ended, and is played again
    std::string address;                                ///< for `note`
    cx::LogSink* log = nullptr;                         ///< takes each line too; may be none
    std::function<bool()> over = [] { return false; };  ///< whether the run must end, also while it is stopped
    std::function<void(std::string_view)> note = [](std::string_view) {};  ///< for the person who started the run
    std::function<void(bool)> waits = [](bool) {};                         ///< called when a wait begins and ends
  };
  Debugger(ControlLines& lines, Options options) : lines_(lines), options_(std::move(options)) {}

  using Inspect = std::function<inspect::Inspector(cx::Environment&)>;
  /// Lines about what there is to see: about the entity of that name, those of that kind, or all.
  using Look = std::function<Expected<std::string>(const std::string& what)>;
  /// What there is to see, for programs.
  using LookJson = std::function<Expected<Json>(const std::string& what)>;
  /// Why a rule has not fired; nothing if the run must first be played again, with a witness of `followed_rule`.
  using WhyNot = std::function<std::optional<Expected<explain::WhyNot>>(cx::Environment&, const ConstructInfo& rule,
                                                                        const explain::Wanted&)>;
  /// What the world says up to where the person is; `about` is the argument of the question.
  using AskWorld = std::function<Expected<WorldAnswered>(const WorldQuestion&, const std::string& about)>;
  struct Knowledge {
    std::function<std::vector<cx::Environment*>()> environments;  ///< of the run, asked for at each stop
    Inspect inspect;
    Look look;
    LookJson look_json = {};
    WhyNot why_not = {};
    std::span<const WorldQuestion> world_questions = {};  ///< one with the name of a command is hidden
    AskWorld ask_world = {};
  };
  void watch(Knowledge knowledge) { knows_ = std::move(knowledge); }
  /// The run has ended: says so to those who are attached.
  void end(std::string_view how);

  // --- A recorded run
  /// It is played again from its start.
  void begin_again();
  /// It has been played to its end: the person looks and asks there, until it is to be played again or they leave.
  void stay_at_end(SimTime t, const Status& how);
  /// Set while playing on is useless: the person wants to be at an earlier place, or has left.
  const std::atomic<bool>& gives_up() const { return gives_up_; }
  bool has_left() const { return left_; }
  /// A tick is over, which is a place of its own: what questions about a time see.
  void tick_is_over(SimTime t);
  /// Somebody asked why this rule has not fired; empty: nobody did.
  const std::string& followed_rule() const { return followed_rule_; }

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
  static constexpr std::int64_t kAfterTick = -2;  // `fired` of a place where a tick is over
  /// A place that the recorded run passed: a tick, the beginning of a run of the rules, or the end of a tick. Each pass
  /// sees the same places.
  struct Visit {
    cx::ControlPlace place;
    std::uint32_t environment = 0;  // in `environment_names_`; that of the end of a tick is none of them
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
  /// What there is to say about a place.
  struct Where {
    cx::ControlPlace place;
    std::string environment;
    bool at_end = false;
    std::optional<std::string> rule = {};  // that fires next
    std::vector<std::int64_t> facts = {};  // for which it does
    std::string text() const;
  };
  struct Command;
  struct Question;
  static const std::vector<Command>& commands();
  static const std::vector<Question>& questions();
  std::string help(const std::string& command) const;

  // --- Stops (debugger.cpp)
  std::optional<std::string> reason_to_stop(cx::Environment& environment, const cx::ControlPlace& place);
  static bool holds(const BreakPoint& fact, const cx::Environment& environment);
  bool is_met(BreakPoint& point, cx::Environment& environment, const cx::ControlPlace& place);
  void stop(cx::Environment& environment, const std::string& why);
  void stay(cx::Environment& environment);
  void keep_pace(SimTime t);
  void answer(const ControlLines::Line& line);
  void go_to(Target target);
  Answer show(Target target);
  std::optional<Where> seen(Target target) const;
  bool is_behind(Target target) const;
  Target here() const;       // where the person is
  Target played_to() const;  // where the run is
  std::uint64_t end_here(cx::Environment& environment) const;
  bool passes_by(cx::Environment& environment, const cx::ControlPlace& place);
  void settle_breaks();
  std::optional<Target> before_firing(std::int64_t n) const;
  std::optional<Target> before_record(cx::Environment& environment, std::uint64_t n) const;
  std::optional<std::uint32_t> number_of(const std::string& environment) const;
  std::optional<Where> place() const;
  std::string where() const;

  // --- What a program asks (questions.cpp)
  Json place_json() const;
  /// Nothing where the run is to be played up to here before the question can be answered.
  std::optional<Expected<Json>> ask(const std::string& name, const Json& request);
  Expected<cx::Environment*> environment_in(const Json& request) const;
  bool may_assert_time() const;
  static Json conditions_json(cx::Environment& environment, const ConstructInfo& rule);
  static Expected<Json> rule_source(cx::Environment& environment, const std::string& name);
  std::optional<Expected<Json>> why_not_rule(cx::Environment& environment, const std::string& rule,
                                             const Json& request);
  static explain::History history_of(const inspect::Timeline& timeline, const std::string& rule);

  // --- What a person asks (commands.cpp)
  Answer carry_out(const std::string& line);
  static Answer said(Expected<std::string> text);
  std::vector<std::string> command_names() const;
  const WorldQuestion* world_question(const std::string& name) const;
  Expected<WorldAnswered> ask_world(const WorldQuestion& question, const std::string& about) const;
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
  Answer go_after(const std::string& time);
  Answer set_speed(const std::string& factor);
  static Answer only_when_recorded();

  std::vector<cx::Environment*> environments() const { return knows_.environments(); }
  inspect::Inspector inspect(cx::Environment& environment) const { return knows_.inspect(environment); }

  ControlLines& lines_;
  Options options_;
  Knowledge knows_{.environments = [] { return std::vector<cx::Environment*>(); }, .inspect = {}, .look = {}};
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
  double speed_ = 0;      // of simulated time against the wall clock, at most; 0: as fast as it can
  std::optional<std::pair<SimTime, std::chrono::steady_clock::time_point>> pace_;  // where it is measured from
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
  bool changed_ = false;        // by what a person evaluated
  bool time_is_there_ = false;  // asserted to look at conditions
  std::string followed_rule_;
};

/// The rule that fires next in that environment; none if it has none on the agenda.
std::optional<ActivationInfo> next_activation(const RuleEngine& engine);

}  // namespace cxlab::lab
