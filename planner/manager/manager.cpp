#include "planner/manager/manager.h"

#include <algorithm>

#include "cx/bus/needed.h"
#include "cx/node/parameter_services.h"

namespace cxlab::planner {

namespace {

/// Combinations of objects that all questions of a tick may try: about two seconds of one core.
constexpr std::int64_t kMostCombinations = 20'000'000;

}  // namespace

PddlManager::PddlManager(PddlManagerOptions options, bus::Bus& bus, RecordSink& sink)
    : options_(std::move(options)),
      bus_(bus),
      sink_(sink),
      node_(
          bus_.join(bus::ParticipantKind::kNode, options_.node, sink_.open_stream("node" + options_.node.full_name()))),
      lifecycle_(
          bus_, node_, [this](cx::Transition t) { return act_on(t); },
          [this](const Error& why) { log(cx::LogLevel::kWarn, why.message); }),
      meter_(kMostCombinations) {}

PddlManager::~PddlManager() {
  bond_.reset();
  bus_.leave(node_);
}

Expected<std::unique_ptr<PddlManager>> PddlManager::create(PddlManagerOptions options, bus::Bus& bus,
                                                           RecordSink& sink) {
  bus::rename_node(options.node);
  std::unique_ptr<PddlManager> manager(new PddlManager(std::move(options), bus, sink));
  const PddlManagerOptions& o = manager->options_;
  if (!o.other.command.empty()) {
    auto other = PlannerServant::start(o.other);
    if (!other) return other.error();
    manager->other_ = *std::move(other);
  }
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
  if (auto served = cx::serve_parameters(bus, manager->node_, manager->parameters_, fixed); !served)
    return served.error();
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
  const auto advertise = [&](Topic& topic, const char* name, const char* type) -> Status {
    auto found = bus::needed_message(bus_.registry(), type);
    if (!found) return found.error();
    auto made = bus_.advertise(node_, name, **found);
    if (!made) return made.error();
    endpoints_.push_back(*made);
    topic = {*made, *found};
    return {};
  };
  if (Status s = advertise(updates_, "~/instance_update", "std_msgs/msg/String"); !s) return s;
  if (Status s = advertise(reports_, "~/plan_report", "cxlab_pddl_interfaces/msg/PlanReport"); !s) return s;
  if (Status s = serve_questions(); !s) return s;
  bus_.allow_types(node_, "~/temp_plan");
  dialects_ = {{kUpstream}, {kExpertino}};
  for (std::size_t i = 0; i < dialects_.size(); ++i) {
    auto type = bus_.registry().action(dialects_[i].package + "/action/PlanTemporal");
    if (!type) return type.error();
    if (!bus::can_offer(bus_.registry(), "action " + bus_.name_of(node_).expand("~/temp_plan"), (*type)->name))
      continue;
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

void PddlManager::clean_up() {
  for (const bus::EndpointId endpoint : endpoints_) bus_.remove(endpoint);
  endpoints_.clear();
  dialects_.clear();
  instances_.clear();
}

Status PddlManager::form_bond() {
  if (options_.bond_period <= 0) return {};
  cx::Bond::Options options;
  options.id = options_.node.name;
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

Status PddlManager::sense(SimTime now) {
  const auto rest = std::ranges::stable_partition(jobs_, [&](const Job& job) { return job.due > now; });
  std::vector<Job> due(rest.begin(), rest.end());
  jobs_.erase(rest.begin(), rest.end());
  std::ranges::stable_sort(due, {}, &Job::due);
  for (const Job& job : due) finish(job);
  return {};
}

Status PddlManager::act(SimTime) {
  meter_ = Meter(kMostCombinations);
  bus_.deliver(node_);
  if (bond_) bond_->act();
  return std::exchange(failure_, Status());
}

void PddlManager::log(cx::LogLevel level, const std::string& text) {
  if (options_.log) options_.log->line({bus_.now(), level, options_.node.name, text, {}});
}

}  // namespace cxlab::planner
