#include "planner/bounds/pair_times.h"

#include <algorithm>
#include <span>

#include "planner/ground/sorted.h"

namespace cxlab::planner {

namespace {

constexpr std::int64_t kEntriesOfWork = 64;  ///< entries that take as long as one piece of Work::kBound

bool share(std::span<const int> a, std::span<const int> b) {
  return std::ranges::any_of(a, [&](int item) { return std::ranges::find(b, item) != b.end(); });
}

void unite(std::vector<int>& items, const std::vector<int>& more) {
  items.insert(items.end(), more.begin(), more.end());
  sort_unique(items);
}

void raise(PairTime* __restrict to, const PairTime* __restrict from, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) to[i] = to[i] < from[i] ? from[i] : to[i];
}

/// Adds to what is not never.
void delay(PairTime* times, PairTime by, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const PairTime later = std::min(times[i] + by, PairTimes::kMost);
    times[i] = times[i] < PairTimes::kNever ? later : PairTimes::kNever;
  }
}

bool any_below(const PairTime* __restrict a, const PairTime* __restrict b, std::size_t count) {
  int below = 0;
  for (std::size_t i = 0; i < count; ++i) below |= static_cast<int>(a[i] < b[i]);
  return below != 0;
}

std::size_t padded(int count) { return (static_cast<std::size_t>(count) + 7) / 8 * 8; }

}  // namespace

HappeningTask::HappeningTask(const GroundTask& task, const std::vector<Micros>& durations, const ById<Micros>& released,
                             Micros unit, Budget& budget)
    : facts_(static_cast<int>(task.facts.size())), beginnings_(task.actions.size(), -1), initial_(task.initial_facts) {
  const auto units = [unit](Micros time) {
    return static_cast<PairTime>(std::min<Micros>(time / unit, PairTimes::kMost));
  };
  const auto release = [&](const std::vector<int>& comparisons) {
    PairTime time = 0;
    for (const int c : comparisons) time = std::max(time, units(released[c]));
    return time;
  };
  ById<char> begun(task.facts.size(), 0);  // a beginning adds it
  for (const GroundAction& action : task.actions) {
    if (!action.durative) continue;
    for_each_share(action, [&](const ConditionalEffects& share) {
      for (const int f : share.at_start.add) begun[f] = 1;
    });
  }
  ById<int> action_of_run, end_of_run;
  for (std::size_t a = 0; a < task.actions.size(); ++a) {
    const GroundAction& action = task.actions[a];
    const int first = beginnings_[a] = static_cast<int>(happenings_.size());
    PairHappening begin;
    begin.needs = action.start.facts;
    begin.adds = action.at_start.add;
    begin.removes = action.at_start.remove;
    begin.release = release(action.start.comparisons);
    if (!action.durative) {
      happenings_.push_back(std::move(begin));
      add_conditional(action, first, -1);
      continue;
    }
    if (durations[a] > 0) {
      std::vector<int> needs = action.over_all.facts;
      std::erase_if(needs, [&](int f) { return begun[f] != 0; });
      unite(begin.needs, needs);
    }
    begin.begins = runs_;
    begin.adds.push_back(facts_ + runs_);
    begin.lasts = units(durations[a]);
    PairHappening end;
    end.needs = action.end.facts;
    if (durations[a] > 0) unite(end.needs, action.over_all.facts);  // what takes no time has nothing in between
    end.needs.push_back(facts_ + runs_);
    end.adds = action.at_end.add;
    end.removes = action.at_end.remove;
    end.removes.push_back(facts_ + runs_);
    end.ends = {runs_};
    end.release = release(action.end.comparisons);
    action_of_run.push_back(static_cast<int>(a));
    end_of_run.push_back(first + 1);
    ++runs_;
    happenings_.push_back(std::move(begin));
    happenings_.push_back(std::move(end));
    add_conditional(action, first, first + 1);
  }
  for (const TimedEvent& event : task.events)
    happenings_.push_back({{}, event.effects.add, event.effects.remove, {}, -1, 0, units(event.time), true});
  find_breaks(task, action_of_run, end_of_run, budget);
  readers_.resize(static_cast<std::size_t>(atoms()));
  ends_of_.resize(static_cast<std::size_t>(runs_));
  for (std::size_t h = 0; h < happenings_.size(); ++h) {
    if (happenings_[h].needs.empty()) without_needs_.push_back(static_cast<int>(h));
    for (const int atom : happenings_[h].needs) readers_[atom].push_back(static_cast<int>(h));
    for (const int run : happenings_[h].ends) ends_of_[run].push_back(static_cast<int>(h));
  }
}

/// What a conditional effect adds is a happening beside that of its action, which removes nothing: others may hold,
/// too.
void HappeningTask::add_conditional(const GroundAction& action, int begin, int end) {
  for (const ConditionalEffects& conditional : action.conditional) {
    for (const bool at_end : {false, true}) {
      const std::vector<int>& adds = (at_end ? conditional.at_end : conditional.at_start).add;
      if (adds.empty()) continue;
      PairHappening& base = happenings_[static_cast<std::size_t>(at_end ? end : begin)];
      std::erase_if(base.removes, [&](int f) { return std::ranges::find(adds, f) != adds.end(); });
      PairHappening extra;
      extra.needs = base.needs;
      unite(extra.needs, (at_end ? conditional.end : conditional.start).facts);
      extra.adds = adds;
      extra.ends = base.ends;
      extra.release = base.release;
      happenings_.push_back(std::move(extra));
    }
  }
}

/// Finds the happenings that make a condition over all of a running action false.
void HappeningTask::find_breaks(const GroundTask& task, const ById<int>& action_of_run, const ById<int>& end_of_run,
                                Budget& budget) {
  ById<std::vector<int>> holders(task.facts.size());  // by fact: runs
  for (int run = 0; run < runs_; ++run)
    if (happenings_[static_cast<std::size_t>(beginnings_[action_of_run[run]])].lasts > 0)
      for (const int f : task.actions[action_of_run[run]].over_all.facts) holders[f].push_back(run);
  ends_itself_.assign(static_cast<std::size_t>(runs_), 0);
  for (PairHappening& happening : happenings_) {
    if (budget.late()) return;
    std::vector<int> broken;
    for (const int f : happening.removes) {
      if (f >= facts_) continue;
      for (const int run : holders[f]) {
        if (happening.begins == run) continue;
        if (!happening.ends.empty() && happening.ends[0] == run)
          ends_itself_[run] = 1;
        else
          broken.push_back(facts_ + run);
      }
    }
    unite(happening.removes, broken);
  }
  const auto removed_facts = [this](const PairHappening& happening) {  // they come before what it breaks
    return std::span(happening.removes.begin(), std::ranges::lower_bound(happening.removes, facts_));
  };
  for (int a = 0; a < runs_; ++a) {
    if (budget.late()) return;
    const PairHappening first = happenings_[static_cast<std::size_t>(end_of_run[a])];
    const std::vector<int>& needs = task.actions[action_of_run[a]].end.facts;
    const std::span<const int> removes = removed_facts(first);
    for (const int atom : first.removes) {
      const int b = atom - facts_;
      if (b < a) continue;
      if (b == a) {
        if (ends_itself_[a]) left_out_.emplace_back(a, a);
        continue;
      }
      const PairHappening& second = happenings_[static_cast<std::size_t>(end_of_run[b])];
      if (!contains(second.removes, facts_ + a)) continue;
      const std::vector<int>& others = task.actions[action_of_run[b]].end.facts;
      const std::span<const int> other_removes = removed_facts(second);
      if (share(first.adds, other_removes) || share(removes, second.adds) || share(needs, other_removes) ||
          share(needs, second.adds) || share(others, removes) || share(others, first.adds))
        continue;  // they cannot share an instant
      if (share(first.adds, second.adds) || share(removes, other_removes)) {
        left_out_.emplace_back(a, b);
        continue;
      }
      PairHappening both = first;
      unite(both.needs, second.needs);
      unite(both.adds, second.adds);
      unite(both.removes, second.removes);
      both.ends.push_back(b);
      both.release = std::max(first.release, second.release);
      happenings_.push_back(std::move(both));
    }
  }
}

PairTimes::PairTimes(const HappeningTask& task)
    : task_(task), width_(padded(task.atoms())), run_width_(padded(task.runs())) {
  const std::size_t atoms = static_cast<std::size_t>(task.atoms()), runs = static_cast<std::size_t>(task.runs());
  pairs_.assign(atoms * width_, kNever);
  ends_.assign(runs * width_, kNever);
  ends_by_atom_.assign(atoms * run_width_, kNever);
  single_.assign(width_, kNever);
  overlaps_itself_.assign(runs, 0);
  queued_.assign(task.happenings().size(), 0);
  beside_.resize(width_);
  end_beside_.resize(run_width_);
}

std::size_t PairTimes::bytes(const HappeningTask& task) {
  const std::size_t atoms = static_cast<std::size_t>(task.atoms()), width = padded(task.atoms());
  return sizeof(PairTime) *
         (atoms * width + static_cast<std::size_t>(task.runs()) * width + atoms * padded(task.runs()));
}

std::int64_t PairTimes::round_work(const HappeningTask& task) {
  std::size_t rows = 0;
  for (const PairHappening& happening : task.happenings()) rows += happening.needs.size() + happening.adds.size() + 1;
  return static_cast<std::int64_t>(rows * (padded(task.atoms()) + padded(task.runs()))) / kEntriesOfWork;
}

bool PairTimes::solve(Budget& budget) {
  for (int p = 0; p < task_.facts(); ++p)
    for (int q = 0; q < task_.facts(); ++q)
      if (task_.initial()[p] && task_.initial()[q]) pairs(p)[q] = 0;
  for (int p = 0; p < task_.facts(); ++p) single_[p] = pairs(p)[p];
  for (std::size_t h = 0; h < task_.happenings().size(); ++h) queue(static_cast<int>(h));
  return settle(budget);
}

bool PairTimes::solve_after(int action, const PairTimes& all, Budget& budget) {
  const PairHappening& begin = task_.happenings()[task_.beginning(action)];
  const int atoms = task_.atoms();
  ById<char> possible(static_cast<std::size_t>(atoms), 1);  // right after it
  for (int p = 0; p < atoms; ++p) {
    possible[p] = all.single_[p] < kNever;
    for (const int need : begin.needs) possible[p] = possible[p] && all.time(need, p) < kNever;
  }
  timed_ = false;
  overlaps_itself_ = all.overlaps_itself_;
  for (const int p : begin.removes) possible[p] = 0;
  for (const int p : begin.adds) possible[p] = 1;
  for (int p = 0; p < atoms; ++p) {
    if (budget.late()) return false;
    for (int q = 0; q < atoms; ++q) {
      const bool together = possible[p] && possible[q] && all.time(p, q) < kNever;
      pairs(p)[q] = together ? 0 : kNever;
      if (p < task_.facts()) continue;
      const int run = p - task_.facts();
      const PairTime end = !together ? kNever : run == begin.begins && !overlaps_itself_[run] ? begin.lasts : 0;
      ends(run)[q] = end;
      ends_by_atom(q)[run] = end;
    }
    single_[p] = pairs(p)[p];
  }
  work_ += static_cast<std::int64_t>(atoms) * atoms;
  for (std::size_t h = 0; h < task_.happenings().size(); ++h) queue(static_cast<int>(h));
  return settle(budget);
}

PairTime PairTimes::time(const std::vector<int>& atoms) const {
  PairTime latest = 0;
  for (const int p : atoms)
    for (const int q : atoms) latest = std::max(latest, time(p, q));
  return latest;
}

PairTime PairTimes::beginning(int action) const {
  const PairHappening& begin = task_.happenings()[task_.beginning(action)];
  return std::max(time(begin.needs), timed_ ? begin.release : 0);
}

bool PairTimes::assumes_order() const {
  return std::ranges::any_of(task_.left_out(), [this](const auto& runs) {
    return runs.first == runs.second ? overlaps_itself_[runs.first] != 0
                                     : time(task_.facts() + runs.first, task_.facts() + runs.second) < kNever;
  });
}

void PairTimes::queue(int happening) {
  if (queued_[happening]) return;
  queued_[happening] = 1;
  queue_.push_back(happening);
}

void PairTimes::queue_readers(int atom) {
  for (const int happening : task_.readers(atom)) queue(happening);
}

void PairTimes::lower_pair(int p, int q, PairTime to) {
  pairs(p)[q] = pairs(q)[p] = to;
  queue_readers(q);
  if (p != q) return;
  single_[p] = to;
  for (const int happening : task_.without_needs()) queue(happening);
}

void PairTimes::lower_end(int run, int atom, PairTime to) {
  ends(run)[atom] = to;
  ends_by_atom(atom)[run] = to;
  for (const int happening : task_.ends_of(run)) queue(happening);
  queue_readers(atom);
  if (atom != task_.facts() + run) return;
  for (const int happening : task_.without_needs()) queue(happening);
}

bool PairTimes::settle(Budget& budget) {
  std::vector<int> round;
  while (!queue_.empty()) {
    round.clear();
    std::swap(round, queue_);
    for (const int happening : round) {
      queued_[happening] = 0;
      apply(happening);
      budget.spend(Work::kBound, work_ / kEntriesOfWork);
      work_ %= kEntriesOfWork;
      if (budget.slice_over()) return false;
    }
  }
  return true;
}

void PairTimes::apply(int index) {
  const PairHappening& happening = task_.happenings()[index];
  const std::size_t atoms = width_, runs = run_width_;
  PairTime now = std::max(time(happening.needs), timed_ ? happening.release : 0);
  for (const int run : happening.ends)
    for (const int need : happening.needs) now = std::max(now, ends(run)[need]);
  work_ += static_cast<std::int64_t>(1 + happening.needs.size());
  if (now >= kNever) return;

  // What can be true beside, right after; when the runs that continue can end.
  std::fill(beside_.begin(), beside_.end(), now);
  std::fill(end_beside_.begin(), end_beside_.end(), now);
  if (happening.needs.empty()) raise(beside_.data(), single_.data(), atoms);
  for (const int need : happening.needs) {
    raise(beside_.data(), pairs(need), atoms);
    raise(end_beside_.data(), ends_by_atom(need), runs);
  }
  for (const int run : happening.ends) raise(beside_.data(), ends(run), atoms);
  if (happening.fixed && timed_)
    for (PairTime& time : beside_) time = time > now ? kNever : now;
  const int facts = task_.facts();
  for (const int atom : happening.removes) {
    const bool own = atom >= facts && !happening.ends.empty() && happening.ends[0] == atom - facts;
    if (!(own && overlaps_itself_[atom - facts] && !task_.ends_itself(atom - facts))) beside_[atom] = kNever;
  }
  if (happening.begins >= 0 && !overlaps_itself_[happening.begins] && beside_[facts + happening.begins] < kNever) {
    overlaps_itself_[happening.begins] = 1;
    for (const int end : task_.ends_of(happening.begins)) queue(end);
  }
  for (int run = 0; run < task_.runs(); ++run) {
    if (happening.needs.empty()) end_beside_[run] = std::max(end_beside_[run], ends(run)[facts + run]);
    end_beside_[run] = std::max(end_beside_[run], beside_[facts + run]);
  }
  if (happening.begins >= 0 && !overlaps_itself_[happening.begins]) end_beside_[happening.begins] = kNever;
  for (const int atom : happening.adds) beside_[atom] = now;

  for (const int added : happening.adds) {
    bool lowered = false;
    if (any_below(beside_.data(), pairs(added), atoms)) {
      for (int q = 0; q < task_.atoms(); ++q)
        if (beside_[q] < pairs(added)[q]) {
          lower_pair(added, q, beside_[q]);
          lowered = true;
        }
    }
    if (any_below(end_beside_.data(), ends_by_atom(added), runs)) {
      for (int run = 0; run < task_.runs(); ++run)
        if (end_beside_[run] < ends_by_atom(added)[run]) lower_end(run, added, end_beside_[run]);
    }
    if (lowered) queue_readers(added);
  }
  if (happening.begins >= 0) {
    delay(beside_.data(), happening.lasts, atoms);
    if (any_below(beside_.data(), ends(happening.begins), atoms)) {
      for (int q = 0; q < task_.atoms(); ++q)
        if (beside_[q] < ends(happening.begins)[q]) lower_end(happening.begins, q, beside_[q]);
    }
    work_ += static_cast<std::int64_t>(atoms);
  }
  work_ += static_cast<std::int64_t>((happening.needs.size() + happening.adds.size() + 1) * (atoms + runs));
}

}  // namespace cxlab::planner
