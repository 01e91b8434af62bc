// cxlab waits: what each robot waited for.

#include <algorithm>

#include "scenarios/rcll/questions/questions.h"
#include "scenarios/rcll/questions/waiting.h"

namespace cxlab::rcll {

namespace {

constexpr SimTime kShortest = std::chrono::seconds(1);  ///< of a wait that has a line of its own

SimTime length_within(const std::vector<Interval>& intervals, const Interval& asked) {
  SimTime sum{};
  for (const Interval& interval : intervals)
    if (const Interval part = common(interval, asked); !part.empty()) sum += part.length();
  return sum;
}

struct Sums {
  std::vector<Waiting> reasons;
  std::vector<std::int64_t> counts;
};

/// A line for the robot: its time by what it did.
std::vector<TableCell> whole_time(const GameStory& story, const RobotStory& robot,
                                  const std::vector<RobotWait>& waits) {
  std::vector<Interval> skills, away;
  for (const SkillRun& skill : robot.skills) skills.push_back(skill.when);
  for (const RobotStory::Away& one : robot.off_field) away.push_back(one.when);
  SimTime standing{}, idle{};
  for (const RobotWait& wait : waits) (wait.in_skill ? standing : idle) += wait.waiting.when.length();
  const SimTime with_skill = length_within(skills, story.asked());
  // A skill ends a tick after people took its robot away: that tick is one of the skill.
  const SimTime off = story.asked().length() - with_skill - idle;
  return {robot.name, TableCell(to_string(robot.team)), story.asked().length(), with_skill - standing, standing, idle,
          off};
}

}  // namespace

Expected<WorldAnswer> answer_waits(const AskedRun& run) {
  const auto story = GameStory::read(run);
  if (!story) return story.error();
  if (!run.about.empty() && !story->robot(run.about)) {
    std::vector<std::string> known;
    for (const RobotStory& robot : story->robots) known.push_back(robot.name);
    return usage_error("there is no robot '" + std::string(run.about) + "' in this game; it has " +
                       some_of_and_nearest(std::string(run.about), known));
  }
  Table waits{"waits",
              "",
              {{"robot", "robot"},
               {"from_s", "from", Column::Kind::kTime},
               {"to_s", "to", Column::Kind::kTime},
               {"length_s", "length", Column::Kind::kSeconds},
               {"for", "for"},
               {"in_skill", "skill"},
               {"why", "why"}},
              {}};
  Table sums{"sums",
             "by reason",
             {{"robot", "robot"},
              {"length_s", "time", Column::Kind::kSeconds},
              {"count", "waits", Column::Kind::kNumber},
              {"for", "for"},
              {"why", "why"}},
             {}};
  Table robots{"robots",
               "all of the time",
               {{"robot", "robot"},
                {"team", "team"},
                {"time_s", "time", Column::Kind::kSeconds},
                {"working_s", "at work", Column::Kind::kSeconds},
                {"standing_s", "waiting in a skill", Column::Kind::kSeconds},
                {"idle_s", "without a skill", Column::Kind::kSeconds},
                {"off_field_s", "off the field", Column::Kind::kSeconds}},
               {}};
  std::int64_t left_out = 0;
  SimTime left_out_time{};
  for (const RobotStory& robot : story->robots) {
    if (!run.about.empty() && robot.name != run.about) continue;
    const std::vector<RobotWait> all = waits_of(*story, robot);
    std::vector<Waiting> by_reason;
    for (const RobotWait& wait : all) {
      const Waiting& one = wait.waiting;
      add_to(by_reason, one);
      if (one.when.length() < kShortest) {
        ++left_out;
        left_out_time += one.when.length();
        continue;
      }
      waits.rows.push_back(
          {robot.name, one.when.from, one.when.to, one.when.length(), one.what, wait.in_skill ? "yes" : "no", one.why});
    }
    std::ranges::stable_sort(by_reason, std::greater(), [](const Waiting& sum) { return sum.when.length(); });
    for (const Waiting& sum : by_reason) {
      const auto count = std::ranges::count_if(all, [&](const RobotWait& w) { return same_reason(w.waiting, sum); });
      sums.rows.push_back({robot.name, sum.when.length(), static_cast<std::int64_t>(count), sum.what, sum.why});
    }
    robots.rows.push_back(whole_time(*story, robot, all));
  }
  WorldAnswer answer{{std::move(waits), std::move(sums), std::move(robots)}, {}};
  if (left_out > 0)
    answer.notes.push_back(std::to_string(left_out) + " waits shorter than " + length_text(kShortest) + ", " +
                           length_text(left_out_time) + " together, have no line of their own; the sums have them");
  return answer;
}

}  // namespace cxlab::rcll
