#include "scenarios/rcll/page/parts.h"

namespace cxlab::rcll {
namespace {

std::string signed_number(std::int64_t number) { return (number < 0 ? "" : "+") + std::to_string(number); }

void add_robots(const GameStory& story, std::vector<PageEvent>& out) {
  for (const RobotStory& robot : story.robots) {
    for (const SkillRun& skill : robot.skills)
      if (skill.ended && skill.code != 0)
        out.push_back({end_of(skill.when), kFailedKind, robot.name, skill.skill + ' ' + skill.target + " failed",
                       "code " + std::to_string(skill.code) + (skill.error.empty() ? "" : ": " + skill.error)});
    for (const RobotStory::Away& away : robot.off_field) {
      out.push_back({begin_of(away.when), kAwayKind, robot.name, away.for_good ? "disqualified" : "taken off the field",
                     away.cause});
      if (!away.for_good && away.when.to < story.end)
        out.push_back({end_of(away.when), kAwayKind, robot.name, "back on the field"});
    }
  }
}

void add_machines(const GameStory& story, std::vector<PageEvent>& out) {
  for (const MachineStory& machine : story.machines)
    for (const auto& [t, reason] : machine.breaks)
      out.push_back({to_seconds(t), kBrokenKind, machine.name, "broke", reason});
}

void add_orders(const GameStory& story, std::vector<PageEvent>& out) {
  for (const auto& [order, t] : story.published)
    for (const Team team : story.teams)
      out.push_back({to_seconds(t),
                     kOrderKind,
                     std::string(to_string(team)),
                     "order " + std::to_string(order) + " published",
                     {},
                     task_id(story, team, order)});
  for (const auto& [t, judged] : story.deliveries) {
    if (!judged.team) continue;
    out.push_back({to_seconds(t), judged.correct ? kOrderKind : kLostKind, std::string(to_string(*judged.team)),
                   "order " + std::to_string(judged.order) + (judged.correct ? " delivered" : ": delivery refused"),
                   judged.reason, task_id(story, *judged.team, judged.order)});
  }
  for (const auto& [t, given] : story.points) {
    if (!given.team) continue;
    out.push_back({to_seconds(t), kPointsKind, std::string(to_string(*given.team)),
                   signed_number(given.points) + ' ' + given.kind, "total " + std::to_string(given.total),
                   given.order == 0 ? "" : task_id(story, *given.team, given.order)});
  }
}

}  // namespace

std::vector<PageEvent> events_of(const GameStory& story) {
  std::vector<PageEvent> out;
  for (const FaultStruck& fault : story.faults) out.push_back({to_seconds(fault.t), kFaultKind, fault.at, fault.kind});
  add_robots(story, out);
  add_machines(story, out);
  add_orders(story, out);
  return out;
}

}  // namespace cxlab::rcll
