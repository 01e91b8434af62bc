#pragma once
// When each action of a sequence begins if all begin as early as they may.
//
// A happening touches keys: the facts and numbers that it reads or changes. A fact and its complement are one key. A
// derived fact stands for all that it is derived from. Two happenings conflict if one changes a key that the other
// reads, or if both change it in ways that do not commute. They then keep the order of the sequence and kSeparation. So
// each reads the same values as in the sequence, and a plan that is right one action after the other is right as
// scheduled. What only validators keep apart (IdleTouch) is kept apart in the same way.

#include <span>
#include <vector>

#include "planner/ground/task.h"

namespace cxlab::planner {

/// What one happening does with one key.
struct Touch {
  static constexpr std::uint8_t kRead = 1;
  static constexpr std::uint8_t kUp = 2, kDown = 4;  ///< added or increased; deleted; both: assigned
  /// Needed true, needed false all along: bounds of the open interval in which a condition over all counts.
  static constexpr std::uint8_t kHoldTrue = 8, kHoldFalse = 16;
  static constexpr std::uint8_t kAnyRead = kRead | kHoldTrue | kHoldFalse;
  int key = 0;
  std::uint8_t at_start = 0;
  std::uint8_t at_end = 0;
  bool meets_events = false;  ///< some event touches the key
};

/// Touches of all actions and events.
class Touches {
 public:
  enum Continuous {
    kOnlyLater,   ///< what changes all along counts as changed at both ends: who reads it comes before or after
    kPointsOnly,  ///< only what the ends themselves read and change, as validators judge what may share an instant
  };
  /// Effects under conditions.
  enum Conditional {
    kAlways,   ///< count as if they always came about
    kApart,    ///< are asked for one by one
    kCertain,  ///< the same, and what only validators keep apart counts where it is certain
  };
  explicit Touches(const GroundTask& task, Continuous continuous = kOnlyLater, Conditional conditional = kAlways);

  int keys() const { return keys_; }
  std::span<const Touch> of(int action) const { return actions_[action]; }
  std::span<const Touch> of_event(int event) const { return events_[event]; }
  /// What an effect under conditions changes where it comes about; not where they always count.
  std::span<const Touch> of_conditional(int action, int effect) const { return conditional_[action][effect]; }
  /// The touches of an action, or of the event e, whose id is -2 - e.
  std::span<const Touch> of_happening(int id) const { return id < 0 ? of_event(-2 - id) : of(id); }
  /// Whether an event makes the goal false.
  bool breaks_goal(int event) const;
  const ById<TimedEvent>& events() const { return task_.events; }
  /// Events that touch a key, ascending.
  std::span<const int> events_of(int key) const { return events_of_key_[key]; }
  /// Whether happenings that do this with a key do not commute.
  static bool conflict(std::uint8_t a, std::uint8_t b) {
    return ((a & Touch::kAnyRead) && (b & (Touch::kUp | Touch::kDown))) ||
           ((b & Touch::kAnyRead) && (a & (Touch::kUp | Touch::kDown))) || ((a & Touch::kUp) && (b & Touch::kDown)) ||
           ((a & Touch::kDown) && (b & Touch::kUp));
  }
  /// Whether it conflicts with everything that something else may do with the key, at an instant where that does not
  /// only begin or end a condition over all.
  static bool conflicts_with_all(std::uint8_t does) {
    return (does & Touch::kRead) && (does & (Touch::kUp | Touch::kDown));
  }
  /// Whether they also must not share an instant: not if they conflict over a condition over all only.
  static bool conflict_at_instant(std::uint8_t a, std::uint8_t b) {
    constexpr std::uint8_t kPoint = Touch::kRead | Touch::kUp | Touch::kDown;
    return conflict(a & kPoint, b & kPoint);
  }
  /// Whether these ends of two happenings (ids as for `of_happening`) must not share an instant.
  bool conflict_at_instant(int id, bool at_end, int other, bool other_at_end) const {
    return conflict_at_instant(of_happening(id), at_end, of_happening(other), other_at_end);
  }
  static bool conflict_at_instant(std::span<const Touch> one, bool at_end, std::span<const Touch> other,
                                  bool other_at_end);
  /// Whether `writer` may make false what `holder` needs.
  static bool violates(std::uint8_t writer, std::uint8_t holder) {
    return ((writer & Touch::kDown) && (holder & Touch::kHoldTrue)) ||
           ((writer & Touch::kUp) && (holder & Touch::kHoldFalse));
  }
  /// Whether it does so for certain: a derived fact or a comparison may survive a change of what it reads.
  static bool surely_violates(std::uint8_t writer, std::uint8_t holder) {
    constexpr std::uint8_t kBoth = Touch::kHoldTrue | Touch::kHoldFalse;
    return (holder & kBoth) != kBoth && violates(writer, holder);
  }

 private:
  void read(std::vector<Touch>& touches, const GroundCondition& condition, bool at_start, bool at_end) const;
  void read(std::vector<Touch>& touches, const Symbols& reads, std::uint8_t does, bool at_start, bool at_end) const;
  void hold(std::vector<Touch>& touches, const GroundCondition& condition) const;
  void read(std::vector<Touch>& touches, const GroundExpression& expression, bool at_start, bool at_end) const;
  void write(std::vector<Touch>& touches, const GroundEffects& effects, bool at_start) const;
  void idle(std::vector<Touch>& touches, const std::vector<IdleTouch>& from, bool certain) const;

  const GroundTask& task_;
  int keys_ = 0;
  ById<std::vector<int>> bases_;  ///< by fact: keys that it depends on (bases_of_facts)
  ById<std::vector<Touch>> actions_, events_;
  ById<ById<std::vector<Touch>>> conditional_;  ///< by action and conditional effect
  std::vector<Touch> goal_;
  ById<std::vector<int>> events_of_key_;
};

/// Earliest starts of a growing sequence.
class Timeline {
 public:
  static constexpr Micros kNever = -1;

  /// `lenient`: what comes too late for an event is accepted and counted, and appends can be taken back.
  explicit Timeline(const Touches& touches, bool lenient = false)
      : touches_(touches), keys_(static_cast<std::size_t>(touches.keys())), lenient_(lenient) {}
  Timeline(const Timeline&) = delete;
  Timeline& operator=(const Timeline&) = delete;

  void clear();
  /// Appends an action; its start, or kNever if an event that has not been appended forbids it.
  Micros append(int action, Micros duration);
  /// Appends the start of an action, not before `release`; its time or kNever.
  Micros append_start(int action, Micros release);
  /// Appends the end of an action, not before `earliest`; its time or kNever.
  Micros append_end(int action, Micros earliest);
  /// The earlier append (0, 1, ...) that kept the last one from starting sooner; -1: none did.
  int cause() const { return cause_; }
  /// Lets the next event happen after all that has been appended. False if that is too late.
  bool append_event();
  /// Takes back all but the first appends, and the completion, where it is lenient.
  void take_back_to(std::size_t appends);
  /// Completes the plan. False if an event that has not been appended breaks the goal before the plan's end.
  bool finish();
  Micros makespan() const { return makespan_; }
  /// By how much happenings came too late, summed; 0 unless lenient.
  Micros lateness() const { return lateness_; }

 private:
  struct Latest {
    Micros time = kEver;
    int by = -1;  ///< append
  };
  struct Last {
    Latest read, up, down;  ///< latest happening of each kind
  };
  /// What an append changed.
  struct Before {
    Latest* where;
    Latest was;
  };
  /// How it stood before an append.
  struct Mark {
    std::size_t changes;
    int next_event;
    Micros lateness, makespan;
  };
  static constexpr Micros kEver = -kSeparation;

  static Latest after(const Last& last, std::uint8_t does);
  void mark();
  void note(Last& last, std::uint8_t does, Micros time);
  enum class Part { kWhole, kStart, kEnd };
  Micros append(int action, Part part, Micros earliest, Micros duration);
  bool before_events(const Touch& touch, std::uint8_t does, Micros time);

  const Touches& touches_;
  ById<Last> keys_;
  bool lenient_ = false;
  Micros lateness_ = 0;
  int next_event_ = 0;
  int appended_ = 0;
  int cause_ = -1;
  Micros makespan_ = 0;
  ById<Mark> marks_;  ///< by append, and one of the completion
  std::vector<Before> changes_;
};

}  // namespace cxlab::planner
