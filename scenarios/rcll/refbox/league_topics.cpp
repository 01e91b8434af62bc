#include "scenarios/rcll/refbox/league_topics.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include "cx/bus/needed.h"
#include "scenarios/rcll/topics/topic.h"

namespace cxlab::rcll {

Expected<std::unique_ptr<LeagueTopics>> LeagueTopics::open(LeagueLink& link) {
  std::unique_ptr<LeagueTopics> made(new LeagueTopics(link));
  for (const auto& [topic, message] : {std::pair{"game_state", "GameState"},
                                       {"order_info", "OrderInfo"},
                                       {"ring_info", "RingInfo"},
                                       {"robot_info", "RobotInfo"},
                                       {"machine_info", "MachineInfo"},
                                       {"machine_report_info", "MachineReportInfo"}})
    if (Status s = made->advertise(topic, message); !s) return s.error();
  if (Status s = made->forward("machine_report", "MachineReport", true); !s) return s.error();
  if (Status s = made->forward("set_robot_maintenance", "SetRobotMaintenance", false); !s) return s.error();
  return made;
}

Status LeagueTopics::advertise(const char* topic, const char* message) {
  auto type = bus::needed_message(link_.bus.registry(), std::string(kInterfaces) + "msg/" + message);
  if (!type) return type.error();
  auto made = link_.bus.advertise(link_.node, topic, **type);
  if (!made) return made.error();
  topics_[message] = {*type, *made};
  return {};
}

Status LeagueTopics::forward(const char* topic, const std::string& message, bool says_team) {
  auto type = bus::needed_message(link_.bus.registry(), std::string(kInterfaces) + "msg/" + message);
  if (!type) return type.error();
  auto made = link_.bus.subscribe(link_.node, topic, **type, [this, message, says_team](const bus::Delivery& d) {
    const auto out = link_.make("llsf_msgs." + message);
    fill(*out, d.message->view(), link_.moment());
    if (says_team) Fields(*out).set("team_color", link_.config.team);
    if (out->IsInitialized()) link_.team().send(*out);
  });
  return made ? Status() : Status(made.error());
}

void LeagueTopics::take(google::protobuf::Message& message) {
  const auto topic = topics_.find(message.GetDescriptor()->name());
  if (topic == topics_.end()) return;
  Fields fields(message);
  if (topic->first == "RobotInfo")
    for (int i = 0; i < fields.size("robots"); ++i) {
      Fields robot = fields.item("robots", i);
      if (robot.text("team_color") == link_.config.team)
        robot.set("name", "robot" + std::to_string(robot.integer("number")));
    }
  bus::Message out(*topic->second.type);
  fill(out.view(), message);
  link_.bus.publish(topic->second.endpoint, std::make_shared<const bus::Message>(std::move(out)));
}

}  // namespace cxlab::rcll
