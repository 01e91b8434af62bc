#include "tests/planner/random/wide_problem.h"

#include <algorithm>

namespace cxlab::planner {

namespace {

/// Draws parts of a problem whose facts and numbers are known.
class Draw {
 public:
  Draw(RandomStream& random, const WideProblem& made) : random_(random), made_(made) {}

  int fact() { return static_cast<int>(random_.below(static_cast<std::uint64_t>(made_.facts))); }
  int number() { return static_cast<int>(random_.below(static_cast<std::uint64_t>(made_.numbers))); }
  Literal literal(double positive) { return {fact(), random_.chance(positive)}; }

  std::vector<Literal> literals(std::int64_t most, double positive) {
    std::vector<Literal> found;
    for (std::int64_t left = random_.between(0, most); left > 0; --left) {
      const Literal drawn = literal(positive);
      if (std::ranges::find(found, drawn.fact, &Literal::fact) == found.end()) found.push_back(drawn);
    }
    return found;
  }

  WideSum constant(int low, int high) {
    return {static_cast<int>(random_.between(low, high)) * (random_.chance(0.85) ? 2 : 1), {}, 0};
  }

  /// A constant, a number, or a sum of both.
  WideSum sum(int low, int high, double of_number, double of_duration) {
    WideSum made = constant(low, high);
    if (random_.chance(of_duration))
      return {random_.chance(0.7) ? 0 : made.halves, {}, static_cast<int>(random_.between(1, 2))};
    if (made_.numbers == 0 || !random_.chance(of_number)) return made;
    if (random_.chance(0.6)) made.halves = 0;
    made.numbers = {{number(), random_.chance(0.8) ? 1 : static_cast<int>(random_.between(-1, 2))}};
    if (made.numbers[0].second == 0) made.numbers[0].second = 1;
    return made;
  }

  WideTest test(double of_duration) {
    constexpr const char* kOps[] = {"<", "<=", "=", ">=", ">", ">=", "<="};
    WideTest made{{0, {{number(), 1}}, 0}, kOps[random_.below(std::size(kOps))], sum(0, 5, 0.25, of_duration)};
    if (random_.chance(0.1)) made.left.numbers.emplace_back(number(), 1);
    return made;
  }

  WideCondition condition(std::int64_t most_facts, double of_number, double of_duration = 0) {
    WideCondition made{literals(most_facts, 0.7), {}, {}};
    if (made_.numbers > 0 && random_.chance(of_number)) made.tests.push_back(test(of_duration));
    if (random_.chance(0.07)) {
      if (made_.with_objects)
        for (int f = 0; f < made_.facts; ++f) made.any.push_back({f, true});
      else
        made.any = {literal(0.6), literal(0.6)};
    }
    return made;
  }

  WideEffects effects(std::int64_t most_facts, double of_number, double of_duration) {
    WideEffects made{literals(most_facts, 0.6), {}};
    if (made_.numbers == 0 || !random_.chance(of_number)) return made;
    constexpr const char* kKinds[] = {"assign", "assign", "increase", "increase", "decrease", "scale-up"};
    WideChange change{number(), kKinds[random_.below(std::size(kKinds))], {}};
    change.value = change.kind == "scale-up" ? constant(0, 2) : sum(1, 4, 0.25, of_duration);
    made.numbers.push_back(std::move(change));
    return made;
  }

  std::vector<WideBound> duration() {
    const double kind = random_.uniform();
    if (kind < 0.45) return {{"=", constant(random_.chance(0.15) ? 0 : 1, 4), false}};
    if (kind < 0.6) return {{"=", sum(1, 3, 0.9, 0), false}};
    if (kind < 0.68) return {{"=", sum(1, 3, 0.6, 0), true}};
    if (kind < 0.75) return {{">=", sum(0, 3, 0.3, 0), false}};
    if (kind < 0.82) return {{"<=", sum(1, 4, 0.3, 0), random_.chance(0.2)}};
    const WideSum least = constant(0, 2);
    WideSum most = least;
    most.halves += static_cast<int>(random_.between(1, 6));
    return {{">=", least, false}, {"<=", most, false}};
  }

  WideConditional conditional() {
    WideConditional made;
    made.at_end = random_.chance(0.7);
    made.start = condition(1, 0.3);
    if (made.at_end && random_.chance(0.4)) std::swap(made.start, made.end);
    if (made.at_end && random_.chance(0.25)) made.over_all = condition(1, 0.3);
    made.effects = effects(2, 0.3, 0);
    return made;
  }

 private:
  RandomStream& random_;
  const WideProblem& made_;
};

bool changes_fact(const WideEffects& effects, int fact) {
  return std::ranges::find(effects.facts, fact, &Literal::fact) != effects.facts.end();
}
bool changes_number(const WideEffects& effects, int number) {
  return std::ranges::find(effects.numbers, number, &WideChange::number) != effects.numbers.end();
}

/// Leaves out of `effects` what `others` change at the same time.
void keep_apart(WideEffects& effects, const WideEffects& others) {
  std::erase_if(effects.facts, [&](const Literal& literal) { return changes_fact(others, literal.fact); });
  std::erase_if(effects.numbers, [&](const WideChange& change) { return changes_number(others, change.number); });
}

// ---- as text -------------------------------------------------------------------------------------------------------

class Writer {
 public:
  explicit Writer(const WideProblem& problem) : problem_(problem) {}

  std::string fact(int f) const {
    return problem_.with_objects ? "(f o" + std::to_string(f) + ")" : "(f" + std::to_string(f) + ")";
  }
  static std::string number(int n) { return "(n" + std::to_string(n) + ")"; }
  std::string literal(const Literal& each) const {
    return each.value ? fact(each.fact) : "(not " + fact(each.fact) + ")";
  }
  static std::string halves(int value) {
    return std::string(value < 0 ? "-" : "") + std::to_string(std::abs(value) / 2) + (value % 2 ? ".5" : "");
  }
  static std::string sum(const WideSum& sum) {
    std::vector<std::string> parts;
    const auto add = [&](const std::string& of, int weight) {
      parts.push_back(weight == 1 ? of : "(* " + std::to_string(weight) + " " + of + ")");
    };
    if (sum.halves != 0 || (sum.numbers.empty() && sum.duration == 0)) parts.push_back(halves(sum.halves));
    for (const auto& [n, weight] : sum.numbers) add(number(n), weight);
    if (sum.duration != 0) add("?duration", sum.duration);
    std::string out = parts[0];
    for (std::size_t i = 1; i < parts.size(); ++i) out = "(+ " + out + " " + parts[i] + ")";
    return out;
  }
  static std::string test(const WideTest& test) {
    return "(" + test.op + " " + sum(test.left) + " " + sum(test.right) + ")";
  }
  /// Each part behind `before`, with `after` behind it.
  std::string condition(const WideCondition& condition, const std::string& before, const std::string& after) const {
    std::string out;
    for (const Literal& each : condition.facts) out += before + literal(each) + after;
    for (const WideTest& each : condition.tests) out += before + test(each) + after;
    if (condition.any.empty()) return out;
    if (problem_.with_objects) return out + before + "(exists (?x - o) (f ?x))" + after;
    out += before + "(or";
    for (const Literal& each : condition.any) out += " " + literal(each);
    return out + ")" + after;
  }
  std::string timed(const WideCondition& condition, const std::string& when) const {
    return this->condition(condition, " (" + when + " ", ")");
  }
  std::string effects(const WideEffects& effects, const std::string& before, const std::string& after) const {
    std::string out;
    for (const Literal& each : effects.facts) out += before + literal(each) + after;
    for (const WideChange& each : effects.numbers)
      out += before + "(" + each.kind + " " + number(each.number) + " " + sum(each.value) + ")" + after;
    return out;
  }
  std::string conditional(const WideConditional& each, bool durative) const {
    if (!durative)
      return " (when (and" + condition(each.start, " ", "") + ") (and" + effects(each.effects, " ", "") + "))";
    return " (when (and" + timed(each.start, "at start") + timed(each.over_all, "over all") +
           timed(each.end, "at end") + ") (and" +
           effects(each.effects, each.at_end ? " (at end " : " (at start ", ")") + "))";
  }

 private:
  const WideProblem& problem_;
};

}  // namespace

WideProblem WideProblem::draw(RandomStream& random) {
  WideProblem made;
  made.with_objects = random.chance(0.3);
  made.facts = static_cast<int>(random.between(2, 4));
  made.numbers = static_cast<int>(random.between(1, 3));
  for (int f = 0; f < made.facts; ++f) made.initial.push_back(static_cast<char>(random.chance(0.3)));
  for (int n = 0; n < made.numbers; ++n)
    made.values.push_back(random.chance(0.8) ? std::optional(static_cast<int>(random.between(0, 4))) : std::nullopt);
  Draw draw(random, made);
  std::vector<char> moves(static_cast<std::size_t>(made.numbers), 0);  // changes continuously
  if (random.chance(0.6)) moves[random.below(moves.size())] = 1;
  for (std::int64_t left = random.between(1, 3); left > 0; --left) {
    WideAction action;
    action.durative = random.chance(0.85);
    action.start = draw.condition(2, 0.3, action.durative ? 0.1 : 0);
    action.at_start = draw.effects(2, 0.35, action.durative ? 0.1 : 0);
    if (action.durative) {
      action.duration = draw.duration();
      action.over_all = draw.condition(1, 0.2, 0.05);
      action.end = draw.condition(1, 0.2, 0.1);
      action.at_end = draw.effects(2, 0.35, 0.2);
      for (int n = 0; n < made.numbers; ++n) {
        if (!moves[static_cast<std::size_t>(n)] || !random.chance(0.6)) continue;
        WideSum rate = draw.constant(1, 2);
        if (random.chance(0.35)) rate.halves = -rate.halves;
        const int by = draw.number();
        if (random.chance(0.3) && !moves[static_cast<std::size_t>(by)])
          rate = {0, {{by, random.chance(0.8) ? 1 : -1}}, 0};
        action.rates.emplace_back(n, rate);
      }
    }
    if (random.chance(0.2)) {
      WideConditional when = draw.conditional();
      if (!action.durative) when.at_end = false, when.over_all = {}, when.end = {};
      if (!when.at_end) when.over_all = {}, when.end = {};
      keep_apart(when.effects, when.at_end ? action.at_end : action.at_start);
      const bool empty = when.start.empty() && when.over_all.empty() && when.end.empty();
      if (!empty && !(when.effects.facts.empty() && when.effects.numbers.empty()))
        action.when.push_back(std::move(when));
    }
    made.actions.push_back(std::move(action));
  }
  for (std::int64_t left = random.chance(0.6) ? random.between(1, 4) : 0; left > 0; --left) {
    WideEvent event;
    event.time = random.between(0, 12) * 500;
    if (random.chance(0.6)) event.time = event.time / 1000 * 1000;
    event.of_number = random.chance(0.3);
    event.fact = draw.literal(0.5);
    event.number = draw.number();
    event.value = static_cast<int>(random.between(0, 5));
    const bool known = std::ranges::any_of(made.events, [&](const WideEvent& other) {
      return other.time == event.time && other.of_number == event.of_number &&
             (event.of_number ? other.number == event.number : other.fact.fact == event.fact.fact);
    });
    if (!known) made.events.push_back(event);
  }
  std::ranges::stable_sort(made.events, {}, &WideEvent::time);
  do made.goal = draw.condition(3, 0.4);
  while (made.goal.facts.empty() && made.goal.tests.empty());
  return made;
}

std::string WideProblem::domain() const {
  const Writer write(*this);
  std::string out = "(define (domain d)\n";
  if (with_objects) {
    out += " (:types o) (:constants";
    for (int f = 0; f < facts; ++f) out += " o" + std::to_string(f);
    out += " - o)\n (:predicates (f ?x - o))";
  } else {
    out += " (:predicates";
    for (int f = 0; f < facts; ++f) out += " " + write.fact(f);
    out += ")";
  }
  out += " (:functions";
  for (int n = 0; n < numbers; ++n) out += " " + Writer::number(n);
  out += ")\n";
  for (std::size_t a = 0; a < actions.size(); ++a) {
    const WideAction& action = actions[a];
    const std::string name = "a" + std::to_string(a);
    if (!action.durative) {
      out += " (:action " + name + " :parameters ()\n  :precondition (and" + write.condition(action.start, " ", "") +
             ")\n  :effect (and" + write.effects(action.at_start, " ", "");
    } else {
      out += " (:durative-action " + name + " :parameters () :duration (and";
      for (const WideBound& each : action.duration) {
        const std::string bound = "(" + each.op + " ?duration " + Writer::sum(each.bound) + ")";
        out += each.at_end ? " (at end " + bound + ")" : " " + bound;
      }
      out += ")\n  :condition (and" + write.timed(action.start, "at start") + write.timed(action.over_all, "over all") +
             write.timed(action.end, "at end") + ")\n  :effect (and" +
             write.effects(action.at_start, " (at start ", ")") + write.effects(action.at_end, " (at end ", ")");
      for (const auto& [n, rate] : action.rates)
        out += " (increase " + Writer::number(n) + " (* #t " + Writer::sum(rate) + "))";
    }
    for (const WideConditional& each : action.when) out += write.conditional(each, action.durative);
    out += "))\n";
  }
  return out + ")\n";
}

std::string WideProblem::problem() const {
  const Writer write(*this);
  std::string out = "(define (problem p) (:domain d)\n (:init";
  for (int f = 0; f < facts; ++f)
    if (initial[static_cast<std::size_t>(f)]) out += " " + write.fact(f);
  for (int n = 0; n < numbers; ++n)
    if (const auto& value = values[static_cast<std::size_t>(n)])
      out += " (= " + Writer::number(n) + " " + std::to_string(*value) + ")";
  for (const WideEvent& event : events)
    out += " (at " + Writer::halves(static_cast<int>(event.time / 500)) + " " +
           (event.of_number ? "(= " + Writer::number(event.number) + " " + std::to_string(event.value) + ")"
                            : write.literal(event.fact)) +
           ")";
  return out + ")\n (:goal (and" + write.condition(goal, " ", "") + ")))\n";
}

}  // namespace cxlab::planner
