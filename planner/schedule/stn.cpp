#include "planner/schedule/stn.h"

#include <algorithm>

namespace cxlab::planner {

void Stn::clear() {
  steps_.clear();
  point_step_.clear();
  point_event_.clear();
  edges_.clear();
  for (const int key : used_keys_) {
    keys_[key].clear();
    is_used_[key] = 0;
  }
  used_keys_.clear();
  next_event_ = 0;
}

int Stn::add_point(int step, int event) {
  point_step_.push_back(step);
  point_event_.push_back(event);
  return static_cast<int>(point_step_.size()) - 1;
}

void Stn::connect(int point, std::span<const Touch> touches, bool at_end) {
  for (const Touch& touched : touches) {
    const std::uint8_t does = at_end ? touched.at_end : touched.at_start;
    if (!does) continue;
    std::vector<Use>& uses = keys_[touched.key];
    const auto is_own = [&](const Use& use) {
      return point_step_[use.point] >= 0 && point_step_[use.point] == point_step_[point];
    };
    // What came before the last one that waits for all before it, and for which all after it wait, keeps clear by
    // itself.
    std::size_t first = uses.size();
    while (first > 0 && (first == uses.size() || is_own(uses[first]) || !Touches::conflicts_with_all(uses[first].does)))
      --first;
    work_ += static_cast<std::int64_t>(1 + uses.size() - first);
    for (; first < uses.size(); ++first)
      if (const Use& use = uses[first]; Touches::conflict(use.does, does) && !is_own(use))
        edges_.push_back({use.point, point, !Touches::conflict_at_instant(use.does, does)});
    if (!is_used_[touched.key]) {
      is_used_[touched.key] = 1;
      used_keys_.push_back(touched.key);
    }
    uses.push_back({point, does});
  }
}

int Stn::begin(int action, DurationRange range) {
  const int step = steps();
  steps_.push_back({action, range, -1, -1, 0});
  steps_[step].start = add_point(step, -1);
  connect(steps_[step].start, touches_.of(action), false);
  return step;
}

void Stn::finish(int step) {
  steps_[step].end = add_point(step, -1);
  connect(steps_[step].end, touches_.of(steps_[step].action), true);
}

void Stn::event() {
  const int point = add_point(-1, next_event_);
  connect(point, touches_.of_event(next_event_), false);
  ++next_event_;
}

void Stn::truncate(int points) {
  for (int point = this->points() - 1; point >= points; --point) {
    const int step = point_step_[point];
    const bool at_end = step >= 0 && steps_[step].end == point;
    for (const Touch& touched : step < 0 ? touches_.of_event(point_event_[point]) : touches_.of(steps_[step].action))
      if (at_end ? touched.at_end : touched.at_start) keys_[touched.key].pop_back();
    if (step < 0)
      --next_event_;
    else if (at_end)
      steps_[step].end = -1;
    else
      steps_.pop_back();
    while (!edges_.empty() && edges_.back().to == point) edges_.pop_back();
    point_step_.pop_back();
    point_event_.pop_back();
  }
}

bool Stn::solve(Micros hold_separation) {
  hold_separation_ = hold_separation;
  // Ends to come: after everything that they conflict with, and after the ends of what they would break.
  const std::size_t points = point_step_.size(), edges = edges_.size();
  std::vector<int> open;
  for (int step = 0; step < steps(); ++step)
    if (steps_[step].end < 0) open.push_back(step);
  for (const int step : open) {
    steps_[step].end = add_point(step, -1);
    for (const Touch& touched : touches_.of(steps_[step].action)) {
      work_ += static_cast<std::int64_t>(1 + keys_[touched.key].size());
      for (const Use& use : keys_[touched.key])
        if (Touches::conflict(use.does, touched.at_end) && point_step_[use.point] != step)
          edges_.push_back({use.point, steps_[step].end, !Touches::conflict_at_instant(use.does, touched.at_end)});
    }
  }
  for (const int writer : open)
    for (const int holder : open) {
      if (writer == holder) continue;
      work_ += static_cast<std::int64_t>(touches_.of(steps_[writer].action).size() *
                                         touches_.of(steps_[holder].action).size());
      for (const Touch& written : touches_.of(steps_[writer].action))
        for (const Touch& held : touches_.of(steps_[holder].action))
          if (written.key == held.key && Touches::surely_violates(written.at_end, held.at_end))
            edges_.push_back({steps_[holder].end, steps_[writer].end, true});
    }
  const bool solved = relax(hold_separation) && keeps_clear_of_events();
  last_happening_ = 0;
  for (std::size_t p = 0; p < points; ++p) last_happening_ = std::max(last_happening_, times_[p]);
  for (const int step : open) steps_[step].end = -1;
  point_step_.resize(points);
  point_event_.resize(points);
  edges_.resize(edges);
  return solved;
}

bool Stn::solve_complete(Micros hold_separation) {
  const auto fits_goal = [&] {
    if (steps_.empty()) return true;  // nothing that an event could come before
    for (int event = next_event_; event < static_cast<int>(touches_.events().size()); ++event)
      if (touches_.breaks_goal(event) && makespan() + kSeparation > touches_.events()[event].time) return false;
    return true;
  };
  if (!solve(hold_separation)) return false;
  const Micros last = next_event_ > 0 ? touches_.events()[next_event_ - 1].time + kSeparation : 0;
  if (makespan() >= last) return fits_goal();
  for (Step& step : steps_) {  // one of the steps waits
    step.release = last - step.range.least;
    if (solve(hold_separation) && fits_goal()) return true;
    step.release = 0;
  }
  return false;
}

bool Stn::relax(Micros hold_separation) {
  times_.assign(point_step_.size(), 0);
  causes_.assign(point_step_.size(), -1);
  for (const Step& step : steps_) times_[step.start] = step.release;
  for (std::size_t p = 0; p < point_event_.size(); ++p)
    if (point_event_[p] >= 0) times_[p] = touches_.events()[point_event_[p]].time;
  bool changed = true;
  const auto raise = [&](int point, int cause, Micros to) {
    if (to <= times_[point]) return true;
    times_[point] = to;
    causes_[point] = cause;
    changed = true;
    return point_event_[point] < 0;
  };
  while (changed) {
    changed = false;
    work_ += static_cast<std::int64_t>(edges_.size() + 2 * times_.size());
    // Edges are in the order of their later point, so that one sweep carries times all the way.
    std::size_t edge = 0;
    const auto follow = [&](const Edge& e) {
      return raise(e.to, e.from, times_[e.from] + (e.hold ? hold_separation : kSeparation));
    };
    for (std::size_t p = 0; p < times_.size(); ++p) {
      for (; edge < edges_.size() && edges_[edge].to == static_cast<int>(p); ++edge)
        if (!follow(edges_[edge])) return false;
      const int step = point_step_[p];
      if (step >= 0 && steps_[step].end == static_cast<int>(p))
        raise(steps_[step].end, steps_[step].start, times_[steps_[step].start] + steps_[step].range.least);
    }
    for (; edge < edges_.size(); ++edge) follow(edges_[edge]);  // between ends to come
    for (const Step& step : steps_) raise(step.start, step.end, times_[step.end] - step.range.most);
    if (changed && has_cycle()) return false;
  }
  return true;
}

/// Whether some point waits for itself: then there are no times.
bool Stn::has_cycle() {
  marks_.assign(causes_.size(), 0);
  for (std::size_t p = 0; p < causes_.size(); ++p) {
    int at = static_cast<int>(p);
    while (at >= 0 && marks_[at] == 0) {
      marks_[at] = static_cast<int>(p) + 1;
      at = causes_[at];
    }
    if (at >= 0 && marks_[at] == static_cast<int>(p) + 1) return true;
  }
  return false;
}

/// Calls `visit` with the latest times that events to come leave to a happening of a step.
template <class Visit>
void Stn::for_each_limit(int step, bool at_end, const Visit& visit) const {
  for (const Touch& touched : touches_.of(steps_[step].action))
    for (const int event : touches_.events_of(touched.key)) {
      if (event < next_event_) continue;
      const std::uint8_t does = at_end ? touched.at_end : touched.at_start;
      for (const Touch& other : touches_.of_event(event))
        if (other.key == touched.key && Touches::conflict(other.at_start, does))
          visit(touches_.events()[event].time - separation(other.at_start, does));
    }
}

bool Stn::keeps_clear_of_events() const {
  if (next_event_ == static_cast<int>(touches_.events().size())) return true;
  bool clear = true;
  for (int p = 0; p < points(); ++p)
    if (const int step = point_step_[p]; step >= 0)
      for_each_limit(step, steps_[step].end == p, [&](Micros latest) { clear = clear && times_[p] <= latest; });
  return clear;
}

Micros Stn::makespan() const {
  Micros latest = 0;
  for (const Step& step : steps_)
    if (step.end >= 0) latest = std::max(latest, times_[step.end]);
  return latest;
}

std::vector<Ordering> Stn::orderings() const {
  const std::size_t points = point_step_.size(), words = (points + 63) / 64;
  const auto name = [&](int point) {
    const int step = point_step_[point];
    return 2 * step + (steps_[step].end == point ? 1 : 0);
  };
  std::vector<Ordering> found;
  for (const Step& step : steps_)
    if (step.end >= 0) found.push_back({name(step.start), name(step.end), step.range.least, step.range.most});
  // before[p]: points that some chain of constraints puts before p
  std::vector<Word> before(points * words, 0);
  std::size_t edge = 0;
  for (std::size_t p = 0; p < points; ++p) {
    Word* own = &before[p * words];
    std::vector<int> direct;
    for (; edge < edges_.size() && edges_[edge].to == static_cast<int>(p); ++edge)
      direct.push_back(static_cast<int>(edge));
    const int step = point_step_[p];
    const bool is_end = step >= 0 && steps_[step].end == static_cast<int>(p);
    const auto follow = [&](int from) {
      for (std::size_t w = 0; w < words; ++w) own[w] |= before[static_cast<std::size_t>(from) * words + w];
    };
    if (is_end) {
      follow(steps_[step].start);
      set(own, steps_[step].start);
    }
    const auto weak = [&](int e) { return edges_[e].hold && hold_separation_ < kSeparation; };
    for (const int e : direct)
      if (!weak(e)) follow(edges_[e].from);
    std::ranges::sort(direct, [&](int a, int b) {
      return edges_[a].from < edges_[b].from || (edges_[a].from == edges_[b].from && edges_[a].hold < edges_[b].hold);
    });
    int last = -1;
    for (const int e : direct) {
      const int from = edges_[e].from;
      if (from == last) continue;
      last = from;
      if (is_set(own, from)) continue;
      const Micros separation = edges_[e].hold ? hold_separation_ : kSeparation;
      if (point_event_[p] >= 0 && point_event_[from] >= 0) continue;
      if (point_event_[p] >= 0) {  // before a fixed time
        found.push_back({Ordering::kOrigin, name(from), 0, touches_.events()[point_event_[p]].time - separation});
      } else if (point_event_[from] >= 0) {
        found.push_back({Ordering::kOrigin, name(static_cast<int>(p)),
                         touches_.events()[point_event_[from]].time + separation, DurationRange::kForever});
      } else {
        found.push_back({name(from), name(static_cast<int>(p)), separation, DurationRange::kForever});
      }
    }
    for (const int e : direct)
      if (!weak(e)) set(own, edges_[e].from);
  }
  for (const Step& step : steps_)  // events that have not happened bound what they would break
    for (const bool at_end : {false, true})
      for_each_limit(point_step_[step.start], at_end, [&](Micros latest) {
        found.push_back({Ordering::kOrigin, name(at_end ? step.end : step.start), 0, latest});
      });
  return found;
}

}  // namespace cxlab::planner
