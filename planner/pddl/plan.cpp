#include "planner/pddl/plan.h"

#include <algorithm>

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

  Expected<Plan> read(std::string_view text) {
    std::string lower(text);
    for (char& c : lower)
      if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    std::string_view rest = lower;
    while (!rest.empty()) {
      const std::size_t end = rest.find('\n');
      std::string_view line = rest.substr(0, end);
      rest = end == std::string_view::npos ? std::string_view{} : rest.substr(end + 1);
      ++line_;
      line = trimmed(without_comment(line));
      if (line.empty()) continue;
      if (Status status = step(line); !status) return status.error();
    }
    return std::move(plan_);
  }

 private:
  Error error(std::string message) const { return input_error(std::move(message), file_, line_); }

  Status step(std::string_view line) {
    const std::size_t open = line.find('(');
    const std::size_t close = line.find(')');
    if (open == std::string_view::npos || close == std::string_view::npos || close < open)
      return error("found '" + std::string(line.substr(0, 60)) + "', " + std::string(kForm));
    PlanStep step;
    step.line = line_;
    std::string_view time = trimmed(line.substr(0, open));
    if (time.empty()) {
      step.start = static_cast<double>(plan_.size());
    } else {
      if (!time.ends_with(':') || !to_number(trimmed(time.substr(0, time.size() - 1)), step.start))
        return error("found '" + std::string(time.substr(0, 60)) + "' for the time, " + std::string(kForm));
    }
    if (Status status = action(line.substr(open + 1, close - open - 1), step); !status) return status;
    if (Status status = duration(trimmed(line.substr(close + 1)), step); !status) return status;
    plan_.push_back(std::move(step));
    return {};
  }

  Status action(std::string_view words, PlanStep& step) {
    std::vector<std::string> names;
    while (!(words = trimmed(words)).empty()) {
      const std::size_t end = std::min(words.find_first_of(" \t"), words.size());
      names.emplace_back(words.substr(0, end));
      words.remove_prefix(end);
    }
    if (names.empty()) return error("found an empty action, " + std::string(kForm));
    step.action = find(domain_.action_names, names[0]);
    if (step.action < 0) {
      std::vector<std::string> known;
      for (const Action& each : domain_.actions) known.push_back(each.name);
      return error("found '" + names[0] + "', expected an action of " + domain_.file +
                   did_you_mean(names[0], known, "; "));
    }
    const Action& action = domain_.actions[step.action];
    const std::string declared = "; declared at " + domain_.file + ":" + std::to_string(action.source.line);
    if (names.size() - 1 != action.parameters.size())
      return error("found " + std::to_string(names.size() - 1) +
                   (names.size() == 2 ? " argument of " : " arguments of ") + action.name + ", expected " +
                   std::to_string(action.parameters.size()) + declared);
    for (std::size_t i = 1; i < names.size(); ++i) {
      const ObjectId object = find(problem_.object_names, names[i]);
      if (object < 0) {
        std::vector<std::string> known;
        for (const Object& each : problem_.objects) known.push_back(each.name);
        return error("found '" + names[i] + "', expected an object of " + problem_.file +
                     did_you_mean(names[i], known, "; "));
      }
      const Variable& parameter = action.parameters[i - 1];
      if (!fits(domain_, problem_.objects[object], parameter.types)) {
        Printer printer(domain_, problem_.objects);
        return error("found '" + names[i] + "' for argument " + std::to_string(i) + " of " + action.name +
                     ", expected an object for " + printer.variables({parameter}) + declared);
      }
      step.arguments.push_back(object);
    }
    return {};
  }

  Status duration(std::string_view text, PlanStep& step) {
    const Action& action = domain_.actions[step.action];
    if (text.empty()) {
      if (!action.durative) return {};
      return error("found no duration of the durative action " + action.name + ", " + std::string(kForm));
    }
    if (!text.starts_with('[') || !text.ends_with(']'))
      return error("found '" + std::string(text.substr(0, 60)) + "' behind the action, expected [DURATION]");
    std::string_view number = trimmed(text.substr(1, text.size() - 2));
    if (number.starts_with("d:")) number = trimmed(number.substr(2, number.find(';') - 2));
    double seconds = 0;
    if (!to_number(number, seconds))
      return error("found '" + std::string(text.substr(0, 60)) + "', expected a duration such as [5.000]");
    if (action.durative) step.duration = seconds;
    return {};
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
  return PlanReader(file, domain, problem).read(text);
}

std::string step_text(const PlanStep& step, const Domain& domain, const Problem& problem) {
  std::string text = "(" + domain.actions[step.action].name;
  for (const ObjectId object : step.arguments) text += " " + problem.objects[object].name;
  return text + ")";
}

std::string to_text(const Plan& plan, const Domain& domain, const Problem& problem) {
  std::vector<const PlanStep*> ordered;
  for (const PlanStep& step : plan) ordered.push_back(&step);
  std::stable_sort(ordered.begin(), ordered.end(),
                   [](const PlanStep* a, const PlanStep* b) { return a->start < b->start; });
  std::string text;
  for (const PlanStep* step : ordered) {
    text += time_text(step->start) + ": " + step_text(*step, domain, problem);
    if (domain.actions[step->action].durative) text += " [" + time_text(step->duration) + "]";
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
