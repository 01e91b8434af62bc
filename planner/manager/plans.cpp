// Goals of the PDDL manager: plans, and when they are answered.

#include <algorithm>
#include <ranges>
#include <tuple>

#include "planner/manager/manager.h"
#include "planner/pddl/text.h"

namespace cxlab::planner {

namespace {

using View = bus::MessageView;

/// Starts that are not further apart than this belong to one class, s.
constexpr double kSameClass = 0.1;
constexpr std::size_t kMostCauses = 5;  ///< of missing plans, that the warnings of a run name

}  // namespace

/// What planning came to.
struct PddlManager::Outcome {
  std::string status;  ///< of PlanReport
  std::string reason;
  bus::GoalStatus ends = bus::GoalStatus::kAborted;
  std::optional<Task> task{};  ///< whose actions and objects the plan counts
  PlanAnswer answer{};
  Goals wanted{};
};

namespace {

std::set<std::string> goals_of(const Task& task) {
  const Condition& goal = task.problem.goal;
  std::set<std::string> texts;
  const auto add = [&](const Condition& part) {
    texts.insert(framework_text(part, task.domain, task.problem.objects, {}));
  };
  if (goal.kind == Condition::Kind::kAnd)
    for (const Condition& part : goal.operands) add(part);
  else
    add(goal);
  return texts;
}

}  // namespace

/// The plan of the instance that has most goals in common with these, and fewest others; of equals the last one.
const PddlManager::LastPlan* PddlManager::nearest_plan(const std::string& instance, const Goals& wanted) const {
  const LastPlan* nearest = nullptr;
  std::tuple<std::ptrdiff_t, std::ptrdiff_t, int> best{};
  for (const auto& [name, plan] : instances_.at(instance).plans) {
    const auto common = std::ranges::count_if(plan.goals, [&](const std::string& g) { return wanted.contains(g); });
    const std::tuple rank{common, -std::ssize(plan.goals), plan.number};
    if (common == 0 || (nearest && rank < best)) continue;
    nearest = &plan;
    best = rank;
  }
  return nearest;
}

/// The steps of the nearest plan. The planner finds out which of them are left.
Plan PddlManager::steps_left(const std::string& instance, const Task& task, const Goals& wanted) const {
  if (!options_.warm_start || options_.original) return {};
  const LastPlan* last = nearest_plan(instance, wanted);
  if (!last) return {};
  Plan steps;
  const View last_plan = last->result->view();
  for (std::size_t i = 0; i < last_plan.size("actions"); ++i) {
    const View action = last_plan.nested("actions", i);
    PlanStep step{
        action.real("start_time"), find(task.domain.action_names, action.text("name")), {}, action.real("duration")};
    const bus::Field& args = *action.type().find("args");
    const ById<Object>& objects = task.problem.objects;
    for (std::size_t k = 0; k < action.size(args); ++k) {
      const auto named = std::ranges::find(objects, action.text(args, k), &Object::name);
      step.arguments.push_back(named == objects.end() ? -1 : static_cast<ObjectId>(named - objects.begin()));
    }
    if (step.action >= 0 && std::ranges::find(step.arguments, -1) == step.arguments.end())
      steps.push_back(std::move(step));
  }
  return steps;
}

PddlManager::Outcome PddlManager::make_plan(const View& goal) {
  auto found = find_goal(goal.text("pddl_instance"), goal.text("goal_instance"));
  if (!found) return {"ERROR", found.error().message};
  const auto& [instance, wanted] = *found;
  if (options_.original && !wanted->objects.empty())
    return {"ERROR", "as in the original, an object filter breaks planning"};
  const SimTime loaded = instances_.at(goal.text("pddl_instance")).loaded;
  auto task = instance->planning_task(*wanted, options_.original ? 0 : cxlab::to_seconds(bus_.now() - loaded));
  if (!task) return {"ERROR", task.error().message};
  if (goal.type().find("output_dir")) dump(goal, *task);
  PlanOptions how;
  how.budget = options_.cost.budget;
  how.patience = options_.cost.patience;
  how.anytime = options_.anytime;
  how.bound = false;
  Goals goals = goals_of(*task);
  how.initial_state = "the instance";
  how.warm_start = steps_left(goal.text("pddl_instance"), *task, goals);
  const double wall_s = static_cast<double>(how.budget) * 1e-6;  // a unit is about a microsecond
  const bool ours = options_.other.command.empty();
  auto answer = ours ? find_plan(*task, how) : other_->find_plan(*task, wall_s);
  if (!answer && !ours) return {"ERROR", answer.error().text()};
  if (!answer) return {is(answer.error(), Failure::kOutOfMemory) ? "MEMORY" : "ERROR", answer.error().message};
  Outcome outcome{"PLAN",           answer->reason,     bus::GoalStatus::kSucceeded,
                  *std::move(task), *std::move(answer), std::move(goals)};
  if (outcome.answer.plan) return outcome;
  const PlanStatus status = outcome.answer.status;
  if (status == PlanStatus::kBudget || status == PlanStatus::kMemory) outcome.ends = bus::GoalStatus::kAborted;
  outcome.status = status == PlanStatus::kUnsolvable ? "UNSOLVABLE"
                   : status == PlanStatus::kBudget   ? "TIMEOUT"
                   : status == PlanStatus::kMemory   ? "MEMORY"
                                                     : "NO-PLAN";
  if (outcome.answer.out_of_reach) outcome.reason = outcome.answer.out_of_reach->text();
  if (options_.original) outcome.ends = bus::GoalStatus::kSucceeded;
  return outcome;
}

void PddlManager::dump(const View& goal, const Task& task) {
  const std::string& directory = goal.text("output_dir");
  if (directory.empty() || !options_.write) return;
  const std::string stem = goal.text("pddl_instance") + "_" + goal.text("goal_instance");
  const std::filesystem::path folder = directory;
  for (const auto& [name, text] : {std::pair(stem + "_domain.pddl", to_pddl(task.domain)),
                                   std::pair(stem + "_problem.pddl", to_pddl(task.domain, task.problem))})
    if (Status s = options_.write(folder / name, text); !s) log(cx::LogLevel::kError, s.error().text());
}

PddlManager::Job PddlManager::job_of(std::size_t dialect, const bus::GoalId& id, const View& goal,
                                     const Outcome& outcome) const {
  Job job{dialect, id, {}, outcome.ends, {}, {}, outcome.wanted, outcome.answer.out_of_reach.has_value()};
  const std::string &instance = goal.text("pddl_instance"), &goal_instance = goal.text("goal_instance");
  auto result = std::make_shared<bus::Message>(*dialects_[dialect].plan_type->result);
  auto report = std::make_shared<bus::Message>(*reports_.type);
  const View reported = report->view();
  reported.set("goal_id", bus::to_string(id)).set("pddl_instance", instance).set("goal_instance", goal_instance);
  reported.set("status", outcome.status)
      .set("reason", outcome.reason)
      .set("units", outcome.answer.units)
      .set("lower_bound", outcome.answer.lower_bound_s);
  result->view().set("success", outcome.answer.plan.has_value());
  if (outcome.answer.plan) {
    const TimedPlan& plan = *outcome.answer.plan;
    std::int64_t equiv_class = 0;
    double class_start = 0;
    for (const PlanStep& step : plan.steps) {
      if (step.start > class_start + kSameClass) {
        ++equiv_class;
        class_start = step.start;
      }
      const View out = result->view().append("actions");
      out.set("pddl_instance", instance).set("goal_instance", goal_instance);
      out.set("name", outcome.task->domain.actions[step.action].name);
      for (const ObjectId object : step.arguments) out.append_text("args", outcome.task->problem.objects[object].name);
      out.set("start_time", step.start).set("duration", step.duration).set("equiv_class", equiv_class);
    }
    reported.set("makespan", plan.makespan_s);
    const bus::Field& latest = *reported.type().find("latest_start");
    if (reported.resize(latest, plan.steps.size()))
      for (std::size_t i = 0; i < plan.steps.size() && 2 * i < plan.latest.size(); ++i)
        reported.set_real(latest, in_seconds(plan.latest[2 * i]), i);
    for (const Ordering& ordering : plan.orderings) {
      const View out = reported.append("orderings");
      const bool origin = ordering.from == Ordering::kOrigin;
      out.set("from_action", origin ? -1 : ordering.from / 2).set("from_end", !origin && ordering.from % 2 == 1);
      out.set("to_action", ordering.to / 2).set("to_end", ordering.to % 2 == 1);
      out.set("at_least", in_seconds(ordering.least))
          .set("at_most", ordering.most == DurationRange::kForever ? -1.0 : in_seconds(ordering.most));
    }
  }
  const double wait = options_.cost.latency_a + options_.cost.latency_b * static_cast<double>(outcome.answer.units);
  job.due = bus_.now() + (options_.cost.is_charged() ? from_seconds(wait) : SimTime{});
  job.result = std::move(result);
  job.report = std::move(report);
  return job;
}

void PddlManager::on_goal(std::size_t dialect, const bus::Delivery& goal) {
  const bus::EndpointId server = dialects_[dialect].plan;
  if (state() != cx::LifeState::kActive) {
    log(cx::LogLevel::kWarn, "a goal was rejected: the node is " + std::string(cx::to_string(state())));
    bus_.answer_goal(server, goal.goal, bus::GoalAnswer::kReject);
    return;
  }
  bus_.answer_goal(server, goal.goal, bus::GoalAnswer::kAccept);
  const View wanted = goal.message->view();
  Job job = job_of(dialect, goal.goal, wanted, make_plan(wanted));
  if (job.due > bus_.now())
    jobs_.push_back(std::move(job));
  else
    finish(job);
}

void PddlManager::finish(const Job& job) {
  const View reported = job.report->view();
  const bool found = reported.text("status") == "PLAN";
  if (found) {
    ++plans_;
    if (const auto entry = instances_.find(reported.text("pddl_instance")); entry != instances_.end())
      entry->second.plans[reported.text("goal_instance")] = {job.wanted, job.result, plans_};
    if (!planned_.emplace(reported.text("pddl_instance"), reported.text("goal_instance")).second) ++replans_;
  } else {
    ++others_[reported.text("status")];
    if (job.has_cause) note_cause(reported.text("reason"));
  }
  data_.begin()
      .field("op", "plan")
      .field("instance", std::string_view(reported.text("pddl_instance")))
      .field("goal", std::string_view(reported.text("goal_instance")));
  data_.field("status", std::string_view(reported.text("status")))
      .field("units", reported.integer("units"))
      .field("makespan", reported.real("makespan"));
  if (job.has_cause) data_.field("reason", std::string_view(reported.text("reason")));
  sink_.write(bus_.stream_of(node_), bus_.now(), RecordKind::kDecision, data_);
  const std::string whose =
      "plan for '" + reported.text("goal_instance") + "' of '" + reported.text("pddl_instance") + "': ";
  if (found)
    log(cx::LogLevel::kInfo, whose + number_text(reported.real("makespan")) + " s");
  else
    log(reported.text("status") == "CANCELED" ? cx::LogLevel::kInfo : cx::LogLevel::kWarn,
        whose + reported.text("status") + ", " + reported.text("reason"));
  bus_.publish(reports_.endpoint, job.report);
  bus_.finish(dialects_[job.dialect].plan, job.goal, job.status, job.result);
}

void PddlManager::note_cause(const std::string& cause) {
  const auto known = std::ranges::find(causes_, cause, &MissingPlan::cause);
  if (known == causes_.end())
    causes_.push_back({cause, bus_.now(), 1});
  else
    ++known->times;
}

std::vector<std::string> PddlManager::warnings() const {
  std::vector<std::string> warnings = replaced_;
  for (const MissingPlan& missing : causes_ | std::views::take(kMostCauses)) {
    const std::string others = missing.times == 1   ? ""
                               : missing.times == 2 ? " and once more"
                                                    : " and " + std::to_string(missing.times - 1) + " times more";
    warnings.push_back(options_.node.full_name() + ": no plan at " + time_text(cxlab::to_seconds(missing.first)) +
                       " s" + others + ": " + missing.cause);
  }
  if (causes_.size() > kMostCauses)
    warnings.push_back(options_.node.full_name() + ": " + std::to_string(causes_.size() - kMostCauses) +
                       " more causes of missing plans are in its log");
  int requests = 0;
  std::string statuses;
  auto answers = others_;
  if (!jobs_.empty()) answers["not answered yet"] = static_cast<int>(jobs_.size());
  for (const auto& [status, times] : answers) {
    requests += times;
    statuses += (statuses.empty() ? "" : ", ") + status + ' ' + std::to_string(times);
  }
  if (plans_ > 0 || requests == 0) return warnings;
  warnings.push_back(options_.node.full_name() + ": no plan was found in " + std::to_string(requests) + " requests (" +
                     statuses + ')' +
                     (others_.contains("TIMEOUT") ? "; a larger planner.budget than " +
                                                        std::to_string(options_.cost.budget) + " gives more time"
                                                  : ""));
  return warnings;
}

void PddlManager::on_cancel(std::size_t dialect, const bus::Delivery& cancel) {
  const bus::EndpointId server = dialects_[dialect].plan;
  const auto job =
      std::ranges::find_if(jobs_, [&](const Job& j) { return j.dialect == dialect && j.goal == cancel.goal; });
  const bool accept = !options_.original && job != jobs_.end();
  bus_.answer_cancel(server, cancel, accept);
  if (!accept) return;
  Job canceled = std::move(*job);
  jobs_.erase(job);
  give_up(std::move(canceled), "CANCELED", "the goal was canceled", bus::GoalStatus::kCanceled);
}

void PddlManager::stop_jobs(const std::string& reason) {
  for (Job& job : std::exchange(jobs_, {})) give_up(std::move(job), "ERROR", reason, bus::GoalStatus::kAborted);
}

/// Answers without the plan that was made.
void PddlManager::give_up(Job job, const char* status, const std::string& reason, bus::GoalStatus ends) {
  auto report = std::make_shared<bus::Message>(*reports_.type);
  for (const char* field : {"goal_id", "pddl_instance", "goal_instance"})
    report->view().set(field, job.report->view().text(field));
  report->view().set("status", status).set("reason", reason);
  job.report = std::move(report);
  job.result = std::make_shared<bus::Message>(*dialects_[job.dialect].plan_type->result);
  job.status = ends;
  job.has_cause = false;
  finish(job);
}

}  // namespace cxlab::planner
