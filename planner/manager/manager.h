#pragma once
// The PDDL manager of CX: a lifecycle node that keeps PDDL instances, answers questions about them and makes plans.
// Planning takes simulated time: a plan of u work units is answered a + b * u seconds after it was asked for. It has no
// thread and no timer: an episode calls it in the order of docs/reference/contracts.md 1.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/record_sink.h"
#include "cx/base/time.h"
#include "cx/bus/bus.h"
#include "cx/node/bond.h"
#include "cx/node/lifecycle.h"
#include "cx/node/log.h"
#include "cx/node/parameters.h"
#include "cx/run/parts.h"
#include "planner/cost.h"
#include "planner/manager/external.h"
#include "planner/manager/instance.h"
#include "planner/planner.h"

namespace cxlab::planner {

struct PddlManagerOptions {
  bus::NodeName node{"pddl_manager", "/", {}};
  bool autostart = true;   ///< configured and activated when it is made
  double bond_period = 0;  ///< s between heartbeats on `bond` while active, as an environment manager; 0 = none
  bool original = false;   ///< answers as the first PDDL manager does, errors included
  bool anytime = false;    ///< plans are improved until budget or patience end
  bool warm_start = true;  ///< a plan begins with what is left of the last one that has most goals in common with it
  PlanningCost cost;
  ExternalPlanner other;       ///< another planner that makes the plans; without a command: ours
  cx::LogSink* log = nullptr;  ///< may be none
  /// Called before each file is read; may be empty.
  std::function<Status(const std::string& logical_name, const std::filesystem::path& file)> on_read;
  /// What a relative directory of an instance means; may be none.
  std::function<std::filesystem::path(const std::string& directory)> resolve;
  /// Whether rules may have the manager read this file; none: any.
  std::function<bool(const std::filesystem::path& file)> may_read;
  /// Writes a problem where a goal asks for it; may be empty.
  std::function<Status(const std::filesystem::path& file, const std::string& text)> write;
};

class PddlManager : public Server {
 public:
  /// Joins the bus; with `autostart` it is active when this returns.
  static Expected<std::unique_ptr<PddlManager>> create(PddlManagerOptions options, bus::Bus& bus, RecordSink& sink);
  ~PddlManager() override;
  PddlManager(const PddlManager&) = delete;
  PddlManager& operator=(const PddlManager&) = delete;

  // --- Life, as of a lifecycle node
  cx::LifeState state() const { return lifecycle_.state(); }
  Status change(cx::Transition transition) { return lifecycle_.change(transition); }

  // --- A tick
  /// Posts the answers whose time has come.
  Status sense(SimTime now) override;
  /// Takes what was sent to the node and answers it; plans that were asked for are made here. Sends heartbeats.
  Status act(SimTime now) override;
  SimTime next_due() const override;

  /// Plans that were found; of these, those for a goal instance that had had one before.
  int plans() const { return plans_; }
  int replans() const { return replans_; }
  /// Instances of somebody that others have replaced; why goals were out of reach; plans that were asked for, of which
  /// none was found.
  std::vector<std::string> warnings() const;

 private:
  using Goals = std::set<std::string>;  ///< what a goal asks for, as texts
  /// The last plan of a goal instance, and what it was made for.
  struct LastPlan {
    Goals goals;
    bus::SharedMessage result;
    int number = 0;  ///< of all plans that were made
  };
  struct Entry {
    std::unique_ptr<Instance> instance;
    SimTime loaded{};
    bus::ParticipantId owner{};             ///< who has it loaded
    std::map<std::string, LastPlan> plans;  // by goal instance
  };
  // The packages that have types for the same services.
  static constexpr const char *kUpstream = "cx_pddl_interfaces", *kExpertino = "expertino_msgs";
  /// A package of interfaces, and the endpoint of its planning action.
  struct Dialect {
    std::string package;
    bus::EndpointId plan{};
    const bus::ActionType* plan_type = nullptr;
  };
  /// A plan that was made and is answered later.
  struct Job {
    std::size_t dialect = 0;
    bus::GoalId goal{};
    SimTime due{};
    bus::GoalStatus status{};
    bus::SharedMessage result, report;
    Goals wanted;
    bool has_cause = false;  ///< the report's reason explains why the goal is out of reach
  };
  /// Why a goal was out of reach, when first and how often.
  struct MissingPlan {
    std::string cause;
    SimTime first{};
    int times = 0;
  };
  using View = bus::MessageView;
  struct Services;

  PddlManager(PddlManagerOptions options, bus::Bus& bus, RecordSink& sink);

  // Life
  Status act_on(cx::Transition transition);
  Status configure();
  void clean_up();
  void stop_jobs(const std::string& reason);
  Status form_bond();

  // Questions (services.cpp)
  Status serve_questions();
  Expected<Instance*> find_instance(const std::string& name);
  Expected<std::pair<Instance*, GoalInstance*>> find_goal(const std::string& instance, const std::string& goal);
  void publish_update(const std::string& instance);

  // Plans (plans.cpp)
  void on_goal(std::size_t dialect, const bus::Delivery& goal);
  void on_cancel(std::size_t dialect, const bus::Delivery& cancel);
  struct Outcome;
  Outcome make_plan(const View& goal);
  const LastPlan* nearest_plan(const std::string& instance, const Goals& wanted) const;
  Plan steps_left(const std::string& instance, const Task& task, const Goals& wanted) const;
  Job job_of(std::size_t dialect, const bus::GoalId& id, const View& goal, const Outcome& outcome) const;
  void dump(const View& goal, const Task& task);
  void give_up(Job job, const char* status, const std::string& reason, bus::GoalStatus ends);
  void finish(const Job& job);
  void note_cause(const std::string& cause);

  void log(cx::LogLevel level, const std::string& text);

  PddlManagerOptions options_;
  std::optional<PlannerServant> other_;  ///< of `options_.other`
  bus::Bus& bus_;
  RecordSink& sink_;
  bus::ParticipantId node_{};
  cx::Parameters parameters_;
  cx::Lifecycle lifecycle_;
  std::vector<bus::EndpointId> endpoints_;  // what there is from configure to cleanup
  std::vector<Dialect> dialects_;
  struct Topic {
    bus::EndpointId endpoint{};
    const bus::MessageType* type = nullptr;
  };
  Topic updates_, reports_;
  std::unique_ptr<cx::Bond> bond_;  // may be none
  Meter meter_;                     ///< of the questions of this tick
  std::map<std::string, Entry> instances_;
  std::vector<Job> jobs_;  // in the order in which they were asked for
  Status failure_;         // ends the run
  int plans_ = 0, replans_ = 0;
  std::vector<std::string> replaced_;                      // warnings
  std::map<std::string, int> others_;                      // answers without a plan, by status
  std::vector<MissingPlan> causes_;                        // each once
  std::set<std::pair<std::string, std::string>> planned_;  // instances with their goals
  RecordData data_;
};

}  // namespace cxlab::planner
