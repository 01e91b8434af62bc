#include "planner/pddl/plan.h"

#include <algorithm>
#include <ranges>

#include "planner/pddl/syntax.h"
#include "planner/pddl/text.h"

namespace cxlab::planner {
namespace {

constexpr std::string_view kForm = "expected TIME: (ACTION OBJECT...) [DURATION]";

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

class PlanReader {
 public:
  PlanReader(const std::string& file, const Domain& domain, const Problem& problem)
      : file_(file), domain_(domain), problem_(problem) {}

  Plan read(std::string_view text) {
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);  // the mark of UTF-8 files
    const std::string lower = lower_case(text);
    for (const auto& part : lower | std::views::split('\n')) {
      ++line_;
      const std::string_view line = trimmed(without_comment({part.begin(), part.end()}));
      if (!line.empty()) step(line);
    }
    return std::move(plan_);
  }

 private:
  template <class... Parts>
  [[noreturn]] void fail(const Parts&... parts) const {
    throw Rejected{input_error(message(parts...), file_, line_)};
  }

  void step(std::string_view line) {
    const std::size_t open = line.find('('), close = line.find(')');
    if (open == std::string_view::npos || close == std::string_view::npos || close < open)
      fail("found '", line.substr(0, 60), "', ", kForm);
    PlanStep& step = plan_.emplace_back();
    step.line = line_;
    const std::string_view time = trimmed(line.substr(0, open));
    if (time.empty())
      step.start = static_cast<double>(plan_.size() - 1);
    else if (!time.ends_with(':') || !to_number(trimmed(time.substr(0, time.size() - 1)), step.start))
      fail("found '", time.substr(0, 60), "' for the time, ", kForm);
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
    if (names.empty()) fail("found an empty action, ", kForm);
    step.action = find(domain_.action_names, names[0]);
    if (step.action < 0)
      fail("found '", names[0], "', expected an action of ", domain_.file, hint(names[0], domain_.actions));
    const Action& action = domain_.actions[step.action];
    const std::string declared = message("; declared at ", domain_.file, ":", action.source.line);
    if (names.size() - 1 != action.parameters.size())
      fail("found ", names.size() - 1, names.size() == 2 ? " argument of " : " arguments of ", action.name,
           ", expected ", action.parameters.size(), declared);
    for (const Variable& parameter : action.parameters) {
      const std::string& name = names[step.arguments.size() + 1];
      const ObjectId object = step.arguments.emplace_back(find(problem_.object_names, name));
      if (object < 0) fail("found '", name, "', expected an object of ", problem_.file, hint(name, problem_.objects));
      if (!fits(domain_, problem_.objects[object], parameter.types))
        fail("found '", name, "' for argument ", step.arguments.size(), " of ", action.name,
             ", expected an object for ", Printer(domain_, problem_.objects).variables({parameter}), declared);
    }
  }

  void duration(std::string_view text, PlanStep& step) {
    const Action& action = domain_.actions[step.action];
    if (text.empty()) {
      if (action.durative) fail("found no duration of the durative action ", action.name, ", ", kForm);
      return;
    }
    if (!text.starts_with('[') || !text.ends_with(']'))
      fail("found '", text.substr(0, 60), "' behind the action, expected [DURATION]");
    std::string_view number = trimmed(text.substr(1, text.size() - 2));
    if (number.starts_with("d:")) number = trimmed(number.substr(2, number.find(';') - 2));
    double seconds = 0;
    if (!to_number(number, seconds)) fail("found '", text.substr(0, 60), "', expected a duration such as [5.000]");
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
