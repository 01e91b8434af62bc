#include "scenarios/rcll/page/page.h"

#include <algorithm>

#include "cx/base/json.h"
#include "cx/base/number_text.h"
#include "scenarios/rcll/page/parts.h"
#include "scenarios/rcll/questions/products.h"

namespace cxlab::rcll {

namespace {

// Colours that people who see fewer of them can tell apart; what is alike has stripes as well.
const std::vector<PageKind>& kinds() {
  static const std::vector<PageKind> kAll{
      {"CYAN", "#2f9fbf", "#007d9c"},
      {"MAGENTA", "#c9519b", "#b3126e"},
      {"drive_to", "#56b4e9", ""},
      {"transport", "#c9a94e", ""},
      {"explore", "#b39bd6", ""},
      {"discard", "#8a8a8a", ""},
      {"pick", "#e69f00", ""},
      {"place", "#009e73", ""},
      {kHoldsKind, "#7a5c99", "#7a5c99"},
      {kWaitsKind, "#e8c9a0", "", true},
      {kIdleKind, "#88888838", ""},
      {kBusyKind, "#009e73", ""},
      {kBlockedKind, "#e69f00", "", true},
      {kDownKind, "#8a6d8f", ""},
      {kBrokenKind, "#a50f15", "#a50f15", true},
      {kFailedKind, "#d5421e", "#b8330f", true},
      {kAwayKind, "#444444", "#444444"},
      {kFaultKind, "#000000", "#000000"},
      {kPauseKind, "#88888860", ""},
      {kPointsKind, "#0072b2", "#0072b2"},
      {kOrderKind, "#6f6f6f", "#6f6f6f"},
      {kInTimeKind, "#009e73", "#00694c"},
      {kLateKind, "#e69f00", "#8f6200", true},
      {kLostKind, "#d5421e", "#b8330f", true},
      {kOpenKind, "#9a9a9a", "#5a5a5a"},
      // Kinds of points, as parts of a sum.
      {"delivery", "", "#0072b2"},
      {"ring", "", "#009e73"},
      {"cap", "", "#a07000"},
      {"buffer", "", "#7a5c99"},
      {"payment", "", "#4a90c2"},
      {"late", "", "#c8401c"},
      {"competitive", "", "#8f8f00"},
      {"exploration", "", "#9b3f80"},
      {"penalty", "", "#a50f15"},
  };
  return kAll;
}

/// "5:12".
std::string minutes(double seconds) {
  const auto whole = static_cast<long long>(seconds);
  return std::to_string(whole / 60) + (whole % 60 < 10 ? ":0" : ":") + std::to_string(whole % 60);
}

std::string text_in(const Json& value) { return value.is_string() ? value.get<std::string>() : json_text(value); }

/// A game that has been played, and what the page makes of it.
struct Page {
  const GameStory& story;
  Json result;
  RunPage out{};

  PageTable points() const;
  PageChart points_over_time() const;
  PageTable robots() const;
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
  PageTable table{"Points", {"team", "points"}, {}};
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
void add_step(PageLine& line, SimTime t, std::int64_t points) {
  const double before = line.steps.empty() ? 0 : line.steps.back().second;
  if (line.steps.empty() || line.steps.back().first != to_seconds(t)) line.steps.emplace_back(to_seconds(t), before);
  line.steps.back().second += static_cast<double>(points);
}

/// For each team a line of all its points, and one for each kind that it had.
PageChart Page::points_over_time() const {
  PageChart chart{"Points over time", {}};
  const Json& teams = result["teams"];
  for (const auto& [name, score] : teams.items()) {
    PageLine sum{name, {}, name};
    std::vector<PageLine> parts;
    for (const auto& [kind, unused] : score["by_kind"].items())
      parts.push_back({kind, {}, story.teams.size() > 1 ? name + ' ' + kind : kind, true});
    for (const auto& [t, given] : story.points) {
      if (given.team != named<Team>(name)) continue;
      add_step(sum, t, given.points);
      if (const auto part = std::ranges::find(parts, given.kind, &PageLine::kind); part != parts.end())
        add_step(*part, t, given.points);
    }
    std::erase_if(parts, [](const PageLine& part) { return part.steps.empty(); });
    if (sum.steps.empty() && std::ranges::find(story.teams, named<Team>(name)) == story.teams.end()) continue;
    chart.lines.push_back(std::move(sum));
    std::ranges::move(parts, std::back_inserter(chart.lines));
  }
  return chart;
}

PageTable Page::robots() const {
  PageTable table{"Work of the robots", {"robot", "at work", "driving", "skills", "failed", "contacts"}, {}};
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

// --- For pages of a user's own

/// In order of their ends.
void sort_by_end(Json& list) {
  std::stable_sort(list.begin(), list.end(), [](const Json& a, const Json& b) { return a["end"] < b["end"]; });
}

Json Page::skills_data() const {
  Json skills = Json::array();
  for (const RobotStory& robot : story.robots)
    for (const SkillRun& skill : robot.skills)
      skills.push_back({{"robot", robot.name},
                        {"skill", skill.skill},
                        {"target", skill.target},
                        {"begin", begin_of(skill.when)},
                        {"end", end_of(skill.when)},
                        {"state", !skill.ended      ? "running"
                                  : skill.code == 0 ? "succeeded"
                                                    : "failed"}});
  sort_by_end(skills);
  return skills;
}

Json Page::holds_data() const {
  Json holds = Json::array();
  for (const RobotStory& robot : story.robots)
    for (const RobotStory::Hold& hold : robot.holds)
      holds.push_back({{"robot", robot.name}, {"begin", begin_of(hold.when)}, {"end", end_of(hold.when)}});
  sort_by_end(holds);
  return holds;
}

Json Page::scores_data() const {
  Json scores = Json::array();
  for (const auto& [t, given] : story.points)
    scores.push_back({{"team", given.team ? to_string(*given.team) : ""},
                      {"kind", given.kind},
                      {"t", to_seconds(t)},
                      {"points", given.points}});
  return scores;
}

Json Page::off_field_data() const {
  Json absences = Json::array();
  for (const RobotStory& robot : story.robots)
    for (const RobotStory::Away& away : robot.off_field)
      absences.push_back({{"robot", robot.name},
                          {"cause", away.cause},
                          {"state", away.for_good ? "disqualified" : "maintenance"},
                          {"begin", begin_of(away.when)},
                          {"end", end_of(away.when)}});
  sort_by_end(absences);
  return absences;
}

Json Page::faults_data() const {
  Json faults = Json::array();
  for (const FaultStruck& fault : story.faults)
    faults.push_back({{"t", to_seconds(fault.t)}, {"kind", fault.kind}, {"at", fault.at}});
  return faults;
}

Json Page::pauses_data() const {
  Json pauses = Json::array();
  for (const Interval& pause : story.pauses) pauses.push_back({{"begin", begin_of(pause)}, {"end", end_of(pause)}});
  return pauses;
}

void Page::build() {
  const std::vector<OrderWork> works = work_for_orders(story);
  out.kinds = kinds();
  for (const Interval& pause : story.pauses)
    out.shades.push_back({kPauseKind, begin_of(pause), end_of(pause), "paused"});
  if (!result["teams"].empty()) out.parts.emplace_back(points());
  out.parts.emplace_back(tasks_of(story, works));
  if (anybody_worked()) out.parts.emplace_back(robot_lanes(story, works));
  out.parts.emplace_back(machine_lanes(story));
  if (!story.points.empty()) out.parts.emplace_back(points_over_time());
  if (!result["robots"].empty()) out.parts.emplace_back(robots());
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
