#include "planner/pddl/plan.h"

#include <algorithm>
#include <optional>
#include <ranges>
#include <span>
#include <utility>

#include "planner/pddl/syntax.h"
#include "planner/pddl/text.h"

namespace cxlab::planner {
namespace {

constexpr std::string_view kForm = "TIME: (ACTION OBJECT...) [DURATION]";

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r\f\v";
  const std::size_t first = text.find_first_not_of(kSpace);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kSpace) - first + 1);
}

/// LPG writes `[D:5.0; C:1.0]`: a semicolon in brackets begins no comment.
std::string_view without_comment(std::string_view line) {
  bool bracket = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '[') bracket = true;
    if (line[i] == ']') bracket = false;
    if (line[i] == ';' && !bracket) return line.substr(0, i);
  }
  return line;
}

/// How a planner announces a plan, and how it writes steps.
enum class Style {
  kTimed,      ///< 0.000: (move a b) [5.000]
  kNumbered,   ///< step    0: MOVE A B
  kWithCost,   ///< move a b (1)
  kAsFunction  ///< 0.0: move(a, b) [5.0]
};
struct Announcement {
  std::string_view begins;  ///< of a line, or
  std::string_view holds;   ///< what it has anywhere
  Style style;
};
constexpr Announcement kAnnouncements[] = {
    {{}, ";;;; solution found", Style::kTimed},             // POPF, OPTIC: behind what they printed last
    {{}, "; plan found with metric", Style::kTimed},        // OPTIC
    {"plan computed:", {}, Style::kTimed},                  // LPG
    {"found plan:", {}, Style::kTimed},                     // ENHSP
    {"found new plan:", {}, Style::kTimed},                 // TFD
    {"rescheduled plan:", {}, Style::kTimed},               // TFD
    {{}, "found legal plan as follows", Style::kNumbered},  // FF, Metric-FF
    {{}, "solution found!", Style::kWithCost},              // Fast Downward, LAMA
    {"sequentialplan:", {}, Style::kAsFunction},            // Unified Planning Framework
    {"timetriggeredplan:", {}, Style::kAsFunction},         // Unified Planning Framework
};

std::optional<Style> announced(std::string_view line) {
  for (const auto& [begins, holds, style] : kAnnouncements)
    if (begins.empty() ? line.find(holds) != line.npos : line.starts_with(begins)) return style;
  return std::nullopt;
}

/// `number:` at the beginning of a line, and what stands behind it.
std::optional<std::pair<double, std::string_view>> after_number(std::string_view line) {
  const std::size_t colon = line.find(':');
  double number = 0;
  if (colon == line.npos || !to_number(trimmed(line.substr(0, colon)), number)) return std::nullopt;
  return std::pair(number, trimmed(line.substr(colon + 1)));
}

/// A step as `TIME: (ACTION OBJECT...) [DURATION]`; none if the line is no step in that style.
std::optional<std::string> step_in(Style style, std::string_view line) {
  switch (style) {
    case Style::kTimed:
      return line.starts_with('(') || after_number(line) ? std::optional<std::string>(line) : std::nullopt;
    case Style::kNumbered: {
      if (line.starts_with("step")) line = trimmed(line.substr(4));
      const auto step = after_number(line);
      return step ? std::optional("(" + std::string(step->second) + ")") : std::nullopt;
    }
    case Style::kWithCost: {
      const std::size_t open = line.rfind(" (");
      double cost = 0;
      if (open == line.npos || !line.ends_with(')') || !to_number(line.substr(open + 2, line.size() - open - 3), cost))
        return std::nullopt;
      return "(" + std::string(line.substr(0, open)) + ")";
    }
    case Style::kAsFunction: {
      const auto timed = after_number(line);
      if (timed) line = timed->second;
      const std::size_t bracket = std::min(line.find('['), line.size());
      std::string call(trimmed(line.substr(0, bracket)));
      if (call.empty()) return std::nullopt;
      std::ranges::replace_if(call, [](char c) { return c == '(' || c == ')' || c == ','; }, ' ');
      return (timed ? number_text(timed->first) + ": (" : "(") + call + ") " + std::string(line.substr(bracket));
    }
  }
  return std::nullopt;
}

class PlanReader {
 public:
  PlanReader(const std::string& file, const Domain& domain, const Problem& problem)
      : file_(file), domain_(domain), problem_(problem) {}

  Plan read(std::string_view text) {
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);  // the mark of UTF-8 files
    const std::string lower = lower_case(text);
    std::vector<std::string_view> lines;
    for (const auto& part : lower | std::views::split('\n')) lines.push_back(trimmed({part.begin(), part.end()}));
    const auto last = std::ranges::find_if(lines.rbegin(), lines.rend(),
                                           [](std::string_view line) { return announced(line).has_value(); });
    if (last != lines.rend()) {
      read_announced(*announced(*last), std::span(lines).subspan(static_cast<std::size_t>(last.base() - lines.begin())),
                     static_cast<int>(last.base() - lines.begin()));
      return std::move(plan_);
    }
    for (const std::string_view raw : lines) {
      ++line_;
      const std::string_view line = trimmed(without_comment(raw));
      if (!line.empty()) step(line);
    }
    return std::move(plan_);
  }

 private:
  /// The steps behind an announcement, up to what is no step.
  void read_announced(Style style, std::span<const std::string_view> lines, int before) {
    line_ = before;
    for (const std::string_view raw : lines) {
      ++line_;
      std::string_view line = trimmed(without_comment(raw));
      if (line.starts_with("time: (action)")) continue;        // the heading of LPG
      if (line.starts_with("[t=") && plan_.empty()) continue;  // Fast Downward's clock
      if (line.starts_with("actual search time") && plan_.empty()) continue;
      if (line.empty() && plan_.empty()) continue;
      const auto found = step_in(style, line);
      if (!found) return;
      if (style == Style::kNumbered && *found == "(reach-goal)" && find(domain_.action_names, "reach-goal") < 0)
        continue;
      step(*found);
    }
  }

  template <class... Parts>
  [[noreturn]] void fail(const Parts&... parts) const {
    throw Rejected{input_error(message(parts...), file_, line_)};
  }

  void step(std::string_view line) {
    const std::size_t open = line.find('('), close = line.find(')');
    if (open == std::string_view::npos || close == std::string_view::npos || close < open)
      fail(found_text(line.substr(0, 60), kForm));
    PlanStep& step = plan_.emplace_back();
    step.line = line_;
    const std::string_view time = trimmed(line.substr(0, open));
    if (time.empty())
      step.start = static_cast<double>(plan_.size() - 1);
    else if (!time.ends_with(':') || !to_number(trimmed(time.substr(0, time.size() - 1)), step.start))
      fail(found_expected(message("'", time.substr(0, 60), "' for the time"), kForm));
    action(line.substr(open + 1, close - open - 1), step);
    duration(trimmed(line.substr(close + 1)), step);
  }

  template <class Item>
  static std::string hint(const std::string& name, const ById<Item>& items) {
    std::vector<std::string> known;
    for (const Item& item : items) known.push_back(item.name);
    return did_you_mean(name, known, "; ");
  }

  void action(std::string_view words, PlanStep& step) {
    std::vector<std::string> names;
    while (!(words = trimmed(words)).empty()) {
      const std::size_t end = std::min(words.find_first_of(" \t"), words.size());
      names.emplace_back(words.substr(0, end));
      words.remove_prefix(end);
    }
    if (names.empty()) fail(found_expected("an empty action", kForm));
    step.action = find(domain_.action_names, names[0]);
    if (step.action < 0) fail(found_text(names[0], "an action of "), domain_.file, hint(names[0], domain_.actions));
    const Action& action = domain_.actions[step.action];
    const std::string declared = message("; declared at ", domain_.file, ":", action.source.line);
    if (names.size() - 1 != action.parameters.size())
      fail(
          found_expected(message(names.size() - 1, names.size() == 2 ? " argument of " : " arguments of ", action.name),
                         message(action.parameters.size())),
          declared);
    for (const Variable& parameter : action.parameters) {
      const std::string& name = names[step.arguments.size() + 1];
      const ObjectId object = step.arguments.emplace_back(find(problem_.object_names, name));
      if (object < 0) fail(found_text(name, "an object of "), problem_.file, hint(name, problem_.objects));
      if (!fits(domain_, problem_.objects[object], parameter.types))
        fail(found_expected(message("'", name, "' for argument ", step.arguments.size(), " of ", action.name),
                            "an object for "),
             Printer(domain_, problem_.objects).variables({parameter}), declared);
    }
  }

  void duration(std::string_view text, PlanStep& step) {
    const Action& action = domain_.actions[step.action];
    if (text.empty()) {
      if (action.durative) fail(found_expected(message("no duration of the durative action ", action.name), kForm));
      return;
    }
    if (!text.starts_with('[') || !text.ends_with(']'))
      fail(found_expected(message("'", text.substr(0, 60), "' behind the action"), "[DURATION]"));
    std::string_view number = trimmed(text.substr(1, text.size() - 2));
    if (number.starts_with("d:")) number = trimmed(number.substr(2, number.find(';') - 2));
    double seconds = 0;
    if (!to_number(number, seconds)) fail(found_text(text.substr(0, 60), "a duration such as [5.000]"));
    if (action.durative) step.duration = seconds;
  }

  const std::string& file_;
  const Domain& domain_;
  const Problem& problem_;
  Plan plan_;
  int line_ = 0;
};

}  // namespace

Expected<Plan> parse_plan(std::string_view text, const std::string& file, const Domain& domain,
                          const Problem& problem) {
  return accepted([&] { return PlanReader(file, domain, problem).read(text); });
}

std::string step_text(const PlanStep& step, const Domain& domain, const Problem& problem) {
  return ground_text(domain.actions[step.action].name, step.arguments, problem.objects);
}

std::string to_text(const Plan& plan, const Domain& domain, const Problem& problem) {
  Plan ordered = plan;
  std::ranges::stable_sort(ordered, {}, &PlanStep::start);
  std::string text;
  for (const PlanStep& step : ordered) {
    text += time_text(step.start) + ": " + step_text(step, domain, problem);
    if (domain.actions[step.action].durative) text += " [" + time_text(step.duration) + "]";
    text += "\n";
  }
  return text;
}

double makespan(const Plan& plan) {
  double end = 0;
  for (const PlanStep& step : plan) end = std::max(end, step.start + step.duration);
  return end;
}

}  // namespace cxlab::planner
