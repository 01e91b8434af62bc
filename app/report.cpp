#include "app/report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>

#include "app/console.h"
#include "app/markup.h"
#include "cx/journal/journal_reader.h"

namespace cxlab::app {

namespace {

/// result.json: its sections are those of the run's world.
using Json = nlohmann::ordered_json;

std::string text(const Json& value) { return value.get<std::string>(); }

std::string number(double value, int digits = 1) {
  char text[48];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  return text;
}

std::string base64(const std::string& bytes) {
  static constexpr char kAlphabet[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned value = 0;
    for (std::size_t k = 0; k < 3; ++k)
      value = value << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) out += i + k <= bytes.size() ? kAlphabet[value >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

constexpr double kWidth = 1000, kLeft = 90;

double x_of(double t, double end) { return kLeft + (kWidth - kLeft - 10) * t / end; }

std::string time_axis(double end, double bottom) {
  const double step = end > 600 ? 120 : end > 120 ? 30 : 10;
  std::string out;
  for (double t = 0; t <= end + 1e-9; t += step) {
    const std::string x = number(x_of(t, end));
    const char* anchor = t + step / 3 > end ? "end" : "middle";  // the last one stays inside of the picture
    out += "<line class=grid x1=" + x + " x2=" + x + " y1=0 y2=" + number(bottom) + " /><text x=" + x +
           " y=" + number(bottom + 14) + " text-anchor=" + anchor + ">" + clock_text(t) + "</text>";
  }
  return out;
}

std::string points_chart(const Report& report, const Json& result, double end) {
  constexpr double kHeight = 180;
  std::map<std::string, std::vector<std::pair<double, double>>> lines;
  double top = 10;
  for (const auto& [team, score] : result["teams"].items()) {
    double sum = 0;
    auto& line = lines[team];
    line.emplace_back(0, 0);
    for (const ScoreStep& step : report.scores) {
      if (step.team != team) continue;
      line.emplace_back(step.t, sum);
      sum += static_cast<double>(step.points);
      line.emplace_back(step.t, sum);
      top = std::max(top, sum);
    }
    line.emplace_back(end, sum);
  }
  std::string out = "<h2>Points over time</h2><svg viewBox='0 0 1000 200'>" + time_axis(end, kHeight);
  for (int i = 0; i <= 4; ++i) {
    const double value = top * i / 4, y = kHeight - (kHeight - 10) * i / 4;
    out += "<line class=grid x1=90 x2=990 y1=" + number(y) + " y2=" + number(y) + " /><text x=84 y=" + number(y + 4) +
           " text-anchor=end>" + number(value, 0) + "</text>";
  }
  for (const auto& [team, line] : lines) {
    out += "<polyline fill=none stroke-width=2.5 class='" + escape(team) + "' points='";
    for (const auto& [t, points] : line)
      out += number(x_of(t, end)) + ',' + number(kHeight - (kHeight - 10) * points / top) + ' ';
    out += "'/>";
  }
  return out + "</svg>";
}

std::string gantt(const Report& report, const Json& result, double end) {
  constexpr double kRow = 34;
  std::vector<std::string> robots;
  for (const Json& robot : result["robots"]) robots.push_back(text(robot["name"]));
  const double height = kRow * static_cast<double>(robots.size());
  std::string out =
      "<h2>What the robots did</h2><p class=key><span class=drive_to>drive</span><span class=pick>pick</span><span "
      "class=place>place</span>"
      "<span class=failed>failed</span></p><svg viewBox='0 0 1000 " +
      number(height + 20) + "'>" + time_axis(end, height);
  for (std::size_t i = 0; i < robots.size(); ++i) {
    const double y = kRow * static_cast<double>(i) + 5;
    out += "<text x=4 y=" + number(y + 16) + ">" + escape(robots[i]) + "</text>";
    for (const SkillBar& bar : report.skills) {
      if (bar.robot != robots[i]) continue;
      out += "<rect class='" + escape(bar.skill) + (bar.ended && !bar.succeeded ? " failed" : "") +
             "' x=" + number(x_of(bar.begin, end), 2) + " y=" + number(y) +
             " width=" + number(std::max(0.5, x_of(bar.end, end) - x_of(bar.begin, end)), 2) + " height=24><title>" +
             escape(bar.skill + ' ' + bar.target) + ", " + number(bar.begin) + " to " + number(bar.end) + " s" +
             (!bar.ended      ? ", still at work"
              : bar.succeeded ? ""
                              : ", failed") +
             "</title></rect>";
    }
  }
  return out + "</svg>";
}

std::string order_table(const Json& orders) {
  if (orders.empty()) return {};
  std::string out = "<h2>Orders</h2><table><tr><th>order<th>product<th>known from<th>delivered<th>points</tr>";
  for (const Json& order : orders)
    out +=
        "<tr><td>" + order["id"].dump() + "<td>" + escape(text(order["complexity"])) + "<td>" +
        clock_text(order["ordered"]) + "<td>" +
        (order["delivered_at"].is_null() ? std::string("-")
                                         : clock_text(order["delivered_at"]) + (order["correct"] ? "" : " (wrong)")) +
        "<td>" + order["points"].dump() + "</tr>";
  return out + "</table>";
}

std::string robot_table(const Json& robots, double end) {
  if (robots.empty()) return {};
  std::string out = "<table><tr><th>robot<th>at work<th>driving<th>skills<th>failed<th>contacts</tr>";
  const auto share = [&](const Json& seconds) { return number(100 * seconds.get<double>() / std::max(1e-9, end), 0); };
  for (const Json& robot : robots)
    out += "<tr><td>" + escape(text(robot["name"])) + "<td>" + share(robot["busy_s"]) + " %<td>" +
           share(robot["drive_s"]) + " %<td>" + robot["skills"].dump() + "<td>" + robot["failures"].dump() + "<td>" +
           robot["contacts"].dump() + "</tr>";
  return out + "</table>";
}

std::string turtle_table(const Json& turtles) {
  if (turtles.empty()) return {};
  std::string out = "<h2>Turtles</h2><table><tr><th>turtle<th>x<th>y<th>driven<th>walls<th>touches<th>teleports</tr>";
  for (const Json& turtle : turtles)
    out += "<tr><td>" + escape(text(turtle["name"])) + (turtle["alive"] ? "" : " (killed)") + "<td>" +
           number(turtle["x"], 2) + "<td>" + number(turtle["y"], 2) + "<td>" + number(turtle["driven_m"]) + " m<td>" +
           turtle["walls"].dump() + "<td>" + turtle["touches"].dump() + "<td>" + turtle["teleports"].dump() + "</tr>";
  return out + "</table>";
}

std::string rule_error_table(const Result& result) {
  if (result.rule_errors.empty()) return {};
  std::string out = "<h2>Errors in rules</h2><table><tr><th>rule<th>place<th>side<th>tick<th>what</tr>";
  constexpr std::size_t kShown = 50;
  for (std::size_t i = 0; i < std::min(kShown, result.rule_errors.size()); ++i) {
    const RuleErrorResult& e = result.rule_errors[i];
    out += "<tr><td>" + escape(e.rule) + "<td>" + escape(e.file) + ':' + std::to_string(e.line) + "<td>" +
           escape(e.side) + "<td>" + std::to_string(e.tick) + "<td class=bad>" + escape(e.message) + "</tr>";
  }
  out += "</table>";
  if (result.rule_errors.size() > kShown)
    out += "<p>and " + std::to_string(result.rule_errors.size() - kShown) + " more, in result.json</p>";
  return out;
}

/// To what lies beside the page: they work as long as it stays in the run's folder.
std::string links(const Report& report) {
  std::string out = "<h2>Files of this run</h2><p>";
  for (const std::string& file : report.files) out += "<a href='" + escape(file) + "'>" + escape(file) + "</a> ";
  return out + "</p>";
}

std::string team_table(const Json& teams) {
  if (teams.empty()) return {};
  std::string out = "<table class=teams><tr><th>team<th>points";
  for (const auto& [kind, points] : teams.front()["by_kind"].items()) out += "<th>" + escape(kind);
  out += "</tr>";
  for (const auto& [team, score] : teams.items()) {
    out += "<tr><td><b class='" + escape(team) + "'>" + escape(team) + "</b><td><b>" + score["points"].dump() + "</b>";
    for (const auto& [kind, points] : score["by_kind"].items()) out += "<td>" + points.dump();
    out += "</tr>";
  }
  return out + "</table>";
}

constexpr const char* kStyle =
    "body{font:15px/1.5 system-ui,sans-serif;max-width:1060px;margin:2em auto;padding:0 1em;color:#222}h1{margin:0}"
    "h2{font-size:1.1em;margin:1.6em 0 .4em}table{border-collapse:collapse}td,th{padding:.25em .9em .25em "
    "0;text-align:left;border-bottom:1px solid #ddd}"
    "th{font-weight:600;color:#666}svg{width:100%;height:auto}svg text{font-size:12px;fill:#555}.grid{stroke:#e4e4e4}"
    "polyline.CYAN{stroke:#0093b8}polyline.MAGENTA{stroke:#c2187f}b.CYAN{color:#0093b8}b.MAGENTA{color:#c2187f}"
    ".drive_to{fill:#8fb8de;background:#8fb8de}.pick{fill:#f2b134;background:#f2b134}.place{fill:#6ab46a;background:#"
    "6ab46a}"
    "rect.failed{fill:#d64545}span.failed{background:#d64545}.key span{padding:.1em "
    ".7em;margin-right:.6em;border-radius:3px}"
    "figure{display:inline-block;margin:.4em .6em .4em "
    "0;width:48%}img{width:100%}figcaption{color:#666}.bad{color:#b00020}";

/// Skills that began and have not ended yet, by robot.
using OpenSkills = std::map<std::string, SkillBar, std::less<>>;

void note_skill(const JournalRecord& record, OpenSkills& open, std::vector<SkillBar>& out) {
  const std::string robot(record.data.text("robot"));
  const std::string_view event = record.data.text("event");
  if (event == "start") {
    open[robot] = {robot,
                   std::string(record.data.text("skill")),
                   std::string(record.data.text("target")),
                   to_seconds(record.t),
                   0,
                   false,
                   true};
  } else if (event == "end" && open.contains(robot)) {
    SkillBar bar = open[robot];
    bar.end = to_seconds(record.t);
    bar.succeeded = record.data.integer("code") == 0;
    out.push_back(std::move(bar));
    open.erase(robot);
  }
}

}  // namespace

Status read_story(const std::filesystem::path& journal, Report& report) {
  auto reader = JournalReader::open(journal);
  if (!reader) return reader.error();
  reader->only({RecordKind::kSkill, RecordKind::kReferee});
  OpenSkills open;
  while (true) {
    auto record = reader->next();
    if (!record) return record.error();
    if (!*record) break;
    if ((*record)->kind == RecordKind::kSkill)
      note_skill(**record, open, report.skills);
    else if ((*record)->kind == RecordKind::kReferee && (*record)->data.text("event") == "score")
      report.scores.push_back({std::string((*record)->data.text("team")), std::string((*record)->data.text("kind")),
                               to_seconds((*record)->t), (*record)->data.integer("points")});
  }
  for (auto& [robot, bar] : open) {
    bar.end = to_seconds(report.result.sim_time);
    bar.ended = false;
    report.skills.push_back(bar);
  }
  return {};
}

std::string to_html(const Report& report) {
  const Result& r = report.result;
  const Json json = Json::parse(r.to_json());
  const double end = std::max(1.0, to_seconds(r.sim_time));
  std::string out =
      "<!doctype html><html lang=en><meta charset=utf-8><meta name=viewport content='width=device-width'><title>" +
      escape(r.scenario) + ", seed " + std::to_string(r.seed) + "</title><style>" + kStyle + "</style><h1>" +
      escape(r.scenario) + ", seed " + std::to_string(r.seed) + "</h1><p>" + to_string(r.status) + " after " +
      clock_text(to_seconds(r.sim_time)) + " of simulated time, " + (r.tier == "none" ? "" : r.tier + " tier, ") +
      number(r.real_time_factor, 0) + " x real time";
  if (r.reason) out += "<br><span class=bad>" + escape(r.reason->text()) + "</span>";
  out += "</p>" + team_table(json["teams"]);
  if (!report.scores.empty()) out += points_chart(report, json, end);
  out += order_table(json["orders"]);
  if (!report.skills.empty()) out += gantt(report, json, end);
  out += robot_table(json["robots"], to_seconds(r.sim_time)) + turtle_table(json.value("turtles", Json::array())) +
         rule_error_table(r) + links(report);
  if (!report.pictures.empty()) out += "<h2>Pictures</h2>";
  for (const lab::Picture& picture : report.pictures) {
    std::ifstream in(picture.file, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(in)), {});
    out += "<figure><img alt='" + escape(picture.caption) + "' src='data:image/png;base64," + base64(bytes) +
           "'><figcaption>" + escape(picture.caption) + "</figcaption></figure>";
  }
  return out + "</html>\n";
}

}  // namespace cxlab::app
