#pragma once
// The side that trains in the reinforcement learning interfaces of CX (package cx_rl_interfaces). Like CX's trainer, it
// asks for the spaces and then resets the agent's world. In each episode it reads the agent's observation, chooses one
// of the actions that a free robot can execute, and takes the reward. Several robots may be at work at once. In mode
// EXECUTION it chooses actions only when the agent asks for one.
//
// With the policy `external` somebody else chooses: each choice is a message cxlab_msgs/msg/RlDecision on ~/decisions,
// and the answer an RlDecisionMade on ~/decisions/made. A seat that answers is in the input log, so the run replays.

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/record_sink.h"
#include "cx/bus/bus.h"
#include "cx/node/log.h"
#include "cx/run/parts.h"
#include "scenarios/rl/policy.h"
#include "scenarios/rl/spaces.h"

namespace cxlab::rl {

struct TrainerOptions {
  bus::NodeName node{"cx_rl_node", "/", {}};
  bool training = true;      ///< else EXECUTION
  bool chance_only = false;  ///< actions by chance, nothing is learned
  bool external = false;     ///< somebody else chooses, nothing is learned
  bool no_op = false;        ///< with `external`: no-op is offered also where no other robot is at work
  int robots = 1;            ///< that may be at work at once
  int max_episodes = 100;
  int max_steps = 1000;  ///< of an episode, which then counts as ended
  LearningRates rates;
  std::optional<QTable> model;  ///< to begin with
  std::uint64_t seed = 0;
  cx::LogSink* log = nullptr;  ///< may be none
  /// Called after each episode of a training with its lines of `training.csv` and, at the end, with the table.
  std::function<Status(const std::string& file, const std::string& text)> write;
};

/// One observation or action as text: `on(a#b)`.
std::string grounded(const std::string& name, const std::vector<std::string>& params);

class Trainer final : public Server {
 public:
  static Expected<std::unique_ptr<Trainer>> create(TrainerOptions options, bus::Bus& bus, RecordSink& sink);
  ~Trainer() override;
  Status sense(SimTime) override { return {}; }
  Status act(SimTime now) override;
  SimTime next_due() const override;
  /// What it still waits for when the run ends: for people, empty where the training is over or there is none.
  std::string unfinished() const;
  /// The same as an error, where it has waited so long that nothing will come any more.
  Status hanging() const;

 private:
  struct Clients;
  /// What it waits for: a service, or an action that the agent has accepted or not.
  struct Wait {
    std::string name;  ///< "the service get_episode_end"; empty = nothing
    SimTime since{};   ///< or of the last sign of life
    bool at_work = false, warned = false;
  };
  struct Action {
    std::string id, text;
  };
  Trainer(TrainerOptions options, bus::Bus& bus, RecordSink& sink);

  /// What a robot was told, and what came of it since.
  struct Chosen {
    std::string state, action;
    double reward = 0;
  };
  /// A decision that is asked for or was made.
  struct Decision {
    std::int64_t id = 0;  ///< 0: none is open
    std::string robot;    ///< empty: the episode has ended
    std::vector<Action> actions;
    SimTime asked{};
  };

  void wait_for(std::string name) { wait_ = {std::move(name), bus_.now()}; }
  SimTime patience() const;
  /// Nobody serves reset_env, and this was not reported yet.
  bool lacks_agent() const;
  /// Asks for the next space, or goes on without one that the agent does not serve; sets when the training begins.
  void ask_for_spaces(SimTime now);
  void take_space(bus::MessageView response);
  void make_spaces();

  // What it waits for; each answer leads to the next. The search for a robot that can do something goes from
  // observe() to choose(); an answer to a search that was given up is ignored. While others are at work, the world
  // changes until a robot is found, so it is observed once again.
  void begin_episode();
  void observe();
  void ask_for_observations();
  void observed(bus::MessageView response);
  void ask_for_robot();
  void robot_found(const bus::Delivery& result);
  void ask_for_actions();
  void choose(bus::MessageView response);
  void decide(std::vector<Action> actions);
  void decided(bus::MessageView made);
  void select(const Action& action);
  void accepted(const bus::GoalId& goal);
  /// `goal` is that of the robot's action.
  void selected(const bus::GoalId& goal, bool done, std::int64_t reward, const std::string& info);
  void ask_for_end();
  void ended(bool end, std::int64_t reward);
  void rest();
  void give_up_search();
  void learn(const std::string& robot, const std::vector<Action>& next);
  void end_episode(const std::string& how);
  void go_on();
  void end_training();
  void publish_decision(const std::string& outcome);
  void answer_status(const bus::Delivery& request);
  void answer_selection(const bus::Delivery& request);

  std::size_t pick(const std::string& state, const std::vector<Action>& actions);
  void log(cx::LogLevel level, const std::string& text) const;

  TrainerOptions options_;
  bus::Bus& bus_;
  RecordSink& sink_;
  StreamId stream_;
  bus::ParticipantId node_;
  std::unique_ptr<Clients> clients_;
  RandomStream chance_;
  QTable table_;
  bool begun_ = false, warned_ = false, over_ = false;
  Wait wait_;
  // Before the first
  std::size_t space_ = 0;  // that is asked for next, or was asked for
  bool space_asked_ = false;
  SimTime ready_since_ = kNever, begins_ = kNever;
  std::vector<std::string> not_served_;
  std::vector<std::string> types_;  // of parameters, whose objects are asked for
  std::size_t type_ = 0;
  SpaceAnswers answers_;
  Spaces spaces_;
  bool strange_ = false;  // something that the spaces lack was reported
  // Of the episode
  int episode_ = 0, steps_ = 0, total_steps_ = 0;
  double reward_ = 0;                                      // of the episode
  double untold_ = 0;                                      // reward that no decision has told of
  std::string state_;                                      // that was observed last
  std::vector<std::string> truths_;                        // the same, one by one
  std::string robot_;                                      // that can do something; empty: none was found yet
  bool searching_ = false;                                 // for a robot that can
  std::uint64_t search_ = 0;                               // counts searches and episodes
  std::deque<std::uint64_t> observations_, lists_, ends_;  // asked for, by search or episode
  std::optional<bus::GoalId> robot_goal_;                  // that asks for a robot
  std::uint64_t phase_ = 0;                                // counts episodes
  std::map<bus::GoalId, std::string> at_work_;             // robots by the goals of their actions
  std::map<std::string, Chosen> chosen_;                   // by robot
  bool end_after_observation_ = false;
  SimTime rests_until_ = kNever;  // nobody was given anything to do
  Decision decision_;
  std::int64_t decisions_ = 0;
  std::string table_text_;  // lines of training.csv
  Status failure_;
};

}  // namespace cxlab::rl
