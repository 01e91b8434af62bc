#include "scenarios/rcll/refbox/robot_peer.h"

#include <google/protobuf/message.h>

#include <algorithm>
#include <cctype>

#include "cx/bus/needed.h"
#include "scenarios/rcll/refbox/codes.h"
#include "scenarios/rcll/rules/machine.h"
#include "sim/skills/skill.h"

namespace cxlab::rcll {

namespace {

using sim::SkillCode;

constexpr std::size_t kFinishedTold = 10;
constexpr double kWaitAtBelt = 30;  // s; as long as the robots of the league's simulation

std::string upper(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

/// "C-Z23" and "c_z23" are C_Z23.
std::string zone_name(const std::string& text) {
  std::string zone = upper(text);
  if (zone.size() > 2 && zone[1] == '-' && zone[2] == 'Z') zone[1] = '_';
  return zone;
}

/// Spots of a machine's point, those to be tried first in front.
std::vector<std::string> spots_of(const std::string& machine, const std::string& machine_point) {
  std::string point = upper(machine_point);
  if (point == "LEFT" || point == "MIDDLE" || point == "RIGHT") point = "SHELF-" + point;
  if (point != "SHELF") return {machine + '-' + point};
  return {machine + "-SHELF-LEFT", machine + "-SHELF-MIDDLE", machine + "-SHELF-RIGHT"};
}

}  // namespace

RobotPeer::RobotPeer(RefboxContext& context, Identity identity, Channel channel)
    : context_(context), identity_(std::move(identity)), channel_(std::move(channel)) {}

RobotPeer::~RobotPeer() = default;

Status RobotPeer::open() {
  for (const auto& [name, type] : {std::pair{"drive_to", "DriveTo"},
                                   {"pick", "Pick"},
                                   {"place", "Place"},
                                   {"transport", "Transport"},
                                   {"explore", "Explore"}}) {
    auto known = bus::needed_action(context_.bus.registry(), std::string("cxlab_skills/action/") + type);
    if (!known) return known.error();
    auto client =
        context_.bus.create_action_client(context_.node, "/" + identity_.name + "/" + name, **known,
                                          {.goal_response = [this](const bus::Delivery& d) { take_answer(d); },
                                           .feedback = [](const bus::Delivery&) {},
                                           .result = [this](const bus::Delivery& d) { take_result(d); },
                                           .cancel_response = [](const bus::Delivery&) {}});
    if (!client) return client.error();
    actions_[name] = {*known, *client};
  }
  auto type = bus::needed_message(context_.bus.registry(), "cxlab_skills/msg/Sightings");
  if (!type) return type.error();
  auto heard = context_.bus.subscribe(context_.node, "/" + identity_.name + "/sightings", **type,
                                      [this](const bus::Delivery& d) { take_sightings(d); });
  return heard ? Status() : Status(heard.error());
}

// --- Tasks

std::string RobotPeer::take(const Fields& task) {
  if (task.text("team_color") != to_string(identity_.team)) {
    answer(task, number_of(InstructError::kWrongTeam));
    return "a task for a robot of " + task.text("team_color");
  }
  if (task.integer("robot_id") != identity_.number) {
    answer(task, number_of(TaskCode::kWrongRobot));
    return "a task for robot " + std::to_string(task.integer("robot_id"));
  }
  const bool same = task_ && Fields(*task_).integer("task_id") == task.integer("task_id");
  if (task.has("cancel_task") && task.integer("cancel_task") != 0) {
    if (waiting_ && Fields(*waiting_).integer("task_id") == task.integer("task_id")) {
      answer(Fields(*waiting_), 0, true);
      waiting_.reset();
    } else if (same && under_way_) {
      cancels_ = true;
      stop_skill();
    }
    return {};
  }
  if (task.has("pause_task") && task.integer("pause_task") != 0) {
    if (!same || !under_way_) return "a pause of a task that is not running";
    paused_ = true;
    stop_skill();
    return {};
  }
  if (same && std::exchange(paused_, false) && !goal_) next_step();
  if (same || (waiting_ && Fields(*waiting_).integer("task_id") == task.integer("task_id"))) return {};
  if (!under_way_) {
    begin(task.message());
    return {};
  }
  if (waiting_) answer(Fields(*waiting_), 0, true);
  waiting_.reset(task.message().New());
  waiting_->CopyFrom(task.message());
  cancels_ = true;
  stop_skill();
  return {};
}

/// The task ends, or rests, when the skill has.
void RobotPeer::stop_skill() {
  if (goal_) {
    if (!std::exchange(stops_, true)) context_.bus.cancel_goal(actions_.at(steps_.front().action).client, *goal_);
  } else if (cancels_) {
    end(0, true);
  }
}

RobotPeer::Plan RobotPeer::plan_of(const Fields& task) const {
  const auto shelf = [](std::int64_t number) {
    constexpr std::array<std::string_view, 3> kSlots{"LEFT", "MIDDLE", "RIGHT"};
    return number >= 1 && number <= 3 ? std::string(kSlots[static_cast<std::size_t>(number - 1)]) : std::string();
  };
  Plan plan;
  if (task.has("move")) {
    const Fields move = task.part("move");
    const std::string to = upper(move.text("waypoint")), point = upper(move.text("machine_point"));
    if (to.find('Z') != to.npos && to.size() == 5)
      plan.steps.push_back({"drive_to", {{"target", zone_name(to)}}});
    else if (!point.empty() || std::ranges::count(to, '-') > 1)
      plan.steps.push_back({"drive_to", {{"target", point.empty() ? to : spots_of(to, point).front()}}});
    else
      plan.steps.push_back({"drive_to", {{"target", to + "-INPUT"}}});
  } else if (task.has("retrieve") || task.has("deliver")) {
    const bool retrieve = task.has("retrieve");
    const Fields at = task.part(retrieve ? "retrieve" : "deliver");
    const std::vector<std::string> spots = spots_of(upper(at.text("machine_id")), at.text("machine_point"));
    const bool belt = spots.front().ends_with("-INPUT") || spots.front().ends_with("-OUTPUT");
    for (const std::string& spot : spots)
      plan.steps.push_back({retrieve ? "pick" : "place", {{"target", spot}}, true, retrieve && belt ? kWaitAtBelt : 0});
    plan.steps.back().or_next = false;
  } else if (task.has("buffer")) {
    const std::string machine = upper(task.part("buffer").text("machine_id"));
    const std::string slot = shelf(task.part("buffer").integer("shelf_number"));
    if (slot.empty()) return {{}, number_of(SkillCode::kInvalidTarget)};
    plan.steps.push_back({"transport", {{"from", machine + "-SHELF-" + slot}, {"to", machine + "-INPUT"}}});
  } else if (task.has("explore_machine")) {
    plan.steps.push_back({"explore", {{"target", zone_name(task.part("explore_machine").text("waypoint"))}}});
  } else {
    plan.error = number_of(TaskCode::kNotSupported);
  }
  return plan;
}

void RobotPeer::begin(const google::protobuf::Message& task) {
  task_.reset(task.New());
  task_->CopyFrom(task);
  under_way_ = true;
  cancels_ = false;
  Plan plan = plan_of(Fields(*task_));
  steps_ = std::move(plan.steps);
  if (plan.error != 0) return end(plan.error);
  next_step();
}

void RobotPeer::next_step() {
  stops_ = false;
  const Step& step = steps_.front();
  const Action& action = actions_.at(step.action);
  bus::Message goal(*action.type->goal);
  for (const auto& [field, value] : step.fields) goal->set(field, value);
  if (step.wait_s > 0 && action.type->goal->find("wait_s")) goal->set("wait_s", step.wait_s);
  goal_ = context_.bus.send_goal(action.client, std::make_shared<bus::Message>(std::move(goal)));
}

void RobotPeer::take_answer(const bus::Delivery& delivery) {
  if (delivery.accepted) return;
  goal_.reset();
  end(number_of(SkillCode::kInternal));  // the robot is at work for somebody else
}

void RobotPeer::take_result(const bus::Delivery& delivery) {
  const Step step = steps_.front();
  context_.bus.forget_goal(actions_.at(step.action).client, *goal_);
  goal_.reset();
  if (delivery.status == bus::GoalStatus::kCanceled || !delivery.message) {
    if (!stops_ || cancels_) return end(0, true);
    if (!paused_) next_step();  // it went on before the skill had ended
    return;
  }
  const bus::MessageView result = delivery.message->view();
  std::int64_t error = result.integer("error_code");
  if (error == number_of(SkillCode::kOffField)) error = number_of(SkillCode::kInternal);
  if (step.action == "explore" && error == 0) {
    const pb::MessagePtr seen = context_.make("MachineReport");
    Fields report(*seen);
    report.set("team_color", to_string(identity_.team));
    this->report(result, report);
    channel_.send(*seen);
    const std::string wanted = upper(Fields(*task_).part("explore_machine").text("machine_id"));
    if (result.text("machine").empty() || (!wanted.empty() && result.text("machine") != wanted))
      error = number_of(SkillCode::kMachineNotFound);
  }
  if (error == number_of(SkillCode::kNoWorkpiece) && step.or_next && !cancels_) {
    steps_.pop_front();
    if (!paused_) next_step();
    return;
  }
  end(error, cancels_ && error != 0);
}

void RobotPeer::end(std::int64_t error, bool canceled) {
  under_way_ = cancels_ = paused_ = false;
  Fields task(*task_);
  answer(task, error, canceled);
  finished_.emplace_back(task.integer("task_id"), error == 0 && !canceled);
  if (finished_.size() > kFinishedTold) finished_.pop_front();
  if (!waiting_) return;
  const pb::MessagePtr next = std::move(waiting_);
  begin(*next);
}

void RobotPeer::answer(const Fields& task, std::int64_t error, bool canceled) {
  const bool done = error == 0 && !canceled;
  Fields(task).set("successful", done).set("canceled", canceled).set("error_code", error);
  channel_.send(task.message());
}

// --- What it says by itself

void RobotPeer::report(const bus::MessageView& seen, Fields& report) const {
  Fields entry = report.append("machines");
  entry.set("zone", seen.text("zone"));
  const std::string& machine = seen.text("machine");
  if (machine.empty()) return;
  entry.set("name", machine).set("type", kind_of(std::string_view(machine).substr(2)));
  entry.set("rotation", seen.integer("rotation"));
}

void RobotPeer::take_sightings(const bus::Delivery& delivery) {
  if (!channel_.is_heard()) return;
  const bus::MessageView sightings = delivery.message->view();
  const pb::MessagePtr message = context_.make("MachineReport");
  Fields seen(*message);
  seen.set("team_color", to_string(identity_.team));
  for (std::size_t i = 0; i < sightings.size("machines"); ++i) report(sightings.nested("machines", i), seen);
  channel_.send(*message);
}

void RobotPeer::speak() {
  if (!rate_.due(context_.now)) return;
  if (!channel_.is_heard()) return;
  if (task_ && !under_way_) channel_.send(*task_);
  const pb::MessagePtr message = context_.make("BeaconSignal");
  Fields beacon(*message);
  beacon.set("time", context_.moment())
      .set("seq", static_cast<std::int64_t>(++beacons_))
      .set("number", identity_.number);
  beacon.set("team_name", context_.team_name(identity_.team)).set("peer_name", identity_.name);
  beacon.set("team_color", to_string(identity_.team));
  const sim::Pose2 at = context_.world.robot(identity_.id).pose_in_world;
  beacon.part("pose").set("timestamp", context_.moment()).set("x", at.x).set("y", at.y).set("ori", at.yaw);
  if (under_way_) beacon.part("task").message().CopyFrom(*task_);
  for (const auto& [id, successful] : finished_)
    beacon.append("finished_tasks").set("TaskId", id).set("successful", successful);
  channel_.send(*message);
}

}  // namespace cxlab::rcll
