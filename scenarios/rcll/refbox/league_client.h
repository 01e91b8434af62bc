#pragma once
// The node `league_client`: an outside referee box and the robots of a team, for an agent that knows the topics and
// actions of a game (docs/rcll.md). Messages of llsf_msgs become topics; reports, instructions and skills become
// messages.
//
//   servers: [{node: league_client, team: CYAN}]

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/bus/bus.h"
#include "cx/network/host.h"
#include "cx/protobuf/types.h"
#include "cx/run/parts.h"
#include "scenarios/catalogue.h"
#include "scenarios/rcll/refbox/channel.h"
#include "scenarios/rcll/refbox/messages.h"

namespace cxlab::rcll {

struct LeagueClientConfig {
  std::string team = "CYAN";
  std::string team_name = "cxlab";  ///< said in beacons
  int robots = 3;                   ///< of the team, 0..3
  std::string key = "randomkey";    ///< of the team's channel; empty: not encrypted
  std::string cipher = "aes-128-cbc";
  int first_robot = 1;           ///< in the order of all robots of the game, from which their ports follow
  int port_shift = 0;            ///< added to all ports
  std::string name_space = "/";  ///< of topics and actions

  template <class Keys>
  void fields(Keys& keys) {
    keys.word("team", team, {"CYAN", "MAGENTA"});
    keys("team_name", team_name);
    keys("robots", robots);
    keys("key", key);
    keys.word("cipher", cipher, {"aes-128-ecb", "aes-128-cbc", "aes-256-ecb", "aes-256-cbc"});
    keys("first_robot", first_robot);
    keys("port_shift", port_shift);
    keys("namespace", name_space);
  }
};

class LeagueClient final : public Server {
 public:
  /// What the stage is made with outlives it.
  static Expected<std::unique_ptr<LeagueClient>> make(const LeagueClientConfig& config, const StageSetup& setup);
  ~LeagueClient() override;

  Status sense(SimTime) override { return {}; }
  Status act(SimTime now) override;
  SimTime next_due() const override;

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
  struct Robot {
    Robot(int which, Channel&& way) : number(which), channel(std::move(way)) {}
    int number;
    Channel channel;
    std::map<std::string_view, Skill> skills;
    bus::EndpointId sightings{};
    const Skill* active = nullptr;
    bus::GoalId goal{};
    std::string target;
    std::deque<Part> parts;  ///< the first is under way
    pb::MessagePtr task;     ///< that was sent last
    pb::MessagePtr seen;     ///< the last MachineReport
    pb::MessagePtr beacon;   ///< the last of the robot
    bool canceled = false;
    std::int64_t task_id = 0;
  };
  struct Instruction {
    bus::GoalId goal{};
    std::string machine, reported;
    pb::MessagePtr message;
    SimTime since{};
    bool reset = false, waits_for_piece = false, at_work = false;
  };

  LeagueClient(LeagueClientConfig config, const StageSetup& setup);
  Status open();
  Status open(Robot& robot);
  Status advertise(const char* topic, const char* message);

  void take(const net::Event& event);
  void take_refbox(google::protobuf::Message& message);
  void take_robot(Robot& robot, google::protobuf::Message& message);
  void publish(const std::string& topic, google::protobuf::Message& message);
  void follow_machines();

  void take_instruction(const bus::Delivery& delivery);
  void finish(const Instruction& instruction, int code, const std::string& error);
  pb::MessagePtr prepare_message(const bus::MessageView& goal) const;
  void take_report(const bus::Delivery& delivery);
  void take_maintenance(const bus::Delivery& delivery);

  void take_goal(Robot& robot, const Skill& skill, const bus::Delivery& delivery);
  void take_cancel(Robot& robot, const Skill& skill, const bus::Delivery& delivery);
  void send_part(Robot& robot);
  void finish(Robot& robot, std::int64_t code, bool canceled = false);
  void say_where_robots_are();
  Moment moment() const { return Moment::of(epoch_, now_); }
  void complain(const std::string& text);

  LeagueClientConfig config_;
  bus::Bus& bus_;
  net::Network& network_;
  cx::LogSink* log_;
  double epoch_;
  SimTime now_{}, next_{};
  bus::ParticipantId node_{};
  std::unique_ptr<pb::Types> types_;
  std::unique_ptr<net::Host> host_;
  std::optional<Channel> public_, team_;
  std::vector<std::unique_ptr<Robot>> robots_;
  struct Topic {
    const bus::MessageType* type = nullptr;
    bus::EndpointId endpoint{};
  };
  std::map<std::string, Topic, std::less<>> topics_;  ///< by the message's name
  const bus::ActionType* instruct_ = nullptr;
  bus::EndpointId instruct_server_{};
  std::vector<Instruction> instructions_;
  std::map<std::string, std::string> machines_;  ///< state by name
  std::uint64_t beacons_ = 0;
  std::string complaint_;  ///< the last one
};

}  // namespace cxlab::rcll
