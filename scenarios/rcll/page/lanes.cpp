// Who did what when, and what it waited for.

#include <algorithm>
#include <map>

#include "scenarios/rcll/page/parts.h"
#include "scenarios/rcll/questions/waiting.h"

namespace cxlab::rcll {
namespace {

using BarShape = PageBar::Shape;

/// The tasks of workpieces, by their numbers.
std::map<int, std::string> tasks_by_piece(const GameStory& story, const std::vector<OrderWork>& works) {
  std::map<int, std::string> out;
  for (const OrderWork& work : works)
    for (const Attempt& attempt : work.attempts)
      out.emplace(attempt.piece->number, task_id(story, work.team, work.order.id));
  return out;
}

/// ", failed (code 3: no workpiece)".
std::string remark_of(const SkillRun& skill) {
  if (!skill.ended) return ", still at work";
  if (skill.code == 0) return {};
  return ", failed (code " + std::to_string(skill.code) + (skill.error.empty() ? "" : ": " + skill.error) + ')';
}

PageBar bar_of(const RobotStory& robot, const SkillRun& skill, const std::map<int, std::string>& tasks) {
  const bool failed = skill.ended && skill.code != 0;
  PageBar bar{failed ? BarShape::kAlert : BarShape::kBar,
              failed ? kFailedKind : skill.skill,
              begin_of(skill.when),
              end_of(skill.when),
              skill.skill + ' ' + skill.target,
              remark_of(skill)};
  for (const RobotStory::Hold& hold : robot.holds)
    if (const auto task = tasks.find(hold.piece); task != tasks.end() && !common(hold.when, skill.when).empty())
      bar.task = task->second;
  return bar;
}

/// A wait for something; else nobody had work for the robot, or the game stood.
bool is_for_something(const Waiting& wait) {
  static constexpr std::string_view kForNothing[]{"work", "agent", "pause", "set-up", "end"};
  return std::ranges::find(kForNothing, wait.what) == std::end(kForNothing);
}

PageBar bar_of(const RobotWait& wait) {
  const Waiting& one = wait.waiting;
  const bool waits = is_for_something(one);
  return {wait.in_skill ? BarShape::kInset : BarShape::kBar,
          waits ? kWaitsKind : kIdleKind,
          begin_of(one.when),
          end_of(one.when),
          one.what == "fault" ? "held up by a fault"
          : waits             ? "waits for " + one.what
                              : "idle",
          ": " + one.why};
}

PageLane lane_of(const GameStory& story, const RobotStory& robot, const std::map<int, std::string>& tasks) {
  PageLane lane{robot.name, {}, {}};
  for (const RobotStory::Hold& hold : robot.holds) {
    const PieceStory* piece = story.piece(hold.piece);
    const auto task = tasks.find(hold.piece);
    lane.bars.push_back({BarShape::kStrip,
                         kHoldsKind,
                         begin_of(hold.when),
                         end_of(hold.when),
                         "holds piece " + std::to_string(hold.piece) +
                             (piece && !piece->product.empty() ? " (" + product_text(piece->product) + ")" : ""),
                         {},
                         task == tasks.end() ? "" : task->second});
  }
  const std::vector<RobotWait> waits = waits_of(story, robot);
  for (const RobotWait& wait : waits)
    if (!wait.in_skill) lane.bars.push_back(bar_of(wait));
  // Failures last: what follows a short one must not hide it.
  for (const bool failures : {false, true})
    for (const SkillRun& skill : robot.skills)
      if ((skill.ended && skill.code != 0) == failures) lane.bars.push_back(bar_of(robot, skill, tasks));
  for (const RobotWait& wait : waits)
    if (wait.in_skill) lane.bars.push_back(bar_of(wait));
  for (const RobotStory::Away& away : robot.off_field)
    lane.bars.push_back({BarShape::kInset, kAwayKind, begin_of(away.when), end_of(away.when),
                         (away.for_good ? "disqualified (" : "maintenance (") + away.cause + ')'});
  for (const FaultStruck& fault : story.faults)
    if (fault.at == robot.name) lane.marks.push_back({kFaultKind, to_seconds(fault.t), fault.kind});
  return lane;
}

const char* kind_of_machine(std::string_view state) {
  if (state == "IDLE") return kIdleKind;
  if (state == "DOWN") return kDownKind;
  if (state == "BROKEN") return kBrokenKind;
  // What it made lies on its belt, and nobody has taken it.
  if (state == "PROCESSED" || state == "READY-AT-OUTPUT" || state == "WAIT-IDLE") return kBlockedKind;
  return kBusyKind;
}

/// ": RETRIEVE_CAP", ": order 5": what it was told; of one that is broken, why.
std::string remark_of(const MachineStory& machine, SimTime t, std::string_view kind) {
  if (kind == kBrokenKind) {
    const std::string why = value_at(machine.breaks, t, std::string());
    return why.empty() ? "" : ": " + why;
  }
  const InstructionHeard* told = kind == kIdleKind || kind == kDownKind ? nullptr : machine.instruction_at(t);
  if (!told) return {};
  std::string what;
  for (const std::string* word : {&told->operation, &told->base_color, &told->ring_color})
    if (!word->empty()) what += (what.empty() ? "" : " ") + *word;
  if (told->order) what += (what.empty() ? "order " : " order ") + std::to_string(*told->order);
  return what.empty() ? "" : ": " + what;
}

PageLane lane_of(const GameStory& story, const MachineStory& machine) {
  PageLane lane{machine.name, {}, {}};
  const auto add = [&](SimTime from, SimTime to, const std::string& state) {
    to = std::min(to, story.end);
    if (to <= from) return;
    const char* kind = kind_of_machine(state);
    PageBar bar{BarShape::kBar, kind, to_seconds(from), to_seconds(to), state, remark_of(machine, from, kind)};
    const InstructionHeard* told = kind == kBusyKind || kind == kBlockedKind ? machine.instruction_at(from) : nullptr;
    if (told && told->order) bar.task = task_id(story, machine.team, *told->order);
    lane.bars.push_back(std::move(bar));
  };
  SimTime from{};
  std::string state = machine.state_at({});
  for (const auto& [t, next] : machine.states) {
    add(from, t, state);
    from = t;
    state = next;
  }
  add(from, story.end, state);
  for (const FaultStruck& fault : story.faults)
    if (fault.at == machine.name) lane.marks.push_back({kFaultKind, to_seconds(fault.t), fault.kind});
  return lane;
}

template <class Kind>
bool has_bar(const PageLanes& lanes, const Kind& kind) {
  for (const PageLane& lane : lanes.lanes)
    if (std::ranges::find(lane.bars, kind, &PageBar::kind) != lane.bars.end()) return true;
  return false;
}

/// Adds the candidates that the lanes show.
void add_key(PageLanes& lanes, std::initializer_list<PageLanes::Key> candidates) {
  for (const PageLanes::Key& one : candidates)
    if (has_bar(lanes, one.kind)) lanes.key.push_back(one);
  const bool faults = std::ranges::any_of(lanes.lanes, [](const PageLane& lane) { return !lane.marks.empty(); });
  if (faults) lanes.key.push_back({"", "a fault"});
}

}  // namespace

PageLanes robot_lanes(const GameStory& story, const std::vector<OrderWork>& works) {
  PageLanes out{"Robots", {}, {}};
  const std::map<int, std::string> tasks = tasks_by_piece(story, works);
  for (const RobotStory& robot : story.robots) out.lanes.push_back(lane_of(story, robot, tasks));
  add_key(out, {{"drive_to", "drives"},
                {"pick", "picks"},
                {"place", "places"},
                {"discard", "discards"},
                {"explore", "explores"},
                {"transport", "transports"},
                {kFailedKind, "failed"},
                {kWaitsKind, "waits"},
                {kIdleKind, "idle"},
                {kHoldsKind, "holds a piece"},
                {kAwayKind, "off the field"}});
  if (!story.pauses.empty()) out.key.push_back({kPauseKind, "the game is paused"});
  return out;
}

PageLanes machine_lanes(const GameStory& story) {
  PageLanes out{"Machines", {}, {}};
  for (const MachineStory& machine : story.machines) out.lanes.push_back(lane_of(story, machine));
  add_key(out, {{kIdleKind, "idle"},
                {kBusyKind, "busy"},
                {kBlockedKind, "blocked by what it made"},
                {kDownKind, "down"},
                {kBrokenKind, "broken"}});
  return out;
}

}  // namespace cxlab::rcll
