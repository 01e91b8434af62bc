#pragma once
// A robot of the team that speaks the league's protocol: each skill is one or several AgentTasks, one after the other,
// and its MachineReports are sightings.

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scenarios/rcll/refbox/codes.h"
#include "scenarios/rcll/refbox/league_link.h"

namespace cxlab::rcll {

class LeagueRobot {
 public:
  /// `number` in the team, from 1. The link outlives it.
  static Expected<std::unique_ptr<LeagueRobot>> open(LeagueLink& link, int number);
  LeagueRobot(const LeagueRobot&) = delete;
  LeagueRobot& operator=(const LeagueRobot&) = delete;

  const Channel& channel() const { return channel_; }
  int number() const { return number_; }
  /// The last beacon of the robot; may be none.
  google::protobuf::Message* beacon() const { return beacon_.get(); }
  void take(google::protobuf::Message& message);
  /// Sends the current task again.
  void repeat();

 private:
  struct Skill {
    std::string_view name;
    const bus::ActionType* type = nullptr;
    bus::EndpointId server{};
  };
  /// One AgentTask of a skill.
  struct Part {
    std::string_view sub_action;
    std::string field;  ///< of AgentTask
    std::vector<std::pair<std::string, std::string>> values;
  };

  LeagueRobot(LeagueLink& link, int number) : link_(link), number_(number), channel_(link.open_robot(number)) {}
  Status serve();
  void take_goal(const Skill& skill, const bus::Delivery& delivery);
  void take_cancel(const Skill& skill, const bus::Delivery& delivery);
  /// Which tasks the skill is; none for one that the protocol does not have.
  std::deque<Part> parts_of(const Skill& skill, const bus::MessageView& goal) const;
  void send_part();
  void take_answer(google::protobuf::Message& task);
  void publish_sightings(google::protobuf::Message& report);
  void finish(std::int64_t code, bool canceled = false);

  LeagueLink& link_;
  int number_;
  Channel channel_;
  std::map<std::string_view, Skill> skills_;
  const bus::MessageType* sightings_type_ = nullptr;
  bus::EndpointId sightings_{};
  const Skill* active_ = nullptr;
  bus::GoalId goal_{};
  std::string target_;
  std::deque<Part> parts_;  ///< the first is the current one
  pb::MessagePtr task_;     ///< that was sent last
  pb::MessagePtr seen_;     ///< the last MachineReport
  pb::MessagePtr beacon_;
  bool canceled_ = false;
  std::int64_t task_id_ = 0;
};

}  // namespace cxlab::rcll
