#include "scenarios/rcll/page/events.h"

#include "scenarios/rcll/page/parts.h"
#include "scenarios/scenario.h"

namespace cxlab::rcll {
namespace {

std::string signed_number(std::int64_t number) { return (number < 0 ? "" : "+") + std::to_string(number); }

/// What of the records of one run people hear of.
struct Teller {
  const std::vector<Team>& teams;
  double t = 0;
  std::vector<PageEvent>& out;

  std::string task(Team team, int order) const { return task_id(teams, team, order); }
  bool plays(std::string_view machine) const {
    return std::ranges::any_of(teams, [&](Team team) { return machine.starts_with(letter(team)); });
  }

  void fault(const RecordValue& data) {
    const std::string_view robot = data.text("robot"), fault = data.text("fault");
    if (!fault.empty())
      out.push_back({t, kFaultKind, std::string(robot.empty() ? data.text("machine") : robot), std::string(fault)});
  }
  void skill(const RecordValue& data) {
    if (data.text("event") != "end" || data.integer("code") == 0) return;
    const std::string_view error = data.text("error");
    out.push_back({t, kFailedKind, std::string(data.text("robot")),
                   std::string(data.text("skill")) + ' ' + std::string(data.text("target")) + " failed",
                   "code " + std::to_string(data.integer("code")) + (error.empty() ? "" : ": ") + std::string(error)});
  }

  void operator()(const DutyChanged& e) {
    if (e.robot.empty()) return;
    if (e.state == "disqualified") out.push_back({t, kAwayKind, e.robot, "disqualified", e.cause});
    if (e.state == "begin") out.push_back({t, kAwayKind, e.robot, "taken off the field", e.cause});
    if (e.state == "end") out.push_back({t, kAwayKind, e.robot, "back on the field"});
  }
  void operator()(const MachineBroke& e) {
    if (plays(e.machine)) out.push_back({t, kBrokenKind, e.machine, "broke", e.reason});
  }
  void operator()(const OrderPublished& e) {
    for (const Team team : teams) {
      out.push_back({t,
                     kOrderKind,
                     std::string(to_string(team)),
                     "order " + std::to_string(e.id) + " published",
                     {},
                     task(team, e.id)});
      out.back().minor = true;
    }
  }
  void operator()(const DeliveryJudged& e) {
    if (!e.team) return;
    out.push_back({t, e.correct ? kOrderKind : kLostKind, std::string(to_string(*e.team)),
                   "order " + std::to_string(e.order) + (e.correct ? " delivered" : ": delivery refused"), e.reason,
                   task(*e.team, e.order)});
  }
  void operator()(const PointsGiven& e) {
    if (!e.team) return;
    out.push_back({t, kPointsKind, std::string(to_string(*e.team)), signed_number(e.points) + ' ' + e.kind,
                   "total " + std::to_string(e.total), e.order == 0 ? "" : task(*e.team, e.order)});
    out.back().minor = true;
  }
  void operator()(const auto&) {}
};

}  // namespace

void happened(const Scenario& scenario, const JournalRecord& record, std::vector<PageEvent>& out) {
  const std::vector<Team> teams = teams_of(scenario.world.get<WorldConfig>());
  Teller teller{teams, to_seconds(record.t), out};
  if (record.kind == RecordKind::kControl) teller.fault(record.data);
  if (record.kind == RecordKind::kSkill) teller.skill(record.data);
  if (record.kind == RecordKind::kReferee)
    if (const auto event = read_event(record.data)) std::visit(teller, *event);
}

}  // namespace cxlab::rcll
