#include "scenarios/rcll/story/page.h"

#include <algorithm>

#include "cx/base/json.h"
#include "cx/base/number_text.h"
#include "scenarios/rcll/story/story.h"

namespace cxlab::rcll {

namespace {

constexpr const char *kHoldsKind = "holds", *kFailedKind = "failed", *kAwayKind = "maintenance", *kFaultKind = "fault",
                     *kPauseKind = "pause";

const std::vector<PageKind>& kinds() {
  static const std::vector<PageKind> kAll{
      {"CYAN", "", "#0093b8"},      {"MAGENTA", "", "#c2187f"},  {"drive_to", "#8fb8de", ""},
      {"transport", "#d0b878", ""}, {"explore", "#c3a6d8", ""},  {"discard", "#9a9a9a", ""},
      {"pick", "#f2b134", ""},      {"place", "#6ab46a", ""},    {kHoldsKind, "#7a5c99", "#fff"},
      {kFailedKind, "#d64545", ""}, {kAwayKind, "#444", "#fff"}, {kFaultKind, "#000", ""},
      {kPauseKind, "#ebebeb", ""}};
  return kAll;
}

/// "5:12".
std::string minutes(double seconds) {
  const auto whole = static_cast<long long>(seconds);
  return std::to_string(whole / 60) + (whole % 60 < 10 ? ":0" : ":") + std::to_string(whole % 60);
}

std::string text_in(const Json& value) { return value.is_string() ? value.get<std::string>() : json_text(value); }

double begin_of(const Interval& when) { return to_seconds(when.from); }
double end_of(const Interval& when) { return to_seconds(when.to); }

/// A game that has been played, and what the page makes of it.
struct Page {
  const GameStory& story;
  Json result;
  RunPage out{};

  PageTable points() const;
  PageChart points_over_time() const;
  PageTable orders() const;
  PageLanes lanes() const;
  PageLane lane_of(const RobotStory& robot) const;
  PageTable robots() const;
  PageTable faults() const;
  Json skills_data() const, holds_data() const, scores_data() const, off_field_data() const, faults_data() const,
      pauses_data() const;

  bool anybody_off_field() const {
    return std::ranges::any_of(story.robots, [](const RobotStory& robot) { return !robot.off_field.empty(); });
  }
  bool anybody_worked() const {
    return std::ranges::any_of(story.robots, [](const RobotStory& robot) { return !robot.skills.empty(); });
  }
  void build();
};

PageTable Page::points() const {
  PageTable table{"", {"team", "points"}, {}};
  const Json& teams = result["teams"];
  for (const auto& [kind, unused] : teams.front()["by_kind"].items()) table.columns.push_back(kind);
  for (const auto& [team, score] : teams.items()) {
    auto& row = table.rows.emplace_back();
    row.emplace_back(team, true, team);
    row.emplace_back(text_in(score["points"]), true);
    for (const Json& points : score["by_kind"]) row.emplace_back(text_in(points));
  }
  return table;
}

/// Points of one instant are one step: a delivery and what it loses by being late.
PageChart Page::points_over_time() const {
  PageChart chart{"Points over time", {}};
  for (const auto& [team, unused] : result["teams"].items()) {
    PageLine& line = chart.lines.emplace_back(PageLine{team, {}});
    double sum = 0;
    for (const auto& [t, given] : story.points) {
      if (given.team != named<Team>(team)) continue;
      sum += static_cast<double>(given.points);
      if (line.steps.empty() || line.steps.back().first != to_seconds(t)) line.steps.emplace_back(to_seconds(t), 0);
      line.steps.back().second = sum;
    }
  }
  return chart;
}

PageTable Page::orders() const {
  PageTable table{"Orders", {"order", "product", "known from"}, {}};
  const Json& orders = result["orders"];
  std::vector<std::string> sides;
  for (const Json& order : orders)
    if (const std::string team = order.value("team", std::string());
        !team.empty() && std::ranges::find(sides, team) == sides.end())
      sides.push_back(team);
  for (const std::string& side : sides.empty() ? std::vector<std::string>{""} : sides) {
    table.columns.push_back(side.empty() ? "delivered" : side + " delivered");
    table.columns.emplace_back("points");
  }
  for (const Json& order : orders) {
    if (!sides.empty() && order["team"] != sides.front()) continue;
    auto& row = table.rows.emplace_back();
    row = {text_in(order["id"]), text_in(order["complexity"]), minutes(order["ordered"])};
    for (const Json& one : orders) {
      if (one["id"] != order["id"]) continue;
      const Json& at = one["delivered_at"];
      row.emplace_back(at.is_null() ? "-" : minutes(at) + (one["correct"].get<bool>() ? "" : " (wrong)"));
      row.emplace_back(text_in(one["points"]));
    }
  }
  return table;
}

PageLane Page::lane_of(const RobotStory& robot) const {
  using Shape = PageBar::Shape;
  PageLane lane{robot.name, {}, {}};
  for (const RobotStory::Hold& hold : robot.holds)
    lane.bars.push_back({Shape::kStrip, kHoldsKind, begin_of(hold.when), end_of(hold.when), "holds a piece"});
  // Failures last: what follows a short one must not hide it.
  for (const bool failures : {false, true})
    for (const SkillRun& skill : robot.skills) {
      const bool failed = skill.ended && skill.code != 0;
      if (failed != failures) continue;
      lane.bars.push_back({failed ? Shape::kAlert : Shape::kBar, failed ? kFailedKind : skill.skill,
                           begin_of(skill.when), end_of(skill.when), skill.skill + ' ' + skill.target,
                           failed         ? ", failed"
                           : !skill.ended ? ", still at work"
                                          : ""});
    }
  for (const RobotStory::Away& away : robot.off_field)
    lane.bars.push_back({Shape::kInset, kAwayKind, begin_of(away.when), end_of(away.when),
                         (away.for_good ? "disqualified (" : "maintenance (") + away.cause + ')'});
  for (const FaultStruck& fault : story.faults)
    if (fault.at == robot.name) lane.marks.push_back({kFaultKind, to_seconds(fault.t), fault.kind});
  return lane;
}

PageLanes Page::lanes() const {
  PageLanes out{"What the robots did",
                {{"drive_to", "drive"},
                 {"pick", "pick"},
                 {"place", "place"},
                 {"discard", "discard"},
                 {"explore", "explore"},
                 {"transport", "transport"},
                 {kFailedKind, "failed"},
                 {kHoldsKind, "holds a piece"}},
                {}};
  if (anybody_off_field()) out.key.push_back({kAwayKind, "off the field"});
  if (!story.pauses.empty()) out.key.push_back({kPauseKind, "the game is paused"});
  if (!story.faults.empty()) out.key.push_back({"", "a fault"});
  for (const RobotStory& robot : story.robots) out.lanes.push_back(lane_of(robot));
  return out;
}

PageTable Page::robots() const {
  PageTable table{"", {"robot", "at work", "driving", "skills", "failed", "contacts"}, {}};
  if (anybody_off_field()) table.columns.emplace_back("maintenance");
  double played = std::max(1.0, to_seconds(story.end));
  for (const Interval& pause : story.pauses) played -= to_seconds(pause.length());
  const auto share = [played](const Json& seconds) {
    return fixed_text(100 * seconds.get<double>() / std::max(1.0, played), 0) + " %";
  };
  for (const Json& robot : result["robots"]) {
    auto& row = table.rows.emplace_back();
    row = {text_in(robot["name"]),   share(robot["busy_s"]),     share(robot["drive_s"]),
           text_in(robot["skills"]), text_in(robot["failures"]), text_in(robot["contacts"])};
    if (!anybody_off_field()) continue;
    std::string stays;
    if (const RobotStory* of = story.robot(text_in(robot["name"])))
      for (const RobotStory::Away& away : of->off_field)
        stays += (stays.empty() ? "" : ", ") + std::string(away.for_good ? "disqualified " : "") +
                 minutes(begin_of(away.when)) + " to " + minutes(end_of(away.when)) + " (" + away.cause + ')';
    row.emplace_back(stays);
  }
  return table;
}

PageTable Page::faults() const {
  constexpr std::size_t kMost = 100;
  PageTable table{"Faults", {"time", "fault", "of"}, {}};
  for (std::size_t i = 0; i < std::min(kMost, story.faults.size()); ++i) {
    const FaultStruck& fault = story.faults[i];
    table.rows.push_back({minutes(to_seconds(fault.t)), fault.kind, fault.at});
  }
  if (story.faults.size() > kMost)
    table.note = "and " + std::to_string(story.faults.size() - kMost) + " more, in journal.jsonl";
  return table;
}

// --- For pages of a user's own

/// In order of their ends.
void sort_by_end(Json& list) {
  std::stable_sort(list.begin(), list.end(), [](const Json& a, const Json& b) { return a["end"] < b["end"]; });
}

Json Page::skills_data() const {
  Json out = Json::array();
  for (const RobotStory& robot : story.robots)
    for (const SkillRun& skill : robot.skills)
      out.push_back({{"robot", robot.name},
                     {"skill", skill.skill},
                     {"target", skill.target},
                     {"begin", begin_of(skill.when)},
                     {"end", end_of(skill.when)},
                     {"state", !skill.ended      ? "running"
                               : skill.code == 0 ? "succeeded"
                                                 : "failed"}});
  sort_by_end(out);
  return out;
}

Json Page::holds_data() const {
  Json out = Json::array();
  for (const RobotStory& robot : story.robots)
    for (const RobotStory::Hold& hold : robot.holds)
      out.push_back({{"robot", robot.name}, {"begin", begin_of(hold.when)}, {"end", end_of(hold.when)}});
  sort_by_end(out);
  return out;
}

Json Page::scores_data() const {
  Json out = Json::array();
  for (const auto& [t, given] : story.points)
    out.push_back({{"team", given.team ? to_string(*given.team) : ""},
                   {"kind", given.kind},
                   {"t", to_seconds(t)},
                   {"points", given.points}});
  return out;
}

Json Page::off_field_data() const {
  Json out = Json::array();
  for (const RobotStory& robot : story.robots)
    for (const RobotStory::Away& away : robot.off_field)
      out.push_back({{"robot", robot.name},
                     {"cause", away.cause},
                     {"state", away.for_good ? "disqualified" : "maintenance"},
                     {"begin", begin_of(away.when)},
                     {"end", end_of(away.when)}});
  sort_by_end(out);
  return out;
}

Json Page::faults_data() const {
  Json out = Json::array();
  for (const FaultStruck& fault : story.faults)
    out.push_back({{"t", to_seconds(fault.t)}, {"kind", fault.kind}, {"at", fault.at}});
  return out;
}

Json Page::pauses_data() const {
  Json out = Json::array();
  for (const Interval& pause : story.pauses) out.push_back({{"begin", begin_of(pause)}, {"end", end_of(pause)}});
  return out;
}

void Page::build() {
  out.kinds = kinds();
  for (const Interval& pause : story.pauses)
    out.shades.push_back({kPauseKind, begin_of(pause), end_of(pause), "paused"});
  if (!result["teams"].empty()) out.parts.emplace_back(points());
  if (!story.points.empty()) out.parts.emplace_back(points_over_time());
  if (!result["orders"].empty()) out.parts.emplace_back(orders());
  if (anybody_worked()) out.parts.emplace_back(lanes());
  if (!result["robots"].empty()) out.parts.emplace_back(robots());
  if (!story.faults.empty()) out.parts.emplace_back(faults());
  for (const auto& [key, data] : {std::pair("skills", skills_data()),
                                  {"holds", holds_data()},
                                  {"scores", scores_data()},
                                  {"off_field", off_field_data()},
                                  {"faults", faults_data()},
                                  {"pauses", pauses_data()}})
    out.data.push_back({key, json_text(data)});
}

}  // namespace

Expected<RunPage> page_of(const AskedRun& run, const Result& result) {
  const auto story = GameStory::read(run);
  if (!story) return story.error();
  Page page{*story, parse_json(result.to_json())};
  page.build();
  return std::move(page.out);
}

}  // namespace cxlab::rcll
