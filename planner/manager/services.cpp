// Questions to the PDDL manager, and what they change.

#include <algorithm>

#include "cx/template/template.h"
#include "planner/manager/manager.h"
#include "planner/pddl/parser.h"

namespace cxlab::planner {

namespace {

using View = bus::MessageView;

std::vector<std::string> strings(const View& message, std::string_view field) {
  const bus::Field& f = *message.type().find(field);
  std::vector<std::string> out(message.size(f));
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = message.text(f, i);
  return out;
}

std::vector<View> messages(const View& message, std::string_view field) {
  const bus::Field& f = *message.type().find(field);
  std::vector<View> out(message.size(f));
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = message.nested(f, i);
  return out;
}

void put_strings(const View& message, std::string_view field, const std::vector<std::string>& texts) {
  for (const std::string& text : texts) message.append_text(field, text);
}

/// `fluent` or `function` of a message.
void put(const View& out, const std::string& instance, const std::string& name,
         const std::vector<std::string>& arguments) {
  out.set("pddl_instance", instance).set("name", name);
  put_strings(out, "args", arguments);
}

std::vector<std::string> names_of(const Problem& problem, const std::vector<ObjectId>& objects) {
  std::vector<std::string> names;
  for (const ObjectId object : objects) names.push_back(problem.objects[static_cast<std::size_t>(object)].name);
  return names;
}

/// The original answers with one space for each element that it took.
void put_spaces(const View& a, bool original, std::size_t count) {
  if (original) a.set("error", std::string(count, ' '));
}

void add_once(std::vector<std::string>& names, const std::string& name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

}  // namespace

Expected<Instance*> PddlManager::find_instance(const std::string& name) {
  const auto known = instances_.find(name);
  if (known == instances_.end()) {
    std::vector<std::string> names;
    for (const auto& [other, _] : instances_) names.push_back(other);
    if (names.empty())
      return input_error("unknown pddl instance '" + name +
                         "': none is loaded, add it with the service add_pddl_instance");
    return unknown_name("pddl instance", name, names);
  }
  if (!options_.original && known->second.instance->advance(to_seconds(bus_.now() - known->second.loaded)))
    tell_update(name);
  return known->second.instance.get();
}

Expected<std::pair<Instance*, GoalInstance*>> PddlManager::find_goal(const std::string& instance,
                                                                     const std::string& goal) {
  auto found = find_instance(instance);
  if (!found) return found.error();
  GoalInstance* there = (*found)->goal(goal);
  if (!there)
    return input_error("pddl instance '" + instance + "' has no goal instance '" + goal +
                       "': create it first with the service create_goal_instance");
  return std::pair(*found, there);
}

void PddlManager::tell_update(const std::string& instance) {
  auto message = std::make_shared<bus::Message>(*update_type_);
  message->view().set("data", instance);
  bus_.publish(updates_, std::move(message));
}

// --- Instances

Expected<std::string> PddlManager::read(const std::string& directory, const std::string& file) {
  namespace fs = std::filesystem;
  fs::path folder = directory, name = file;
  if (options_.resolve && folder.is_relative()) folder = options_.resolve(directory);
  if (name.is_absolute()) {
    folder = name.parent_path();
    name = name.filename();
  }
  const templates::Loader below = templates::folder_loader(folder.string());
  const templates::Loader loader = [&](const std::string& wanted) -> std::optional<std::string> {
    auto text = below(wanted);
    if (text && options_.on_read && failure_) failure_ = options_.on_read("pddl/" + wanted, folder / wanted);
    return text;
  };
  if (!fs::is_regular_file(folder / name)) return input_error("there is no such file", (folder / name).string());
  auto text = templates::render(loader, name.string());
  if (text) return text;
  Error error = text.error();
  if (!error.file.empty()) error.file = (folder / error.file).string();
  return error;
}

Expected<std::unique_ptr<Instance>> PddlManager::load(const View& q) {
  const std::string &directory = q.text("directory"), &domain_file = q.text("domain_file"),
                    &problem_file = q.text("problem_file");
  auto domain_text = read(directory, domain_file);
  if (!domain_text) return domain_text.error();
  auto domain = parse_domain(*domain_text, domain_file);
  if (!domain) return domain.error();
  if (problem_file.empty() && options_.original)
    return input_error("unsupported operand type(s) for -: 'method' and 'function'");
  std::string problem_text = "(define (problem none) (:domain " + domain->name + ") (:init) (:goal (and)))";
  if (!problem_file.empty()) {
    auto text = read(directory, problem_file);
    if (!text) return text.error();
    problem_text = *std::move(text);
  }
  auto problem = parse_problem(problem_text, problem_file, *domain);
  if (!problem) return problem.error();
  return std::make_unique<Instance>(Task{*std::move(domain), *std::move(problem)});
}

Status PddlManager::add_pddl_instance(const View& q, const View&) {
  const std::string& name = q.text("name");
  if (name.empty()) return input_error("a pddl instance needs a name");
  auto instance = load(q);
  if (!instance) {
    log(cx::LogLevel::kError, "pddl instance '" + name + "': " + instance.error().text());
    return instance.error();
  }
  if (instances_.contains(name))
    log(cx::LogLevel::kWarn, "pddl instance '" + name + "' is there already and is replaced");
  instances_[name] = {*std::move(instance), bus_.now(), {}};
  return {};
}

Status PddlManager::get_action_names(const View& q, const View& a) {
  auto instance = find_instance(q.text("pddl_instance"));
  if (!instance) return instance.error();
  for (const Action& action : (*instance)->domain().actions) a.append_text("action_names", action.name);
  return {};
}

Status PddlManager::get_fluents(const View& q, const View& a) {
  const std::string& name = q.text("pddl_instance");
  auto instance = find_instance(name);
  if (!instance) return instance.error();
  for (const Fact& fact : (*instance)->facts())
    put(a.append("fluents"), name, (*instance)->domain().predicates[static_cast<std::size_t>(fact.predicate)].name,
        names_of((*instance)->problem(), fact.objects));
  return {};
}

Status PddlManager::get_functions(const View& q, const View& a) {
  const std::string& name = q.text("pddl_instance");
  auto instance = find_instance(name);
  if (!instance) return instance.error();
  for (const Assignment& value : (*instance)->values()) {
    const View out = a.append("functions");
    put(out, name, (*instance)->domain().functions[static_cast<std::size_t>(value.function)].name,
        names_of((*instance)->problem(), value.objects));
    out.set("value", value.value);
  }
  return {};
}

Status PddlManager::get_predicates(const View& q, const View& a) {
  const std::string& name = q.text("pddl_instance");
  auto instance = find_instance(name);
  if (!instance) return instance.error();
  const Domain& domain = (*instance)->domain();
  for (const Predicate& predicate : domain.predicates) {
    const View out = a.append("predicates");
    out.set("pddl_instance", name).set("name", predicate.name);
    for (const Variable& parameter : predicate.parameters) {
      std::string type;
      for (const TypeId t : parameter.types)
        type += (type.empty() ? "" : "|") + domain.types[static_cast<std::size_t>(t)].name;
      out.append_text("param_types", type);
      out.append_text("param_names", parameter.name.substr(1));
    }
  }
  return {};
}

Status PddlManager::get_type_objects(const View& q, const View& a) {
  auto instance = find_instance(q.text("pddl_instance"));
  if (!instance) return instance.error();
  auto type = (*instance)->type(q.text("type"));
  if (!type) return type.error();
  put_strings(a, "objects", (*instance)->objects_of_type(*type));
  return {};
}

// --- What is so

/// All or nothing.
Status PddlManager::set_fluents(const std::vector<View>& fluents, bool value, const View& a) {
  std::vector<std::pair<Instance*, Fact>> changes;
  std::vector<std::string> changed;
  for (const View& fluent : fluents) {
    auto instance = find_instance(fluent.text("pddl_instance"));
    if (!instance) return instance.error();
    auto fact = (*instance)->fact(fluent.text("name"), strings(fluent, "args"));
    if (!fact) return fact.error();
    if ((*instance)->domain().predicates[static_cast<std::size_t>(fact->predicate)].derived)
      return (*instance)->set(*fact, value);
    changes.emplace_back(*instance, *std::move(fact));
    add_once(changed, fluent.text("pddl_instance"));
  }
  for (const auto& [instance, fact] : changes)
    if (Status s = instance->set(fact, value); !s) return s;
  for (const std::string& name : changed) tell_update(name);
  put_spaces(a, options_.original, fluents.size());
  return {};
}

Status PddlManager::add_fluent(const View& q, const View& a) { return set_fluents({q.nested("fluent")}, true, a); }
Status PddlManager::add_fluents(const View& q, const View& a) { return set_fluents(messages(q, "fluents"), true, a); }
Status PddlManager::rm_fluents(const View& q, const View& a) { return set_fluents(messages(q, "fluents"), false, a); }

Status PddlManager::set_functions(const View& q, const View& a) {
  std::vector<std::pair<Instance*, Assignment>> changes;
  std::vector<std::string> changed;
  for (const View& function : messages(q, "functions")) {
    auto instance = find_instance(function.text("pddl_instance"));
    if (!instance) return instance.error();
    auto number = (*instance)->number(function.text("name"), strings(function, "args"));
    if (!number) return number.error();
    changes.push_back({*instance, {number->predicate, std::move(number->objects), function.real("value")}});
    add_once(changed, function.text("pddl_instance"));
  }
  for (const auto& [instance, value] : changes) instance->set_value({value.function, value.objects}, value.value);
  for (const std::string& name : changed) tell_update(name);
  put_spaces(a, options_.original, changes.size());
  return {};
}

/// The objects of a request, by instance.
struct PddlManager::ObjectsOf {
  std::string name;
  Instance* instance;
  std::vector<ObjectName> objects;
};

Expected<std::vector<PddlManager::ObjectsOf>> PddlManager::objects_by_instance(const View& q) {
  std::vector<ObjectsOf> all;
  for (const View& object : messages(q, "objects")) {
    const std::string& name = object.text("pddl_instance");
    auto instance = find_instance(name);
    if (!instance) return instance.error();
    auto known = std::find_if(all.begin(), all.end(), [&](const ObjectsOf& o) { return o.instance == *instance; });
    if (known == all.end()) known = all.insert(all.end(), {name, *instance, {}});
    known->objects.push_back({object.text("name"), object.text("type")});
  }
  return all;
}

/// All or nothing.
Status PddlManager::add_objects(const View& q, const View& a) {
  auto all = objects_by_instance(q);
  if (!all) return all.error();
  std::vector<std::vector<Object>> made;
  for (const ObjectsOf& of : *all) {
    auto objects = of.instance->new_objects(of.objects);
    if (!objects) return objects.error();
    made.push_back(*std::move(objects));
  }
  for (std::size_t i = 0; i < made.size(); ++i) (*all)[i].instance->add_objects(std::move(made[i]));
  for (const ObjectsOf& of : *all) tell_update(of.name);
  put_spaces(a, options_.original, messages(q, "objects").size());
  return {};
}

/// All or nothing.
Status PddlManager::rm_objects(const View& q, const View& a) {
  auto all = objects_by_instance(q);
  if (!all) return all.error();
  std::vector<std::vector<char>> stay;
  for (const ObjectsOf& of : *all) {
    auto keep = of.instance->others_than(of.objects);
    if (!keep) return keep.error();
    stay.push_back(*std::move(keep));
  }
  for (std::size_t i = 0; i < stay.size(); ++i) (*all)[i].instance->keep_objects(stay[i]);
  for (const ObjectsOf& of : *all) tell_update(of.name);
  put_spaces(a, options_.original, messages(q, "objects").size());
  return {};
}

// --- Goals and filters

Status PddlManager::set_goals(const View& q, const View&) {
  struct New {
    GoalInstance* goal;
    std::optional<Fact> fact;
    Assignment value;
  };
  std::vector<New> all;
  const auto goal_of = [&](const View& part) { return find_goal(part.text("pddl_instance"), q.text("goal_instance")); };
  const auto collect = [&]() -> Status {
    for (const View& fluent : messages(q, "fluents")) {
      auto goal = goal_of(fluent);
      if (!goal) return goal.error();
      auto fact = goal->first->fact(fluent.text("name"), strings(fluent, "args"));
      if (!fact) return fact.error();
      all.push_back({goal->second, *std::move(fact), {}});
    }
    for (const View& function : messages(q, "functions")) {
      auto goal = goal_of(function);
      if (!goal) return goal.error();
      auto number = goal->first->number(function.text("name"), strings(function, "args"));
      if (!number) return number.error();
      const double value = function.real("value");
      if (options_.original && value == 0) return input_error("a goal of type real is no boolean goal");
      all.push_back({goal->second, std::nullopt, {number->predicate, std::move(number->objects), value}});
    }
    return {};
  };
  const Status done = collect();
  if (!done && !options_.original) return done;  // the original keeps what came before the error
  for (New& n : all) {
    if (n.fact)
      n.goal->facts.push_back(*std::move(n.fact));
    else
      n.goal->values.push_back(std::move(n.value));
  }
  return done;
}

Status PddlManager::clear_goals(const View& q, const View&) {
  auto goal = find_goal(q.text("pddl_instance"), q.text("goal_instance"));
  if (!goal) {
    answer_ = !options_.original;
    return goal.error();
  }
  goal->second->facts.clear();
  goal->second->values.clear();
  return {};
}

Status PddlManager::create_goal_instance(const View& q, const View&) {
  auto instance = find_instance(q.text("pddl_instance"));
  if (!instance) return instance.error();
  return (*instance)->create_goal(q.text("goal_instance"));
}

/// The original takes any names.
Status PddlManager::set_filter(const View& q, const char* field, Names GoalInstance::* filter,
                               Status (Instance::*set)(GoalInstance&, const Names&) const) {
  auto goal = find_goal(q.text("pddl_instance"), q.text("goal_instance"));
  if (!goal) return goal.error();
  const auto& [instance, wanted] = *goal;
  if (!options_.original) return (instance->*set)(*wanted, strings(q, field));
  wanted->*filter = strings(q, field);
  return {};
}

Status PddlManager::set_action_filter(const View& q, const View&) {
  return set_filter(q, "actions", &GoalInstance::actions, &Instance::set_actions);
}
Status PddlManager::set_fluent_filter(const View& q, const View&) {
  return set_filter(q, "fluents", &GoalInstance::fluents, &Instance::set_fluents);
}
Status PddlManager::set_object_filter(const View& q, const View&) {
  return set_filter(q, "objects", &GoalInstance::objects, &Instance::set_objects);
}

// --- Actions

Status PddlManager::check(const View& action, Instance::When when, const View& a) {
  auto instance = find_instance(action.text("pddl_instance"));
  if (!instance) return instance.error();
  auto call = (*instance)->step(action.text("name"), strings(action, "args"));
  if (!call) return call.error();
  const std::vector<std::string> missing = (*instance)->unsatisfied(*call, when);
  if (missing.empty() && (when == Instance::When::kStart || when == Instance::When::kAtStart))
    (*instance)->remember_start(*call);
  a.set("sat", missing.empty());
  put_strings(a, "unsatisfied_conditions", missing);
  return {};
}

Status PddlManager::check_action_condition(const View& q, const View& a) {
  return check(q.nested("action"), options_.original ? Instance::When::kAtStart : Instance::When::kStart, a);
}

Status PddlManager::check_action_condition_at(const View& q, const View& a) {
  const std::string& point = q.text("time_point");
  if (point == "START") return check(q.nested("action"), Instance::When::kAtStart, a);
  if (point == "OVER-ALL") return check(q.nested("action"), Instance::When::kOverAll, a);
  if (point == "END") return check(q.nested("action"), Instance::When::kEnd, a);
  return input_error("time_point: found '" + point + "', expected START, OVER-ALL or END");
}

Status PddlManager::get_action_effects(const View& q, const View& a) {
  const View action = q.nested("action");
  const std::string& name = action.text("pddl_instance");
  auto instance = find_instance(name);
  if (!instance) return instance.error();
  auto call = (*instance)->step(action.text("name"), strings(action, "args"));
  if (!call) return call.error();
  auto effects = options_.original ? (*instance)->original_effects(*call) : (*instance)->effects(*call);
  if (!effects) return effects.error();
  if (const bus::Field* echo = a.type().find("action")) a.nested(*echo).copy_from(action);
  for (const ReportedEffect& effect : *effects) {
    const View out = a.append(effect.numeric ? "function_effects" : "fluent_effects");
    out.set("time_point", effect.at_end ? "END" : "START");
    if (effect.numeric) {
      const View function = out.nested("function");
      put(function, name, effect.name, effect.arguments);
      function.set("value", effect.number);
      out.set("operator_type", std::string(1, effect.operation)).set("value", effect.number);
    } else {
      put(out.nested("fluent"), name, effect.name, effect.arguments);
      out.set("value", effect.value);
    }
  }
  return {};
}

}  // namespace cxlab::planner
