#include "scenarios/rcll/questions/orders.h"
#include "scenarios/rcll/game/scene.h"
#include "scenarios/rcll/page/parts.h"

namespace cxlab::rcll {
namespace {

std::optional<double> seconds_of(const std::optional<SimTime>& t) {
  return t ? std::optional(to_seconds(*t)) : std::nullopt;
}

const char* kind_of_order(std::string_view state) {
  if (state == "delivered") return kInTimeKind;
  if (state == "late") return kLateKind;
  if (state == "lost" || state == "never begun" || state == "unfinished") return kLostKind;
  return kOpenKind;
}

PageTask task_of(const GameStory& story, const OrderWork& work, const std::vector<OrderWork>& works) {
  const OrderAccount account = account_of(story, work, works);
  const Order& order = work.order;
  const bool two_teams = story.teams.size() > 1;
  PageTask task;
  task.id = task_id(story, work.team, order.id);
  task.name = "order " + std::to_string(order.id) + (two_teams ? ' ' + std::string(to_string(work.team)) : "");
  if (two_teams) task.kind = to_string(work.team);
  task.text = std::string(to_string(order.complexity)) + ": " + product_text(describe(stack_of(order.product)));
  if (order.quantity > 1) task.text += ", " + std::to_string(order.quantity) + " of them";
  if (order.competitive) task.text += ", competitive";
  task.look = piece_look(stack_of(order.product));
  const auto published = story.published.find(order.id);
  task.known = to_seconds(published == story.published.end() ? story.clock.when(order.activate_at) : published->second);
  task.begin = to_seconds(story.clock.when(order.delivery_begin));
  task.end = to_seconds(story.clock.when(order.delivery_end));
  task.begun = seconds_of(work.begun());
  task.done = seconds_of(work.delivered_at());
  task.state = account.state;
  task.state_kind = kind_of_order(account.state);
  task.late_s = account.late_s;
  task.waited_s = to_seconds(account.waited);
  task.points = static_cast<double>(work.points);
  task.reason = account.outcome;
  for (const OrderStep& step : account.steps)
    task.steps.push_back({step.what.empty() ? "?" : step.what, step.machine, seconds_of(step.arrived),
                          seconds_of(step.done), to_seconds(step.waited), step.waited_for});
  return task;
}

}  // namespace

std::string task_id(const std::vector<Team>& teams, Team team, int order) {
  return (teams.size() > 1 ? std::string(to_string(team)) + '-' : "") + std::to_string(order);
}

PageTasks tasks_of(const GameStory& story, const std::vector<OrderWork>& works) {
  PageTasks out{"Orders", "order", {}};
  for (const OrderWork& work : works) out.tasks.push_back(task_of(story, work, works));
  return out;
}

}  // namespace cxlab::rcll
