#include "app/plan_picture.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "app/markup.h"

namespace cxlab::app {

namespace {

constexpr int kRow = 20, kTop = 30, kLegend = 34;
constexpr double kOrdinaryBar = 30, kNarrowest = 420, kWidest = 1600;  ///< width of a bar of median length; of all time
constexpr double kLetter = 6.4;                                        ///< width, at least that of most letters

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", value);
  return text;
}

/// The least of ... 1, 2, 5, 10, 20, 50 ... that is not below `least`.
double round_step(double least) {
  const double unit = std::pow(10, std::floor(std::log10(std::max(least, 1e-3))));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * unit >= least) return factor * unit;
  return 10 * unit;
}

/// Width of all the time: an ordinary bar can be told from its neighbours, and the legend has room.
double width_of(const planner::TimedPlan& plan) {
  std::vector<double> durations;
  for (const planner::PlanStep& step : plan.steps)
    if (step.duration > 0) durations.push_back(step.duration);
  if (durations.empty()) return kNarrowest;
  const auto median = durations.begin() + static_cast<std::ptrdiff_t>(durations.size() / 2);
  std::nth_element(durations.begin(), median, durations.end());
  return std::clamp(kOrdinaryBar * plan.makespan_s / *median, kNarrowest, kWidest);
}

/// A sample of each mark with its meaning, from (x, y) on.
std::string legend(int x, int y) {
  const std::string middle = std::to_string(y - 4), text = std::to_string(y);
  const auto at = [&](int offset) { return std::to_string(x + offset); };
  return "<rect x=\"" + at(0) + "\" y=\"" + std::to_string(y - 10) +
         "\" width=\"24\" height=\"13\" fill=\"#4e79a7\"/><text x=\"" + at(30) + "\" y=\"" + text +
         "\">runs</text><line x1=\"" + at(70) + "\" y1=\"" + middle + "\" x2=\"" + at(94) + "\" y2=\"" + middle +
         "\" stroke=\"#bbb\" stroke-width=\"3\"/><text x=\"" + at(100) + "\" y=\"" + text +
         "\">slack: may end this late, makespan kept</text><line x1=\"" + at(326) + "\" y1=\"" + middle + "\" x2=\"" +
         at(350) + "\" y2=\"" + middle +
         "\" stroke=\"#999\" stroke-width=\"0.7\" marker-end=\"url(#tip)\"/><text x=\"" + at(356) + "\" y=\"" + text +
         "\">waits for</text>\n";
}

}  // namespace

std::string plan_picture(const planner::TimedPlan& plan, const planner::Task& task) {
  std::size_t longest = 16;
  for (const planner::PlanStep& step : plan.steps)
    longest = std::max(longest, planner::step_text(step, task.domain, task.problem).size());
  const int left = static_cast<int>(kLetter * static_cast<double>(longest)) + 16;
  const double width = width_of(plan), scale = width / std::max(plan.makespan_s, 1e-9);
  const auto x = [&](double seconds) { return number(left + seconds * scale); };
  const auto y = [](std::size_t row) { return kTop + static_cast<int>(row) * kRow; };
  const int bottom = y(plan.steps.size()) + 10, height = bottom + kLegend;
  std::string svg =
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + std::to_string(left + static_cast<int>(width) + 40) +
      "\" height=\"" + std::to_string(height) +
      "\" font-family=\"sans-serif\" font-size=\"11\">\n"
      "<defs><marker id=\"tip\" markerWidth=\"6\" markerHeight=\"6\" refX=\"5\" refY=\"3\" orient=\"auto\">"
      "<path d=\"M0,0 L6,3 L0,6 z\" fill=\"#999\"/></marker></defs>\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
  const double step_s = round_step(plan.makespan_s / 10);
  for (int tick = 0; tick * step_s <= plan.makespan_s; ++tick) {
    const double seconds = tick * step_s;
    svg += "<line x1=\"" + x(seconds) + "\" y1=\"" + std::to_string(kTop - 8) + "\" x2=\"" + x(seconds) + "\" y2=\"" +
           std::to_string(bottom) + "\" stroke=\"#eee\"/><text x=\"" + x(seconds) +
           "\" y=\"16\" text-anchor=\"middle\">" + number(seconds) + " s</text>\n";
  }
  static const char* const kColours[] = {"#4e79a7", "#f28e2b", "#59a14f", "#e15759",
                                         "#76b7b2", "#edc948", "#b07aa1", "#9c755f"};
  std::vector<int> actions;  // of the plan: so many have a colour of their own
  for (const planner::PlanStep& step : plan.steps)
    if (std::find(actions.begin(), actions.end(), step.action) == actions.end()) actions.push_back(step.action);
  for (std::size_t i = 0; i < plan.steps.size(); ++i) {
    const planner::PlanStep& step = plan.steps[i];
    const auto colour =
        static_cast<std::size_t>(std::find(actions.begin(), actions.end(), step.action) - actions.begin());
    const double latest = static_cast<double>(plan.latest[2 * i + 1]) / planner::kMicrosPerSecond;
    svg += "<text x=\"" + std::to_string(left - 8) + "\" y=\"" + std::to_string(y(i) + 13) + "\" text-anchor=\"end\">" +
           escape(planner::step_text(step, task.domain, task.problem)) + "</text>";
    svg += "<line x1=\"" + x(step.start) + "\" y1=\"" + std::to_string(y(i) + 8) + "\" x2=\"" + x(latest) + "\" y2=\"" +
           std::to_string(y(i) + 8) + "\" stroke=\"#bbb\" stroke-width=\"3\"/>";
    svg += "<rect x=\"" + x(step.start) + "\" y=\"" + std::to_string(y(i) + 2) + "\" width=\"" +
           number(std::max(1.0, step.duration * scale)) + "\" height=\"13\" fill=\"" +
           kColours[colour % std::size(kColours)] + "\"><title>" + number(step.start) + " to " +
           number(step.start + step.duration) + " s, at the latest " + number(latest) + " s</title></rect>\n";
  }
  for (const planner::Ordering& ordering : plan.orderings) {
    if (ordering.from < 0 || ordering.from / 2 == ordering.to / 2) continue;
    const auto point = [&](int p) {
      const planner::PlanStep& step = plan.steps[static_cast<std::size_t>(p / 2)];
      return x(step.start + (p % 2 ? step.duration : 0));
    };
    svg += "<line x1=\"" + point(ordering.from) + "\" y1=\"" +
           std::to_string(y(static_cast<std::size_t>(ordering.from / 2)) + 8) + "\" x2=\"" + point(ordering.to) +
           "\" y2=\"" + std::to_string(y(static_cast<std::size_t>(ordering.to / 2)) + 8) +
           "\" stroke=\"#999\" stroke-width=\"0.7\" marker-end=\"url(#tip)\"/>\n";
  }
  return svg + legend(left, bottom + 20) + "</svg>\n";
}

}  // namespace cxlab::app
