#pragma once
// Messages of an outside referee box as topics of a game (docs/reference/rcll-topics.md), and reports of an agent as
// messages to it.

#include <map>
#include <memory>
#include <string>

#include "scenarios/rcll/refbox/league_link.h"

namespace cxlab::rcll {

class LeagueTopics {
 public:
  /// The link outlives it.
  static Expected<std::unique_ptr<LeagueTopics>> open(LeagueLink& link);

  /// Publishes a message of the referee box; others than those of a topic are ignored. Robots of the team get the names
  /// that their actions have here, whatever they say of themselves.
  void take(google::protobuf::Message& message);

 private:
  struct Topic {
    const bus::MessageType* type = nullptr;
    bus::EndpointId endpoint{};
  };

  explicit LeagueTopics(LeagueLink& link) : link_(link) {}
  Status advertise(const char* topic, const char* message);
  /// Sends what comes on the topic to the referee box as the message of that name; `says_team`: with the team's colour.
  Status forward(const char* topic, const std::string& message, bool says_team);

  LeagueLink& link_;
  std::map<std::string, Topic> topics_;  ///< by the message's name
};

}  // namespace cxlab::rcll
