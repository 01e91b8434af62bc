#include "scenarios/rcll/refbox/league_robot.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <algorithm>
#include <cmath>

#include "cx/bus/needed.h"
#include "scenarios/rcll/rules/layout.h"

namespace cxlab::rcll {

namespace {

/// "C-CS1-SHELF-LEFT": machine and point.
std::pair<std::string, std::string> split_spot(const std::string& spot) {
  const std::size_t dash = spot.find('-', std::min(spot.find('-') + 1, spot.size()));
  if (dash == std::string::npos) return {spot, ""};
  return {spot.substr(0, dash), spot.substr(dash + 1)};
}

/// The zone of a place in the field.
std::string zone_at(double x, double y) {
  const auto within = [](double value, int most) { return std::clamp(static_cast<int>(value) + 1, 1, most); };
  return to_string(Zone{x < 0 ? Team::kMagenta : Team::kCyan, within(std::abs(x), kColumns), within(y, kRows)});
}

}  // namespace

Expected<std::unique_ptr<LeagueRobot>> LeagueRobot::open(LeagueLink& link, int number) {
  std::unique_ptr<LeagueRobot> robot(new LeagueRobot(link, number));
  if (Status s = robot->serve(); !s) return s.error();
  return robot;
}

Status LeagueRobot::serve() {
  const std::string name = "robot" + std::to_string(number_) + '/';
  for (const auto& [skill, type] : {std::pair{"drive_to", "DriveTo"},
                                    {"pick", "Pick"},
                                    {"place", "Place"},
                                    {"transport", "Transport"},
                                    {"explore", "Explore"},
                                    {"discard", "Discard"}}) {
    auto known = bus::needed_action(link_.bus.registry(), std::string("cxlab_skills/action/") + type);
    if (!known) return known.error();
    Skill& made = skills_[skill];
    made = {skill, *known, {}};
    auto server = link_.bus.serve_action(link_.node, name + skill, **known,
                                         {[this, &made](const bus::Delivery& d) { take_goal(made, d); },
                                          [this, &made](const bus::Delivery& d) { take_cancel(made, d); }});
    if (!server) return server.error();
    made.server = *server;
  }
  auto type = bus::needed_message(link_.bus.registry(), "cxlab_skills/msg/Sightings");
  if (!type) return type.error();
  sightings_type_ = *type;
  auto sightings = link_.bus.advertise(link_.node, name + "sightings", **type);
  if (!sightings) return sightings.error();
  sightings_ = *sightings;
  return {};
}

// --- From the agent

void LeagueRobot::take_goal(const Skill& skill, const bus::Delivery& delivery) {
  if (active_) {
    link_.bus.answer_goal(skill.server, delivery.goal, bus::GoalAnswer::kReject);
    return;
  }
  link_.bus.answer_goal(skill.server, delivery.goal, bus::GoalAnswer::kAccept);
  const bus::MessageView goal = delivery.message->view();
  active_ = &skill;
  goal_ = delivery.goal;
  canceled_ = false;
  target_ = skill.name == "transport" ? goal.text("from") + " to " + goal.text("to") : goal.text("target");
  parts_ = parts_of(skill, goal);
  if (parts_.empty()) return finish(number_of(TaskCode::kNotSupported));
  send_part();
}

std::deque<LeagueRobot::Part> LeagueRobot::parts_of(const Skill& skill, const bus::MessageView& goal) const {
  const auto move = [](std::string_view sub_action, const std::string& to) {
    const auto [machine, point] = split_spot(to);
    Part part{sub_action, "move", {{"waypoint", machine}}};
    if (!point.empty()) part.values.emplace_back("machine_point", point);
    return part;
  };
  const auto handle = [](std::string_view sub_action, const char* field, const std::string& spot) {
    const auto [machine, point] = split_spot(spot);
    return Part{sub_action, field, {{"machine_id", machine}, {"machine_point", point}}};
  };
  if (skill.name == "transport") {
    const std::string from = goal.text("from"), to = goal.text("to");
    return {move("drive_from", from), handle("pick", "retrieve", from), move("drive_to", to),
            handle("place", "deliver", to)};
  }
  const std::string target = goal.text("target");
  if (skill.name == "pick") return {move("", target), handle("", "retrieve", target)};
  if (skill.name == "place") return {move("", target), handle("", "deliver", target)};
  if (skill.name == "explore")
    return {{"", "explore_machine", {{"machine_id", ""}, {"machine_point", ""}, {"waypoint", target}}}};
  if (skill.name != "drive_to") return {};
  const bus::MessageView pose = goal.nested("pose");
  return {move("", target.empty() ? zone_at(pose.real("x"), pose.real("y")) : target)};
}

void LeagueRobot::take_cancel(const Skill& skill, const bus::Delivery& delivery) {
  link_.bus.answer_cancel(skill.server, delivery, true);
  canceled_ = true;
  Fields(*task_).set("cancel_task", true);
  channel_.send(*task_);
}

void LeagueRobot::send_part() {
  const Part& part = parts_.front();
  task_ = link_.make("llsf_msgs.AgentTask");
  Fields task(*task_);
  task.set("team_color", link_.config.team).set("task_id", ++task_id_).set("robot_id", number_);
  for (const auto& [field, value] : part.values) task.part(part.field).set(field, value);
  channel_.send(*task_);
  bus::Message feedback(*active_->type->feedback);
  if (!part.sub_action.empty()) feedback->set("sub_action", part.sub_action);
  link_.bus.publish_feedback(active_->server, goal_, std::make_shared<const bus::Message>(std::move(feedback)));
}

void LeagueRobot::repeat() {
  if (active_ && task_) channel_.send(*task_);
}

// --- From the robot

void LeagueRobot::take(google::protobuf::Message& message) {
  const std::string& type = message.GetDescriptor()->name();
  const auto copy = [&message] {
    pb::MessagePtr out(message.New());
    out->CopyFrom(message);
    return out;
  };
  if (type == "BeaconSignal") {
    beacon_ = copy();
  } else if (type == "MachineReport") {
    seen_ = copy();
    publish_sightings(message);
  } else if (type == "AgentTask") {
    take_answer(message);
  }
}

void LeagueRobot::publish_sightings(google::protobuf::Message& message) {
  bus::Message sightings(*sightings_type_);
  const Fields report(message);
  for (int i = 0; i < report.size("machines"); ++i) {
    const Fields entry = report.item("machines", i);
    const bus::MessageView seen = sightings->append("machines");
    seen.set("zone", entry.text("zone")).set("machine", entry.text("name"));
    if (entry.has("rotation")) seen.set("rotation", entry.integer("rotation"));
  }
  link_.bus.publish(sightings_, std::make_shared<const bus::Message>(std::move(sightings)));
}

void LeagueRobot::take_answer(google::protobuf::Message& message) {
  const Fields answer(message);
  const bool ended = answer.has("successful") || answer.has("canceled");
  if (!active_ || !ended || answer.integer("task_id") != task_id_) return;
  const bool canceled = answer.has("canceled") && answer.integer("canceled") != 0;
  if (canceled || !answer.integer("successful"))
    return finish(std::max(number_of(TaskCode::kFailed), answer.integer("error_code")), canceled && canceled_);
  if (parts_.size() == 1) return finish(number_of(TaskCode::kNone));
  parts_.pop_front();
  if (canceled_) return finish(number_of(TaskCode::kFailed), true);
  send_part();
}

void LeagueRobot::finish(std::int64_t code, bool canceled) {
  const bool done = code == number_of(TaskCode::kNone);
  bus::Message result(*active_->type->result);
  result->set("success", done).set("error_code", canceled ? 0 : code).set("target", target_);
  if (!done) result->set("error", canceled ? "canceled" : "error " + std::to_string(code) + " of the robot");
  if (active_->name == "transport" && !done) result->set("sub_action", parts_.front().sub_action);
  if (active_->name == "explore") {
    result->set("zone", target_).set("rotation", -1);
    for (int i = 0; seen_ && i < Fields(*seen_).size("machines"); ++i) {
      const Fields entry = Fields(*seen_).item("machines", i);
      if (entry.text("zone") != target_ || !entry.has("name")) continue;
      result->set("machine", entry.text("name")).set("rotation", entry.integer("rotation"));
    }
  }
  const bus::GoalStatus status = canceled ? bus::GoalStatus::kCanceled
                                 : done   ? bus::GoalStatus::kSucceeded
                                          : bus::GoalStatus::kAborted;
  link_.bus.finish(active_->server, goal_, status, std::make_shared<const bus::Message>(std::move(result)));
  active_ = nullptr;
  task_.reset();
  parts_.clear();
}

}  // namespace cxlab::rcll
