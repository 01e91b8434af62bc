// Questions to the PDDL manager, and what they change.

#include <algorithm>
#include <functional>

#include "cx/base/file.h"
#include "cx/base/remedy.h"
#include "cx/bus/needed.h"
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
  for (const ObjectId object : objects) names.push_back(problem.objects[object].name);
  return names;
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
  if (!options_.original && known->second.instance->advance(cxlab::to_seconds(bus_.now() - known->second.loaded)))
    publish_update(name);
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

void PddlManager::publish_update(const std::string& instance) {
  auto message = std::make_shared<bus::Message>(*updates_.type);
  message->view().set("data", instance);
  bus_.publish(updates_.endpoint, std::move(message));
}

/// Answers one request. The error that a handler returns is the answer.
struct PddlManager::Services {
  using Names = Instance::Names;
  using Handler = Status (Services::*)(const View& request, const View& answer);
  struct Row {
    const char *name, *type;
    Handler handler;
    bool upstream, expertino;  ///< which packages have it
  };

  PddlManager& manager;
  bus::ParticipantId caller{};
  const bool original = manager.options_.original;
  bool silent = false;  ///< the request stays without an answer, as in the original

  /// The instance that a part of a request names, and the fluent, function or action.
  template <class Named>
  Expected<std::pair<Instance*, Named>> find(const View& part,
                                             Expected<Named> (Instance::*look_up)(const std::string&, const Names&)
                                                 const) {
    auto instance = manager.find_instance(part.text("pddl_instance"));
    if (!instance) return instance.error();
    auto named = ((*instance)->*look_up)(part.text("name"), strings(part, "args"));
    if (!named) return named.error();
    return std::pair(*instance, *std::move(named));
  }

  /// Notifies those who watch the instances that the parts of a request changed. The original answers with one space
  /// for each part.
  void notify(const std::vector<View>& parts, const View& a) {
    Names changed;
    for (const View& part : parts)
      if (std::ranges::find(changed, part.text("pddl_instance")) == changed.end())
        changed.push_back(part.text("pddl_instance"));
    for (const std::string& name : changed) manager.publish_update(name);
    if (original) a.set("error", std::string(parts.size(), ' '));
  }

  // --- Instances

  /// The text of a file, rendered where it is a template, and its name for messages.
  Expected<std::pair<std::string, std::string>> read(const std::string& directory, const std::string& file) {
    namespace fs = std::filesystem;
    fs::path folder = directory, name = file;
    if (manager.options_.resolve && folder.is_relative()) folder = manager.options_.resolve(directory);
    if (name.is_absolute()) {
      folder = name.parent_path();
      name = name.filename();
    }
    const templates::Loader below = templates::folder_loader(folder.string());
    const auto refused = [&](const fs::path& wanted) {
      return manager.options_.may_read && manager.bus_.is_environment(caller) && !manager.options_.may_read(wanted);
    };
    const templates::Loader loader = [&](const std::string& wanted) -> std::optional<std::string> {
      if (refused(folder / wanted)) return std::nullopt;
      auto text = below(wanted);
      if (text && manager.options_.on_read && manager.failure_)
        manager.failure_ = manager.options_.on_read("pddl/" + wanted, folder / wanted);
      return text;
    };
    if (refused(folder / name))
      return input_error("reading '" + (folder / name).string() +
                         "' is refused: for rules the manager reads packages (--package NAME=FOLDER), what rules "
                         "wrote, and files *.pddl "
                         "that lie beside the scenario or in a folder that a rule file names (" +
                         kTrustRemedy + ')');
    if (!is_file(folder / name)) return input_error("there is no such file", (folder / name).string());
    const auto source = below(name.string());
    auto text = templates::render(loader, name.string());
    if (text)
      return std::pair(*std::move(text), (folder / name).string() + (source && is_template(*source) ? kRendered : ""));
    Error error = text.error();
    if (!error.file.empty()) error.file = (folder / error.file).string();
    return error;
  }

  Expected<std::unique_ptr<Instance>> load(const View& q) {
    const std::string &directory = q.text("directory"), &domain_file = q.text("domain_file"),
                      &problem_file = q.text("problem_file");
    auto domain_text = read(directory, domain_file);
    if (!domain_text) return domain_text.error();
    auto domain = parse_domain(domain_text->first, domain_text->second);
    if (!domain) return domain.error();
    if (problem_file.empty() && original)
      return input_error("unsupported operand type(s) for -: 'method' and 'function'");
    auto problem_text =
        problem_file.empty()
            ? std::pair("(define (problem none) (:domain " + domain->name + ") (:init) (:goal (and)))", std::string())
            : read(directory, problem_file);
    if (!problem_text) return problem_text.error();
    auto problem = parse_problem(problem_text->first, problem_text->second, *domain);
    if (!problem) return problem.error();
    return std::make_unique<Instance>(Task{*std::move(domain), *std::move(problem)}, &manager.meter_);
  }

  Status add_pddl_instance(const View& q, const View&) {
    const std::string& name = q.text("name");
    if (name.empty()) return input_error("a pddl instance needs a name");
    auto instance = load(q);
    if (!instance) {
      manager.log(cx::LogLevel::kError, "pddl instance '" + name + "': " + instance.error().text());
      return instance.error();
    }
    if (const auto there = manager.instances_.find(name); there != manager.instances_.end()) {
      manager.log(cx::LogLevel::kWarn, "pddl instance '" + name + "' is there already and is replaced");
      if (there->second.owner != caller)
        manager.replaced_.push_back(manager.options_.node.full_name() +
                                    ": another client replaced the pddl instance '" + name +
                                    "', expected a manager for each agent");
    }
    manager.instances_[name] = {*std::move(instance), manager.bus_.now(), caller, {}};
    return {};
  }

  template <Status (*ask)(Instance&, const View& q, const View& a)>
  Status of_instance(const View& q, const View& a) {
    auto instance = manager.find_instance(q.text("pddl_instance"));
    return instance ? ask(**instance, q, a) : Status(instance.error());
  }

  static Status get_action_names(Instance& instance, const View&, const View& a) {
    for (const Action& action : instance.domain().actions) a.append_text("action_names", action.name);
    return {};
  }

  static Status get_fluents(Instance& instance, const View& q, const View& a) {
    for (const Fact& fact : instance.facts())
      put(a.append("fluents"), q.text("pddl_instance"), instance.domain().predicates[fact.predicate].name,
          names_of(instance.problem(), fact.objects));
    return {};
  }

  static Status get_functions(Instance& instance, const View& q, const View& a) {
    for (const Assignment& value : instance.values()) {
      const View out = a.append("functions");
      put(out, q.text("pddl_instance"), instance.domain().functions[value.function].name,
          names_of(instance.problem(), value.objects));
      out.set("value", value.value);
    }
    return {};
  }

  static Status get_predicates(Instance& instance, const View& q, const View& a) {
    const Domain& domain = instance.domain();
    for (const Predicate& predicate : domain.predicates) {
      const View out = a.append("predicates");
      out.set("pddl_instance", q.text("pddl_instance")).set("name", predicate.name);
      for (const Variable& parameter : predicate.parameters) {
        std::string type;
        for (const TypeId t : parameter.types) type += (type.empty() ? "" : "|") + domain.types[t].name;
        out.append_text("param_types", type);
        out.append_text("param_names", parameter.name.substr(1));
      }
    }
    return {};
  }

  static Status get_type_objects(Instance& instance, const View& q, const View& a) {
    auto type = instance.type(q.text("type"));
    if (!type) return type.error();
    put_strings(a, "objects", names_of(instance.problem(), objects_of(instance.domain(), instance.problem(), {*type})));
    return {};
  }

  static Status create_goal_instance(Instance& instance, const View& q, const View&) {
    return instance.create_goal(q.text("goal_instance"));
  }

  // --- Facts, numbers and objects

  /// All or nothing.
  Status set_fluents(const std::vector<View>& fluents, bool value, const View& a) {
    std::vector<std::pair<Instance*, Fact>> changes;
    for (const View& fluent : fluents) {
      auto found = find(fluent, &Instance::fact);
      if (!found) return found.error();
      const auto& [instance, fact] = *found;
      if (instance->domain().predicates[fact.predicate].derived) return instance->set(fact, value);
      changes.push_back(*std::move(found));
    }
    for (const auto& [instance, fact] : changes)
      if (Status s = instance->set(fact, value); !s) return s;
    notify(fluents, a);
    return {};
  }

  Status add_fluent(const View& q, const View& a) { return set_fluents({q.nested("fluent")}, true, a); }
  Status add_fluents(const View& q, const View& a) { return set_fluents(messages(q, "fluents"), true, a); }
  Status rm_fluents(const View& q, const View& a) { return set_fluents(messages(q, "fluents"), false, a); }

  /// All or nothing.
  Status set_functions(const View& q, const View& a) {
    const std::vector<View> functions = messages(q, "functions");
    std::vector<std::pair<Instance*, Fact>> changes;
    for (const View& function : functions) {
      auto found = find(function, &Instance::number);
      if (!found) return found.error();
      changes.push_back(*std::move(found));
    }
    for (std::size_t i = 0; i < changes.size(); ++i)
      changes[i].first->set_value(changes[i].second, functions[i].real("value"));
    notify(functions, a);
    return {};
  }

  /// All or nothing: `prepare` returns what changes in one instance, or an error.
  template <auto prepare, auto apply>
  Status change_objects(const View& q, const View& a) {
    const std::vector<View> parts = messages(q, "objects");
    std::vector<std::pair<Instance*, std::vector<ObjectName>>> all;
    for (const View& part : parts) {
      auto instance = manager.find_instance(part.text("pddl_instance"));
      if (!instance) return instance.error();
      auto known = std::ranges::find_if(all, [&](const auto& each) { return each.first == *instance; });
      if (known == all.end()) known = all.insert(all.end(), {*instance, {}});
      known->second.push_back({part.text("name"), part.text("type")});
    }
    std::vector<std::function<void()>> changes;
    for (const auto& [instance, objects] : all) {
      auto change = (instance->*prepare)(objects);
      if (!change) return change.error();
      changes.push_back([target = instance, made = *std::move(change)] { (target->*apply)(made); });
    }
    for (const auto& change : changes) change();
    notify(parts, a);
    return {};
  }

  // --- Goals and filters

  Status set_goals(const View& q, const View&) {
    struct New {
      GoalInstance* goal;
      Fact fact;
      std::optional<double> value;  ///< of a function
    };
    std::vector<New> all;
    const auto add = [&](const View& part, bool numeric) -> Status {
      auto goal = manager.find_goal(part.text("pddl_instance"), q.text("goal_instance"));
      if (!goal) return goal.error();
      auto found = find(part, numeric ? &Instance::number : &Instance::fact);
      if (!found) return found.error();
      if (original && numeric && part.real("value") == 0) return input_error("a goal of type real is no boolean goal");
      all.push_back({goal->second, std::move(found->second), std::nullopt});
      if (numeric) all.back().value = part.real("value");
      return {};
    };
    Status done;
    for (const bool numeric : {false, true})
      for (const View& part : messages(q, numeric ? "functions" : "fluents"))
        if (done) done = add(part, numeric);
    if (!done && !original) return done;  // the original keeps what came before the error
    for (New& n : all) {
      if (n.value)
        n.goal->values.push_back({n.fact.predicate, std::move(n.fact.objects), *n.value});
      else
        n.goal->facts.push_back(std::move(n.fact));
    }
    return done;
  }

  Status clear_goals(const View& q, const View&) {
    auto goal = manager.find_goal(q.text("pddl_instance"), q.text("goal_instance"));
    silent = original && !goal;
    if (!goal) return goal.error();
    goal->second->facts.clear();
    goal->second->values.clear();
    return {};
  }

  /// The original accepts any names.
  Status set_filter(const View& q, const char* field, Names GoalInstance::* filter) {
    auto goal = manager.find_goal(q.text("pddl_instance"), q.text("goal_instance"));
    if (!goal) return goal.error();
    const auto& [instance, wanted] = *goal;
    auto names = original ? strings(q, field) : instance->known_names(filter, strings(q, field));
    if (!names) return names.error();
    wanted->*filter = *std::move(names);
    return {};
  }

  Status set_action_filter(const View& q, const View&) { return set_filter(q, "actions", &GoalInstance::actions); }
  Status set_fluent_filter(const View& q, const View&) { return set_filter(q, "fluents", &GoalInstance::fluents); }
  Status set_object_filter(const View& q, const View&) { return set_filter(q, "objects", &GoalInstance::objects); }

  // --- Actions

  Status check(const View& action, Instance::When when, const View& a) {
    auto found = find(action, &Instance::step);
    if (!found) return found.error();
    const auto& [instance, call] = *found;
    const Names missing = instance->unsatisfied(call, when);
    if (missing.empty() && !manager.meter_.over() &&
        (when == Instance::When::kStart || when == Instance::When::kAtStart))
      instance->remember_start(call);
    a.set("sat", missing.empty());
    put_strings(a, "unsatisfied_conditions", missing);
    return {};
  }

  Status check_action_condition(const View& q, const View& a) {
    return check(q.nested("action"), original ? Instance::When::kAtStart : Instance::When::kStart, a);
  }

  Status check_action_condition_at(const View& q, const View& a) {
    const std::string& point = q.text("time_point");
    if (point == "START") return check(q.nested("action"), Instance::When::kAtStart, a);
    if (point == "OVER-ALL") return check(q.nested("action"), Instance::When::kOverAll, a);
    if (point == "END") return check(q.nested("action"), Instance::When::kEnd, a);
    return input_error("time_point: " + found_text(point, "START, OVER-ALL or END"));
  }

  Status get_action_effects(const View& q, const View& a) {
    const View action = q.nested("action");
    auto found = find(action, &Instance::step);
    if (!found) return found.error();
    const auto& [instance, call] = *found;
    auto effects = original ? instance->original_effects(call) : instance->effects(call);
    if (!effects) return effects.error();
    if (const bus::Field* echo = a.type().find("action")) a.nested(*echo).copy_from(action);
    for (const ReportedEffect& effect : *effects) {
      const View out = a.append(effect.numeric ? "function_effects" : "fluent_effects");
      const View changed = out.nested(effect.numeric ? "function" : "fluent");
      put(changed, action.text("pddl_instance"), effect.name, effect.arguments);
      out.set("time_point", effect.at_end ? "END" : "START");
      if (effect.numeric) {
        changed.set("value", effect.number);
        out.set("operator_type", std::string(1, effect.operation)).set("value", effect.number);
      } else {
        out.set("value", effect.value);
      }
    }
    return {};
  }
};

Status PddlManager::serve_questions() {
  using S = Services;
  static constexpr S::Row kRows[] = {
      {"add_pddl_instance", "AddPddlInstance", &S::add_pddl_instance, true, true},
      {"get_action_names", "GetActionNames", &S::of_instance<S::get_action_names>, true, true},
      {"get_fluents", "GetFluents", &S::of_instance<S::get_fluents>, true, true},
      {"get_functions", "GetFunctions", &S::of_instance<S::get_functions>, true, true},
      {"get_predicates", "GetPredicates", &S::of_instance<S::get_predicates>, true, false},
      {"get_type_objects", "GetTypeObjects", &S::of_instance<S::get_type_objects>, true, false},
      {"add_fluent", "AddFluent", &S::add_fluent, true, true},
      {"add_fluents", "AddFluents", &S::add_fluents, true, true},
      {"rm_fluents", "RemoveFluents", &S::rm_fluents, true, true},
      {"set_functions", "SetFunctions", &S::set_functions, true, true},
      {"add_objects", "AddObjects", &S::change_objects<&Instance::new_objects, &Instance::add_objects>, true, true},
      {"rm_objects", "RemoveObjects", &S::change_objects<&Instance::others_than, &Instance::keep_objects>, true, true},
      {"set_goals", "SetGoals", &S::set_goals, true, true},
      {"clear_goals", "ClearGoals", &S::clear_goals, true, true},
      {"create_goal_instance", "CreateGoalInstance", &S::of_instance<S::create_goal_instance>, true, true},
      {"set_action_filter", "SetActionFilter", &S::set_action_filter, true, true},
      {"set_fluent_filter", "SetFluentFilter", &S::set_fluent_filter, true, true},
      {"set_object_filter", "SetObjectFilter", &S::set_object_filter, true, true},
      {"check_action_condition", "CheckActionCondition", &S::check_action_condition, true, false},
      {"check_action_precondition", "CheckActionPrecondition", &S::check_action_condition, false, true},
      {"get_action_effects", "GetActionEffects", &S::get_action_effects, true, true},
      {"check_action_condition_at", "CheckActionConditionAt", &S::check_action_condition_at, false, false},
  };
  const auto serve = [this](const std::string& package, const S::Row& row) -> Status {
    auto found = bus_.registry().service(package + "/srv/" + row.type);
    if (!found) return found.error();
    const std::string name = std::string("~/") + row.name;
    if (!bus::can_offer(bus_.registry(), "service " + bus_.name_of(node_).expand(name), (*found)->name)) return {};
    bus_.allow_types(node_, name);
    const auto endpoint = std::make_shared<bus::EndpointId>();
    auto made = bus_.serve(node_, name, **found,
                           [this, type = *found, endpoint, handler = row.handler](const bus::Delivery& d) {
                             auto response = std::make_shared<bus::Message>(*type->response);
                             S services{*this, d.from};
                             Status done = (services.*handler)(d.message->view(), response->view());
                             if (services.silent) return;
                             if (meter_.over()) {
                               done = resource_error(
                                   "the questions of this tick try too many combinations of objects: write conditions "
                                   "and effects with fewer variables in one quantifier");
                               response = std::make_shared<bus::Message>(*type->response);
                               log(cx::LogLevel::kWarn, done.error().message);
                             }
                             response->view().set("success", done.ok());
                             if (!done) response->view().set("error", done.error().text());
                             bus_.respond(*endpoint, d, std::move(response));
                           });
    if (!made) return made.error();
    *endpoint = *made;
    endpoints_.push_back(*made);
    return {};
  };
  for (const S::Row& row : kRows) {
    Status done;
    if (row.upstream) done = serve(kUpstream, row);
    if (done && row.expertino) done = serve(kExpertino, row);
    if (!row.upstream && !row.expertino) done = serve("cxlab_pddl_interfaces", row);
    if (!done) return done;
  }
  return {};
}

}  // namespace cxlab::planner
