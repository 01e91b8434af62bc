#pragma once
// The node that carries out a scenario's stimuli: whatever the rules do, at its time each is posted to the bus.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cx/bus/bus.h"
#include "cx/run/parts.h"
#include "scenarios/scenario.h"

namespace cxlab {

class StimuliServer : public Server {
 public:
  using Log = std::function<void(const std::string& line)>;
  /// Joins the bus as node "stimuli". Types, names and contents are checked now; errors name the stimulus' file and
  /// line. `managers` are the nodes of the environment managers: a stimulus that names none means the only one.
  static Expected<std::unique_ptr<StimuliServer>> create(std::vector<Stimulus> stimuli,
                                                         const std::vector<std::string>& managers, bus::Bus& bus,
                                                         RecordSink& sink, Log log);
  ~StimuliServer() override;

  Status sense(SimTime now) override;
  Status act(SimTime now) override;
  SimTime next_due() const override;

 private:
  struct State;
  explicit StimuliServer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cxlab
