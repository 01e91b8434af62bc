#include "tests/planner/random/numeric_problem.h"

#include <algorithm>

namespace cxlab::planner {

namespace {

Literal draw_literal(RandomStream& random, int facts, double positive) {
  return {static_cast<int>(random.below(static_cast<std::uint64_t>(facts))), random.chance(positive)};
}

std::vector<Literal> draw_literals(RandomStream& random, int facts, std::int64_t most, double positive) {
  std::vector<Literal> found;
  for (std::int64_t left = random.between(0, most); left > 0; --left) {
    const Literal literal = draw_literal(random, facts, positive);
    if (std::ranges::find(found, literal.fact, &Literal::fact) == found.end()) found.push_back(literal);
  }
  return found;
}

NumericCondition draw_condition(RandomStream& random, const NumericProblem& problem, std::int64_t most_facts,
                                double number) {
  NumericCondition made{draw_literals(random, problem.facts, most_facts, 0.7), {}};
  if (problem.numbers > 0 && random.chance(number)) {
    constexpr const char* kOps[] = {"<", "<=", "=", ">=", ">", ">=", "<="};
    made.numbers.push_back({static_cast<int>(random.below(static_cast<std::uint64_t>(problem.numbers))),
                            kOps[random.below(std::size(kOps))], static_cast<int>(random.between(0, 5))});
  }
  return made;
}

NumericEffects draw_effects(RandomStream& random, const NumericProblem& problem, std::int64_t most_facts,
                            double number) {
  NumericEffects made{draw_literals(random, problem.facts, most_facts, 0.6), {}};
  if (problem.numbers > 0 && random.chance(number)) {
    constexpr const char* kKinds[] = {"assign", "increase", "increase", "decrease"};
    made.numbers.push_back({static_cast<int>(random.below(static_cast<std::uint64_t>(problem.numbers))),
                            kKinds[random.below(std::size(kKinds))], static_cast<int>(random.between(1, 4)),
                            random.chance(0.2)});
  }
  return made;
}

std::string fact(int fact) { return "(f" + std::to_string(fact) + ")"; }
std::string number(int number) { return "(n" + std::to_string(number) + ")"; }
std::string text(const Literal& literal) {
  return literal.value ? fact(literal.fact) : "(not " + fact(literal.fact) + ")";
}
std::string text(const NumberTest& test) {
  return "(" + test.op + " " + number(test.number) + " " + std::to_string(test.value) + ")";
}

std::string timed(const NumericCondition& condition, const std::string& when) {
  std::string out;
  for (const Literal& literal : condition.facts) out += " (" + when + " " + text(literal) + ")";
  for (const NumberTest& test : condition.numbers) out += " (" + when + " " + text(test) + ")";
  return out;
}

std::string timed(const NumericEffects& effects, const std::string& when) {
  std::string out;
  for (const Literal& literal : effects.facts) out += " (" + when + " " + text(literal) + ")";
  for (const NumberEffect& effect : effects.numbers) {
    const std::string value = std::to_string(effect.value);
    out += " (" + when + " (" + effect.kind + " " + number(effect.number) + " " +
           (effect.times_duration ? "(* ?duration " + value + ")" : value) + "))";
  }
  return out;
}

}  // namespace

NumericProblem NumericProblem::draw(RandomStream& random) {
  NumericProblem made;
  made.facts = static_cast<int>(random.between(2, 4));
  made.numbers = static_cast<int>(random.between(0, 2));
  for (int f = 0; f < made.facts; ++f) made.initial.push_back(static_cast<char>(random.chance(0.3)));
  for (int n = 0; n < made.numbers; ++n)
    made.values.push_back(random.chance(0.85) ? std::optional(static_cast<int>(random.between(0, 4))) : std::nullopt);
  for (std::int64_t left = random.between(1, 3); left > 0; --left) {
    NumericAction action;
    action.least = action.most = static_cast<int>(random.between(1, 4));
    if (random.chance(0.1)) action.least = action.most = 0;
    if (random.chance(0.25)) {
      action.duration = NumericAction::Duration::kChosen;
      action.least = static_cast<int>(random.between(0, 2));
      action.most = action.least + static_cast<int>(random.between(1, 3));
    } else if (made.numbers > 0 && random.chance(0.1)) {
      action.duration = NumericAction::Duration::kNumber;
      action.number = static_cast<int>(random.below(static_cast<std::uint64_t>(made.numbers)));
    }
    action.start = draw_condition(random, made, 2, 0.3);
    action.over_all = draw_condition(random, made, 1, 0.2);
    action.end = draw_condition(random, made, 1, 0.2);
    action.at_start = draw_effects(random, made, 2, 0.3);
    action.at_end = draw_effects(random, made, 2, 0.3);
    if (made.numbers > 0 && random.chance(0.3)) {
      const int rate = static_cast<int>(random.between(1, 2));
      action.rates = {{static_cast<int>(random.below(static_cast<std::uint64_t>(made.numbers))),
                       random.chance(0.6) ? rate : -rate}};
    }
    if (random.chance(0.1)) {
      action.when = draw_literal(random, made.facts, 0.6);
      action.then = draw_literal(random, made.facts, 0.8);
      std::erase_if(action.at_end.facts, [&](const Literal& literal) { return literal.fact == action.then.fact; });
    }
    made.actions.push_back(std::move(action));
  }
  for (std::int64_t left = random.chance(0.6) ? random.between(1, 4) : 0; left > 0; --left) {
    NumericEvent event;
    event.time = static_cast<int>(random.between(1, 6));
    event.of_number = made.numbers > 0 && random.chance(0.25);
    event.fact = draw_literal(random, made.facts, 0.5);
    event.number = made.numbers > 0 ? static_cast<int>(random.below(static_cast<std::uint64_t>(made.numbers))) : 0;
    event.value = static_cast<int>(random.between(0, 5));
    const bool known = std::ranges::any_of(made.events, [&](const NumericEvent& other) {
      return other.time == event.time && other.of_number == event.of_number &&
             (event.of_number ? other.number == event.number : other.fact.fact == event.fact.fact);
    });
    if (!known) made.events.push_back(event);
  }
  std::ranges::stable_sort(made.events, {}, &NumericEvent::time);
  do made.goal = draw_condition(random, made, 3, 0.35);
  while (made.goal.facts.empty() && made.goal.numbers.empty());
  return made;
}

std::string NumericProblem::domain() const {
  std::string out = "(define (domain d)\n (:predicates";
  for (int f = 0; f < facts; ++f) out += " " + fact(f);
  out += ")";
  if (numbers > 0) {
    out += " (:functions";
    for (int n = 0; n < numbers; ++n) out += " " + number(n);
    out += ")";
  }
  out += "\n";
  for (std::size_t a = 0; a < actions.size(); ++a) {
    const NumericAction& action = actions[a];
    out += " (:durative-action a" + std::to_string(a) + " :parameters () :duration ";
    if (action.duration == NumericAction::Duration::kFixed)
      out += "(= ?duration " + std::to_string(action.least) + ")";
    else if (action.duration == NumericAction::Duration::kNumber)
      out += "(= ?duration " + number(action.number) + ")";
    else
      out += "(and (>= ?duration " + std::to_string(action.least) + ") (<= ?duration " + std::to_string(action.most) +
             "))";
    out += "\n  :condition (and" + timed(action.start, "at start") + timed(action.over_all, "over all") +
           timed(action.end, "at end") + ")\n  :effect (and" + timed(action.at_start, "at start") +
           timed(action.at_end, "at end");
    for (const auto& [n, rate] : action.rates)
      out += std::string(" (") + (rate < 0 ? "decrease " : "increase ") + number(n) + " (* #t " +
             std::to_string(std::abs(rate)) + "))";
    if (action.when) out += " (when (at start " + text(*action.when) + ") (at end " + text(action.then) + "))";
    out += "))\n";
  }
  return out + ")\n";
}

std::string NumericProblem::problem() const {
  std::string out = "(define (problem p) (:domain d)\n (:init";
  for (int f = 0; f < facts; ++f)
    if (initial[static_cast<std::size_t>(f)]) out += " " + fact(f);
  for (int n = 0; n < numbers; ++n)
    if (const auto& value = values[static_cast<std::size_t>(n)])
      out += " (= " + number(n) + " " + std::to_string(*value) + ")";
  for (const NumericEvent& event : events)
    out +=
        " (at " + std::to_string(event.time) + " " +
        (event.of_number ? "(= " + number(event.number) + " " + std::to_string(event.value) + ")" : text(event.fact)) +
        ")";
  out += ")\n (:goal (and";
  for (const Literal& literal : goal.facts) out += " " + text(literal);
  for (const NumberTest& test : goal.numbers) out += " " + text(test);
  return out + ")))\n";
}

std::string to_text(const std::vector<WitnessStep>& plan) {
  const auto seconds = [](int milliseconds) {
    const std::string rest = std::to_string(1000 + milliseconds % 1000);
    return std::to_string(milliseconds / 1000) + "." + rest.substr(1);
  };
  std::string out;
  for (const WitnessStep& step : plan)
    out += seconds(step.start) + ": (a" + std::to_string(step.action) + ") [" + seconds(step.duration) + "]\n";
  return out;
}

}  // namespace cxlab::planner
