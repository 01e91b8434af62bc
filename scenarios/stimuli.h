#pragma once
// The node that carries out a scenario's stimuli: it posts each to the bus at its time, whatever the rules do.

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cx/bus/bus.h"
#include "cx/run/parts.h"
#include "scenarios/scenario.h"

namespace cxlab {

class StimuliServer : public Server {
 public:
  using Log = std::function<void(const std::string& line)>;
  /// Joins the bus as node "stimuli". Types, names and contents are checked now; errors name the stimulus' file and
  /// line. `managers` are the nodes of the environment managers: a stimulus without one is for the only one.
  static Expected<std::unique_ptr<StimuliServer>> create(const std::vector<Stimulus>& stimuli,
                                                         const std::vector<std::string>& managers, bus::Bus& bus,
                                                         RecordSink& sink, Log log);

  Status sense(SimTime now) override;
  Status act(SimTime now) override;
  SimTime next_due() const override;

 private:
  /// A stimulus with its message compiled.
  struct Prepared {
    Stimulus stimulus;
    bus::SharedMessage message;
    const bus::ServiceType* service = nullptr;
    const bus::ActionType* action = nullptr;
  };
  using Channel = std::pair<std::string, std::string>;  ///< name and type: one name may be served under several

  StimuliServer(const std::vector<std::string>& managers, bus::Bus& bus, RecordSink& sink, Log log);
  Status prepare(const Stimulus& stimulus);
  /// A request to a node (a parameter, an environment, a plugin) as a call of its service.
  Expected<Stimulus> as_call(const Stimulus& stimulus) const;
  Status post(const Prepared& item);
  Expected<bus::EndpointId> open(const Prepared& item);
  Status serve(const Prepared& item);
  Status cancel_goal(const Stimulus& stimulus);
  Status stop_node(const Stimulus& stimulus);
  /// Logs and records an answer.
  void say(const std::string& target, const std::string& what, const bus::Delivery& delivery);

  bus::Bus& bus_;
  RecordSink& sink_;
  Log log_;
  std::vector<std::string> managers_;
  RecordData data_;
  bus::ParticipantId self_{};
  std::vector<Prepared> prepared_;
  std::size_t next_ = 0;
  std::map<Channel, bus::EndpointId> endpoints_;
  std::map<std::string, bus::EndpointId> services_;
  std::map<std::string, std::pair<bus::EndpointId, bus::GoalId>> last_goal_;
};

}  // namespace cxlab
