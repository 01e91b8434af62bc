#pragma once
// The node `league_client`: an outside referee box and the robots of a team, for an agent that knows the topics and
// actions of a game (docs/reference/rcll-topics.md). Messages of llsf_msgs become topics; reports, instructions and
// skills become messages. Each of these jobs is a part of its own; the client hands them what comes from the network
// and repeats each second what has no answer yet.
//
//   servers: [{node: league_client, team: CYAN}]

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "cx/run/parts.h"
#include "scenarios/rcll/refbox/league_instructions.h"
#include "scenarios/rcll/refbox/league_link.h"
#include "scenarios/rcll/refbox/league_robot.h"
#include "scenarios/rcll/refbox/league_topics.h"

namespace cxlab::rcll {

class LeagueClient final : public Server {
 public:
  /// What the stage is made with outlives it.
  static Expected<std::unique_ptr<LeagueClient>> make(const LeagueClientConfig& config, const StageSetup& setup);

  Status sense(SimTime) override { return {}; }
  Status act(SimTime now) override;
  SimTime next_due() const override { return next_; }

 private:
  explicit LeagueClient(cx::LogSink* log) : log_(log) {}
  Status open(const LeagueClientConfig& config, const StageSetup& setup);
  void take(const net::Event& event);
  void take_refbox(google::protobuf::Message& message);
  void say_where_robots_are();
  void complain(const std::string& text);

  cx::LogSink* log_;
  SimTime next_{};
  std::unique_ptr<LeagueLink> link_;
  std::unique_ptr<LeagueTopics> topics_;
  std::unique_ptr<LeagueInstructions> instructions_;
  std::vector<std::unique_ptr<LeagueRobot>> robots_;
  std::uint64_t beacons_ = 0;
  std::string complaint_;  ///< the last one
};

}  // namespace cxlab::rcll
