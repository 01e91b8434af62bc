#include "tests/planner/random/constants.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace cxlab::planner {

namespace {

std::string text(double value) {
  char out[400];
  std::snprintf(out, sizeof out, "%.30f", value);
  std::string digits = out;
  digits.erase(digits.find_last_not_of('0') + 1);
  if (digits.back() == '.') digits += '0';
  return value < 0 ? "(- 0 " + digits.substr(1) + ")" : digits;
}

/// Draws a constant of any size between 1e-12 and 1e15. Often it is one of a few, so that constants meet.
double draw_constant(RandomStream& random) {
  static constexpr double kFew[] = {0, 1, 1e-7, 4e-7, 1e-6, 0.001, 0.1, 0.3, 1e6, 16777217, 4294967296, 1e12};
  if (random.chance(0.5)) return kFew[random.below(std::size(kFew))];
  return static_cast<double>(random.between(1, 99)) * std::pow(10, static_cast<double>(random.between(-12, 13)));
}

struct Comparison {
  int function = 0;
  std::string op;
  double bound = 0;
  bool holds(const std::vector<double>& values) const {
    const double value = values[static_cast<std::size_t>(function)];
    if (op == ">=") return value >= bound;
    if (op == "<=") return value <= bound;
    if (op == ">") return value > bound;
    if (op == "<") return value < bound;
    return value == bound;
  }
  std::string print() const { return "(" + op + " (n" + std::to_string(function) + ") " + text(bound) + ")"; }
};

struct Change {
  int function = 0;
  std::string op;
  double by = 0;
  void apply(std::vector<double>& values) const {
    double& value = values[static_cast<std::size_t>(function)];
    if (op == "increase") value += by;
    if (op == "decrease") value -= by;
    if (op == "scale-up") value *= by;
    if (op == "assign") value = by;
  }
  std::string print() const { return "(" + op + " (n" + std::to_string(function) + ") " + text(by) + ")"; }
};

struct Action {
  double duration = 0;  // s; 0: none
  std::vector<Comparison> conditions;
  std::vector<Change> effects;
  bool applicable(const std::vector<double>& values) const {
    return std::ranges::all_of(conditions, [&](const Comparison& c) { return c.holds(values); });
  }
};

constexpr const char* kComparisons[] = {">=", "<=", ">", "<", "="};
constexpr const char* kChanges[] = {"increase", "decrease", "assign", "scale-up"};

Comparison draw_comparison(RandomStream& random, int functions) {
  return {static_cast<int>(random.below(static_cast<std::uint64_t>(functions))), kComparisons[random.below(4)],
          draw_constant(random)};
}

/// Draws a comparison that holds for these values, often with the least margin.
Comparison draw_true_comparison(RandomStream& random, const std::vector<double>& values) {
  Comparison made;
  made.function = static_cast<int>(random.below(values.size()));
  made.op = kComparisons[random.below(5)];
  made.bound = values[static_cast<std::size_t>(made.function)];
  const double margin = random.chance(0.5) ? std::abs(made.bound) * 1e-3 : 1e-3 * draw_constant(random);
  if (made.op == ">") made.bound -= margin;
  if (made.op == "<") made.bound += margin;
  if (made.op.back() == '=' && random.chance(0.2))
    made.bound *= 1 + (random.chance(0.5) ? 5e-10 : -5e-10);  // tolerated
  return made;
}

std::string name(std::size_t action) { return "a" + std::to_string(action); }

std::string print(const Action& action, std::size_t number) {
  const bool timed = action.duration > 0;
  std::string out = timed ? "(:durative-action " : "(:action ";
  out += name(number) + " :parameters ()";
  if (timed) out += " :duration (= ?duration " + text(action.duration) + ")";
  out += timed ? " :condition (and" : " :precondition (and";
  for (const Comparison& condition : action.conditions)
    out += timed ? " (at start " + condition.print() + ")" : " " + condition.print();
  out += ") :effect (and";
  for (const Change& effect : action.effects) out += timed ? " (at end " + effect.print() + ")" : " " + effect.print();
  return out + "))\n";
}

}  // namespace

PlantedProblem PlantedProblem::draw(RandomStream& random) {
  const int functions = static_cast<int>(random.between(1, 3));
  std::vector<double> values;
  std::string init;
  for (int f = 0; f < functions; ++f) {
    values.push_back(draw_constant(random));
    init += " (= (n" + std::to_string(f) + ") " + text(values.back()) + ")";
  }
  std::vector<Action> actions(static_cast<std::size_t>(random.between(2, 4)));
  std::vector<Comparison> asked;
  for (Action& action : actions) {
    if (random.chance(0.5)) action.duration = std::clamp(draw_constant(random), 0.01, 1e6);
    if (random.chance(0.6))
      action.conditions = {random.chance(0.5) ? draw_comparison(random, functions)
                                              : draw_true_comparison(random, values)};
    if (!asked.empty() && random.chance(0.5)) {  // one that is near to another
      action.conditions = {asked.front()};
      action.conditions[0].bound += random.chance(0.5) ? 3e-7 : -3e-7;
    }
    asked.insert(asked.end(), action.conditions.begin(), action.conditions.end());
    for (int f = 0; f < functions; ++f)
      if (f == 0 || random.chance(0.4))
        action.effects.push_back({f, kChanges[random.below(std::size(kChanges))], draw_constant(random)});
  }
  PlantedProblem made;
  double time = 1;
  for (std::int64_t steps = random.between(1, 4); steps > 0; --steps) {
    std::vector<std::size_t> open;
    for (std::size_t a = 0; a < actions.size(); ++a)
      if (actions[a].applicable(values)) open.push_back(a);
    if (open.empty()) break;
    const std::size_t a = open[random.below(open.size())];
    made.plan += text(time) + ": (" + name(a) + ")" +
                 (actions[a].duration > 0 ? " [" + text(actions[a].duration) + "]" : "") + "\n";
    time += actions[a].duration + 1;
    for (const Change& effect : actions[a].effects) effect.apply(values);
  }
  made.domain = "(define (domain d) (:requirements :durative-actions :fluents)\n(:functions";
  for (int f = 0; f < functions; ++f) made.domain += " (n" + std::to_string(f) + ")";
  made.domain += ")\n";
  for (std::size_t a = 0; a < actions.size(); ++a) made.domain += print(actions[a], a);
  made.domain += ")\n";
  made.problem = "(define (problem p) (:domain d) (:init" + init + ")\n(:goal (and";
  for (std::int64_t goals = random.between(1, 3); goals > 0; --goals)
    made.problem += " " + draw_true_comparison(random, values).print();
  made.problem += ")))\n";
  return made;
}

}  // namespace cxlab::planner
