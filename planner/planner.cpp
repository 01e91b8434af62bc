#include "planner/planner.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include "planner/ground/ground.h"
#include "planner/pddl/text.h"
#include "planner/strategies/clock_strategy.h"
#include "planner/strategies/happening_strategy.h"
#include "planner/strategies/improvement.h"
#include "planner/strategies/late_repair.h"
#include "planner/strategies/sequence_search.h"
#include "planner/strategies/unsolvable.h"
#include "planner/strategies/warm_start.h"

namespace cxlab::planner {

namespace {

constexpr std::int64_t kFirstTurn = 20'000;  ///< units, at least; the turns of each round are half as long again
constexpr std::int64_t kLongestTurn = 1'000'000'000'000;
constexpr std::int64_t kTurnOfOperator = 20;            ///< units of the first turn by operator
constexpr std::int64_t kShareOfUnlikely = 4;            ///< of a turn, for overlaps where nothing hints at them
constexpr std::int64_t kSearchTurn = 400'000;           ///< units of a search that is to give another plan to improve
constexpr std::int64_t kHappeningsTurn = 20'000;        ///< units of a search for better orders of happenings
constexpr std::int64_t kUnitsOfHappenings = 2'000'000;  ///< when all other searches have come to their end
constexpr std::int64_t kShareBeforeRepair = 8;  ///< of the first turn, where a plan may come too late for events
constexpr std::int64_t kShareOfWarmStart = 8;   ///< of the budget, for each half of a warm start
constexpr std::int64_t kIdle = 2000;            ///< moves without a better plan that end the first improvements
constexpr std::uint64_t kKindsOfRounds = 4;     ///< of improvement
constexpr std::size_t kMostMissing = 5;         ///< numbers that an answer names
constexpr std::int64_t kUnitsOfExplanation = 5'000'000;

const Conclusion kProvedByHappenings = {PlanStatus::kUnsolvable,
                                        "no order of starts, ends and events reaches the goal"};

/// Strategies in turns, until a plan is found and proved best or the budget ends.
class Portfolio {
 public:
  explicit Portfolio(PlanningContext& context) : context_(context) {}

  Conclusion run();

 private:
  void find_first();
  bool prove_in(const Turn& turn);
  bool prove_by_happenings(const Turn& turn);
  bool finish_happenings(const Turn& turn);
  void improve_makespan();
  void improve_metric();
  bool is_improving(std::uint64_t round);

  PlanningContext& context_;
  SequenceSearch sequences_{context_, Cut::kNothing}, envelopes_{context_, Cut::kEnvelopes},
      everything_{context_, Cut::kEverything};
  ClockStrategy clock_{context_};
  HappeningStrategy happenings_{context_, false}, better_happenings_{context_, true};
  std::optional<Conclusion> proof_;    ///< tried to its end
  std::int64_t units_of_rounds_ = -1;  ///< when the last rounds of all kinds began
  Conclusion without_plan_{PlanStatus::kBudget, "the budget ended before a plan was found"};
};

/// Each strategy has one turn in a round, and turns become longer.
void Portfolio::find_first() {
  std::int64_t units = kTurnOfOperator * static_cast<std::int64_t>(context_.whole.space.relaxed.operators().size());
  units = std::max(kFirstTurn, units);
  std::int64_t spent = -1;
  for (std::uint64_t round = 0; !context_.is_over(); ++round, units = std::min(units + units / 2, kLongestTurn)) {
    if (round > 1 && std::exchange(spent, context_.budget.units()) == context_.budget.units()) {
      without_plan_.reason = "the searches find nothing but plans that the validator refuses";
      return;
    }
    const Turn turn{round, units};
    const bool repairs = context_.has_events();
    if (sequences_.run({round, repairs && round == 0 ? units / kShareBeforeRepair : units})) return;
    if (repairs && repair_late(context_, sequences_, turn)) return;
    if (envelopes_.run(turn)) return;
    if (clock_.run(turn)) return;
    if (happenings_.run(turn)) return;
    if (happenings_.exhausted() && prove_by_happenings(turn)) return;
    if (sequences_.exhausted() && prove_in(turn)) return;
    if (round == 0 && !(sequences_.exhausted() && envelopes_.exhausted())) continue;
    const bool likely = envelopes_.space() || round == 1;  // something needs other actions to run, or it was never
                                                           // tried
    if (everything_.run({round, likely ? units : units / kShareOfUnlikely})) return;
    if (!context_.budget.late() && sequences_.exhausted() && envelopes_.exhausted() && everything_.exhausted() &&
        clock_.exhausted()) {
      const Conclusion conclusion = proof_ ? *proof_ : prove_unsolvable(context_);
      if (conclusion.status != PlanStatus::kUnsolvable && finish_happenings(turn)) return;
      if (!context_.budget.over()) without_plan_ = conclusion;
      return;
    }
  }
}

/// If no list of whole actions is a plan, the search for overlaps may never end: tries to prove that no plan exists at
/// all.
bool Portfolio::prove_in(const Turn& turn) {
  if (!context_.has_durations || proof_) return false;
  const BudgetSlice slice(context_.budget, turn.units);
  const Conclusion conclusion = prove_unsolvable(context_);
  if (conclusion.status == PlanStatus::kBudget) return false;
  proof_ = conclusion;
  if (conclusion.status != PlanStatus::kUnsolvable) return false;
  without_plan_ = conclusion;
  return true;
}

/// Whether no plan exists, or at least none that a search could find.
bool Portfolio::prove_by_happenings(const Turn& turn) {
  if (happenings_.prove(turn)) {
    without_plan_ = kProvedByHappenings;
    return true;
  }
  if (!happenings_.has_ended_proof() || !happenings_.has_seen_all()) return false;
  if (sequences_.exhausted() && !proof_ && !prove_in(turn) && !proof_) return false;
  without_plan_ = proof_ && proof_->status == PlanStatus::kUnsolvable ? *proof_ : kNoPlan;
  return true;
}

/// All other searches have come to their end: the happenings go on for a while. Whether that gave an answer.
bool Portfolio::finish_happenings(const Turn& turn) {
  const BudgetSlice slice(context_.budget, kUnitsOfHappenings);
  while (!context_.budget.slice_over() && !context_.budget.late() &&
         !(happenings_.exhausted() && happenings_.has_ended_proof())) {
    if (happenings_.run(turn)) return true;
    if (!happenings_.prove(turn)) continue;
    without_plan_ = kProvedByHappenings;
    return true;
  }
  return false;
}

/// False as well when a round of each kind had nothing to do.
bool Portfolio::is_improving(std::uint64_t round) {
  Budget& budget = context_.budget;
  if (round % kKindsOfRounds == 0 && std::exchange(units_of_rounds_, budget.units()) == budget.units()) return false;
  return !budget.over() && !context_.bound.proves(context_.best);
}

/// Four kinds of rounds. The best plan may be one that no list of whole actions gives; then its parts are improved.
void Portfolio::improve_makespan() {
  if (context_.budget.late()) return;
  Improvement improve(context_);
  std::int64_t idle = kIdle;
  for (std::uint64_t round = 0; is_improving(round); ++round) {
    if (context_.bound.is_due()) {
      context_.bound.raise();
      continue;
    }
    const Turn turn{round, kSearchTurn};
    const auto kind = round % kKindsOfRounds;
    if (kind == 2) {
      clock_.run(turn);
      better_happenings_.run({round, kHappeningsTurn});
      if (better_happenings_.has_seen_all()) return;
    }
    std::optional<Sequence> other = kind == 3 ? sequences_.find(turn) : std::nullopt;
    const Sequence list = other ? *std::move(other) : context_.best_list();
    if (!list.empty() && kind == 1) {
      if (everything_.space() && !everything_.exhausted())
        improve.of_parts(*everything_.space(), to_parts(everything_.space()->split, list), round, idle);
    } else if (!list.empty()) {
      improve.of_list(list, round, idle);
    } else if (const SplitSpace* cut = context_.best_parts().cut) {
      if (kind == 3) (cut == envelopes_.space() ? envelopes_ : everything_).run(turn);
      improve.of_parts(*cut, context_.best_parts().list, round, idle);
      idle += idle / 4;
    } else if (clock_.exhausted() && better_happenings_.exhausted()) {
      return;
    } else {
      clock_.run(turn);
    }
  }
}

/// The same with searches for lists whose numbers leave room for a better metric.
void Portfolio::improve_metric() {
  if (context_.budget.late()) return;
  Improvement improve(context_);
  BetterMetricSearch better_list(context_, context_.whole);
  std::optional<BetterMetricSearch> better_parts;
  const SplitSpace* all = everything_.space();
  if (all && !everything_.exhausted()) better_parts.emplace(context_, *all);
  std::int64_t idle = kIdle;
  for (std::uint64_t round = 0; is_improving(round); ++round) {
    const Turn turn{round, kSearchTurn};
    const auto kind = round % kKindsOfRounds;
    if (kind == 3) {
      const auto found = better_parts ? better_parts->run(turn) : std::nullopt;
      if (found) context_.offer(*all, *found);
    } else if (kind == 1 && context_.best_parts().cut) {
      improve.of_parts(*context_.best_parts().cut, context_.best_parts().list, round, idle);
    } else if (kind == 1) {
      if (better_parts && !context_.best_list().empty())
        improve.of_parts(*all, to_parts(all->split, context_.best_list()), round, idle);
    } else {
      std::optional<Sequence> other = kind == 2 ? better_list.run(turn) : std::nullopt;
      if (kind == 2) {
        clock_.run(turn);
        better_happenings_.run({round, kHappeningsTurn});
        if (better_happenings_.has_seen_all()) return;
      }
      const Sequence list = other ? *std::move(other) : context_.best_list();
      const bool improved = improve.of_list(list, round, idle);
      if (improved && kind == 2) idle += idle / 2;
      const bool others = !better_list.exhausted() || (better_parts && !better_parts->exhausted());
      if (list.empty() && !others && clock_.exhausted() && better_happenings_.exhausted()) return;
    }
  }
}

Conclusion Portfolio::run() {
  PlanningContext& context = context_;
  const std::int64_t warm_turn = std::min(kSearchTurn, context.options.budget / kShareOfWarmStart);
  if (!context.budget.late() && !warm_start(context, warm_turn)) find_first();
  sequences_.forget();
  envelopes_.forget();
  everything_.forget();
  happenings_.forget();
  if (!context.best.exists()) return without_plan_;
  if (!context.options.anytime || context.best.by_metric()) context.bound.keep_first_slice_short();
  if (context.options.bound || !context.best.by_metric() || context.bound.may_prove(context.best))
    context.bound.raise();
  if (context.options.anytime) context.best.by_metric() ? improve_metric() : improve_makespan();
  if (!context.bound.proves(context.best)) return {PlanStatus::kPlan, "a plan"};
  std::string reason = context.best.by_metric() ? "no plan has a better metric" : "no plan is shorter";
  if (context.bound.assumes_order()) reason += " in which no two actions change one fact at one instant";
  return {PlanStatus::kPlan, reason};
}

/// What the reason of an unsolvable problem adds about numbers without a value.
std::string missing_values(const Task& task, const GroundTask& ground) {
  std::vector<std::string> names;
  for (const int n : ground.missing_values) {
    const auto& [function, objects] = ground.numbers[n];
    names.push_back(ground_text(task.domain.functions[function].name, objects, task.problem.objects));
  }
  return names.empty() ? "" : "; without a value in :init, and nothing assigns one: " + some_of(names, kMostMissing);
}

}  // namespace

Expected<PlanAnswer> find_plan(const Task& task, const PlanOptions& options) {
  const auto began = Incumbent::Clock::now();
  Budget budget(options.budget, options.timeout_s, options.patience);
  PlanAnswer answer;
  const auto conclude = [&](Conclusion conclusion) {
    answer.status = conclusion.status;
    answer.reason = std::move(conclusion.reason);
    answer.units = budget.units();
    return std::move(answer);
  };
  Expected<GroundTask> made = ground(task, budget);
  if (!made && is(made.error(), Failure::kOutOfBudget)) return conclude({PlanStatus::kBudget, made.error().message});
  if (!made) return made.error();
  if (made->proved_unsolvable) {
    std::optional<double> seconds_left = options.timeout_s;
    if (seconds_left) *seconds_left -= std::chrono::duration<double>(Incumbent::Clock::now() - began).count();
    Budget rest(std::min(options.budget - budget.units(), kUnitsOfExplanation), seconds_left);
    answer.out_of_reach = explain_out_of_reach(task, rest, options.initial_state);
    return conclude({PlanStatus::kUnsolvable, "the goal is out of reach, judged by facts one by one and in pairs" +
                                                  missing_values(task, *made)});
  }
  PlanningContext context(task, options, budget, *std::move(made), began);
  Conclusion conclusion = Portfolio(context).run();
  context.bound.report(context.best, answer);
  std::move(context.best).report(answer);
  return conclude(std::move(conclusion));
}

}  // namespace cxlab::planner
