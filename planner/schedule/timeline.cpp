#include "planner/schedule/timeline.h"

#include <algorithm>

#include "planner/ground/sorted.h"

namespace cxlab::planner {

namespace {

void touch(std::vector<Touch>& touches, int key, std::uint8_t does, bool at_start, bool at_end) {
  auto found = std::ranges::find(touches, key, &Touch::key);
  if (found == touches.end()) found = touches.insert(found, Touch{key});
  if (at_start) found->at_start |= does;
  if (at_end) found->at_end |= does;
}

}  // namespace

Touches::Touches(const GroundTask& task, Continuous continuous, Conditional conditional)
    : task_(task),
      keys_(static_cast<int>(task.facts.size() + task.numbers.size()) + task.others),
      bases_(bases_of_facts(task)) {
  for (const GroundAction& action : task.actions) {
    std::vector<Touch> touches;
    write(touches, action.at_start, true);
    write(touches, action.at_end, false);
    if (conditional != kAlways) conditional_.emplace_back();
    for (const ConditionalEffects& share : action.conditional) {
      std::vector<Touch>& into = conditional == kAlways ? touches : conditional_.back().emplace_back();
      write(into, share.at_start, true);
      write(into, share.at_end, false);
    }
    for_each_share(action, [&](const ConditionalEffects& share) {
      read(touches, share.start, true, false);
      hold(touches, share.over_all);
      read(touches, share.end, false, true);
    });
    if (!task.derived_reads.empty()) {
      const SchemaReads& reads = task.derived_reads[action.schema];
      read(touches, reads.start, Touch::kRead, true, false);
      read(touches, reads.over_all, Touch::kHoldTrue | Touch::kHoldFalse, true, true);
      read(touches, reads.end, Touch::kRead, false, true);
    }
    for (const GroundDuration& duration : action.duration)
      read(touches, duration.bound, !duration.at_end, duration.at_end);
    for (const ContinuousEffect& effect : action.continuous) {
      if (continuous == kPointsOnly) break;
      read(touches, effect.rate, true, true);
      touch(touches, static_cast<int>(task.facts.size()) + effect.number, Touch::kRead | Touch::kUp | Touch::kDown,
            true, true);
    }
    idle(touches, action.idle, conditional == kCertain);
    actions_.push_back(std::move(touches));
  }
  hold(goal_, task.goal);
  events_of_key_.resize(static_cast<std::size_t>(keys_));
  for (std::size_t e = 0; e < task.events.size(); ++e) {
    std::vector<Touch> touches;
    write(touches, task.events[e].effects, true);
    idle(touches, task.events[e].idle, false);
    for (const Touch& touched : touches) events_of_key_[touched.key].push_back(static_cast<int>(e));
    events_.push_back(std::move(touches));
  }
  for (std::vector<Touch>& touches : actions_)
    for (Touch& touched : touches) touched.meets_events = !events_of_key_[touched.key].empty();
}

bool Touches::conflict_at_instant(std::span<const Touch> one, bool at_end, std::span<const Touch> other,
                                  bool other_at_end) {
  for (const Touch& mine : one)
    for (const Touch& theirs : other)
      if (mine.key == theirs.key &&
          conflict_at_instant(at_end ? mine.at_end : mine.at_start, other_at_end ? theirs.at_end : theirs.at_start))
        return true;
  return false;
}

bool Touches::breaks_goal(int event) const {
  for (const Touch& touched : of_event(event))
    for (const Touch& needed : goal_)
      if (touched.key == needed.key && violates(touched.at_start, needed.at_start)) return true;
  return false;
}

void Touches::read(std::vector<Touch>& touches, const GroundCondition& condition, bool at_start, bool at_end) const {
  for (const int f : condition.facts)
    for (const int key : bases_[f]) touch(touches, key, Touch::kRead, at_start, at_end);
  for (const int c : condition.comparisons) read(touches, task_.comparisons[c].expression, at_start, at_end);
}

void Touches::hold(std::vector<Touch>& touches, const GroundCondition& condition) const {
  constexpr std::uint8_t kBoth = Touch::kHoldTrue | Touch::kHoldFalse;
  for (const int f : condition.facts) {
    const GroundFact& fact = task_.facts[f];
    const std::uint8_t does = fact.derived ? kBoth : task_.positive(f) != f ? Touch::kHoldFalse : Touch::kHoldTrue;
    for (const int key : bases_[f]) touch(touches, key, does, true, true);
  }
  for (const int c : condition.comparisons)
    task_.comparisons[c].expression.for_each_number(
        [&](int n) { touch(touches, static_cast<int>(task_.facts.size()) + n, kBoth, true, true); });
}

void Touches::read(std::vector<Touch>& touches, const Symbols& reads, std::uint8_t does, bool at_start,
                   bool at_end) const {
  if (reads.predicates.empty()) return;
  for (std::size_t f = 0; f < task_.facts.size(); ++f)
    if (const GroundFact& fact = task_.facts[f];
        !fact.derived && fact.predicate >= 0 && reads.predicates[fact.predicate])
      touch(touches, task_.positive(static_cast<int>(f)), does, at_start, at_end);
  for (std::size_t n = 0; n < task_.numbers.size(); ++n)
    if (reads.functions[task_.numbers[n].function])
      touch(touches, static_cast<int>(task_.facts.size() + n), does, at_start, at_end);
}

void Touches::read(std::vector<Touch>& touches, const GroundExpression& expression, bool at_start, bool at_end) const {
  expression.for_each_number(
      [&](int n) { touch(touches, static_cast<int>(task_.facts.size()) + n, Touch::kRead, at_start, at_end); });
}

void Touches::write(std::vector<Touch>& touches, const GroundEffects& effects, bool at_start) const {
  const auto change = [&](int f, bool add) {
    const bool up = add != (task_.facts[f].is_complement && task_.facts[f].complement >= 0);
    touch(touches, task_.positive(f), up ? Touch::kUp : Touch::kDown, at_start, !at_start);
  };
  for (const int f : effects.add) change(f, true);
  for (const int f : effects.remove) change(f, false);
  for (const NumericEffect& effect : effects.numbers) {
    const std::uint8_t does = effect.kind == NumericEffect::Kind::kIncrease ? Touch::kUp : Touch::kUp | Touch::kDown;
    touch(touches, static_cast<int>(task_.facts.size()) + effect.number, does, at_start, !at_start);
    read(touches, effect.value, at_start, !at_start);
  }
}

void Touches::idle(std::vector<Touch>& touches, const std::vector<IdleTouch>& from, bool certain) const {
  for (const IdleTouch& each : from) {
    if (certain && each.conditional) continue;
    const int key = each.key < static_cast<int>(task_.facts.size()) ? task_.positive(each.key) : each.key;
    const int does = (each.read ? Touch::kRead : 0) | (each.up ? Touch::kUp : 0) | (each.down ? Touch::kDown : 0);
    touch(touches, key, static_cast<std::uint8_t>(does), !each.at_end, each.at_end);
  }
}

bool Timeline::finish() {
  mark();
  if (appended_ == 0) return true;  // nothing that an event could come before
  for (int event = next_event_; event < static_cast<int>(touches_.events().size()); ++event) {
    const Micros late = makespan_ + kSeparation - touches_.events()[event].time;
    if (late <= 0 || !touches_.breaks_goal(event)) continue;
    if (!lenient_) return false;
    lateness_ += late;
  }
  return true;
}

void Timeline::clear() {
  std::ranges::fill(keys_, Last{});
  next_event_ = 0;
  appended_ = 0;
  makespan_ = 0;
  lateness_ = 0;
  marks_.clear();
  changes_.clear();
}

void Timeline::take_back_to(std::size_t appends) {
  if (appends == marks_.size()) return;
  const Mark mark = marks_[appends];
  for (; changes_.size() > mark.changes; changes_.pop_back()) *changes_.back().where = changes_.back().was;
  next_event_ = mark.next_event;
  lateness_ = mark.lateness;
  makespan_ = mark.makespan;
  appended_ = static_cast<int>(appends);
  marks_.resize(appends);
}

void Timeline::mark() {
  if (lenient_) marks_.push_back({changes_.size(), next_event_, lateness_, makespan_});
}

Timeline::Latest Timeline::after(const Last& last, std::uint8_t does) {
  const auto later = [](const Latest& a, const Latest& b) { return a.time >= b.time ? a : b; };
  Latest latest;
  if (does & Touch::kAnyRead) latest = later(last.up, last.down);
  if (does & Touch::kUp) latest = later(latest, later(last.read, last.down));
  if (does & Touch::kDown) latest = later(latest, later(last.read, last.up));
  return latest;
}

void Timeline::note(Last& last, std::uint8_t does, Micros time) {
  const auto keep = [&](Latest& latest) {
    if (time <= latest.time) return;
    if (lenient_) changes_.push_back({&latest, latest});
    latest = {time, appended_};
  };
  if (does & Touch::kAnyRead) keep(last.read);
  if (does & Touch::kUp) keep(last.up);
  if (does & Touch::kDown) keep(last.down);
}

bool Timeline::before_events(const Touch& touch, std::uint8_t does, Micros time) {
  if (!touch.meets_events) return true;
  for (const int event : touches_.events_of(touch.key)) {
    if (event < next_event_) continue;
    for (const Touch& touched : touches_.of_event(event)) {
      if (touched.key != touch.key || !Touches::conflict(touched.at_start, does)) continue;
      const Micros late = time + (Touches::conflict_at_instant(touched.at_start, does) ? kSeparation : 0) -
                          touches_.events()[event].time;
      if (late <= 0) continue;
      if (!lenient_) return false;
      lateness_ += late;
      return true;
    }
  }
  return true;
}

Micros Timeline::append(int action, Micros duration) { return append(action, Part::kWhole, 0, duration); }

Micros Timeline::append_start(int action, Micros release) { return append(action, Part::kStart, release, 0); }

Micros Timeline::append_end(int action, Micros earliest) { return append(action, Part::kEnd, earliest, 0); }

Micros Timeline::append(int action, Part part, Micros earliest, Micros duration) {
  // Calls `visit` with each touch, what is done, and how much later than the time that is returned.
  const auto all = [touches = touches_.of(action), part, duration](const auto& visit) {
    for (const Touch& touched : touches) {
      if (part != Part::kEnd && touched.at_start && !visit(touched, touched.at_start, Micros{0})) return false;
      if (part != Part::kStart && touched.at_end && !visit(touched, touched.at_end, duration)) return false;
    }
    return true;
  };
  mark();
  Micros time = earliest;
  cause_ = -1;
  all([&](const Touch& touched, std::uint8_t does, Micros later) {
    const Latest latest = after(keys_[touched.key], does);
    if (latest.time + kSeparation - later > time) {
      time = latest.time + kSeparation - later;
      cause_ = latest.by;
    }
    return true;
  });
  if (next_event_ < static_cast<int>(touches_.events().size()) &&
      !all([&](const Touch& touched, std::uint8_t does, Micros later) {
        return before_events(touched, does, time + later);
      }))
    return kNever;
  all([&](const Touch& touched, std::uint8_t does, Micros later) {
    note(keys_[touched.key], does, time + later);
    return true;
  });
  if (part != Part::kStart) makespan_ = std::max(makespan_, time + duration);
  ++appended_;
  return time;
}

bool Timeline::append_event() {
  mark();
  const Micros time = touches_.events()[next_event_].time;
  for (const Touch& touched : touches_.of_event(next_event_)) {
    const Micros earliest = after(keys_[touched.key], touched.at_start).time + kSeparation;
    if (earliest <= time) continue;
    if (!lenient_) return false;
    lateness_ += earliest - time;
  }
  for (const Touch& touched : touches_.of_event(next_event_)) note(keys_[touched.key], touched.at_start, time);
  ++next_event_;
  ++appended_;
  return true;
}

}  // namespace cxlab::planner
