#include "sim/skills/skill_server.h"

#include <cmath>
#include <utility>
#include <vector>

#include "cx/base/number_text.h"
#include "cx/bus/needed.h"

namespace cxlab::sim {

SkillServer::SkillServer(RobotId robot, const FloorPlan& plan, const Places& places, RobotSkills& skills, bus::Bus& bus,
                         RecordSink& sink)
    : name_(plan.robots[static_cast<std::size_t>(robot)].name),
      plan_(plan),
      places_(places),
      skills_(skills),
      bus_(bus),
      sink_(sink) {
  stats_.name = name_;
  stream_ = sink.open_stream("node/" + name_);
  node_ = bus.join(bus::ParticipantKind::kNode, bus::NodeName{name_, "/", {}}, stream_);
}

Expected<std::unique_ptr<SkillServer>> SkillServer::create(RobotId robot, const FloorPlan& plan, const Places& places,
                                                           RobotSkills& skills, bus::Bus& bus, RecordSink& sink) {
  std::unique_ptr<SkillServer> server(new SkillServer(robot, plan, places, skills, bus, sink));
  for (const SkillWord& skill : skill_words())
    if (Status s = server->open(skill); !s) return s.error();
  return server;
}

Status SkillServer::open(const SkillWord& skill) {
  auto known = bus::needed_action(bus_.registry(), std::string(skill.type));
  if (!known) return known.error();
  Action& action = actions_.emplace_back();
  action.kind = skill.kind;
  action.type = *known;
  auto endpoint = bus_.serve_action(node_, "/" + name_ + "/" + std::string(skill.name), **known,
                                    {[this, &action](const bus::Delivery& d) { take_goal(action, d); },
                                     [this, &action](const bus::Delivery& d) { take_cancel(action, d); }});
  if (!endpoint) return endpoint.error();
  action.endpoint = *endpoint;
  return {};
}

void SkillServer::record(const Action& action, const std::string& target, std::string_view event) {
  data_.begin()
      .field("robot", name_)
      .field("skill", to_string(action.kind))
      .field("target", target)
      .field("event", event);
}

// --- Goals

std::string SkillServer::target_of(const Action& action, const bus::MessageView& goal) {
  if (action.kind == SkillKind::kTransport) return goal.text("from") + " to " + goal.text("to");
  return goal.text("target");
}

std::string_view SkillServer::sub_action() const {
  const bool drives = active_->phase == SkillPhase::kDrive || active_->phase == SkillPhase::kWait;
  if (skills_.part() == SkillKind::kPlace) return drives ? "drive_to" : "place";
  return drives ? "drive_from" : "pick";
}

Expected<SkillGoal> SkillServer::read_goal(const Action& action, const bus::MessageView& message) const {
  SkillGoal goal{action.kind, target_of(action, message), std::nullopt, {}, {}};
  const auto unknown = [&](const std::string& name, const std::string& expected, bool spots, bool places) {
    std::vector<std::string> names;
    if (spots)
      for (const Spot& spot : plan_.spots) names.push_back(spot.name);
    if (places)
      for (const auto& [place, unused] : places_) names.push_back(place);
    return "'" + name + "' is not " + expected + did_you_mean(name, names, "; ");
  };

  if (action.kind == SkillKind::kTransport) {
    for (const char* end : {"from", "to"}) {
      const std::string name = message.text(end);
      const auto spot = plan_.find_spot(name);
      if (!spot) return input_error(std::string(end) + ": " + unknown(name, "a spot of a machine", true, false));
      (goal.spot ? goal.to : goal.spot) = spot;
    }
    goal.pose = plan_.spot(*goal.spot).align_in_world;
    return goal;
  }
  const auto place = places_.find(goal.target);
  if (action.kind == SkillKind::kExplore) {
    if (place == places_.end()) return input_error(unknown(goal.target, "a zone", false, true));
    goal.pose = {place->second.middle.x(), place->second.middle.y(), 0};
    return goal;
  }
  if (goal.spot = plan_.find_spot(goal.target); goal.spot) {
    goal.pose = plan_.spot(*goal.spot).align_in_world;
    if (const bus::Field* wait = message.type().find("wait_s"); wait && action.kind == SkillKind::kPick) {
      const double seconds = message.real(*wait), longest = to_seconds(kLongestWait);
      if (!(seconds >= 0 && seconds <= longest))
        return input_error("wait_s: " + found_expected(shortest_text(seconds), "0 to " + shortest_text(longest)));
      goal.wait = from_seconds(seconds);
    }
    return goal;
  }
  const bool by_place = action.kind == SkillKind::kDriveTo || action.kind == SkillKind::kDiscard;
  if (!by_place) return input_error(unknown(goal.target, "a spot of a machine", true, false));
  if (place != places_.end()) {
    goal.pose = place->second.stand;
    return goal;
  }
  if (!goal.target.empty()) return input_error(unknown(goal.target, "a spot of a machine or a place", true, true));
  if (action.kind == SkillKind::kDiscard) return goal;
  const bus::MessageView pose = message.nested("pose");
  goal.pose = {pose.real("x"), pose.real("y"), pose.real("theta")};
  if (!std::isfinite(goal.pose.x) || !std::isfinite(goal.pose.y) || !std::isfinite(goal.pose.yaw))
    return input_error("the pose is not finite");
  goal.pose.yaw = wrap_angle(goal.pose.yaw);
  return goal;
}

const Station* SkillServer::unknown_station(const SkillGoal& goal) const {
  if (!knows_) return nullptr;
  for (const std::optional<SpotId>& spot : {goal.spot, goal.to})
    if (spot && !knows_(plan_.spot(*spot).station)) return &plan_.station(plan_.spot(*spot).station);
  return nullptr;
}

void SkillServer::take_goal(const Action& action, const bus::Delivery& delivery) {
  const bus::MessageView message = delivery.message->view();
  if (active_) {
    record(action, target_of(action, message), "refused");
    data_.field("reason", "busy with " + std::string(to_string(active_->skill.kind)) + " " + active_->skill.target);
    sink_.write(stream_, now_, RecordKind::kSkill, data_, {&delivery.cause, 1});
    bus_.answer_goal(action.endpoint, delivery.goal, bus::GoalAnswer::kReject);
    return;
  }
  bus_.answer_goal(action.endpoint, delivery.goal, bus::GoalAnswer::kAccept);
  auto goal = read_goal(action, message);
  ++stats_.skills;
  record(action, target_of(action, message), "start");
  sink_.write(stream_, now_, RecordKind::kSkill, data_, {&delivery.cause, 1});
  active_ = Active{};
  active_->action = &action;
  active_->goal = delivery.goal;
  active_->since = active_->phase_since = now_;
  active_->skill.target = target_of(action, message);
  if (off_field_) return finish(SkillResult::of(SkillCode::kOffField));
  if (!goal) return finish({SkillCode::kInvalidTarget, false, goal.error().message, {}});
  if (const Station* station = unknown_station(*goal))
    return finish(
        {SkillCode::kMachineNotFound,
         false,
         "nobody knows yet where " + station->name + " stands: its marker was not read, and it is not reported",
         {}});
  active_->skill = *goal;
  note_doing();
  skills_.start(*goal, now_);
}

void SkillServer::take_cancel(const Action& action, const bus::Delivery& delivery) {
  const bool ours = active_ && active_->action == &action && active_->goal == delivery.goal;
  bus_.answer_cancel(action.endpoint, delivery, ours);
  if (!ours || active_->cancelling) return;
  active_->cancelling = true;
  skills_.cancel(now_);
}

void SkillServer::set_off_field(bool off, SimTime now) {
  now_ = now;
  off_field_ = off;
  skills_.abandon(now);
  if (active_) finish(SkillResult::of(SkillCode::kOffField));
  note_doing();
}

void SkillServer::take(SimTime now) {
  now_ = now;
  if (bus_.has_waiting(node_)) bus_.deliver(node_);
  if (!active_ || active_->cancelling || bus_.is_there(node_)) return;
  active_->cancelling = true;  // the node was stopped: the robot does not drive on
  skills_.cancel(now);
}

// --- Feedback and result

void SkillServer::count_phase(SimTime now, RobotStats& stats) const {
  const double duration = to_seconds(now - active_->phase_since);
  if (active_->phase == SkillPhase::kDrive) stats.drive_s += duration;
  if (active_->phase == SkillPhase::kWait) stats.wait_s += duration;
}

void SkillServer::note_doing() {
  constexpr std::size_t kMostOfATarget = 80;
  if (!active_) {
    doing_ = off_field_ ? "off-field" : "idle";
    return;
  }
  doing_ = to_string(active_->action->kind);
  (doing_ += ' ') += to_string(active_->phase.value_or(SkillPhase::kWait));
  if (active_->waits_for) (doing_ += " for ") += plan_.robot(*active_->waits_for).name;
  if (const std::string& target = active_->skill.target; !target.empty())
    (doing_ += ' ') += target.substr(0, kMostOfATarget);
}

void SkillServer::report_phase(SimTime now) {
  if (!active_) return;
  const SkillPhase phase = skills_.phase();
  const auto waits_for = phase == SkillPhase::kWait ? skills_.waits_for(now) : std::nullopt;
  const bool is_new = active_->phase != phase;
  if (!is_new && active_->waits_for == waits_for) return;
  count_phase(now, stats_);
  active_->phase_since = now;
  active_->phase = phase;
  active_->waits_for = waits_for;
  note_doing();
  const Action& action = *active_->action;
  record(action, active_->skill.target, "phase");
  data_.field("phase", to_string(phase));
  if (waits_for) data_.field("for", plan_.robot(*waits_for).name);
  sink_.write(stream_, now, RecordKind::kSkill, data_);
  if (!is_new) return;
  auto feedback = std::make_shared<bus::Message>(*action.type->feedback);
  feedback->view().set("phase", to_string(phase)).set("remaining_m", skills_.remaining(now));
  if (action.kind == SkillKind::kTransport) feedback->view().set("sub_action", sub_action());
  bus_.publish_feedback(action.endpoint, active_->goal, std::move(feedback));
}

void SkillServer::sense(SimTime now) {
  now_ = now;
  const auto result = skills_.sense(now);
  if (result && active_)
    finish(*result);
  else
    report_phase(now);
}

void SkillServer::finish(const SkillResult& result) {
  count_phase(now_, stats_);
  const std::string in(sub_action());
  const Active ended = *std::exchange(active_, std::nullopt);
  note_doing();
  const Action& action = *ended.action;
  const double duration = to_seconds(now_ - ended.since);
  stats_.busy_s += duration;
  const bool done = result.code == SkillCode::kNone && !result.cancelled;
  if (result.code != SkillCode::kNone) ++stats_.failures;
  record(action, ended.skill.target, "end");
  data_.field("code", static_cast<int>(result.code))
      .field("error", result.text)
      .field("cancelled", result.cancelled)
      .field("duration_s", duration);
  sink_.write(stream_, now_, RecordKind::kSkill, data_);
  auto message = std::make_shared<bus::Message>(*action.type->result);
  message->view()
      .set("success", done)
      .set("error_code", static_cast<int>(result.code))
      .set("error", result.text)
      .set("target", ended.skill.target);
  if (action.kind == SkillKind::kTransport && !done && result.code != SkillCode::kInvalidTarget &&
      result.code != SkillCode::kMachineNotFound)
    message->view().set("sub_action", in);
  if (action.kind == SkillKind::kExplore && done) {
    const Station* seen = result.seen ? &plan_.station(*result.seen) : nullptr;
    message->view()
        .set("zone", ended.skill.target)
        .set("machine", seen ? seen->name : "")
        .set("rotation", seen ? whole_degrees(seen->pose_in_world.yaw) : -1);
  }
  const bus::GoalStatus status = done               ? bus::GoalStatus::kSucceeded
                                 : result.cancelled ? bus::GoalStatus::kCanceled
                                                    : bus::GoalStatus::kAborted;
  bus_.finish(action.endpoint, ended.goal, status, std::move(message));
}

RobotStats SkillServer::stats(SimTime now) const {
  RobotStats stats = stats_;
  if (active_) {
    stats.busy_s += to_seconds(now - active_->since);
    count_phase(now, stats);
  }
  return stats;
}

}  // namespace cxlab::sim
