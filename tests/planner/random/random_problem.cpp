#include "tests/planner/random/random_problem.h"

#include <algorithm>

namespace cxlab::planner {

namespace {

std::vector<Literal> draw_literals(RandomStream& random, int facts, std::int64_t most, double positive) {
  std::vector<Literal> found;
  for (std::int64_t left = random.between(0, most); left > 0; --left) {
    const Literal literal{static_cast<int>(random.below(static_cast<std::uint64_t>(facts))), random.chance(positive)};
    if (std::ranges::find(found, literal.fact, &Literal::fact) == found.end()) found.push_back(literal);
  }
  return found;
}

std::string name(int fact) { return "(f" + std::to_string(fact) + ")"; }
std::string text(const Literal& literal) {
  return literal.value ? name(literal.fact) : "(not " + name(literal.fact) + ")";
}

std::string timed(const std::vector<Literal>& literals, const char* when) {
  std::string out;
  for (const Literal& literal : literals) out += std::string(" (") + when + " " + text(literal) + ")";
  return out;
}

}  // namespace

RandomProblem RandomProblem::draw(RandomStream& random) {
  RandomProblem made;
  made.facts = static_cast<int>(random.between(3, 5));
  for (int f = 0; f < made.facts; ++f) made.initial.push_back(static_cast<char>(random.chance(0.3)));
  const bool counted = random.chance(0.3);
  for (std::int64_t left = random.between(2, 4); left > 0; --left) {
    RandomAction action;
    action.duration = static_cast<int>(random.between(1, 3));
    action.start = draw_literals(random, made.facts, 2, 0.7);
    action.over_all = draw_literals(random, made.facts, 1, 0.7);
    action.end = draw_literals(random, made.facts, 1, 0.7);
    action.start_effects = draw_literals(random, made.facts, 2, 0.5);
    action.end_effects = draw_literals(random, made.facts, 2, 0.6);
    if (counted) {
      action.least_count = static_cast<int>(random.between(-1, 2));
      action.change = static_cast<int>(random.between(-1, 1));
    }
    made.actions.push_back(std::move(action));
  }
  if (random.chance(0.3))
    for (std::int64_t left = random.between(1, 2); left > 0; --left)
      made.events.push_back(
          {static_cast<int>(random.between(1, 4)),
           {static_cast<int>(random.below(static_cast<std::uint64_t>(made.facts))), random.chance(0.5)}});
  std::ranges::sort(made.events, {}, &RandomEvent::time);
  made.events.erase(std::unique(made.events.begin(), made.events.end(),
                                [](const auto& a, const auto& b) { return a.time == b.time; }),
                    made.events.end());
  do made.goal = draw_literals(random, made.facts, 3, 0.8);
  while (made.goal.empty());
  return made;
}

RandomProblem RandomProblem::draw_with_metric(RandomStream& random) {
  RandomProblem made = draw(random);
  made.time_weight = static_cast<int>(random.between(0, 3));
  made.count_weight = static_cast<int>(random.between(-2, 4));
  if (made.count_weight == 0) made.count_weight = 1;
  for (RandomAction& action : made.actions)
    action.change = static_cast<int>(random.between(0, 5) - random.between(0, 1));
  return made;
}

RandomProblem RandomProblem::draw_shop(RandomStream& random) {
  RandomProblem made;
  const int places = static_cast<int>(random.between(1, 2)), jobs = static_cast<int>(random.between(2, 4));
  made.facts = places + jobs;
  made.initial.assign(static_cast<std::size_t>(made.facts), 0);
  for (int place = 0; place < places; ++place) made.initial[static_cast<std::size_t>(place)] = 1;
  const auto draw_place = [&] { return static_cast<int>(random.below(static_cast<std::uint64_t>(places))); };
  const auto add = [](std::vector<Literal>& literals, Literal literal) {
    if (std::ranges::find(literals, literal.fact, &Literal::fact) == literals.end()) literals.push_back(literal);
  };
  for (int job = 0; job < jobs; ++job) {
    RandomAction action;
    action.duration = static_cast<int>(random.between(1, 3));
    action.end_effects = {{places + job, true}};
    const int place = draw_place();
    if (random.chance(0.7)) add(action.start, {place, true});
    if (random.chance(0.4)) {
      add(action.start_effects, {place, false});
      add(action.end_effects, {place, true});
    } else {
      add(action.over_all, {place, true});
      add(action.end_effects, {place, random.chance(0.2)});
    }
    if (random.chance(0.3)) add(action.end_effects, {draw_place(), random.chance(0.5)});
    if (job > 0 && random.chance(0.4))
      add(action.start, {places + static_cast<int>(random.below(static_cast<std::uint64_t>(job))), true});
    if (job > 0 && random.chance(0.2))
      add(action.end_effects, {places + static_cast<int>(random.below(static_cast<std::uint64_t>(job))), false});
    made.goal.push_back({places + job, true});
    made.actions.push_back(std::move(action));
  }
  RandomAction clear;
  clear.duration = static_cast<int>(random.between(1, 2));
  clear.end_effects = {{draw_place(), true}};
  if (random.chance(0.3)) clear.start = {{clear.end_effects[0].fact, false}};
  made.actions.push_back(std::move(clear));
  if (random.chance(0.2))
    made.events.push_back({static_cast<int>(random.between(1, 4)), {draw_place(), random.chance(0.5)}});
  return made;
}

std::string RandomProblem::domain() const {
  std::string out =
      "(define (domain d) (:requirements :durative-actions :negative-preconditions :fluents "
      ":timed-initial-literals)\n(:predicates";
  for (int f = 0; f < facts; ++f) out += " " + name(f);
  out += ")\n(:functions (n))\n";
  for (std::size_t a = 0; a < actions.size(); ++a) {
    const RandomAction& action = actions[a];
    out += "(:durative-action a" + std::to_string(a) + " :parameters () :duration (= ?duration " +
           std::to_string(action.duration) + ")\n :condition (and";
    out += timed(action.start, "at start") + timed(action.over_all, "over all") + timed(action.end, "at end");
    if (action.least_count >= 0) out += " (at start (>= (n) " + std::to_string(action.least_count) + "))";
    out += ")\n :effect (and" + timed(action.start_effects, "at start") + timed(action.end_effects, "at end");
    if (action.change != 0) out += " (at end (increase (n) " + std::to_string(action.change) + "))";
    out += "))\n";
  }
  return out + ")\n";
}

std::string RandomProblem::problem() const {
  std::string out = "(define (problem p) (:domain d) (:init (= (n) " + std::to_string(count) + ")";
  for (int f = 0; f < facts; ++f)
    if (initial[static_cast<std::size_t>(f)]) out += " " + name(f);
  for (const RandomEvent& event : events) out += " (at " + std::to_string(event.time) + " " + text(event.effect) + ")";
  out += ")\n(:goal (and";
  for (const Literal& literal : goal) out += " " + text(literal);
  out += "))";
  if (time_weight != 0 || count_weight != 0)
    out += "\n(:metric minimize (+ (* " + std::to_string(time_weight) + " (total-time)) (* " +
           std::to_string(count_weight) + " (n))))";
  return out + ")\n";
}

}  // namespace cxlab::planner
