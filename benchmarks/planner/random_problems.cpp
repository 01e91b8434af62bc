// Plans random temporal problems with numbers, continuous change and events. Compares the answers with a search that
// tries all plans of up to three actions and shares no code with the planner. Prints how many problems have a plan, a
// proof or neither, which answers are wrong, and which problems take the most CPU time for their units of work.
//
//   bench_random_problems KIND FIRST COUNT [BUDGET]   seeds FIRST .. FIRST + COUNT - 1; BUDGET: units each, 4,000,000
//   bench_random_problems KIND show SEED              the problem and a plan that the search for witnesses finds
//
// KIND: numeric (tests/planner/random/numeric_problem.h) or wide (wide_problem.h).
//
// Exit code 1: an answer is wrong. It is a proof that a solvable problem has no plan, or a plan that the validator
// refuses. Or it is no plan after 2 s of CPU time, although the search finds one.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <functional>
#include <string>

#include "planner/pddl/parser.h"
#include "planner/planner.h"
#include "planner/validator/validator.h"
#include "tests/planner/random/numeric_problem.h"
#include "tests/planner/random/wide_problem.h"

using namespace cxlab;
using namespace cxlab::planner;

namespace {

constexpr double kMostSeconds = 2;          ///< for a plan
constexpr std::size_t kListed = 10;         ///< problems with the highest ratios
constexpr std::int64_t kFewUnits = 20'000;  ///< too few to say what a unit takes

double cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

struct Witness {
  std::optional<std::string> plan;
  bool too_large = false;
};

struct Drawn {
  std::string domain, problem;
  std::function<Witness()> witness;
};

Drawn draw_numeric(std::uint64_t seed) {
  RandomStream random(seed, "random temporal-numeric problems");
  NumericProblem drawn = NumericProblem::draw(random);
  return {drawn.domain(), drawn.problem(), [drawn] {
            const WitnessAnswer found = find_witness(drawn);
            return Witness{found.plan ? std::optional(to_text(*found.plan)) : std::nullopt, found.too_large};
          }};
}

Drawn draw_wide(std::uint64_t seed) {
  RandomStream random(seed, "random temporal-numeric problems");
  WideProblem drawn = WideProblem::draw(random);
  return {drawn.domain(), drawn.problem(), [drawn] {
            WideAnswer found = find_witness(drawn);
            return Witness{std::move(found.plan), found.too_large};
          }};
}

using Draw = Drawn (*)(std::uint64_t seed);

Expected<Task> parse(const Drawn& drawn) {
  Expected<Domain> domain = parse_domain(drawn.domain, "domain");
  if (!domain) return domain.error();
  Expected<Problem> parsed = parse_problem(drawn.problem, "problem", *domain);
  if (!parsed) return parsed.error();
  return Task{*std::move(domain), *std::move(parsed)};
}

struct Spent {
  std::uint64_t seed = 0;
  double seconds = 0;
  std::int64_t units = 0;
  double microseconds_a_unit() const { return seconds * 1e6 / static_cast<double>(std::max(units, kFewUnits)); }
};

struct Tally {
  int plans = 0, proofs = 0, ended = 0, out_of_budget = 0;
  int all_tried = 0;  ///< without a plan, and the search for witnesses has tried everything
  int wrong = 0;
  int refused = 0;  ///< problems with a plan that the planner's own validator refused on the way
  double slowest_plan_s = 0;
  std::vector<Spent> spent;
};

int show(Draw draw, std::uint64_t seed) {
  const Drawn problem = draw(seed);
  std::printf("%s%s", problem.domain.c_str(), problem.problem.c_str());
  const Witness witness = problem.witness();
  if (witness.plan)
    std::printf("; witness\n%s", witness.plan->c_str());
  else
    std::printf("; no witness%s\n", witness.too_large ? ", not all was tried" : "");
  return 0;
}

/// The fault of an answer; nullptr if it has none.
const char* judge(const Drawn& problem, const Task& task, const PlanAnswer& answer, double seconds, Tally& tally) {
  const Validator validator(task.domain, task.problem);
  tally.refused += answer.refused > 0;
  if (answer.plan) {
    ++tally.plans;
    tally.slowest_plan_s = std::max(tally.slowest_plan_s, seconds);
    const Expected<Verdict> verdict = validator.check(answer.plan->steps);
    if (!verdict || !verdict->valid) return "the plan is not valid";
    if (answer.plan->makespan_s < answer.lower_bound_s - 1e-6) return "the bound is above the plan";
    if (seconds <= kMostSeconds) return nullptr;
    return problem.witness().plan ? "the plan took too long" : nullptr;
  }
  const bool proved = answer.status == PlanStatus::kUnsolvable;
  tally.proofs += proved;
  tally.ended += answer.status == PlanStatus::kEnded;
  tally.out_of_budget += answer.status == PlanStatus::kBudget;
  const Witness witness = problem.witness();
  tally.all_tried += !witness.plan && !witness.too_large;
  if (!witness.plan) return nullptr;
  const auto plan = parse_plan(*witness.plan, "witness", task.domain, task.problem);
  const Expected<Verdict> verdict = plan ? validator.check(*plan) : Expected<Verdict>(plan.error());
  if (!verdict || !verdict->valid) return "the validator refuses the witness";
  return proved ? "a false proof" : "a plan was missed";
}

int run(Draw draw, std::uint64_t first, int count, std::int64_t budget) {
  Tally tally;
  for (std::uint64_t seed = first; seed < first + static_cast<std::uint64_t>(count); ++seed) {
    const Drawn problem = draw(seed);
    const Expected<Task> task = parse(problem);
    if (!task) {
      std::printf("%llu: %s\n", static_cast<unsigned long long>(seed), task.error().text().c_str());
      ++tally.wrong;
      continue;
    }
    const double before = cpu_s();
    const Expected<PlanAnswer> answer = find_plan(*task, {.budget = budget});
    const double seconds = cpu_s() - before;
    if (!answer) {
      std::printf("%llu: %s\n", static_cast<unsigned long long>(seed), answer.error().text().c_str());
      ++tally.wrong;
      continue;
    }
    tally.spent.push_back({seed, seconds, answer->units});
    if (const char* fault = judge(problem, *task, *answer, seconds, tally)) {
      ++tally.wrong;
      std::printf("%llu: %s (%s; %lld units, %.2f s)\n", static_cast<unsigned long long>(seed), fault,
                  answer->reason.c_str(), static_cast<long long>(answer->units), seconds);
      std::fflush(stdout);
    }
  }
  std::printf(
      "plans %d (the slowest %.2f s), proofs %d, ended %d, out of budget %d; wrong %d; with a refused plan %d\n",
      tally.plans, tally.slowest_plan_s, tally.proofs, tally.ended, tally.out_of_budget, tally.wrong, tally.refused);
  std::printf("of the %d without a plan all small plans were tried in %d\n",
              tally.proofs + tally.ended + tally.out_of_budget, tally.all_tried);
  double seconds = 0;
  std::int64_t units = 0;
  for (const Spent& each : tally.spent) seconds += each.seconds, units += each.units;
  std::printf("%.1f s for %lld units: %.2f microseconds a unit; the highest:\n", seconds, static_cast<long long>(units),
              seconds * 1e6 / static_cast<double>(std::max<std::int64_t>(units, 1)));
  std::ranges::sort(tally.spent, std::greater{}, &Spent::microseconds_a_unit);
  for (std::size_t i = 0; i < std::min(kListed, tally.spent.size()); ++i)
    std::printf("  %llu: %.2f (%.3f s, %lld units)\n", static_cast<unsigned long long>(tally.spent[i].seed),
                tally.spent[i].microseconds_a_unit(), tally.spent[i].seconds,
                static_cast<long long>(tally.spent[i].units));
  return tally.wrong > 0 ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string kind = argc > 1 ? argv[1] : "";
  const Draw draw = kind == "numeric" ? draw_numeric : kind == "wide" ? draw_wide : nullptr;
  if (draw && argc == 4 && std::strcmp(argv[2], "show") == 0) return show(draw, std::strtoull(argv[3], nullptr, 10));
  if (!draw || (argc != 4 && argc != 5)) {
    std::fprintf(stderr,
                 "usage: bench_random_problems numeric|wide FIRST COUNT [BUDGET]\n"
                 "       bench_random_problems numeric|wide show SEED\n");
    return 2;
  }
  return run(draw, std::strtoull(argv[2], nullptr, 10), std::atoi(argv[3]),
             argc == 5 ? std::atoll(argv[4]) : 4'000'000);
}
