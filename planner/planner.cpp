#include "planner/planner.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <memory>

#include "planner/bounds/lower_bound.h"
#include "planner/ground/ground.h"
#include "planner/improve/rebuild.h"
#include "planner/improve/remainder.h"
#include "planner/pddl/parser.h"
#include "planner/search/clock.h"
#include "planner/search/kept_search.h"
#include "planner/search/lasting.h"
#include "planner/search/split.h"
#include "planner/validator/validator.h"

namespace cxlab::planner {

namespace {

constexpr std::int64_t kFirstSlice =
    20'000;  ///< units of the first try, at least; each round of tries has half as many more
constexpr std::int64_t kLongestSlice = 1'000'000'000'000;
constexpr std::int64_t kSliceOfOperator = 20;  ///< units of the first try by operator
constexpr std::uint64_t kRoundsOfFirst = 4;   ///< in one of so many the search of seed 0 goes on; the others start anew
constexpr std::int64_t kShareOfUnlikely = 4;  ///< of a slice, for overlaps where nothing hints at them
constexpr double kCostNoise = 3;              ///< in every other try: what one prefers in vain is dear in another
constexpr std::int64_t kRestartSlice = 400'000;  ///< units of a search that is to give another plan to start from
constexpr std::int64_t kSpaceWork = 4;           ///< of making a search space, by action, in pieces of Work::kGround
constexpr std::int64_t kCopyWork = 8;            ///< of a task with other actions
constexpr std::int64_t kLandmarkWork = 300'000'000;  ///< word operations
constexpr std::int64_t kBoundSlice = 30'000;         ///< units for the first lower bound,
constexpr std::int64_t kLeastBoundSlice =
    2'000;                                ///< as many as the first plan took and these where no better one is asked for
constexpr std::int64_t kBoundGrowth = 6;  ///< how much longer the next slice for it is,
constexpr std::int64_t kBoundShare = 5;   ///< and how many times as much has then been spent in all
constexpr std::size_t kMostMissing = 5;   ///< numbers that an answer names
constexpr double kSecond = static_cast<double>(kMicrosPerSecond);

using Clock = std::chrono::steady_clock;

/// A ground task with what searches on it need.
struct SearchSpace {
  SearchSpace(const GroundTask& task, Budget& budget)
      : simulator(task), relaxed(simulator, true), landmarks(simulator, relaxed, kLandmarkWork, budget) {
    budget.spend(Work::kGround, kSpaceWork * static_cast<std::int64_t>(task.actions.size()));
    budget.spend(Work::kReach, landmarks.work() / 16);
  }
  Simulator simulator;
  RelaxedTask relaxed;
  Landmarks landmarks;
};

class Planner {
 public:
  Planner(const Task& task, const PlanOptions& options, Budget& budget, Clock::time_point began, GroundTask ground)
      : task_(task),
        options_(options),
        budget_(budget),
        began_(began),
        ground_(std::move(ground)),
        touches_(ground_),
        validator_(task.domain, task.problem) {}

  Expected<PlanAnswer> run() {
    if (ground_.proved_unsolvable) {
      answer_.status = PlanStatus::kUnsolvable;
      answer_.reason = "the goal is out of reach, judged by facts one by one and in pairs" + missing_values();
      return finish();
    }
    sequences_ = std::make_unique<SearchSpace>(ground_, budget_);
    objective_ = std::make_unique<Objective>(sequences_->simulator);
    answer_.by_metric = !objective_->is_makespan();
    answer_.status = PlanStatus::kBudget;
    answer_.reason = "the budget ended before a plan was found";
    if (budget_.late()) return finish();
    whole_ = std::make_unique<SplitTask>(split(ground_, std::vector<char>(ground_.actions.size(), 0)));
    budget_.spend(Work::kGround, kCopyWork * static_cast<std::int64_t>(ground_.actions.size()));
    if (!budget_.late()) warm_start();
    if (!answer_.plan) find_first();
    forget_kept_searches();
    if (answer_.plan) {
      answer_.status = PlanStatus::kPlan;
      if (!options_.anytime) bound_slice_ = std::min(kBoundSlice, std::max(kLeastBoundSlice, budget_.units()));
      raise_bound();
      if (options_.anytime && answer_.by_metric)
        improve_metric();
      else if (options_.anytime)
        improve();
      answer_.reason = !proved_best()      ? "a plan"
                       : answer_.by_metric ? "no plan has a better metric"
                                           : "no plan is shorter";
      if (proved_best() && answer_.bound_assumes_order)
        answer_.reason += " in which no two actions change one fact at one instant";
    }
    return finish();
  }

 private:
  Expected<PlanAnswer> finish() {
    if (unsupported_ && !answer_.plan) return *unsupported_;
    answer_.units = budget_.units();
    return std::move(answer_);
  }

  std::string missing_values() const {
    std::vector<std::string> names;
    for (const int n : ground_.missing_values) names.push_back(number_name(task_, ground_.numbers[n]));
    return names.empty() ? "" : "; without a value in :init, and nothing assigns one: " + some_of(names, kMostMissing);
  }

  bool proved_best() const {
    if (!answer_.plan) return false;
    const Micros separations = kSeparation * static_cast<Micros>(2 * answer_.plan->steps.size());
    if (!answer_.by_metric) return best_makespan_ <= bound_ + separations;
    const double slack = objective_->time_weight() * static_cast<double>(separations) / kSecond;
    return metric_bound_ && answer_.plan->metric &&
           signed_metric(*answer_.plan->metric) <= *metric_bound_ + slack + 1e-9;
  }

  /// From the metric as it is told to the one that is made small, and back.
  double signed_metric(double metric) const { return task_.problem.metric->maximize ? -metric : metric; }

  void raise_bound() {
    if (budget_.late()) return;
    const LowerBound found = lower_bound(ground_, budget_, bound_slice_);
    bound_slice_ = found.complete ? Budget::kUnlimited / kBoundShare : bound_slice_ * kBoundGrowth;
    if (found.makespan < bound_) return;
    bound_ = found.makespan;
    answer_.lower_bound_s = static_cast<double>(bound_) / kSecond;
    answer_.bound_assumes_order = found.assumes_order;
    metric_bound_ = objective_->bound(bound_);
    if (metric_bound_ && answer_.plan->metric) answer_.metric_bound = signed_metric(*metric_bound_);
  }

  /// Hands out a plan if it is the best so far and the validator agrees.
  bool publish(const Concurrent& plan) {
    Stn stn(touches_);
    fill(stn, plan);
    if (!stn.solve_complete(kSeparation) && !stn.solve_complete(0)) return false;
    TimedPlan timed;
    std::vector<int> by_start(plan.steps.size());
    for (std::size_t i = 0; i < by_start.size(); ++i) by_start[i] = static_cast<int>(i);
    std::ranges::stable_sort(by_start, {}, [&](int step) { return stn.start(step); });
    std::vector<int> place(by_start.size());
    for (std::size_t i = 0; i < by_start.size(); ++i) {
      const int step = by_start[i];
      place[step] = static_cast<int>(i);
      const GroundAction& action = ground_.actions[plan.steps[step].action];
      timed.steps.push_back({static_cast<double>(stn.start(step)) / kSecond, action.schema, action.arguments,
                             static_cast<double>(stn.end(step) - stn.start(step)) / kSecond, 0});
    }
    for (Ordering ordering : stn.orderings()) {
      if (ordering.from >= 0) ordering.from = 2 * place[ordering.from / 2] + ordering.from % 2;
      ordering.to = 2 * place[ordering.to / 2] + ordering.to % 2;
      timed.orderings.push_back(ordering);
    }
    return hand_out(std::move(timed), stn.makespan());
  }

  /// Steps at fixed times.
  bool publish(const std::vector<ClockStep>& steps) {
    TimedPlan timed;
    Micros makespan = 0;
    for (const ClockStep& step : steps) {
      const GroundAction& action = ground_.actions[step.action];
      const int point = static_cast<int>(2 * timed.steps.size());
      const Micros length = step.end - step.start;
      timed.steps.push_back({static_cast<double>(step.start) / kSecond, action.schema, action.arguments,
                             static_cast<double>(length) / kSecond, 0});
      timed.orderings.push_back({Ordering::kOrigin, point, step.start, step.start});
      timed.orderings.push_back({point, point + 1, length, length});
      makespan = std::max(makespan, step.end);
    }
    return hand_out(std::move(timed), makespan);
  }

  bool hand_out(TimedPlan timed, Micros makespan) {
    if (answer_.plan && !answer_.by_metric && makespan >= best_makespan_) return false;
    timed.makespan_s = static_cast<double>(makespan) / kSecond;
    timed.latest = latest_times(timed, makespan);
    const Expected<Verdict> verdict = validator_.check(timed.steps);
    budget_.spend(Work::kNode, static_cast<std::int64_t>(10 * timed.steps.size()));
    if (!verdict && verdict.error().code == kUnsupported) unsupported_ = verdict.error();
    if (!verdict || !verdict->valid) {
      ++answer_.refused;
      answer_.refusal = verdict ? verdict->violation->message : verdict.error().text();
      return false;
    }
    timed.metric = verdict->metric;
    const double value =
        answer_.by_metric
            ? Objective::value_of(
                  timed.metric ? signed_metric(*timed.metric) : std::numeric_limits<double>::quiet_NaN(), makespan)
            : static_cast<double>(makespan);
    if (answer_.plan && (value > best_value_ || (value == best_value_ && makespan >= best_makespan_))) return false;
    best_value_ = value;
    best_makespan_ = makespan;
    if (!answer_.plan) answer_.first_plan_s = std::chrono::duration<double>(Clock::now() - began_).count();
    answer_.plan = std::move(timed);
    if (options_.on_plan) options_.on_plan(*answer_.plan, budget_.units());
    return true;
  }

  static std::vector<Micros> latest_times(const TimedPlan& plan, Micros makespan) {
    std::vector<Micros> latest(2 * plan.steps.size(), makespan);
    for (bool changed = true; changed;) {
      changed = false;
      for (const Ordering& ordering : plan.orderings) {
        const auto lower = [&](int point, Micros to) {
          if (point >= 0 && to < latest[point]) latest[point] = to, changed = true;
        };
        lower(ordering.from, latest[ordering.to] - ordering.least);
        if (ordering.most < DurationRange::kForever)
          lower(ordering.to, (ordering.from < 0 ? 0 : latest[ordering.from]) + ordering.most);
      }
    }
    return latest;
  }

  /// A plan of whole actions.
  void take(const Sequence& sequence) {
    if (best_sequence_.empty()) best_sequence_ = sequence;
    publish(SplitCheck(*whole_, ground_, touches_).translate(sequence));
  }

  bool has_durations() const { return std::ranges::any_of(ground_.actions, &GroundAction::durative); }

  LazyOptions lazy_options(std::uint64_t seed) const {
    LazyOptions options;
    options.seed = seed;
    options.late_goal = late_goal_;
    options.random_choice = seed == 0 ? 0 : 0.05;
    if (seed % 2 == 1) options.cost_noise = kCostNoise;
    options.most_words =
        options_.most_memory_mb * 1024 * 1024 / 8 / (has_durations() ? 4 : 2);  // searches alive at the same time
    return options;
  }

  /// `in_time`: sequences that come too late for events are given up at once. `keep`: the first one goes on.
  SearchEnd search_sequences(std::uint64_t seed, std::int64_t slice, bool in_time, Sequence& found, bool keep = false) {
    KeptSearch once;
    PathCheck* check = in_time && !ground_.events.empty() ? &event_check_ : nullptr;
    budget_.set_slice(budget_.units() + slice);
    const SearchEnd end = (keep ? first_ : once)
                              .go_on(sequences_->simulator, sequences_->relaxed, sequences_->landmarks, check,
                                     lazy_options(seed), budget_, found);
    budget_.clear_slice();
    return end;
  }

  /// Searches with actions cut in two.
  struct Cut {
    std::unique_ptr<SplitTask> split;
    std::unique_ptr<SearchSpace> space;
    std::unique_ptr<SplitCheck> check;
    KeptSearch first;
    bool exhausted = false;
  };

  Cut make_cut(bool all) {
    std::vector<char> marked;
    const PackedState initial = sequences_->simulator.initial();
    for (const GroundAction& action : ground_.actions) {
      const std::optional<DurationRange> range =
          sequences_->simulator.durations(static_cast<int>(marked.size()), initial.data());
      const bool lasts = !range || range->most >= kSeparation;
      marked.push_back(lasts && can_be_cut(ground_, action) && (all || is_envelope(ground_, action)));
    }
    Cut cut;
    if (budget_.late() || std::ranges::find(marked, 1) == marked.end()) {
      cut.exhausted = true;
      return cut;
    }
    cut.split = std::make_unique<SplitTask>(split(with_lasting_facts(ground_), marked));
    if (!budget_.late()) cut.space = std::make_unique<SearchSpace>(cut.split->task, budget_);
    if (budget_.late())
      cut.exhausted = true;
    else
      cut.check = std::make_unique<SplitCheck>(*cut.split, ground_, touches_);
    budget_.spend(Work::kGround, 2 * kCopyWork * static_cast<std::int64_t>(ground_.actions.size()));
    return cut;
  }

  void forget_kept_searches() {
    first_.forget();
    for (std::optional<Cut>* cut : {&envelopes_, &everything_})
      if (*cut) (*cut)->first.forget();
  }

  bool search_cut(Cut& cut, std::uint64_t seed, std::int64_t slice) {
    if (cut.exhausted) return false;
    KeptSearch once;
    const bool keep = seed % kRoundsOfFirst == 0 && !answer_.plan;
    Sequence found;
    budget_.set_slice(budget_.units() + slice);
    const SearchEnd end = (keep ? cut.first : once)
                              .go_on(cut.space->simulator, cut.space->relaxed, cut.space->landmarks, cut.check.get(),
                                     lazy_options(seed), budget_, found);
    budget_.clear_slice();
    cut.exhausted = is_exhausted(end);
    note(end);
    if (end != SearchEnd::kFound) return false;
    if (publish(cut.check->translate(found))) best_cut_ = {&cut, std::move(found)};
    return answer_.plan.has_value();
  }

  /// Searches along the clock, where actions cannot be cut.
  bool search_clock(std::uint64_t seed, std::int64_t slice) {
    if (clock_exhausted_ || budget_.late()) return false;
    if (!clock_) {
      const auto must_be_whole = [this](const GroundAction& action) {
        return action.durative && !can_be_cut(ground_, action);
      };
      clock_exhausted_ = std::ranges::none_of(ground_.actions, must_be_whole);
      if (clock_exhausted_) return false;
      clock_ = std::make_unique<ClockSearch>(ground_, sequences_->simulator, touches_);
    }
    budget_.set_slice(budget_.units() + slice);
    const SearchEnd end = clock_->run(lazy_options(seed), answer_.by_metric ? DurationRange::kForever : best_makespan_,
                                      budget_, [this](const std::vector<ClockStep>& steps) { return publish(steps); });
    budget_.clear_slice();
    note(end);
    clock_exhausted_ = is_exhausted(end);
    return end == SearchEnd::kFound;
  }

  /// Every search has ended without a plan: looks whether any order of happenings reaches the goal, whatever their
  /// times.
  void prove_unsolvable() {
    if (ground_.events.empty() && !has_durations()) {
      answer_.status = PlanStatus::kUnsolvable;  // the search over sequences has seen every order
      answer_.reason = "no order of actions reaches the goal";
      return;
    }
    answer_.status = PlanStatus::kEnded;
    answer_.reason = "no plan was found by any search; that none exists is not proved";
    const std::optional<GroundTask> relaxed = untimed(ground_, Ends::kAsBegun);
    if (!relaxed) return;
    const SearchSpace space(*relaxed, budget_);
    LazySearch search(space.simulator, space.relaxed, space.landmarks);
    Sequence found;
    const SearchEnd end = search.run(space.simulator.initial(), lazy_options(0), budget_, found);
    if (end == SearchEnd::kExhausted) {
      answer_.status = PlanStatus::kUnsolvable;
      answer_.reason = "no order of happenings reaches the goal, whatever their times";
    } else if (end == SearchEnd::kBudget) {
      answer_.status = PlanStatus::kBudget;
      answer_.reason = "the budget ended before a plan was found";
    }
  }

  /// Looks for a sequence without regard to when events end what it needs, and moves its actions until they are in
  /// time.
  bool mend_late(std::uint64_t seed, std::int64_t slice) {
    Sequence found;
    const SearchEnd end = search_sequences(seed, slice, false, found);
    note(end);
    if (end != SearchEnd::kFound) return false;
    Decoder decoder(*whole_, ground_, sequences_->simulator, touches_, *objective_);
    const SplitCheck check(*whole_, ground_, touches_);
    const auto on_better = [&](const DecodedPlan& plan) {
      if (!answer_.plan && publish(check.translate(plan.order)))
        best_sequence_ = plan.order, budget_.set_slice(budget_.units());
    };
    const RelaxedTask timed(sequences_->simulator, false);
    const std::int64_t until = budget_.units() + 2 * slice;
    for (std::uint64_t round = 0; !answer_.plan && budget_.units() < until && !budget_.over(); ++round) {
      budget_.set_slice(until);
      LocalSearch local(decoder, seed + round);
      if (!local.start(found)) break;
      if (local.best().lateness == 0) on_better(local.best());
      local.run(budget_, 1000, on_better);
      Rebuild rebuild(decoder, timed, seed + round);
      if (answer_.plan || !rebuild.start(local.best().order)) break;
      rebuild.run(budget_, 100, on_better);
      found = rebuild.best().order;
    }
    budget_.clear_slice();
    return answer_.plan.has_value();
  }

  /// Whether a search has nothing more to give, however the goal may come about.
  bool is_exhausted(SearchEnd end) {
    if (end == SearchEnd::kExhausted && !late_goal_) early_exhausted_ = true;
    return end == SearchEnd::kExhausted && (late_goal_ || ground_.events.empty());
  }

  void note(SearchEnd end) { out_of_memory_ |= end == SearchEnd::kMemory; }

  void find_first() {
    bool sequences_exhausted = false;
    std::int64_t slice =
        std::max(kFirstSlice, kSliceOfOperator * static_cast<std::int64_t>(sequences_->relaxed.operators().size()));
    for (std::uint64_t round = 0; !budget_.over() && !unsupported_;
         ++round, slice = std::min(slice + slice / 2, kLongestSlice)) {
      const std::uint64_t seed = round;
      // Plans after whose last action events bring about the goal only where there seem to be no others.
      late_goal_ = !ground_.events.empty() && (early_exhausted_ || round % 2 == 1);
      if (!sequences_exhausted) {
        Sequence found;
        const SearchEnd end = search_sequences(seed, slice, true, found, seed % kRoundsOfFirst == 0);
        note(end);
        if (end == SearchEnd::kFound) take(found);
        if (answer_.plan) return;
        sequences_exhausted = is_exhausted(end);
      }
      if (!ground_.events.empty() && mend_late(seed, slice)) return;
      if (!envelopes_) envelopes_ = make_cut(false);
      if (search_cut(*envelopes_, seed, slice)) return;
      if (search_clock(seed, slice)) return;
      if (round == 0 && !(sequences_exhausted && envelopes_->exhausted)) continue;
      if (!everything_) everything_ = make_cut(true);
      const bool likely =
          envelopes_->split != nullptr || round == 1;  // something needs others to be under way, or never tried
      if (search_cut(*everything_, seed, likely ? slice : slice / kShareOfUnlikely)) return;
      if (!budget_.late() && sequences_exhausted && envelopes_->exhausted && everything_->exhausted &&
          clock_exhausted_) {
        prove_unsolvable();
        return;
      }
    }
    if (out_of_memory_ && !budget_.over()) answer_.status = PlanStatus::kMemory;
  }

  /// Takes what is left of a plan under execution; after it a search fills in what is missing.
  void warm_start() {
    if (options_.warm_start.empty() || !ground_.events.empty()) return;
    Remainder remainder(sequences_->simulator, budget_);
    Remainder::Done done = remainder.of(options_.warm_start);
    if (!remainder.is_goal(done)) {
      Sequence rest;
      LazySearch search(sequences_->simulator, sequences_->relaxed, sequences_->landmarks);
      budget_.set_slice(budget_.units() + kRestartSlice);
      const SearchEnd end = search.run(done.state, lazy_options(0), budget_, rest);
      budget_.clear_slice();
      if (end != SearchEnd::kFound) return;
      done.steps.insert(done.steps.end(), rest.begin(), rest.end());
    }
    take(remainder.without_needless(std::move(done.steps)));
  }

  void improve() {
    // Rounds: another first plan, or the best one; then what rebuilds it, and local search, now on whole actions, now
    // on parts.
    if (budget_.late()) return;
    const RelaxedTask timed(sequences_->simulator, false);
    Decoder decoder(*whole_, ground_, sequences_->simulator, touches_, *objective_);
    const SplitCheck check(*whole_, ground_, touches_);
    const auto on_better = [&](const DecodedPlan& plan) {
      if (plan.value < best_value_ && publish(check.translate(plan.order))) best_sequence_ = plan.order;
    };
    std::int64_t idle = 2000;
    for (std::uint64_t round = 0; !budget_.over() && !proved_best(); ++round) {
      if (budget_.units() > kBoundShare * bound_slice_) {
        raise_bound();
        continue;
      }
      Sequence from = best_sequence_;
      if (round % 4 == 3) {
        Sequence found;
        if (search_sequences(round, kRestartSlice, false, found) == SearchEnd::kFound) from = std::move(found);
      }
      if (round % 4 == 2) search_clock(round, kRestartSlice);
      if (from.empty()) {
        if (!best_cut_.first) {
          if (clock_exhausted_) return;
          search_clock(round, kRestartSlice);
          continue;
        }
        if (round % 4 == 3) search_cut(*best_cut_.first, round, kRestartSlice);
        improve_cut(*best_cut_.first, best_cut_.second, round, idle);
        idle += idle / 4;
        continue;
      }
      if (round % 4 == 1) {
        improve_parts(from, round, idle);
        continue;
      }
      LocalSearch local(decoder, round + 1);
      if (!local.start(from)) continue;
      const std::int64_t before = budget_.units();
      local.run(budget_, idle, on_better);
      Rebuild rebuild(decoder, timed, round + 1);
      if (!rebuild.start(local.best().order)) continue;
      budget_.set_slice(budget_.units() + std::max<std::int64_t>(20'000, budget_.units() - before));
      rebuild.run(budget_, idle, on_better);
      budget_.clear_slice();
      if (round % 8 == 7) idle += idle / 2;
    }
  }

  /// Improvement by the metric. Rounds: local search and rebuilding on whole actions, local search on parts, searches
  /// for sequences of both kinds whose numbers leave room for a better metric.
  void improve_metric() {
    if (budget_.late()) return;
    const RelaxedTask priced(sequences_->simulator, objective_->prices());
    Decoder decoder(*whole_, ground_, sequences_->simulator, touches_, *objective_);
    const SplitCheck check(*whole_, ground_, touches_);
    if (!everything_) everything_ = make_cut(true);
    const auto on_better = [&](const DecodedPlan& plan) {
      if (plan.value < best_value_ && publish(check.translate(plan.order))) best_sequence_ = plan.order, best_cut_ = {};
    };
    bool searched_all = false, searched_parts = everything_->exhausted;  // there is nothing better than the best plan
    std::int64_t idle = 2000;
    for (std::uint64_t round = 0; !budget_.over() && !proved_best(); ++round) {
      const int kind = static_cast<int>(round % 4);
      Sequence from = kind == 3 ? Sequence{} : best_sequence_;
      if (kind == 1) {
        if (best_cut_.first)
          improve_cut(*best_cut_.first, best_cut_.second, round, idle);
        else if (!everything_->exhausted && !from.empty())
          improve_cut(*everything_, to_parts(*everything_->split, from), round, idle);
      } else if (kind == 3 && !searched_parts) {
        SplitCheck parts(*everything_->split, ground_, touches_);
        searched_parts = search_for_better(everything_->split->task, &parts, round, from) == SearchEnd::kExhausted;
        if (!from.empty() && publish(parts.translate(from))) best_cut_ = {&*everything_, std::move(from)};
      } else if (kind == 0 || kind == 2) {
        if (kind == 2 && !searched_all)
          searched_all = search_for_better(ground_, nullptr, round, from) == SearchEnd::kExhausted;
        if (kind == 2) search_clock(round, kRestartSlice);
        LocalSearch local(decoder, round + 1);
        if (from.empty() || !local.start(from)) {
          if (searched_all && searched_parts && clock_exhausted_ && from.empty()) return;
          continue;
        }
        const std::int64_t began = budget_.units();
        if (local.best().lateness == 0) on_better(local.best());
        local.run(budget_, idle, on_better);
        Rebuild rebuild(decoder, priced, round + 1);
        if (!rebuild.start(local.best().order)) continue;
        budget_.set_slice(budget_.units() + std::max<std::int64_t>(20'000, budget_.units() - began));
        rebuild.run(budget_, idle, on_better);
        budget_.clear_slice();
        if (kind == 2) idle += idle / 2;
      }
    }
  }

  SearchEnd search_for_better(const GroundTask& base, PathCheck* check, std::uint64_t seed, Sequence& found) {
    const std::optional<double> metric = answer_.plan->metric;
    std::optional<GroundComparison> better =
        metric ? objective_->better_than(signed_metric(*metric), bound_) : std::nullopt;
    if (!better) return SearchEnd::kExhausted;
    if (budget_.late()) return SearchEnd::kBudget;
    GroundTask task = base;
    task.goal.comparisons.push_back(static_cast<int>(task.comparisons.size()));
    task.comparisons.push_back(std::move(*better));
    const Simulator simulator(task);
    if (budget_.late()) return SearchEnd::kBudget;
    const RelaxedTask relaxed(simulator, Objective(simulator).prices());
    const Landmarks none(simulator, relaxed, 0, budget_);
    LazySearch search(simulator, relaxed, none, check);
    LazyOptions options = lazy_options(seed);
    options.landmarks = false;
    Sequence sequence;
    budget_.set_slice(budget_.units() + kRestartSlice);
    const SearchEnd end = search.run(simulator.initial(), options, budget_, sequence);
    budget_.clear_slice();
    if (end == SearchEnd::kFound) found = std::move(sequence);
    return end;
  }

  void improve_parts(const Sequence& from, std::uint64_t round, std::int64_t idle) {
    if (!everything_) everything_ = make_cut(true);
    if (!everything_->exhausted) improve_cut(*everything_, to_parts(*everything_->split, from), round, idle);
  }

  void improve_cut(Cut& cut, const Sequence& from, std::uint64_t round, std::int64_t idle) {
    Decoder decoder(*cut.split, ground_, cut.space->simulator, touches_, *objective_);
    LocalSearch local(decoder, round + 1);
    if (!local.start(from)) return;
    const SplitCheck check(*cut.split, ground_, touches_);
    local.run(budget_, idle, [&](const DecodedPlan& plan) {
      if (plan.value < best_value_ && publish(check.translate(plan.order)) && (best_cut_.first || answer_.by_metric))
        best_cut_ = {&cut, plan.order};
    });
  }

  const Task& task_;
  const PlanOptions& options_;
  Budget& budget_;
  const Clock::time_point began_;
  GroundTask ground_;
  Touches touches_;
  Validator validator_;
  std::unique_ptr<SearchSpace> sequences_;  ///< of whole actions
  EventCheck event_check_{touches_};
  KeptSearch first_;                  ///< for sequences
  std::unique_ptr<SplitTask> whole_;  ///< nothing is cut
  std::optional<Cut> envelopes_, everything_;
  std::pair<Cut*, Sequence> best_cut_{nullptr,
                                      {}};  ///< the best plan as a sequence of parts, where no sequence was found
  std::unique_ptr<ClockSearch> clock_;
  bool clock_exhausted_ = false;
  bool late_goal_ = false;        ///< searches take plans after which events bring about the goal
  bool early_exhausted_ = false;  ///< a search for other plans has come to its end
  PlanAnswer answer_;
  Sequence best_sequence_;
  std::unique_ptr<Objective> objective_;
  double best_value_ = std::numeric_limits<double>::infinity();  ///< of the objective
  Micros best_makespan_ = DurationRange::kForever, bound_ = 0;
  std::optional<double> metric_bound_;  ///< of the metric that is made small
  std::int64_t bound_slice_ = kBoundSlice;
  bool out_of_memory_ = false;
  std::optional<Error> unsupported_;  ///< what the validator cannot judge
};

}  // namespace

Expected<PlanAnswer> find_plan(const Task& task, const PlanOptions& options) {
  const Clock::time_point began = Clock::now();
  Budget budget(options.budget, options.timeout_s);
  Expected<GroundTask> made = ground(task, budget);
  if (!made && made.error().code == kOutOfBudget) {
    PlanAnswer answer;
    answer.status = PlanStatus::kBudget;
    answer.reason = made.error().message;
    answer.units = budget.units();
    return answer;
  }
  if (!made) return made.error();
  return Planner(task, options, budget, began, std::move(*made)).run();
}

}  // namespace cxlab::planner
