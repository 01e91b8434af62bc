#include "planner/search/clock.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "planner/ground/sorted.h"
#include "planner/search/bucket_queue.h"
#include "planner/search/split.h"
#include "planner/state/number.h"

namespace cxlab::planner {

namespace {

constexpr Micros kNever = DurationRange::kForever;

bool same_action(const GroundAction& a, const GroundAction& b) {
  return a.schema == b.schema && a.arguments == b.arguments;
}

/// The whole number of microseconds, at least 1, after which a comparison of this value and rate turns; kNever: it does
/// not.
Micros turn(const GroundComparison& comparison, double value, double rate) {
  if (rate == 0 || std::isnan(value) || (value > 0) == (rate > 0)) return kNever;
  const double exact = -value / rate * static_cast<double>(kMicrosPerSecond);
  if (!(exact < static_cast<double>(kNever))) return kNever;
  double rounded = std::round(exact);
  if (comparison.kind == GroundComparison::Kind::kNotNegative)
    rounded = rate > 0 ? std::ceil(exact - 1e-6) : std::floor(exact + 1e-6);
  if (comparison.kind == GroundComparison::Kind::kPositive)
    rounded = rate > 0 ? std::floor(exact + 1e-6) + 1 : std::ceil(exact - 1e-6) - 1;
  return rounded >= 1 ? static_cast<Micros>(rounded) : kNever;
}

}  // namespace

ClockSearch::ClockSearch(const GroundTask& task, const Simulator& simulator, const Touches& touches)
    : task_(task), simulator_(simulator), touches_(touches), loose_(task) {
  for (std::size_t a = 0; a < task.actions.size(); ++a) {
    const GroundAction& action = task.actions[a];
    const auto reads_length = [&](int c) { return task.comparisons[c].expression.mentions_duration(); };
    starts_by_length_.push_back(std::ranges::any_of(action.start.comparisons, reads_length) ||
                                std::ranges::any_of(action.at_start.numbers, [](const NumericEffect& effect) {
                                  return effect.value.mentions_duration();
                                }));
    // Where only the way matters in which numbers change, the end is a decision of its own.
    const bool copy = action.stretch > 0 || action.aim >= 0;
    if (!copy || reads_duration(action)) candidates_.push_back(static_cast<int>(a));
  }
}

/// The first time from now at which it can happen.
Micros ClockSearch::clear_of_recent(const Moment& moment, int action, bool at_end) const {
  Micros time = moment.time;
  for (const Recent& recent : moment.recent)
    if (recent.time + kSeparation > time && touches_.conflict_at_instant(action, at_end, recent.action, recent.at_end))
      time = recent.time + kSeparation;
  return time;
}

/// When something happens without a decision.
Micros ClockSearch::forced(const Moment& moment) const {
  Micros time = kNever;
  for (const Running& running : moment.running) time = std::min(time, running.last_end());
  if (moment.next_event < static_cast<int>(task_.events.size()))
    time = std::min(time, task_.events[moment.next_event].time);
  return time;
}

ById<double> ClockSearch::rates(const Moment& moment) const {
  ById<double> rates(task_.numbers.size(), 0);
  for (const Running& running : moment.running)
    for (const ContinuousEffect& effect : task_.actions[running.action].continuous)
      rates[effect.number] = sum(rates[effect.number], effect.rate.evaluate(simulator_.numbers(moment.state.data()),
                                                                            in_seconds(running.range.least)));
  return rates;
}

bool ClockSearch::holds_over_all(Moment& moment) const {
  for (Running& running : moment.running) {
    const Micros ran = running.is_fixed() ? running.range.least : moment.time - running.start;
    if (!simulator_.over_all_holds(running.action, moment.state.data(), ran)) return false;
    for (std::size_t i = 0; i < running.remembered.size(); ++i) {
      const ConditionalEffects& conditional = task_.actions[running.action].conditional[i];
      if (!simulator_.holds(conditional.over_all, moment.state.data(), in_seconds(ran))) running.remembered[i] = 0;
    }
  }
  return true;
}

/// Lets time pass in which nothing happens.
bool ClockSearch::advance(Moment& moment, Micros to) const {
  if (to == moment.time) return true;
  if (!holds_over_all(moment)) return false;
  const ById<double> rates = this->rates(moment);
  double* numbers = reinterpret_cast<double*>(moment.state.data() + task_.words());
  bool changed = false;
  for (std::size_t n = 0; n < rates.size(); ++n)
    if (rates[n] != 0) {
      numbers[n] = sum(numbers[n], product(rates[n], in_seconds(to - moment.time)));
      if (std::isnan(numbers[n])) return false;
      changed = true;
    }
  moment.time = to;
  std::erase_if(moment.recent, [&](const Recent& recent) { return recent.time + kSeparation <= to; });
  if (!changed) return true;
  simulator_.derive(moment.state.data());
  return holds_over_all(moment);  // linear in time: both ends decide
}

bool ClockSearch::begin(Moment& moment, int index) const {
  const GroundAction& action = task_.actions[index];
  for (const Running& running : moment.running)
    if (same_action(task_.actions[running.action], action)) return false;
  Micros time = clear_of_recent(moment, index, false);
  std::optional<DurationRange> range = DurationRange{};
  if (action.durative) {
    range = simulator_.durations_of_copy(index, moment.state.data());
    if (!range) return false;
    if (starts_by_length_[index]) range->most = range->least;
    for (bool moved = range->least == range->most; moved;) {  // keep the end clear of ends and events to come
      moved = false;
      const auto keep_clear = [&](Micros other, int by, bool at_end) {
        if (std::abs(time + range->least - other) >= kSeparation ||
            !touches_.conflict_at_instant(index, true, by, at_end))
          return;
        time = other + kSeparation - range->least;
        moved = true;
      };
      for (const Running& running : moment.running)
        if (running.is_fixed()) keep_clear(running.last_end(), running.action, true);
      for (std::size_t e = static_cast<std::size_t>(moment.next_event); e < task_.events.size(); ++e)
        keep_clear(task_.events[e].time, -2 - static_cast<int>(e), false);
    }
  }
  if (time > moment.time && (time >= forced(moment) || !advance(moment, time))) return false;
  if (action.durative && range->most < kSeparation) {
    if (!simulator_.apply_with(index, moment.state.data(), range->least)) return false;
    moment.ended.push_back({index, time, time + range->least});
    moment.recent.push_back({time, index, true});
  } else {
    Running running{index, time, *range, {}};
    if (!simulator_.begin(index, moment.state.data(), range->least, running.remembered)) return false;
    if (action.durative) {
      const auto place = std::ranges::upper_bound(moment.running, index, {}, &Running::action);
      moment.running.insert(place, std::move(running));
    } else {
      moment.ended.push_back({index, time, time});
    }
  }
  moment.recent.push_back({time, index, false});
  return true;
}

bool ClockSearch::finish(Moment& moment, std::size_t place) const {
  const Running running = moment.running[place];
  if (clear_of_recent(moment, running.action, true) > moment.time) return false;
  if (!simulator_.finish(running.action, moment.state.data(), moment.time - running.start, running.remembered))
    return false;
  moment.running.erase(moment.running.begin() + static_cast<std::ptrdiff_t>(place));
  moment.ended.push_back({running.action, running.start, moment.time});
  moment.recent.push_back({moment.time, running.action, true});
  return true;
}

/// Ends a step that could continue.
bool ClockSearch::end(Moment& moment, std::size_t place) const {
  const Micros time = clear_of_recent(moment, moment.running[place].action, true);
  if (time < moment.running[place].first_end() || (time > moment.time && time >= forced(moment))) return false;
  return advance(moment, time) && finish(moment, place);
}

bool ClockSearch::pass_event(Moment& moment) const {
  const int name = -2 - moment.next_event;
  if (clear_of_recent(moment, name, false) > moment.time) return false;
  simulator_.apply_event(moment.next_event, moment.state.data());
  moment.recent.push_back({moment.time, name, false});
  ++moment.next_event;
  return true;
}

/// The first time after now at which a comparison turns.
Micros ClockSearch::next_turn(const Moment& moment, const ById<double>& rates) const {
  Micros first = kNever;
  for (const GroundComparison& comparison : task_.comparisons) {
    if (!comparison.linear.is_linear || comparison.linear.duration_weight != 0) continue;
    double rate = 0, value = comparison.linear.constant;
    for (const auto& [number, weight] : comparison.linear.weights) {
      rate += weight * rates[number];
      value += weight * simulator_.numbers(moment.state.data())[number];
    }
    if (const Micros in = turn(comparison, value, rate); in < kNever) first = std::min(first, moment.time + in);
  }
  return first;
}

bool ClockSearch::wait(Moment& moment) const {
  const Micros must = forced(moment);
  Micros until = std::min(must, next_turn(moment, rates(moment)));
  for (const Running& running : moment.running)
    if (running.first_end() > moment.time) until = std::min(until, running.first_end());
  if (until == kNever || !advance(moment, until)) return false;
  if (until < must) return true;
  while (moment.next_event < static_cast<int>(task_.events.size()) && task_.events[moment.next_event].time == until)
    if (!pass_event(moment)) return false;
  for (std::size_t i = 0; i < moment.running.size();) {
    if (moment.running[i].last_end() > until)
      ++i;
    else if (!finish(moment, i))
      return false;
  }
  return true;
}

int ClockSearch::estimate(RelaxedHeuristic& heuristic, const Moment& moment) {
  std::vector<LooseEstimate::Running> running;
  for (const Running& each : moment.running) {
    running.push_back({each.action, {}, each.range.least});
    if (each.is_fixed()) running.back().left = each.last_end() - moment.time;
  }
  return loose_.evaluate(heuristic, moment.state.data(), simulator_.numbers(moment.state.data()), moment.next_event,
                         running);
}

std::vector<Word> ClockSearch::key(const Moment& moment, bool with_time) const {
  std::vector<Word> key(moment.state.begin(), moment.state.begin() + simulator_.significant_words());
  key.push_back(static_cast<Word>(moment.next_event));
  if (with_time) key.push_back(static_cast<Word>(moment.time));
  for (const Running& running : moment.running) {
    key.push_back(static_cast<Word>(running.action));
    key.push_back(static_cast<Word>(moment.time - running.start));
    key.push_back(static_cast<Word>(running.range.least));
    for (const char held : running.remembered) key.push_back(static_cast<Word>(held));
  }
  return key;
}

bool ClockSearch::too_late(const Moment& moment, Micros before) const {
  return moment.time >= before ||
         std::ranges::any_of(moment.running, [&](const Running& running) { return running.first_end() >= before; });
}

SearchEnd ClockSearch::run(const LazyOptions& options, Micros before, Budget& budget,
                           const std::function<bool(const std::vector<ClockStep>&)>& accept) {
  RandomStream random(options.seed, "planner clock search");
  RelaxedHeuristic heuristic = loose_.heuristic();
  std::int64_t reported = 0;
  ById<Moment> moments;
  ById<std::vector<int>> preferred_of;  // by moment
  std::set<std::vector<Word>> known;
  std::size_t words = 0;
  BucketQueue<int> queue;  // of moments

  const auto plan_of = [&](const Moment& last) {
    std::vector<ClockStep> steps = last.ended;
    for (int at = last.parent; at >= 0; at = moments[at].parent)
      steps.insert(steps.end(), moments[at].ended.begin(), moments[at].ended.end());
    std::ranges::stable_sort(steps, {}, &ClockStep::start);
    return steps;
  };
  /// Whether it is a plan that was wanted.
  const auto add = [&](Moment made, bool wanted) {
    if (too_late(made, before)) return false;
    const bool time_matters = made.next_event < static_cast<int>(task_.events.size()) || before < kNever;
    std::vector<Word> name = key(made, time_matters);
    const std::size_t size = 2 * name.size() + 20;
    if (!known.insert(std::move(name)).second) return false;
    if (made.running.empty() && simulator_.is_lasting_goal(made.state.data(), made.next_event) && accept(plan_of(made)))
      return true;
    const int found = estimate(heuristic, made);
    budget.spend(Work::kReach, heuristic.work() - reported);
    reported = heuristic.work();
    if (found == RelaxedHeuristic::kDeadEnd) return false;
    queue.push(2 * std::min(found, 1 << 15) + !wanted, static_cast<int>(moments.size()));
    std::vector<int> best;
    const ById<char>& preferred = loose_.preferred();
    for (std::size_t a = 0; a < preferred.size(); ++a)
      if (preferred[a]) best.push_back(static_cast<int>(a));
    words += size + best.size();
    preferred_of.push_back(std::move(best));
    moments.push_back(std::move(made));
    return false;
  };
  Moment start;
  start.state = simulator_.initial();
  if (add(std::move(start), true)) return SearchEnd::kFound;
  std::vector<int> order = candidates_;
  while (!queue.empty()) {
    if (budget.slice_over()) return SearchEnd::kBudget;
    if (words > options.most_words / 4) return SearchEnd::kMemory;
    const bool any = options.random_choice > 0 && random.chance(options.random_choice);
    const int node = any ? queue.pop_any(random) : queue.pop();
    const std::vector<int> wanted = preferred_of[node];
    const auto next = [&] {
      budget.spend(Work::kNode, 1 + static_cast<std::int64_t>(moments[node].running.size()));
      Moment moment = moments[node];
      moment.parent = node;
      moment.ended.clear();
      return moment;
    };
    for (std::size_t i = 0; i < moments[node].running.size(); ++i) {
      const Running& running = moments[node].running[i];
      if (running.is_fixed() || moments[node].time < running.first_end()) continue;
      Moment made = next();
      if (end(made, i) && add(std::move(made), true)) return SearchEnd::kFound;
    }
    if (options.seed != 0) random.shuffle(order);
    budget.spend(Work::kReach, static_cast<std::int64_t>(order.size()));
    for (const int action : order) {
      const auto is_true = [&](int f) { return is_set(moments[node].state.data(), f); };
      if (!std::ranges::all_of(task_.actions[action].start.facts, is_true)) continue;
      Moment made = next();
      if (begin(made, action) && add(std::move(made), contains(wanted, action))) return SearchEnd::kFound;
    }
    budget.spend(Work::kReach, static_cast<std::int64_t>(task_.comparisons.size()));
    if (Moment made = next(); wait(made) && add(std::move(made), true)) return SearchEnd::kFound;
  }
  return SearchEnd::kExhausted;
}

}  // namespace cxlab::planner
