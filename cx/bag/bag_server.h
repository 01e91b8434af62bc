#pragma once
// The node that plays a bag of ROS 2 into a run (docs/reference/bag.md): topics are published at their times; what
// agents ask of services and actions that nobody in the run serves is answered as it was in the recording; and what was
// asked of services and actions that an agent serves is asked again.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cx/bag/bag_spec.h"
#include "cx/bag/part.h"
#include "cx/bag/recording.h"
#include "cx/base/expected.h"
#include "cx/bus/bus.h"
#include "cx/run/parts.h"

namespace cxlab::bag {

/// When the last message is played, in simulated time.
SimTime end_of(const Recording& recording, const BagSpec& spec);

struct BagSetup {
  BagSpec spec;  ///< `file` is not read: the recording is open
  Recording recording;
  std::vector<std::string> managers;            ///< full names of the nodes of environment managers
  std::vector<bus::ParticipantId> beside = {};  ///< whose messages come in addition to those of the bag
  std::function<void(bool warning, const std::string& text)> log;
};

class BagServer final : public Server {
 public:
  /// Joins the bus as node "bag", after the world and its nodes and before all agents. Fails with kInput if the
  /// workspace defines a type of the bag differently.
  static Expected<std::unique_ptr<BagServer>> create(BagSetup setup, bus::Bus& bus, RecordSink& sink);
  ~BagServer() override;

  Status sense(SimTime now) override;
  Status act(SimTime now) override;
  SimTime next_due() const override;

  /// What a person should know, for the result; with what is left open so far.
  std::vector<std::string> warnings() const;

 private:
  BagServer(BagSetup setup, bus::Bus& bus);
  struct ActionOfBag;
  Status make_parts();
  Status make_topic(const Topic& topic, const std::string& name, std::size_t place);
  Status make_service(const Topic& topic, const std::string& name, std::size_t place);
  Status make_actions();
  /// Why the topic is not played whatever the run does; empty: it is.
  std::string left_out_for_good(const Topic& topic, const std::string& name) const;
  void leave_out(const Topic& topic, const std::string& why);
  void add(std::unique_ptr<Part> part, const std::vector<std::size_t>& places);
  Error differs(const Topic& topic, const std::string& type, const std::string& difference) const;
  std::string remapped(const std::string& name) const;

  SimTime begins() const;  ///< in the run
  Status advance();
  Status skip();
  void report();

  BagSpec spec_;
  Recording recording_;
  std::vector<std::string> managers_;
  Playing playing_;
  std::vector<std::unique_ptr<Part>> parts_;
  std::vector<Part*> part_of_;  ///< by topic of the recording; none: it is left out
  std::vector<ActionOfBag> actions_;
  std::vector<std::string> left_out_, unknown_;
  std::size_t filtered_ = 0;
  std::optional<RecordedMessage> next_;
  bool reported_ = false, begun_ = false;
};

}  // namespace cxlab::bag
