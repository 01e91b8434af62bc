// cxlab plan: a plan for a PDDL problem.

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <functional>
#include <mutex>
#include <new>
#include <optional>
#include <thread>

#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "app/planning.h"
#include "cx/base/file.h"
#include "cx/base/json.h"
#include "lab/page.h"
#include "planner/pddl/parser.h"
#include "planner/planner.h"

namespace cxlab::app {

namespace {

using planner::PlanStatus;

constexpr double kLongestTimeout = 1e9;  ///< s; clocks end some time after it

struct PlanCommand {
  std::string domain, problem, data, out, svg;
  std::optional<double> timeout_s;
  std::int64_t budget = planner::PlanOptions{}.budget;
  std::optional<std::int64_t> patience;
  bool anytime = false, json = false, stream = false;
};

const char* word(PlanStatus status) {
  switch (status) {
    case PlanStatus::kPlan: return "plan";
    case PlanStatus::kUnsolvable: return "unsolvable";
    case PlanStatus::kEnded: return "ended";
    case PlanStatus::kMemory: return "memory";
    case PlanStatus::kBudget: return "budget";
  }
  return "ended";
}

Json to_json(const planner::OutOfReach& out_of_reach) {
  Json out = {{"text", out_of_reach.text()}};
  for (const planner::Cause& cause : out_of_reach.causes) {
    Json& one = out["causes"].emplace_back(Json{{"condition", cause.condition}});
    if (!cause.when.empty()) one["when"] = cause.when;
    if (!cause.makers.empty())
      one.update({{"makers", cause.makers}, {"verb", cause.verb}, {"followed", cause.followed}, {"at", cause.at}});
    if (!cause.end.empty()) one["end"] = cause.end;
  }
  return out;
}

/// `timed`: with wall times; without, the same budget gives the same bytes.
Json to_json(const planner::PlanAnswer& answer, const planner::Task& task, bool timed) {
  Json out;
  out["status"] = word(answer.status);
  out["reason"] = answer.reason;
  out["units"] = answer.units;
  if (answer.out_of_reach) out["out_of_reach"] = to_json(*answer.out_of_reach);
  if (!answer.plan) return out;
  out["makespan_s"] = answer.plan->makespan_s;
  out["lower_bound_s"] = answer.lower_bound_s;
  out["lower_bound_assumes_order"] = answer.bound_assumes_order;
  if (answer.plan->metric) out["metric"] = rounded_metric(*answer.plan->metric);
  if (answer.metric_bound) out["metric_bound"] = rounded_metric(*answer.metric_bound);
  if (timed) out["first_plan_wall_s"] = answer.first_plan_s;
  out["steps"] = out["orderings"] = Json::array();
  for (std::size_t i = 0; i < answer.plan->steps.size(); ++i) {
    const planner::PlanStep& step = answer.plan->steps[i];
    Json arguments = Json::array();
    for (const planner::ObjectId object : step.arguments)
      arguments.push_back(task.problem.objects[static_cast<std::size_t>(object)].name);
    const auto latest = [&](std::size_t point) {
      return static_cast<double>(answer.plan->latest[point]) / planner::kMicrosPerSecond;
    };
    out["steps"].push_back({{"start", step.start},
                            {"duration", step.duration},
                            {"latest_start", latest(2 * i)},
                            {"latest_end", latest(2 * i + 1)},
                            {"action", task.domain.actions[static_cast<std::size_t>(step.action)].name},
                            {"arguments", std::move(arguments)}});
  }
  const auto point = [](int p) {
    return p < 0 ? Json("origin") : Json({{"step", p / 2}, {"at", p % 2 ? "end" : "start"}});
  };
  for (const planner::Ordering& ordering : answer.plan->orderings) {
    Json edge = {{"from", point(ordering.from)},
                 {"to", point(ordering.to)},
                 {"least_s", static_cast<double>(ordering.least) / planner::kMicrosPerSecond}};
    if (ordering.most < planner::DurationRange::kForever)
      edge["most_s"] = static_cast<double>(ordering.most) / planner::kMicrosPerSecond;
    out["orderings"].push_back(std::move(edge));
  }
  return out;
}

/// A plan of --stream that is not the last line: bounds are not known yet.
void print_found(const planner::TimedPlan& plan, std::int64_t units, const planner::Task& task) {
  planner::PlanAnswer so_far;
  so_far.plan = plan;
  so_far.units = units;
  Json line = to_json(so_far, task, false);
  line["status"] = "found";
  for (const char* unknown : {"reason", "lower_bound_s", "lower_bound_assumes_order"}) line.erase(unknown);
  std::printf("%s\n", json_text(line).c_str());
  std::fflush(stdout);
}

/// While it lives, SIGINT and SIGTERM end the process at once, wherever the planner is, after a report of the best plan
/// found so far.
class Interruption {
 public:
  using Report = std::function<void(const planner::PlanAnswer& so_far)>;

  explicit Interruption(Report report) : report_(std::move(report)) {
    so_far_.status = PlanStatus::kBudget;
    sigemptyset(&signals_);
    sigaddset(&signals_, SIGINT);
    sigaddset(&signals_, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &signals_, nullptr);  // of all threads that begin from now on
    watcher_ = std::thread([this] { watch(); });
  }
  ~Interruption() {
    mutex_.lock();  // a report that has begun ends the process
    over_ = true;
    mutex_.unlock();
    pthread_kill(watcher_.native_handle(), SIGTERM);
    watcher_.join();
    pthread_sigmask(SIG_UNBLOCK, &signals_, nullptr);
  }
  void found(const planner::TimedPlan& plan, std::int64_t units) {
    const std::lock_guard lock(mutex_);
    so_far_.status = PlanStatus::kPlan;
    so_far_.plan = plan;
    so_far_.units = units;
  }

 private:
  void watch() {
    int number = 0;
    sigwait(&signals_, &number);
    const std::lock_guard lock(mutex_);
    if (over_) return;
    so_far_.reason = so_far_.plan ? "interrupted" : "interrupted before there was a plan";
    report_(so_far_);
    std::fprintf(stderr, "%s by %s; %s\n", coloured("interrupted:", kRed).c_str(),
                 number == SIGINT ? "SIGINT" : "SIGTERM",
                 so_far_.plan ? "the answer is the best plan so far" : "there is no plan");
    std::fflush(nullptr);
    std::_Exit(128 + number);
  }

  Report report_;
  sigset_t signals_{};
  std::mutex mutex_;  // of the two below
  planner::PlanAnswer so_far_;
  bool over_ = false;
  std::thread watcher_;
};

int write(const std::string& file, const std::string& text) {
  const Status written = write_output(file, text);
  return written ? 0 : fail(written.error());
}

/// Prints and writes the answer as asked; the exit code.
int report(const planner::PlanAnswer& answer, const planner::Task& task, const PlanCommand& command) {
  std::fprintf(stderr, "%s: %s%s\n", word(answer.status), answer.reason.c_str(),
               answer.units > 0 || answer.status != PlanStatus::kBudget
                   ? ("; " + std::to_string(answer.units) + " units").c_str()
                   : "");
  if (answer.out_of_reach) std::fprintf(stderr, "%s\n", answer.out_of_reach->text().c_str());
  int code = static_cast<int>(answer.status);
  if (answer.plan) {
    const double makespan = answer.plan->makespan_s, bound = answer.lower_bound_s;
    if (const std::optional<double> gap = answer.gap())
      std::fprintf(stderr, "makespan %.3f s, no plan under %.3f s%s: at most %.1f %% from the shortest\n", makespan,
                   bound, answer.bound_assumes_order ? " in which no two actions change one fact at one instant" : "",
                   100 * *gap);
    else
      std::fprintf(stderr, "makespan %.3f s, no bound is known\n", makespan);
    if (answer.by_metric && answer.plan->metric) {
      const std::string best = answer.metric_bound
                                   ? "no plan has a better one than " + metric_text(*answer.metric_bound)
                                   : "the best one is not known";
      std::fprintf(stderr, "metric %s, %s\n", metric_text(*answer.plan->metric).c_str(), best.c_str());
    }
    const std::string text = planner::to_text(answer.plan->steps, task.domain, task.problem);
    if (!command.out.empty())
      code = std::max(code, write(command.out, text));
    else if (!command.json && !command.stream)
      std::fputs(text.c_str(), stdout);
    if (!command.svg.empty()) {
      const auto picture = lab::render_page("plan.svg", json_text(to_json(answer, task, false)));
      code = std::max(code, picture ? write(command.svg, *picture) : fail(picture.error()));
    }
  }
  if (command.json || command.stream)
    std::printf("%s\n",
                json_text(to_json(answer, task, command.timeout_s.has_value()), command.stream ? -1 : 1).c_str());
  return code;
}

/// The time counts from here: reading the files is part of it.
int run(const PlanCommand& command) {
  using Clock = std::chrono::steady_clock;
  planner::Deadline deadline;
  if (command.timeout_s)
    deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                  std::chrono::duration<double>(std::min(*command.timeout_s, kLongestTimeout)));
  const Expected<std::string> data = read_template_data(command.data, command.domain, command.problem);
  if (!data) return fail_planning(data.error());
  const Expected<planner::Task> task =
      planner::load_task(command.domain, command.problem, {.deadline = deadline, .data = *data});
  if (!task && is(task.error(), planner::Failure::kLate)) {
    planner::PlanAnswer answer;
    answer.status = PlanStatus::kBudget;
    answer.reason = task.error().text();
    return report(answer, {}, command);
  }
  if (!task) return fail_planning(task.error());
  planner::PlanOptions options;
  options.budget = command.budget;
  options.patience = command.patience;
  if (deadline) options.timeout_s = std::chrono::duration<double>(*deadline - Clock::now()).count();
  options.anytime = command.anytime;
  std::optional<Interruption> interruption(std::in_place,
                                           [&](const planner::PlanAnswer& so_far) { report(so_far, *task, command); });
  options.on_plan = [&](const planner::TimedPlan& plan, std::int64_t units) {
    interruption->found(plan, units);
    const std::string metric = plan.metric && rounded_metric(*plan.metric) != rounded_metric(plan.makespan_s)
                                   ? ", metric " + metric_text(*plan.metric)
                                   : "";
    std::fprintf(stderr, "plan: %zu steps, makespan %.3f s%s, after %lld units\n", plan.steps.size(), plan.makespan_s,
                 metric.c_str(), static_cast<long long>(units));
    if (command.stream) print_found(plan, units, *task);
  };
  const Expected<planner::PlanAnswer> answer = planner::find_plan(*task, options);
  interruption.reset();
  if (!answer) return fail_planning(answer.error());
  return report(*answer, *task, command);
}

}  // namespace

void add_plan(CLI::App& app, Action& action) {
  auto options = std::make_shared<PlanCommand>();
  CLI::App* plan = app.add_subcommand("plan", "Find a plan for a PDDL problem with time, numbers and events");
  plan->add_option("domain", options->domain, "PDDL domain")->required();
  plan->add_option("problem", options->problem, "PDDL problem")->required();
  plan->add_option("--data", options->data, "JSON object for a domain or problem that is a template");
  plan->add_option("--timeout", options->timeout_s, "Wall time, s")->check(positive());
  whole_number(plan->add_option("--budget", options->budget,
                                "Work units; one is about a microsecond. The same budget gives the same plan"),
               1)
      ->capture_default_str();
  plan->add_flag("--anytime", options->anytime,
                 "Continues to better plans (by the metric, or shorter ones) until time or budget end");
  whole_number(plan->add_option("--patience", options->patience,
                                "With --anytime: ends when no better plan is found for so many work units"),
               1);
  plan->add_option("--out", options->out, "Writes the plan to this file instead of standard output");
  plan->add_option("--svg", options->svg, "Draws the plan: bars, slack and partial order");
  plan->add_flag("--json", options->json, "Prints plan, partial order and bound as JSON");
  plan->add_flag("--stream", options->stream,
                 "Prints each better plan as one line of JSON when it is found; the last line is the answer");
  plan->footer(
      "Exit codes: 0 a plan; 10 proved unsolvable; 12 ended without plan or proof; 22 memory; 23 time or budget ended; "
      "31 bad\n"
      "input; 34 unsupported PDDL; 2 usage; 5 output cannot be written.");
  plan->callback([options, &action] {
    action = [options] {
      try {
        return run(*options);
      } catch (const std::bad_alloc&) {
        std::fputs("error: out of memory\n", stderr);
        return static_cast<int>(PlanStatus::kMemory);
      }
    };
  });
}

}  // namespace cxlab::app
