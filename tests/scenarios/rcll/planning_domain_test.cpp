// The coarse actions of the planning agent and their parts. Nothing here names an action. The test derives a problem
// from the parsed domain for each action NAME that has a NAME-drive: its conditions are the initial state, its effects
// are the goal. For the domain of a copy of the agent: CXLAB_PDDL=DIR (an absolute path).

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "planner/pddl/parser.h"
#include "planner/pddl/text.h"
#include "planner/planner.h"
#include "planner/state/state.h"
#include "planner/validator/validator.h"

namespace cxlab::planner {
namespace {

constexpr double kAnyNumber = 5;  // of numbers of which no condition says anything

/// The agent states its goals to the PDDL manager.
const LoadOptions kWithoutGoal = {.needs_goal = false};

/// The folder of the domain: that of the shipped agent, or $CXLAB_PDDL.
std::string folder() {
  if (const char* own = std::getenv("CXLAB_PDDL")) return std::string(own) + '/';
  return std::string(std::getenv("CXLAB_SOURCE_DIR")) + "/scenarios/rcll/planning_agent/pddl/";
}

Task production() {
  auto task = load_task(folder() + "production.pddl", folder() + "problem.pddl", kWithoutGoal);
  if (!task) throw std::runtime_error(task.error().text());
  return *task;
}

const Action& action(const Domain& domain, const std::string& name) {
  return domain.actions[domain.action_names.at(name)];
}

std::vector<std::string> names_of_robot_actions(const Domain& domain) {
  std::vector<std::string> names;
  for (const Action& a : domain.actions)
    if (a.durative && domain.action_names.contains(a.name + "-drive")) names.push_back(a.name);
  return names;
}

/// The true facts and the numbers of a state, in words.
std::set<std::string> in_words(const State& state, const Domain& domain, const Problem& problem) {
  std::set<std::string> words;
  for (const Fact& fact : state.facts())
    words.insert(ground_text(domain.predicates[fact.predicate].name, fact.objects, problem.objects));
  for (const Assignment& number : state.values())
    words.insert(ground_text(domain.functions[number.function].name, number.objects, problem.objects) + " = " +
                 number_text(number.value));
  return words;
}

std::string difference(const std::set<std::string>& expected, const std::set<std::string>& found) {
  std::string text;
  for (const std::string& word : expected)
    if (!found.contains(word)) text += " missing: " + word;
  for (const std::string& word : found)
    if (!expected.contains(word)) text += " too much: " + word;
  return text;
}

/// A coarse action with one object for each of its parameters, in a state in which it may begin.
class Begun {
 public:
  Begun(const Domain& domain, const std::string& name) : domain_(domain), coarse_(action(domain, name)) {
    problem_.objects = domain.constants;
    for (const Variable& parameter : coarse_.parameters) {
      arguments_.push_back(static_cast<ObjectId>(problem_.objects.size()));
      problem_.objects.push_back({parameter.name.substr(1) + "-object", parameter.types, {}});
    }
    for (const char* part : {"", "-drive", "-pick", "-place", "-return", "-lose"})
      give_numbers(action(domain, name + part));
    demand(coarse_.condition.start, true);
  }

  const Domain& domain() const { return domain_; }
  const Action& coarse() const { return coarse_; }
  const Problem& problem() const { return problem_; }
  Problem& problem() { return problem_; }
  const std::vector<ObjectId>& arguments() const { return arguments_; }
  State initial() const { return State(domain_, problem_); }

  /// Makes all facts true that an effect of a part of the action names and no condition forbids.
  void fill(const std::vector<std::string>& parts) {
    for (const std::string& part : parts)
      for (const Effect& effect : action(domain_, part).effects)
        if (!effect.is_numeric() && effect.variables.empty()) make_true({effect.predicate, bound(effect.terms)});
    std::erase_if(problem_.init, [this](const Fact& fact) {
      return std::find(forbidden_.begin(), forbidden_.end(), fact) != forbidden_.end();
    });
  }

  void make_true(const Fact& fact) {
    if (std::find(problem_.init.begin(), problem_.init.end(), fact) == problem_.init.end())
      problem_.init.push_back(fact);
  }

  /// The state after the effects of that time. None where the action may not begin.
  std::optional<State> after(State state, const std::string& name, Effect::Time time = Effect::Time::kStart) const {
    const Action& done = action(domain_, name);
    const Evaluator evaluator(domain_, problem_);
    Frame frame = this->frame(done);
    if (time == Effect::Time::kStart && !evaluator.holds(done.condition.start, frame, state)) return std::nullopt;
    std::vector<Change> changes;
    for (const Effect& effect : done.effects)
      if (effect.time == time)
        evaluator.collect(
            effect, frame, state, 0, [&](Frame& f) { return evaluator.holds(effect.condition.start, f, state); },
            changes);
    if (!apply_changes(changes, state)) return std::nullopt;
    return state;
  }

  Frame frame(const Action& of) const {
    Frame frame;
    for (const ObjectId object : arguments_) frame.push_back(object);
    frame.resize(static_cast<std::size_t>(of.slots));
    return frame;
  }

 private:
  std::vector<ObjectId> bound(const std::vector<Term>& terms) const {
    const Objects objects(terms, frame(coarse_));
    return {objects.begin(), objects.end()};
  }

  void give_number(const Expression& part, double value) {
    if (part.kind != Expression::Kind::kFunction) return;
    const std::vector<ObjectId> objects = bound(part.terms);
    for (Assignment& known : problem_.values)
      if (known.function == part.function && known.objects == objects) {
        known.value = value;
        return;
      }
    problem_.values.push_back({part.function, objects, value});
  }

  void give_numbers(const Action& of) {
    const auto give = [this](const Expression& part) { give_number(part, kAnyNumber); };
    for (const DurationConstraint& duration : of.duration) for_each_part(duration.bound, give);
    for (const Effect& effect : of.effects)
      if (effect.is_numeric()) {
        Expression changed{Expression::Kind::kFunction, 0, effect.function, effect.terms, {}};
        give(changed);
        for_each_part(effect.value, give);
      }
  }

  /// Makes a condition true: what these actions use is `and`, `not`, facts, and a number beside a constant.
  void demand(const Condition& condition, bool value) {
    switch (condition.kind) {
      case Condition::Kind::kAnd:
        for (const Condition& part : condition.operands) demand(part, value);
        break;
      case Condition::Kind::kNot: demand(condition.operands.front(), !value); break;
      case Condition::Kind::kAtom:
        if (value)
          make_true({condition.predicate, bound(condition.terms)});
        else
          forbidden_.push_back({condition.predicate, bound(condition.terms)});
        break;
      case Condition::Kind::kCompare: give_number(condition.sides.front(), condition.sides.back().value); break;
      default: break;  // MayBegin tells
    }
  }

  const Domain& domain_;
  const Action& coarse_;
  Problem problem_;
  std::vector<ObjectId> arguments_;
  std::vector<Fact> forbidden_;
};

/// The goal "as in that state", of all that the action changes.
Condition as_in(const State& state, const Begun& begun) {
  Condition goal;
  for (const Effect& effect : begun.coarse().effects) {
    Condition part;
    const Objects objects(effect.terms, begun.frame(begun.coarse()));
    std::vector<Term> terms;
    for (const ObjectId object : objects) terms.push_back(Term::object(object));
    if (effect.is_numeric()) {
      part.kind = Condition::Kind::kCompare;
      part.comparison = Comparison::kEqual;
      part.sides = {Expression{Expression::Kind::kFunction, 0, effect.function, terms, {}},
                    Expression::constant(*state.value(effect.function, objects))};
    } else {
      part.kind = Condition::Kind::kAtom;
      part.predicate = effect.predicate;
      part.terms = terms;
      if (!state.holds(effect.predicate, objects)) {
        Condition none;
        none.kind = Condition::Kind::kNot;
        none.operands = {part};
        part = none;
      }
    }
    goal.operands.push_back(part);
  }
  return goal;
}

/// The domain with these actions alone.
Domain with_actions(const Domain& whole, const std::vector<std::string>& names) {
  Domain domain = whole;
  domain.actions.clear();
  domain.action_names.clear();
  for (const std::string& name : names) {
    domain.action_names[name] = static_cast<ActionId>(domain.actions.size());
    domain.actions.push_back(action(whole, name));
  }
  return domain;
}

/// The fault of the refinement of a coarse action; empty if it has none.
std::string fault_of_refinement(const Domain& domain, const std::string& name) {
  const std::vector<std::string> parts = {name + "-drive", name + "-pick", name + "-place"};

  // The planner gets from the conditions to the effects, with drive, pick and place, once each.
  Begun begun(domain, name);
  const auto started = begun.after(begun.initial(), name);
  if (!started) return "its conditions cannot be made true";
  const auto ended = begun.after(*started, name, Effect::Time::kEnd);
  if (!ended) return "its end has no effect";
  Task task{with_actions(domain, parts), begun.problem()};
  task.problem.goal = as_in(*ended, begun);
  const auto answer = find_plan(task, {.budget = 1'000'000});
  if (!answer) return answer.error().text();
  if (!answer->plan) return "no plan of its parts: " + answer->reason;
  const Plan& steps = answer->plan->steps;
  std::vector<std::string> found;
  for (const PlanStep& step : steps) {
    found.push_back(task.domain.actions[step.action].name);
    if (step.arguments != begun.arguments())
      return "a part has other arguments: " + step_text(step, task.domain, task.problem);
  }
  if (found != parts) return "another plan:\n" + to_text(steps, task.domain, task.problem);
  const auto verdict = Validator(task.domain, task.problem).check(steps);
  if (!verdict) return verdict.error().text();
  if (!verdict->valid) return to_text(*verdict->violation);

  // The state is the same afterwards, whatever else was true before.
  Begun full(domain, name);
  full.fill({name, parts[0], parts[1], parts[2]});
  std::erase_if(full.problem().init,
                [&](const Fact& fact) { return domain.predicates[fact.predicate].name.starts_with(name + "-"); });
  for (const Begun* from : {&begun, &full}) {
    const State coarse = *from->after(*from->after(from->initial(), name), name, Effect::Time::kEnd);
    std::optional<State> fine = from->initial();
    for (const std::string& part : parts) {
      fine = from->after(*fine, part);
      if (!fine) return part + " may not begin";
    }
    const std::string differs =
        difference(in_words(coarse, domain, from->problem()), in_words(*fine, domain, from->problem()));
    if (!differs.empty()) return "after its parts:" + differs;
  }
  return "";
}

TEST(PlanningDomain, EveryActionOfARobotHasItsPartsAndItsFailures) {
  const Task task = production();
  const std::vector<std::string> names = names_of_robot_actions(task.domain);
  EXPECT_EQ(names.size(), 7u);
  for (const std::string& name : names)
    for (const char* part : {"-drive", "-pick", "-place", "-return", "-lose"})
      EXPECT_TRUE(task.domain.action_names.contains(name + part)) << name << part;
}

TEST(PlanningDomain, PlansAddARobotOrADeadlineAsTheLastParameter) {
  const auto planning = load_task(folder() + "planning.pddl", folder() + "planning_problem.pddl", kWithoutGoal);
  ASSERT_TRUE(planning) << planning.error().text();
  const Task world = production();
  const auto type_of_last = [&](const std::string& name) {
    const Action& planned = action(planning->domain, name);
    EXPECT_EQ(planned.parameters.size(), action(world.domain, name).parameters.size() + 1) << name;
    return planning->domain.types[static_cast<std::size_t>(planned.parameters.back().types.front())].name;
  };
  for (const std::string& name : names_of_robot_actions(world.domain)) {
    EXPECT_EQ(type_of_last(name), "robot");
    EXPECT_EQ(action(planning->domain, name + "-place").parameters.size(),
              action(world.domain, name + "-place").parameters.size());
  }
  EXPECT_EQ(type_of_last("deliver"), "moment");
}

TEST(PlanningDomain, DrivePickAndPlaceRefineEachActionOfARobot) {
  const Task task = production();
  for (const std::string& name : names_of_robot_actions(task.domain))
    EXPECT_EQ(fault_of_refinement(task.domain, name), "") << name;
}

TEST(PlanningDomain, RefinementFailsWithoutAnyOneEffectOfAPart) {
  const Task task = production();
  for (const std::string& name : names_of_robot_actions(task.domain))
    for (const char* part : {"-drive", "-pick", "-place"}) {
      const std::size_t effects = action(task.domain, name + part).effects.size();
      for (std::size_t i = 0; i < effects; ++i) {
        Domain changed = task.domain;
        auto& of = changed.actions[changed.action_names.at(name + part)].effects;
        of.erase(of.begin() + static_cast<std::ptrdiff_t>(i));
        EXPECT_NE(fault_of_refinement(changed, name), "") << name << part << " without effect " << i;
      }
    }
}

TEST(PlanningDomain, ReturnAfterDriveRestoresTheStateBefore) {
  const Task task = production();
  for (const std::string& name : names_of_robot_actions(task.domain)) {
    const Begun begun(task.domain, name);
    const auto driving = begun.after(begun.initial(), name + "-drive");
    ASSERT_TRUE(driving) << name;
    EXPECT_NE(in_words(*driving, task.domain, begun.problem()),
              in_words(begun.initial(), task.domain, begun.problem()));
    const auto back = begun.after(*driving, name + "-return");
    ASSERT_TRUE(back) << name;
    EXPECT_EQ(difference(in_words(begun.initial(), task.domain, begun.problem()),
                         in_words(*back, task.domain, begun.problem())),
              "")
        << name;
  }
}

/// Sides of machines in a state: which should be free, because nothing lies there, and which are free.
class Sides {
 public:
  Sides(const Domain& domain, const Problem& problem, const State& state) : domain_(domain) {
    const Predicate& side = domain.predicates[domain.predicate_names.at("input-free")];
    for (const ObjectId machine : objects_of(domain, problem, side.parameters.front().types)) {
      compare(state, "input-free", machine, {"at-input", "carrier-at-input"});
      compare(state, "output-free", machine, {"at-output", "bare-base-at-output"});
    }
  }
  std::vector<Fact> should_be_free, free;

 private:
  void compare(const State& state, const char* side, ObjectId machine, const std::vector<std::string>& pieces) {
    const Fact fact{domain_.predicate_names.at(side), {machine}};
    const auto lies_there = [&](const Fact& piece) {
      return std::find(pieces.begin(), pieces.end(), domain_.predicates[piece.predicate].name) != pieces.end() &&
             piece.objects.back() == machine;
    };
    const std::vector<Fact> facts = state.facts();
    if (std::none_of(facts.begin(), facts.end(), lies_there)) should_be_free.push_back(fact);
    if (state.holds(fact.predicate, fact.objects)) free.push_back(fact);
  }
  const Domain& domain_;
};

TEST(PlanningDomain, LostPieceLeavesNoClaim) {
  const Task task = production();
  const Domain& domain = task.domain;
  for (const std::string& name : names_of_robot_actions(domain))
    for (const bool picked : {false, true}) {
      SCOPED_TRACE(name + (picked ? " with the piece" : " on the way to the piece"));
      Begun begun(domain, name);
      for (const Fact& side : Sides(domain, begun.problem(), begun.initial()).should_be_free) begun.make_true(side);
      auto state = begun.after(begun.initial(), name + "-drive");
      ASSERT_TRUE(state);
      if (picked) state = begun.after(*state, name + "-pick");
      ASSERT_TRUE(state);
      state = begun.after(*state, name + "-lose");
      ASSERT_TRUE(state);

      const Sides sides(domain, begun.problem(), *state);
      EXPECT_EQ(sides.free, sides.should_be_free);
      for (const Assignment& before : begun.initial().values())
        EXPECT_EQ(state->value(before.function, before.objects), before.value)
            << domain.functions[before.function].name;
      for (const Fact& fact : state->facts())
        EXPECT_FALSE(domain.predicates[fact.predicate].name.starts_with(name + "-")) << "still under way";

      // A product begins again, with its first step, or with the one that it was at before it had begun.
      const PredicateId not_begun = domain.predicate_names.at("not-begun"),
                        at_step = domain.predicate_names.at("at-step");
      const auto& product_types = domain.predicates[not_begun].parameters.front().types;
      for (const ObjectId product : objects_of(domain, begun.problem(), product_types)) {
        EXPECT_TRUE(state->holds(not_begun, std::vector<ObjectId>{product}));
        std::vector<Fact> steps;
        for (const Fact& fact : state->facts())
          if (fact.predicate == at_step && fact.objects.front() == product) steps.push_back(fact);
        ASSERT_EQ(steps.size(), 1u);
        if (begun.initial().holds(not_begun, std::vector<ObjectId>{product}))
          EXPECT_TRUE(begun.initial().holds(at_step, steps.front().objects));
        else
          EXPECT_EQ(begun.problem().objects[steps.front().objects.back()].name, "s0");
      }
    }
}

TEST(PlanningDomain, OutputThatARobotHasLeftIsNotFreedAgainWhenItLosesThePiece) {
  const Task task = production();
  const Domain& domain = task.domain;
  const PredicateId output_free = domain.predicate_names.at("output-free");
  int outputs = 0;
  for (const std::string& name : names_of_robot_actions(domain)) {
    const Begun begun(domain, name);
    const auto driving = begun.after(begun.initial(), name + "-drive");
    ASSERT_TRUE(driving) << name;
    auto state = begun.after(*driving, name + "-pick");
    ASSERT_TRUE(state) << name;
    std::vector<Fact> left;
    for (const Fact& fact : state->facts())
      if (fact.predicate == output_free && !driving->holds(fact.predicate, fact.objects)) left.push_back(fact);
    for (const Fact& fact : left) state->set(fact.predicate, fact.objects, false);  // the next piece lies there
    state = begun.after(*state, name + "-lose");
    ASSERT_TRUE(state) << name;
    for (const Fact& fact : left) EXPECT_FALSE(state->holds(fact.predicate, fact.objects)) << name;
    outputs += static_cast<int>(left.size());
  }
  EXPECT_EQ(outputs, 4);
}

/// The facts and numbers after an instantaneous action with these arguments, in a state with two products and three
/// machines.
std::set<std::string> after_accident(const Domain& domain, const std::string& init, const std::string& name,
                                     const std::vector<std::string>& arguments) {
  const auto problem = parse_problem(
      "(define (problem p) (:domain rcll-production) (:objects o1 o2 - product cs1 - "
      "cap-station rs1 - ring-station ds - delivery-station) (:init " +
          init + ") (:goal (delivered o1)))",
      "p.pddl", domain);
  if (!problem) throw std::runtime_error(problem.error().text());
  State state(domain, *problem);
  const Action& done = action(domain, name);
  Frame frame;
  for (const std::string& argument : arguments)
    frame.push_back(static_cast<ObjectId>(std::find_if(problem->objects.begin(), problem->objects.end(),
                                                       [&](const auto& o) { return o.name == argument; }) -
                                          problem->objects.begin()));
  frame.resize(static_cast<std::size_t>(done.slots));
  const Evaluator evaluator(domain, *problem);
  std::vector<Change> changes;
  for (const Effect& effect : done.effects)
    evaluator.collect(
        effect, frame, state, 0, [&](Frame& f) { return evaluator.holds(effect.condition.start, f, state); }, changes);
  EXPECT_TRUE(apply_changes(changes, state));
  return in_words(state, domain, *problem);
}

TEST(PlanningDomain, AccidentsAtMachinesTakeWhatLiesThereAndLeaveNoClaim) {
  const Task task = production();
  struct Accident {
    std::string init, name;
    std::vector<std::string> arguments;
    std::set<std::string> after;
  };
  const std::set<std::string> anew = {"(not-begun o1)", "(at-step o1 s0)"};
  const auto with = [&](std::set<std::string> more) {
    more.insert(anew.begin(), anew.end());
    return more;
  };
  for (const Accident& a : {
           Accident{"", "lose-work", {"o1", "rs1"}, with({"(input-free rs1)", "(output-free rs1)"})},
           Accident{"(at-step o2 s1)",
                    "lose-work",
                    {"o1", "rs1"},
                    with({"(input-free rs1)", "(output-free rs1)", "(at-step o2 s1)"})},
           Accident{"", "lose-carrier", {"cs1"}, {"(input-free cs1)", "(output-free cs1)"}},
           Accident{"(at-input o1 rs1) (at-step o1 s2) (at-input o2 cs1) (at-step o2 s1)",
                    "empty-input",
                    {"rs1"},
                    with({"(input-free rs1)", "(at-input o2 cs1)", "(at-step o2 s1)"})},
           Accident{
               "(at-output o1 rs1) (at-step o1 s2)", "empty-input", {"rs1"}, {"(at-output o1 rs1)", "(at-step o1 s2)"}},
           Accident{"(at-output o1 rs1) (at-step o1 s2) (at-output o2 cs1) (at-step o2 s1)",
                    "empty-output",
                    {"rs1"},
                    with({"(output-free rs1)", "(at-output o2 cs1)", "(at-step o2 s1)"})},
           Accident{
               "(at-input o1 rs1) (at-step o1 s2)", "empty-output", {"rs1"}, {"(at-input o1 rs1)", "(at-step o1 s2)"}},
           Accident{"(cap-loaded cs1)", "empty-cap-station", {"cs1"}, {}},
           Accident{"(carrier-at-input cs1)", "empty-cap-station", {"cs1"}, {"(input-free cs1)"}},
           Accident{"(bare-base-at-output cs1)", "empty-cap-station", {"cs1"}, {"(output-free cs1)"}},
           Accident{"(= (payments rs1) 2) (= (slide-room rs1) 1)",
                    "empty-slide",
                    {"rs1"},
                    {"(payments rs1) = 0", "(slide-room rs1) = 3"}},
       })
    EXPECT_EQ(difference(a.after, after_accident(task.domain, a.init, a.name, a.arguments)), "")
        << a.name << " from " << a.init;
}

TEST(LevelTwo, ABaseComesOutAtTheSideOverWhichItIsThereSooner) {
  auto task = load_task(folder() + "refinement.pddl", folder() + "refinement_problem.pddl", kWithoutGoal);
  ASSERT_TRUE(task) << task.error().text();
  struct Ways {
    double to_input, on_from_input, to_output, on_from_output;
    std::string side;
    double makespan;  // 15 s for the pick; the base takes 5 s to come out
  };
  for (const Ways& ways : {Ways{10, 12, 8, 10, "output", 33}, Ways{8, 10, 10, 12, "input", 33},
                           Ways{8, 14, 12, 8, "output", 35}, Ways{1, 9, 4, 8, "output", 28}}) {
    const auto problem = parse_problem(
        "(define (problem p) (:domain rcll-refinement) (:init (station-free) (robot-free) (= (dispense-time) 5) (= "
        "(handling-time) 15)"
        " (= (way-to input) " +
            std::to_string(ways.to_input) + ") (= (way-on input) " + std::to_string(ways.on_from_input) +
            ") (= (way-to output) " + std::to_string(ways.to_output) + ") (= (way-on output) " +
            std::to_string(ways.on_from_output) + ")) (:goal (base-there)))",
        "p.pddl", task->domain);
    ASSERT_TRUE(problem) << problem.error().text();
    const auto found = find_plan({task->domain, *problem}, {.budget = 50'000, .anytime = true});
    ASSERT_TRUE(found && found->plan);
    EXPECT_NEAR(found->plan->makespan_s, ways.makespan, 0.01);
    for (const PlanStep& step : found->plan->steps)
      EXPECT_EQ(problem->objects[step.arguments[0]].name, ways.side) << ways.makespan;
  }
}

}  // namespace
}  // namespace cxlab::planner
