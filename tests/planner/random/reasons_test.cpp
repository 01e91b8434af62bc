// The explanation of a goal out of reach is true: the test checks every claim against everything that can happen.

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <optional>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "planner/pddl/parser.h"
#include "planner/pddl/text.h"
#include "planner/planner.h"
#include "planner/state/state.h"
#include "tests/planner/random/numeric_problem.h"

namespace cxlab::planner {
namespace {

Task parsed(const std::string& domain_text, const std::string& problem_text) {
  Expected<Domain> domain = parse_domain(domain_text, "domain.pddl");
  EXPECT_TRUE(domain) << domain.error().text() << domain_text;
  Expected<Problem> problem = parse_problem(problem_text, "problem.pddl", *domain);
  EXPECT_TRUE(problem) << problem.error().text() << problem_text;
  return {*std::move(domain), *std::move(problem)};
}

/// The problem with what is claimed never to be so as its goal; none where its oracle cannot say it.
std::optional<NumericProblem> asking_for(const Cause& cause, NumericProblem problem) {
  problem.goal = {};
  static const std::regex fact("\\(f(\\d+)\\)"), comparison("\\((<|<=|=|>=|>) \\(n(\\d+)\\) (\\d+)\\)");
  for (const FactPattern& each : cause.facts) problem.goal.facts.push_back({each.predicate, each.value});
  std::smatch found;
  if (cause.facts.empty() && std::regex_match(cause.condition, found, comparison))
    problem.goal.numbers.push_back({std::stoi(found[2]), found[1], std::stoi(found[3])});
  if (problem.goal.facts.empty() && problem.goal.numbers.empty()) return std::nullopt;
  return problem;
}

TEST(Reasons, OfTemporalNumericProblemsNameOnlyWhatNeverComesAbout) {
  int proved = 0, explained = 0, checked = 0, numbers = 0, twos = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    RandomStream random(seed, "reasons");
    const NumericProblem problem = NumericProblem::draw(random);
    const std::string text = problem.domain() + problem.problem();
    const Task task = parsed(problem.domain(), problem.problem());
    const Expected<PlanAnswer> answer = find_plan(task, {.budget = 20'000});
    ASSERT_TRUE(answer);
    if (answer->status != PlanStatus::kUnsolvable || !answer->reason.starts_with("the goal is out of reach")) {
      EXPECT_FALSE(answer->out_of_reach);
      continue;
    }
    ++proved;
    if (!answer->out_of_reach) continue;
    ++explained;
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + answer->out_of_reach->text() + "\n" + text);
    for (const Cause& cause : answer->out_of_reach->causes) {
      const auto asked = asking_for(cause, problem);
      if (!asked) continue;
      ++checked;
      numbers += !asked->goal.numbers.empty();
      twos += cause.together;
      const WitnessAnswer witness = find_witness(*asked, {.most_situations = 6'000});
      EXPECT_FALSE(witness.plan) << cause.condition << "\n" << to_text(*witness.plan);
    }
  }
  EXPECT_GT(explained, proved * 9 / 10) << proved;
  EXPECT_GT(checked, 250);
  EXPECT_GT(numbers, 20);
  EXPECT_GT(twos, 1);
}

// --- Problems with objects, types, quantifiers, rules and numbers, without time

/// Writes small problems; most lack something.
class Writer {
 public:
  explicit Writer(RandomStream& random) : random_(random), plain_(random.chance(0.5)) {}

  std::string domain() {
    std::string out =
        "(define (domain d) (:requirements :adl :fluents :derived-predicates) (:types a b) (:constants k - b a0 - a)\n"
        " (:predicates (p ?x - a) (q ?x - a ?y - b) (r ?y - b) (s ?x - a ?y - b) (z) (w ?x - a))\n"
        " (:functions (n ?x - a))\n"
        " (:derived (w ?x - a) (exists (?y - b) (and (q ?x ?y) (r ?y))))\n";
    for (int i = 0; i < 4; ++i) out += action(i);
    return out + ")";
  }

  std::string problem() {
    std::string out = "(define (problem p) (:domain d) (:objects a1 - a b0 - b)\n (:init";
    for (const char* fact :
         {"(p a0)", "(p a1)", "(q a0 b0)", "(q a1 k)", "(r b0)", "(r k)", "(s a0 b0)", "(s a1 b0)", "(s a0 k)", "(z)"})
      if (random_.chance(0.3)) out += std::string(" ") + fact;
    for (const char* number : {"(n a0)", "(n a1)"})
      if (random_.chance(0.8)) out += std::string(" (= ") + number + ' ' + std::to_string(random_.below(3)) + ")";
    out += ")\n (:goal (and";
    for (std::int64_t left = random_.between(plain_ ? 2 : 1, 3); left > 0; --left)
      out += ' ' + condition(random_.chance(0.5) ? "a0" : "a1", random_.chance(0.5) ? "b0" : "k");
    return out + ")))";
  }

 private:
  std::string pick(std::initializer_list<std::string> from) { return from.begin()[random_.below(from.size())]; }
  std::string literal(const std::string& x, const std::string& y, double positive) {
    const std::string atom = pick({"(p " + x + ")", "(q " + x + ' ' + y + ")", "(r " + y + ")", "(z)"});
    return random_.chance(positive) ? atom : "(not " + atom + ")";
  }
  std::string condition(const std::string& x, const std::string& y) {
    switch (plain_ ? 11 : random_.below(12)) {
      case 0: return "(forall (?u - b) " + literal(x, "?u", 0.8) + ")";
      case 1: return "(exists (?v - a) (and " + literal("?v", y, 0.8) + ' ' + literal("?v", y, 0.8) + "))";
      case 2: return "(or " + literal(x, y, 0.8) + ' ' + literal(x, y, 0.8) + ")";
      case 3: return "(imply " + literal(x, y, 0.8) + ' ' + literal(x, y, 0.8) + ")";
      case 4: return '(' + pick({">=", "<=", ">", "=", "<"}) + " (n " + x + ") " + pick({"0", "1", "2", "3"}) + ")";
      case 5: return "(not (= " + x + " a0))";
      case 6: return random_.chance(0.7) ? "(w " + x + ")" : "(not (w " + x + "))";
      case 7: return "(s " + x + ' ' + y + ")";
      default: return literal(x, y, 0.8);
    }
  }
  std::string action(int number) {
    const std::string y = random_.chance(0.3) ? "k" : "?y";
    std::string out = " (:action act" + std::to_string(number) + " :parameters (?x - a" + (y == "k" ? "" : " ?y - b") +
                      ") :precondition (and";
    for (std::int64_t left = random_.between(1, 3); left > 0; --left) out += ' ' + condition("?x", y);
    out += ") :effect (and";
    for (std::int64_t left = random_.between(1, 2); left > 0; --left) {
      const std::string effect = literal("?x", y, 0.6);
      out += random_.chance(0.2) ? " (when " + condition("?x", y) + ' ' + effect + ")" : ' ' + effect;
    }
    if (random_.chance(0.3)) out += ' ' + pick({"(increase (n ?x) 1)", "(decrease (n ?x) 1)", "(assign (n ?x) 2)"});
    return out + "))\n";
  }

  RandomStream& random_;
  const bool plain_;  ///< only facts, which are judged in pairs, too
};

/// All states of a problem that actions lead to; none if there are too many.
std::optional<std::vector<State>> all_states(const Task& task, std::size_t most) {
  const Evaluator evaluator(task.domain, task.problem);
  std::vector<State> states = {State(task.domain, task.problem)};
  evaluator.derive(states[0]);
  const auto key = [&](const State& state) {
    std::vector<std::string> parts;
    for (const Fact& fact : state.facts())
      parts.push_back(ground_text(task.domain.predicates[fact.predicate].name, fact.objects, task.problem.objects));
    for (const Assignment& value : state.values())
      parts.push_back(ground_text(task.domain.functions[value.function].name, value.objects, task.problem.objects) +
                      number_text(value.value));
    std::ranges::sort(parts);
    std::string all;
    for (const std::string& part : parts) all += part;
    return all;
  };
  std::set<std::string> seen = {key(states[0])};
  for (std::size_t next = 0; next < states.size(); ++next) {
    if (states.size() > most) return std::nullopt;
    for (const Action& action : task.domain.actions) {
      Frame frame(static_cast<std::size_t>(action.slots), -1);
      evaluator.each_binding(action.parameters, frame, [&] {
        if (!evaluator.holds(action.condition.start, frame, states[next])) return true;
        std::vector<Change> changes;
        bool valued = true;
        for (const Effect& effect : action.effects)
          valued = valued &&
                   evaluator.collect(
                       effect, frame, states[next], 0,
                       [&](Frame& now) { return evaluator.holds(effect.condition.start, now, states[next]); }, changes);
        State after = states[next];
        if (!valued || !apply_changes(changes, after)) return true;
        evaluator.derive(after);
        if (seen.insert(key(after)).second) states.push_back(std::move(after));
        return true;
      });
    }
  }
  return states;
}

bool matches(std::span<const ObjectId> objects, const FactPattern& pattern) {
  for (std::size_t i = 0; i < objects.size(); ++i)
    if (std::ranges::find(pattern.objects[i], objects[i]) == pattern.objects[i].end()) return false;
  return true;
}

/// Whether the state has one of the facts.
bool has(const State& state, const FactPattern& pattern) {
  std::vector<std::size_t> choice(pattern.objects.size(), 0);
  for (;;) {
    std::vector<ObjectId> objects;
    for (std::size_t i = 0; i < choice.size(); ++i) objects.push_back(pattern.objects[i][choice[i]]);
    if (state.holds(pattern.predicate, objects) == pattern.value) return true;
    std::size_t i = 0;
    while (i < choice.size() && ++choice[i] == pattern.objects[i].size()) choice[i++] = 0;
    if (i == choice.size()) return false;
  }
}

/// The names of the actions whose effects, whatever they ask for, could bring a fact about.
std::set<std::string> possible_makers(const Task& task, const FactPattern& pattern) {
  const Evaluator evaluator(task.domain, task.problem);
  std::set<std::string> names;
  for (const Action& action : task.domain.actions) {
    Frame frame(static_cast<std::size_t>(action.slots), -1);
    evaluator.each_binding(action.parameters, frame, [&] {
      for (const Effect& effect : action.effects)
        if (effect.kind == (pattern.value ? Effect::Kind::kAdd : Effect::Kind::kDelete) &&
            effect.predicate == pattern.predicate) {
          const Objects objects(effect.terms, frame);
          if (matches({objects.begin(), objects.end()}, pattern)) names.insert(action.name);
        }
      return true;
    });
  }
  return names;
}

TEST(Reasons, OfProblemsWithObjectsNameOnlyWhatIsSoInNoState) {
  int proved = 0, explained = 0, states_seen = 0, chains = 0, twos = 0, patterns = 0, conditions = 0;
  for (std::uint64_t seed = 1; seed <= 800; ++seed) {
    RandomStream random(seed, "reasons with objects");
    Writer writer(random);
    const std::string domain = writer.domain(), problem = writer.problem();
    const Task task = parsed(domain, problem);
    const Expected<PlanAnswer> answer = find_plan(task, {.budget = 20'000});
    ASSERT_TRUE(answer);
    if (answer->status != PlanStatus::kUnsolvable || !answer->reason.starts_with("the goal is out of reach")) continue;
    ++proved;
    if (!answer->out_of_reach) continue;
    ++explained;
    const OutOfReach& reason = *answer->out_of_reach;
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + reason.text() + "\n" + domain + problem);
    for (const Cause& cause : reason.causes) {
      if (cause.facts.empty() || cause.together || cause.again) continue;
      if (task.domain.predicates[cause.facts[0].predicate].derived) continue;
      EXPECT_EQ(std::set<std::string>(cause.makers.begin(), cause.makers.end()), possible_makers(task, cause.facts[0]))
          << cause.condition;
    }
    const auto states = all_states(task, 150);
    if (!states) continue;
    ++states_seen;
    chains += reason.causes.size() > 2;
    for (const Cause& cause : reason.causes) {
      twos += cause.together;
      for (const FactPattern& fact : cause.facts)
        patterns += std::ranges::any_of(fact.objects, [](const auto& any) { return any.size() > 1; });
      std::optional<Task> asked;  // what is written is what is meant
      if (cause.condition.find('?') == std::string::npos && cause.condition.starts_with("(") &&
          cause.condition.find("one way") == std::string::npos) {
        ++conditions;
        const std::size_t goal = problem.find("(:goal");
        const std::string both = cause.together ? std::regex_replace(cause.condition, std::regex(" and "), " ") : "";
        asked =
            parsed(domain, problem.substr(0, goal) + "(:goal (and " + (both.empty() ? cause.condition : both) + ")))");
      }
      for (const State& state : *states) {
        const bool all = std::ranges::all_of(cause.facts, [&](const FactPattern& fact) { return has(state, fact); });
        EXPECT_FALSE(!cause.facts.empty() && all) << cause.condition;
        if (!asked) continue;
        Frame frame(static_cast<std::size_t>(asked->problem.goal_slots), -1);
        EXPECT_FALSE(Evaluator(asked->domain, asked->problem).holds(asked->problem.goal, frame, state))
            << cause.condition;
      }
    }
  }
  EXPECT_GT(explained, proved * 9 / 10) << proved;
  EXPECT_GT(states_seen, 400);
  EXPECT_GT(chains, 50);
  EXPECT_GT(twos, 1);
  EXPECT_GT(patterns, 100);
  EXPECT_GT(conditions, 500);
}

}  // namespace
}  // namespace cxlab::planner
