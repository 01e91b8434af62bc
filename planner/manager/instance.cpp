#include "planner/manager/instance.h"

#include <algorithm>
#include <tuple>

#include "planner/pddl/syntax.h"
#include "planner/pddl/text.h"
#include "planner/state/number.h"

namespace cxlab::planner {
namespace {

constexpr std::size_t kMostNames = 10;  ///< that an error names

template <class Items>
std::vector<std::string> names_of(const Items& items) {
  std::vector<std::string> names;
  for (const auto& item : items) names.push_back(item.name);
  return names;
}

/// An effect at the end with a condition at the start.
bool asks_before(const Effect& effect) {
  return effect.time != Effect::Time::kStart && !effect.condition.start.is_true();
}

std::string changed_name(const Domain& domain, const Effect& effect) {
  return effect.is_numeric() ? domain.functions[effect.function].name : domain.predicates[effect.predicate].name;
}

/// Without its arguments and number.
ReportedEffect reported(const Domain& domain, const Effect& effect) {
  const char operation = effect.kind == Effect::Kind::kIncrease   ? '+'
                         : effect.kind == Effect::Kind::kDecrease ? '-'
                                                                  : '=';
  return {changed_name(domain, effect),
          {},
          effect.time != Effect::Time::kStart,
          effect.is_numeric(),
          effect.kind == Effect::Kind::kAdd,
          operation,
          0};
}

bool scales(const Effect& effect) {
  return effect.kind == Effect::Kind::kScaleUp || effect.kind == Effect::Kind::kScaleDown;
}

std::vector<ObjectId> binding(const Effect& effect, const Frame& frame) {
  std::vector<ObjectId> objects;
  for (const Variable& variable : effect.variables) objects.push_back(frame[variable.slot]);
  return objects;
}

}  // namespace

Error unknown_name(const std::string& what, const std::string& found, const std::vector<std::string>& known) {
  const std::string text = "unknown " + what + " '" + found + "'";
  if (known.empty()) return input_error(text + ", there is none");
  if (const std::string hint = did_you_mean(found, known); !hint.empty()) return input_error(text + hint);
  return input_error(text + ", known: " + some_of(known, kMostNames));
}

Instance::Instance(Task task, Meter* meter)
    : task_(std::move(task)), state_(task_.domain, task_.problem), meter_(meter) {
  task_.problem.goal = {};
  task_.problem.goal_slots = 0;
  goals_["base"];
  renew_evaluator();
}

void Instance::renew_evaluator() {
  evaluator_.emplace(task_.domain, task_.problem, meter_);
  touch();
}

const State& Instance::state() const {
  if (!derived_) evaluator_->derive(state_);
  derived_ = !evaluator_->is_over();
  return state_;
}

// --- Names

template <class Found, class Item>
Expected<Found> Instance::look_up(const char* what, const ById<Item>& items, const NameTable& table,
                                  const std::string& name, const Names& arguments) const {
  const int id = find(table, lower_case(name));
  if (id < 0) return unknown_name(what, name, names_of(items));
  const std::vector<Variable>& parameters = items[id].parameters;
  if (arguments.size() != parameters.size())
    return input_error(
        message("'", name, "': ", found_expected(message(arguments.size(), " arguments"), message(parameters.size()))));
  Found found{id, {}};
  auto& [_, objects] = found;
  for (const Variable& parameter : parameters) {
    const std::string& argument = arguments[objects.size()];
    const ObjectId object = objects.emplace_back(find(problem().object_names, lower_case(argument)));
    if (object < 0) return unknown_name("object", argument, names_of(problem().objects));
    if (!fits(domain(), problem().objects[object], parameter.types))
      return input_error(
          "'" + name + "': '" + argument + "' has the wrong type for " + parameter.name + ": " +
          found_expected(types_text(domain(), problem().objects[object].types), types_text(domain(), parameter.types)));
  }
  return found;
}

Expected<Fact> Instance::fact(const std::string& predicate, const Names& arguments) const {
  return look_up<Fact>("fluent", domain().predicates, domain().predicate_names, predicate, arguments);
}

Expected<Fact> Instance::number(const std::string& function, const Names& arguments) const {
  return look_up<Fact>("function", domain().functions, domain().function_names, function, arguments);
}

Expected<ActionCall> Instance::step(const std::string& action, const Names& arguments) const {
  return look_up<ActionCall>("action", domain().actions, domain().action_names, action, arguments);
}

Expected<TypeId> Instance::type(const std::string& name) const {
  const TypeId id = find(domain().type_names, lower_case(name));
  if (id < 0) return unknown_name("type", name, names_of(domain().types));
  return id;
}

// --- The state of now

std::vector<Fact> Instance::facts() const { return in_order(state()); }

std::vector<Fact> Instance::in_order(State others) const {
  std::vector<Fact> all;
  for (const Fact& fact : problem().init) {
    if (!others.holds(fact.predicate, fact.objects)) continue;
    all.push_back(fact);
    others.set(fact.predicate, fact.objects, false);
  }
  std::vector<Fact> later = others.facts();
  std::ranges::stable_partition(later, [&](const Fact& f) { return !domain().predicates[f.predicate].derived; });
  all.insert(all.end(), later.begin(), later.end());
  return all;
}

Status Instance::set(const Fact& fact, bool value) {
  const Predicate& predicate = domain().predicates[fact.predicate];
  if (predicate.derived) return input_error("'" + predicate.name + "' is derived from other fluents and cannot be set");
  state_.set(fact.predicate, fact.objects, value);
  touch();
  return {};
}

void Instance::set_value(const Fact& number, double value) {
  state_.set_value(number.predicate, number.objects, value);
  touch();
}

Expected<std::vector<Object>> Instance::new_objects(const std::vector<ObjectName>& wanted) const {
  std::vector<Object> made;
  for (const ObjectName& object : wanted) {
    auto type_id = type(object.type);
    if (!type_id) return type_id.error();
    if (object.name.empty()) return input_error("found an object without a name");
    const Object* there = nullptr;
    if (const ObjectId known = find(problem().object_names, lower_case(object.name)); known >= 0)
      there = &problem().objects[known];
    for (const Object& before : made)
      if (lower_case(before.name) == lower_case(object.name)) there = &before;
    if (!there)
      made.push_back({object.name, {*type_id}, {Source::File::kProblem, 0}});
    else if (!fits(domain(), *there, {*type_id}))
      return input_error("object '" + object.name + "' is there already: " +
                         found_expected("the type " + types_text(domain(), there->types), object.type));
  }
  return made;
}

void Instance::add_objects(const std::vector<Object>& objects) {
  Problem& problem = task_.problem;
  for (const Object& object : objects) {
    problem.object_names[lower_case(object.name)] = static_cast<int>(problem.objects.size());
    problem.objects.push_back(object);
  }
  renew_evaluator();
}

Expected<std::vector<char>> Instance::others_than(const std::vector<ObjectName>& gone) const {
  std::vector<char> keep(problem().objects.size(), 1);
  for (const ObjectName& object : gone) {
    const ObjectId id = find(problem().object_names, lower_case(object.name));
    if (id < 0) return unknown_name("object", object.name, names_of(problem().objects));
    const Object& there = problem().objects[id];
    if (!object.type.empty()) {
      auto type_id = type(object.type);
      if (!type_id) return type_id.error();
      if (!fits(domain(), there, {*type_id}))
        return input_error("object '" + object.name +
                           "': " + found_expected("the type " + types_text(domain(), there.types), object.type));
    }
    if (id < static_cast<ObjectId>(domain().constants.size()))
      return input_error("'" + object.name + "' is a constant of the domain and cannot be removed");
    keep[static_cast<std::size_t>(id)] = 0;
  }
  return keep;
}

/// The state is written to the problem, from which objects can be removed, and read again. So are the goals.
void Instance::keep_objects(const std::vector<char>& keep) {
  Problem now = problem();
  started_.clear();
  now.init.clear();
  for (Fact& fact : in_order(state_))
    if (!domain().predicates[fact.predicate].derived) now.init.push_back(std::move(fact));
  now.values = state_.values();
  for (auto& [_, goal] : goals_) {
    std::tie(goal.facts, goal.values) = goals_without(now, goal, keep);
    for (std::size_t i = 0; i < keep.size(); ++i)
      if (!keep[i]) std::erase(goal.objects, now.objects[i].name);
  }
  const auto before = [](const auto& events, std::size_t next) {
    return std::vector(events.begin() + static_cast<std::ptrdiff_t>(next), events.end());
  };
  now.timed_facts = before(now.timed_facts, next_fact_);
  now.timed_values = before(now.timed_values, next_value_);
  next_fact_ = next_value_ = 0;
  task_.problem = without_objects(now, keep);
  state_ = State(domain(), problem());
  renew_evaluator();
}

bool Instance::advance(double seconds) {
  bool any = false;
  const Problem& p = problem();
  for (; next_fact_ < p.timed_facts.size() && p.timed_facts[next_fact_].time <= seconds; ++next_fact_, any = true) {
    const TimedFact& event = p.timed_facts[next_fact_];
    state_.set(event.fact.predicate, event.fact.objects, event.value);
  }
  for (; next_value_ < p.timed_values.size() && p.timed_values[next_value_].time <= seconds;
       ++next_value_, any = true) {
    const Assignment& event = p.timed_values[next_value_].assignment;
    state_.set_value(event.function, event.objects, event.value);
  }
  if (any) touch();
  return any;
}

// --- Goals

Status Instance::create_goal(const std::string& name) {
  if (name.empty()) return input_error("a goal instance needs a name");
  goals_[name] = {};
  return {};
}

GoalInstance* Instance::goal(const std::string& name) {
  const auto known = goals_.find(name);
  return known == goals_.end() ? nullptr : &known->second;
}

Expected<Instance::Names> Instance::known_names(Names GoalInstance::* filter, const Names& names) const {
  const bool of_actions = filter == &GoalInstance::actions, of_objects = filter == &GoalInstance::objects;
  const char* what = of_actions ? "action" : of_objects ? "object" : "fluent";
  Names known = of_actions   ? names_of(domain().actions)
                : of_objects ? names_of(problem().objects)
                             : names_of(domain().predicates);
  if (!of_actions && !of_objects) std::ranges::move(names_of(domain().functions), std::back_inserter(known));
  Names out;
  for (const std::string& name : names) {
    const auto found = std::ranges::find(known, lower_case(name), [](const auto& each) { return lower_case(each); });
    if (found == known.end()) return unknown_name(what, name, known);
    out.push_back(*found);
  }
  return out;
}

// --- Actions

Frame Instance::frame(const ActionCall& call) const {
  Frame frame(call.arguments);
  frame.resize(static_cast<std::size_t>(domain().actions[call.action].slots));
  return frame;
}

/// The shortest that the action may take, s.
double Instance::duration(const ActionCall& call, const Frame& frame) const {
  double shortest = 0;
  for (const DurationConstraint& constraint : domain().actions[call.action].duration) {
    const auto bound = evaluator_->number(constraint.bound, frame, state_);
    if (bound && (constraint.comparison == Comparison::kEqual || constraint.comparison == Comparison::kGreaterEqual))
      shortest = std::max(shortest, *bound);
  }
  return shortest;
}

Instance::Names Instance::unsatisfied(const ActionCall& call, When when) const {
  const Action& action = domain().actions[call.action];
  Frame bound = frame(call);
  const double length = action.durative ? duration(call, bound) : 0;
  Names missing;
  const auto check = [&](const auto& self, const Condition& condition, const State& now) -> void {
    if (condition.kind == Condition::Kind::kAnd) {
      for (const Condition& part : condition.operands) self(self, part, now);
    } else if (!evaluator_->holds(condition, bound, now, length)) {
      std::string condition_text = framework_text(condition, domain(), problem().objects, call.arguments);
      if (std::ranges::find(missing, condition_text) == missing.end()) missing.push_back(std::move(condition_text));
    }
  };
  const State& now = state();
  if (when == When::kStart || when == When::kAtStart) check(check, action.condition.start, now);
  if (when == When::kOverAll) check(check, action.condition.over_all, now);
  if (when == When::kEnd) check(check, action.condition.end, now);
  // Where the action takes no time, the open interval between start and end is empty.
  const bool takes_time = std::ranges::none_of(action.duration, [&](const DurationConstraint& constraint) {
    const auto bound_now = evaluator_->number(constraint.bound, bound, state_);
    return constraint.comparison != Comparison::kGreaterEqual && bound_now && *bound_now <= 0;
  });
  if (when == When::kStart && takes_time && !action.condition.over_all.is_true()) {
    std::vector<Change> changes;
    bool defined = true;
    for (const Effect& effect : action.effects)
      if (effect.time == Effect::Time::kStart)
        defined = evaluator_->collect(
                      effect, bound, now, length,
                      [&](Frame& f) { return evaluator_->holds(effect.condition.start, f, now, length); }, changes) &&
                  defined;
    State after = now;
    if (defined && apply_changes(changes, after)) {
      evaluator_->derive(after);
      check(check, action.condition.over_all, after);
    } else {
      missing.push_back("an effect at the start reads a number without a value");
    }
  }
  return missing;
}

void Instance::remember_start(const ActionCall& call) {
  const Action& action = domain().actions[call.action];
  if (std::ranges::none_of(action.effects, asks_before)) return;
  EffectSet promised;
  Frame bound = frame(call);
  const State& now = state();
  const double length = duration(call, bound);
  for (std::size_t i = 0; i < action.effects.size(); ++i) {
    const Effect& effect = action.effects[i];
    if (!asks_before(effect)) continue;
    evaluator_->each_binding(effect.variables, bound, [&] {
      if (evaluator_->holds(effect.condition.start, bound, now, length)) promised.emplace(i, binding(effect, bound));
      return true;
    });
  }
  started_[{call.action, call.arguments}] = std::move(promised);
}

Expected<std::vector<ReportedEffect>> Instance::effects(const ActionCall& call) const {
  const Action& action = domain().actions[call.action];
  Frame bound = frame(call);
  const State& now = state();
  const double length = action.durative ? duration(call, bound) : 0;
  const auto started = started_.find({call.action, call.arguments});
  std::vector<ReportedEffect> effects;
  for (std::size_t i = 0; i < action.effects.size(); ++i) {
    const Effect& effect = action.effects[i];
    std::vector<Change> changes;
    const TimedCondition& when = effect.condition;
    const bool remembered = started != started_.end() && asks_before(effect);
    const auto holds = [&](Frame& f) {
      const bool held = remembered ? started->second.contains({i, binding(effect, f)})
                                   : evaluator_->holds(when.start, f, now, length);
      return held && evaluator_->holds(when.over_all, f, now, length) && evaluator_->holds(when.end, f, now, length);
    };
    const std::string where = "effect on '" + changed_name(domain(), effect) + "' of '" + action.name + "': ";
    if (!evaluator_->collect(effect, bound, now, length, holds, changes))
      return input_error(where + "its right-hand side has no value now");
    for (const Change& change : changes) {
      ReportedEffect& out = effects.emplace_back(reported(domain(), effect));
      for (const ObjectId object : change.objects) out.arguments.push_back(problem().objects[object].name);
      out.number = effect.time == Effect::Time::kContinuous ? product(change.value, length) : change.value;
      if (!scales(effect)) continue;
      const bool up = effect.kind == Effect::Kind::kScaleUp;
      const auto old = now.value(change.id, change.objects);
      if (!old || (!up && change.value == 0)) return input_error(where + "there is no value to scale");
      out.number = up ? product(*old, change.value) : quotient(*old, change.value);
    }
  }
  return effects;
}

Expected<std::vector<ReportedEffect>> Instance::original_effects(const ActionCall& call) const {
  const Action& action = domain().actions[call.action];
  const Frame bound = frame(call);
  std::vector<ReportedEffect> effects;
  for (const Effect& effect : action.effects) {
    if (effect.is_numeric() && !action.durative)
      return input_error("'InstantaneousAction' object has no attribute 'function_effects'");
    ReportedEffect& out = effects.emplace_back(reported(domain(), effect));
    for (const Term& term : effect.terms) {
      const auto variable = std::ranges::find(effect.variables, term.index, &Variable::slot);
      if (term.is_variable && variable != effect.variables.end())
        out.arguments.push_back(variable->name.substr(1));
      else
        out.arguments.push_back(problem().objects[term.in(bound)].name);
    }
    if (!effect.is_numeric()) continue;
    const bool plain =
        effect.value.kind == Expression::Kind::kConstant || effect.value.kind == Expression::Kind::kFunction;
    const auto value = plain ? evaluator_->number(effect.value, bound, state_) : std::nullopt;
    if (!value || scales(effect) || effect.time == Effect::Time::kContinuous) return input_error("Unknown value type");
    out.number = *value;
  }
  // The original reports one time point after the other, that of the first effect first.
  const bool end_first = !effects.empty() && effects.front().at_end;
  std::ranges::stable_partition(effects, [&](const ReportedEffect& effect) { return effect.at_end == end_first; });
  return effects;
}

}  // namespace cxlab::planner
