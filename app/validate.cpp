// cxlab validate: tells whether a plan is valid, and the first fault if it is not.

#include <cmath>
#include <cstdio>
#include <memory>

#include "app/arguments.h"
#include "app/command.h"
#include "app/planning.h"
#include "cx/base/file.h"
#include "cx/base/json.h"
#include "planner/ground/budget.h"
#include "planner/pddl/parser.h"
#include "planner/pddl/text.h"
#include "planner/planner.h"
#include "planner/validator/robustness.h"

namespace cxlab::app {

namespace {

using planner::time_text;

struct ValidateOptions {
  std::string domain, problem, plan, data;
  planner::ValidateOptions rules;
  bool robust = false;
  double limit = 0;  ///< s; 0 = the makespan
  std::int64_t budget = planner::PlanOptions{}.budget;
  bool json = false;
};

Json to_json(const planner::Violation& violation, const planner::Plan& plan, const planner::Task& task) {
  Json out = {{"kind", to_word(violation.kind)}, {"time", violation.time}};
  if (violation.step >= 0) {
    out["step"] = violation.step;
    const planner::PlanStep& step = plan[static_cast<std::size_t>(violation.step)];
    out["action"] = step_text(step, task.domain, task.problem);
    out["line"] = step.line;
  }
  if (violation.other_step >= 0) out["other_step"] = violation.other_step;
  out["when"] = violation.when;
  out["condition"] = violation.condition;
  out["message"] = violation.message;
  out["advice"] = violation.advice;
  return out;
}

void print_text(const planner::Verdict& verdict, const std::optional<planner::Robustness>& robust, std::size_t steps) {
  if (!verdict.valid) {
    std::printf("invalid: %s\n", planner::to_text(*verdict.violation).c_str());
    return;
  }
  std::printf("valid: %zu steps, makespan %s s", steps, time_text(verdict.makespan).c_str());
  if (verdict.metric) std::printf(", metric %s", metric_text(*verdict.metric).c_str());
  std::printf("\n");
  if (!robust) return;
  std::printf("robust: steps may begin up to %s s early or late (%d plans checked)\n", time_text(robust->holds).c_str(),
              robust->samples);
  if (robust->violation)
    std::printf("with up to %s s: %s\n", time_text(robust->breaks).c_str(),
                planner::to_text(*robust->violation).c_str());
}

void print_json(const planner::Verdict& verdict, const std::optional<planner::Robustness>& robust,
                const planner::Plan& plan, const planner::Task& task) {
  Json out = {{"valid", verdict.valid}, {"steps", plan.size()}, {"makespan", verdict.makespan}};
  out["metric"] = verdict.metric ? Json(rounded_metric(*verdict.metric)) : Json();
  out["violation"] = verdict.violation ? to_json(*verdict.violation, plan, task) : Json();
  if (robust) {
    out["robust"] = {{"holds_s", robust->holds}, {"breaks_s", robust->breaks}, {"plans", robust->samples}};
    out["robust"]["violation"] = robust->violation ? to_json(*robust->violation, plan, task) : Json();
  }
  std::printf("%s\n", json_text(out, 2).c_str());
}

int validate(const ValidateOptions& options) {
  const auto data = read_template_data(options.data, options.domain, options.problem);
  if (!data) return fail_planning(data.error());
  const auto task = planner::load_task(options.domain, options.problem, {.data = *data});
  if (!task) return fail_planning(task.error());
  const auto text = read_file(options.plan);
  if (!text) return fail_planning(text.error());
  const auto plan = planner::parse_plan(*text, options.plan, task->domain, task->problem);
  if (!plan) return fail_planning(plan.error());
  planner::Budget budget(options.budget, {});
  planner::Meter meter([&budget]() -> std::int64_t {
    constexpr std::int64_t kPortion = 1000;
    budget.spend(planner::Work::kGround, kPortion);
    return budget.over() ? 0 : kPortion;
  });
  const planner::Validator validator(task->domain, task->problem, &meter);
  const auto verdict = validator.check(*plan, options.rules);
  if (!verdict) return fail_planning(verdict.error());
  std::optional<planner::Robustness> robust;
  if (options.robust && verdict->valid) {
    const auto found =
        planner::robustness(validator, *plan, options.rules, options.limit > 0 ? options.limit : verdict->makespan);
    if (!found) return fail_planning(found.error());
    robust = *found;
  }
  if (options.json) {
    print_json(*verdict, robust, *plan, *task);
  } else {
    print_text(*verdict, robust, plan->size());
  }
  return verdict->valid ? 0 : static_cast<int>(ErrorKind::kNo);
}

}  // namespace

int fail_planning(const Error& error) {
  fail(error);
  return planner::exit_code(error);
}

Expected<std::string> read_template_data(const std::string& file, const std::string& domain,
                                         const std::string& problem) {
  if (file.empty()) return std::string("{}");
  auto text = read_file(file);
  if (!text) return text.error();
  const Json json = parse_json(*text);
  if (json.is_discarded()) return input_error(found_expected("no JSON", "an object such as {\"robots\": 2}"), file);
  if (!json.is_object())
    return input_error(found_expected(json.type_name(), "an object such as {\"robots\": 2}"), file);
  for (const std::string& source : {domain, problem})
    if (const auto read = read_file(source); !read || planner::is_template(*read)) return text;
  return input_error("these data are not used: neither " + domain + " nor " + problem + " is a template", file);
}

double rounded_metric(double metric) {
  constexpr double kMillion = 1e6, kMost = 1e9;  // doubles beyond have no millionths to round to
  return std::abs(metric) < kMost ? std::round(metric * kMillion) / kMillion + 0.0 : metric;  // + 0.0: no -0
}

std::string metric_text(double metric) { return planner::number_text(rounded_metric(metric)); }

void add_validate(CLI::App& app, Action& action) {
  auto options = std::make_shared<ValidateOptions>();
  CLI::App* command =
      app.add_subcommand("validate", "Report whether a plan is valid, and the first fault if it is not");
  command->add_option("domain", options->domain, "PDDL file of the domain")->required();
  command->add_option("problem", options->problem, "PDDL file of the problem")->required();
  command
      ->add_option("plan", options->plan,
                   "Plan, one step a line: TIME: (ACTION OBJECT...) [DURATION]; or what a planner printed")
      ->required();
  command->add_option("--data", options->data, "JSON object for a domain or problem that is a template");
  command->add_option("--epsilon", options->rules.epsilon, "Least time between happenings that interfere, s")
      ->check(not_negative())
      ->capture_default_str();
  command
      ->add_option("--tolerance", options->rules.duration_tolerance, "Time by which a duration may miss its bounds, s")
      ->check(not_negative())
      ->capture_default_str();
  whole_number(command->add_option("--budget", options->budget, "Work units that quantifiers may use"), 1)
      ->capture_default_str();
  command->add_flag("--robust", options->robust, "Also searches by how much steps may begin early or late");
  command->add_option("--robust-limit", options->limit, "Largest shift to try, s (default: the makespan)")
      ->check(positive());
  command->add_flag("--json", options->json, "Prints the answer as JSON");
  command->footer(
      "Exit codes: 0 valid; 1 not valid; 23 budget ended; 31 a file cannot be used; 34 something in it is not "
      "supported.");
  command->callback([options, &action] { action = [options] { return validate(*options); }; });
}

}  // namespace cxlab::app
