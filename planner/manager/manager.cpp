#include "planner/manager/manager.h"

#include <algorithm>

#include "cx/node/parameter_services.h"

namespace cxlab::planner {

namespace {

/// The types of one package for the same services.
constexpr const char* kUpstream = "cx_pddl_interfaces";
constexpr const char* kExpertino = "expertino_msgs";
constexpr const char* kOwn = "cxlab_pddl_interfaces";

}  // namespace

struct PddlManager::ServiceRow {
  const char *name, *type;
  Handler handler;
  bool upstream, expertino;  ///< which packages have it
};

PddlManager::PddlManager(PddlManagerOptions options, bus::Bus& bus, RecordSink& sink)
    : options_(std::move(options)),
      bus_(bus),
      sink_(sink),
      node_(bus_.join(bus::ParticipantKind::kNode, {options_.node, options_.name_space, options_.remaps},
                      sink_.open_stream("node" + bus::NodeName{options_.node, options_.name_space, {}}.full_name()))),
      lifecycle_(
          bus_, node_, [this](cx::Transition t) { return act_on(t); },
          [this](const Error& why) { log(cx::LogLevel::kWarn, why.message); }) {}

PddlManager::~PddlManager() {
  bond_.reset();
  bus_.leave(node_);
}

Expected<std::unique_ptr<PddlManager>> PddlManager::create(PddlManagerOptions options, bus::Bus& bus,
                                                           RecordSink& sink) {
  bus::NodeName name{options.node, options.name_space, options.remaps};
  bus::rename_node(name);
  options.node = name.name;
  options.name_space = name.name_space;
  options.remaps = name.remaps;
  std::unique_ptr<PddlManager> manager(new PddlManager(std::move(options), bus, sink));
  const PddlManagerOptions& o = manager->options_;
  const std::pair<const char*, std::string> parameters[] = {{"autostart_node", o.autostart ? "true" : "false"},
                                                            {"bond_heartbeat_period", std::to_string(o.bond_period)},
                                                            {"compat", o.original ? "original" : "none"},
                                                            {"anytime", o.anytime ? "true" : "false"},
                                                            {"warm_start", o.warm_start ? "true" : "false"}};
  for (const auto& [parameter, value] : parameters)
    if (Status s = manager->parameters_.set(parameter, value, {"pddl_manager"}); !s) return s.error();
  const auto fixed = [](const std::string& changed, const cx::Parameter&) {
    return Status(usage_error("parameter '" + changed + "' is set where the node is named"));
  };
  if (Status s = cx::serve_parameters(bus, manager->node_, manager->parameters_, fixed); !s) return s.error();
  if (Status s = manager->lifecycle_.serve(); !s) return s.error();
  if (!o.autostart) return manager;
  if (Status s = manager->change(cx::Transition::kConfigure); !s) return s.error();
  if (Status s = manager->change(cx::Transition::kActivate); !s) return s.error();
  return manager;
}

// --- Life

Status PddlManager::act_on(cx::Transition transition) {
  const bool active = state() == cx::LifeState::kActive;
  switch (transition) {
    case cx::Transition::kConfigure: return configure();
    case cx::Transition::kActivate: return form_bond();
    case cx::Transition::kDeactivate:
    case cx::Transition::kShutdown:
      if (active) {
        stop_jobs("the node was deactivated");
        if (bond_) bond_->end();
        bond_.reset();
      }
      if (transition == cx::Transition::kShutdown) clean_up();
      return {};
    case cx::Transition::kCleanup: clean_up(); return {};
  }
  return {};
}

Status PddlManager::configure() {
  const auto advertise = [&](const char* topic, const char* name,
                             const bus::MessageType*& type) -> Expected<bus::EndpointId> {
    auto found = bus_.registry().message(name);
    if (!found) return found.error();
    type = *found;
    auto made = bus_.advertise(node_, topic, *type);
    if (made) endpoints_.push_back(*made);
    return made;
  };
  auto updates = advertise("~/instance_update", "std_msgs/msg/String", update_type_);
  if (!updates) return updates.error();
  updates_ = *updates;
  auto reports = advertise("~/plan_report", "cxlab_pddl_interfaces/msg/PlanReport", report_type_);
  if (!reports) return reports.error();
  reports_ = *reports;

  using M = PddlManager;
  static constexpr ServiceRow kServices[] = {
      {"add_pddl_instance", "AddPddlInstance", &M::add_pddl_instance, true, true},
      {"get_action_names", "GetActionNames", &M::get_action_names, true, true},
      {"get_fluents", "GetFluents", &M::get_fluents, true, true},
      {"get_functions", "GetFunctions", &M::get_functions, true, true},
      {"get_predicates", "GetPredicates", &M::get_predicates, true, false},
      {"get_type_objects", "GetTypeObjects", &M::get_type_objects, true, false},
      {"add_fluent", "AddFluent", &M::add_fluent, true, true},
      {"add_fluents", "AddFluents", &M::add_fluents, true, true},
      {"rm_fluents", "RemoveFluents", &M::rm_fluents, true, true},
      {"set_functions", "SetFunctions", &M::set_functions, true, true},
      {"add_objects", "AddObjects", &M::add_objects, true, true},
      {"rm_objects", "RemoveObjects", &M::rm_objects, true, true},
      {"set_goals", "SetGoals", &M::set_goals, true, true},
      {"clear_goals", "ClearGoals", &M::clear_goals, true, true},
      {"create_goal_instance", "CreateGoalInstance", &M::create_goal_instance, true, true},
      {"set_action_filter", "SetActionFilter", &M::set_action_filter, true, true},
      {"set_fluent_filter", "SetFluentFilter", &M::set_fluent_filter, true, true},
      {"set_object_filter", "SetObjectFilter", &M::set_object_filter, true, true},
      {"check_action_condition", "CheckActionCondition", &M::check_action_condition, true, false},
      {"check_action_precondition", "CheckActionPrecondition", &M::check_action_condition, false, true},
      {"get_action_effects", "GetActionEffects", &M::get_action_effects, true, true},
  };
  for (const ServiceRow& row : kServices) {
    if (row.upstream)
      if (Status s = serve(kUpstream, row); !s) return s;
    if (row.expertino)
      if (Status s = serve(kExpertino, row); !s) return s;
  }
  if (Status s = serve(
          kOwn, {"check_action_condition_at", "CheckActionConditionAt", &M::check_action_condition_at, false, false});
      !s)
    return s;

  bus_.allow_types(node_, "~/temp_plan");
  dialects_ = {{kUpstream}, {kExpertino}};
  for (std::size_t i = 0; i < dialects_.size(); ++i) {
    auto type = bus_.registry().action(dialects_[i].package + "/action/PlanTemporal");
    if (!type) return type.error();
    dialects_[i].plan_type = *type;
    auto made = bus_.serve_action(node_, "~/temp_plan", **type,
                                  {[this, i](const bus::Delivery& goal) { on_goal(i, goal); },
                                   [this, i](const bus::Delivery& cancel) { on_cancel(i, cancel); }});
    if (!made) return made.error();
    dialects_[i].plan = *made;
    endpoints_.push_back(*made);
  }
  return {};
}

Status PddlManager::serve(const std::string& package, const ServiceRow& row) {
  auto found = bus_.registry().service(package + "/srv/" + row.type);
  if (!found) return found.error();
  const bus::ServiceType* type = *found;
  const std::string name = std::string("~/") + row.name;
  bus_.allow_types(node_, name);
  const auto endpoint = std::make_shared<bus::EndpointId>();
  auto made = bus_.serve(node_, name, *type, [this, type, endpoint, handler = row.handler](const bus::Delivery& d) {
    auto response = std::make_shared<bus::Message>(*type->response);
    answer_ = true;
    const Status done = (this->*handler)(d.message->view(), response->view());
    if (!answer_) return;
    response->view().set("success", done.ok());
    if (!done) response->view().set("error", done.error().text());
    bus_.respond(*endpoint, d, std::move(response));
  });
  if (!made) return made.error();
  *endpoint = *made;
  endpoints_.push_back(*made);
  return {};
}

void PddlManager::clean_up() {
  for (const bus::EndpointId endpoint : endpoints_) bus_.remove(endpoint);
  endpoints_.clear();
  dialects_.clear();
  instances_.clear();
}

Status PddlManager::form_bond() {
  if (options_.bond_period <= 0) return {};
  cx::Bond::Options options;
  options.id = options_.node;
  options.instance = bus_.name_of(node_).full_name();
  options.period = from_seconds(options_.bond_period);
  options.connect_timeout = kNever;  // nobody has to watch it
  auto bond = cx::Bond::create(bus_, node_, std::move(options), [this](cx::Bond::Loss loss) {
    log(cx::LogLevel::kWarn, "the peer of its bond " + std::string(cx::to_string(loss)));
  });
  if (!bond) return bond.error();
  bond_ = *std::move(bond);
  return {};
}

// --- A tick

SimTime PddlManager::next_due() const {
  SimTime first = bond_ ? bond_->next_due() : kNever;
  for (const Job& job : jobs_) first = std::min(first, job.due);
  return first;
}

Status PddlManager::answer_due(SimTime now) {
  std::vector<Job> due;
  for (const Job& job : jobs_)
    if (job.due <= now) due.push_back(job);
  std::erase_if(jobs_, [&](const Job& job) { return job.due <= now; });
  std::stable_sort(due.begin(), due.end(), [](const Job& a, const Job& b) { return a.due < b.due; });
  for (const Job& job : due) finish(job);
  return {};
}

Status PddlManager::act() {
  bus_.deliver(node_);
  if (bond_) bond_->act();
  return std::exchange(failure_, Status());
}

void PddlManager::log(cx::LogLevel level, const std::string& text) {
  if (options_.log) options_.log->line({bus_.now(), level, options_.node, text, {}});
}

}  // namespace cxlab::planner
