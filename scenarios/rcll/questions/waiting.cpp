#include "scenarios/rcll/questions/waiting.h"

#include <algorithm>
#include <set>

namespace cxlab::rcll {

namespace {

/// Times within the stretch at which a reason may change.
class Cuts {
 public:
  explicit Cuts(const Interval& whole) : whole_(whole) {
    at_.insert(whole.from);
    at_.insert(whole.to);
  }
  void at(SimTime t) {
    if (whole_.from < t && t < whole_.to) at_.insert(t);
  }
  void at(const Interval& interval) {
    at(interval.from);
    at(interval.to);
  }
  template <class Values>
  void at_all(const Values& values) {
    for (const auto& one : values) at(one.t);
  }
  std::vector<Interval> parts() const {
    std::vector<Interval> out;
    for (auto i = at_.begin(), next = std::next(i); next != at_.end(); ++i, ++next) out.push_back({*i, *next});
    return out;
  }

 private:
  Interval whole_;
  std::set<SimTime> at_;
};

/// What the game does to everybody; else nothing.
std::optional<Waiting> of_the_game(const GameStory& story, const Interval& when) {
  for (const Interval& pause : story.pauses)
    if (pause.from <= when.from && when.from < pause.to) return Waiting{when, "pause", "the game was paused"};
  const Phase phase = story.clock.phase(when.from);
  if (phase == Phase::kSetup) return Waiting{when, "set-up", "production had not begun"};
  if (phase == Phase::kPostGame) return Waiting{when, "end", "the game was over"};
  return std::nullopt;
}

void cut_at_phases(const GameStory& story, Cuts& cuts) {
  for (const Interval& pause : story.pauses) cuts.at(pause);
  cuts.at(story.clock.when(0));
  cuts.at(story.clock.when(to_seconds(story.clock.game.production_end - story.clock.game.production_begin)));
}

int price_of(const GameStory& story, const std::string& part) {
  const auto colour = named<RingColor>(part);
  return colour ? story.game.schedule.price(*colour) : 0;
}

Waiting reason_at(const GameStory& story, const Interval& when, const Needed& needed) {
  if (auto game = of_the_game(story, when)) return *std::move(game);
  if (!needed.machine) return {when, needed.otherwise.what, needed.otherwise.why};
  const MachineStory& machine = *needed.machine;
  const SimTime t = when.from;
  const std::string state = machine.state_at(t);
  if (state == "DOWN" || state == "BROKEN") return {when, machine.name, machine.name + " was " + state};
  if (needed.take ? state != "READY-AT-OUTPUT" : state != "IDLE" && state != "PREPARED")
    return {when, machine.name,
            state == "IDLE" ? machine.name + " had nothing to hand out" : machine.name + " was " + state};
  if (needed.on_belt && state == "PREPARED") return {when, "belt", machine.name + " drew it in"};
  if (!needed.take) {
    if (needed.order && needed.part == "delivery" && story.clock.production(t) < needed.order->delivery_begin)
      return {when, "window",
              "the window of order " + std::to_string(needed.order->id) + " begins at " +
                  time_text(needed.order->delivery_begin)};
    if (machine.kind == "RS" && value_at(machine.payments, t, 0) < price_of(story, needed.part))
      return {when, machine.name, machine.name + " had too few payments for " + needed.part};
    if (machine.kind == "CS" && needed.part.starts_with("CAP_") && !value_at(machine.cap, t, false))
      return {when, machine.name, machine.name + " had no cap"};
  }
  const auto others = story.robots_at(machine, t, needed.robot);
  if (!needed.robot.empty() && !others.empty())
    return {when, others.front()->name, others.front()->name + " was on its way to " + machine.name + " or at it"};
  return {when, needed.otherwise.what, needed.otherwise.why};
}

/// What the decision of an agent says of a robot that does nothing.
Waiting without_work(const GameStory& story, const RobotStory& robot, const Interval& when, SimTime since) {
  constexpr SimTime kReaction = std::chrono::seconds(1);
  const Decision* last = nullptr;
  for (const Decision& decision : story.decisions)
    if (decision.t <= when.from && decision.t + kReaction >= since && decision.names(robot.name)) last = &decision;
  return {when, "work", last ? "the agent decided " + last->text() : "no decision of the agent says why"};
}

void join_or_add(std::vector<Waiting>& out, Waiting next) {
  if (!out.empty() && out.back().when.to == next.when.from && same_reason(out.back(), next))
    out.back().when.to = next.when.to;
  else
    out.push_back(std::move(next));
}

/// The machine that the next skill of a robot without a skill works at, if the robot needs it now: it holds a piece for
/// it, or stands before it.
Needed next_need(const GameStory& story, const RobotStory& robot, const SkillRun* before, const SkillRun* next,
                 SimTime t) {
  Needed needed;
  needed.robot = robot.name;
  if (!next || next->spots.empty()) return needed;
  const RobotStory::Hold* hold = robot.hold_at(t);
  const std::string& spot = hold ? next->spots.back() : next->spots.front();
  const MachineStory* machine = story.machine_at(spot);
  const bool stands_there = before && !before->spots.empty() && story.machine_at(before->spots.back()) == machine;
  if (!machine || !(hold || stands_there)) return needed;
  needed.machine = machine;
  needed.take = !hold;
  if (!hold && !spot.ends_with("-OUTPUT")) needed.machine = nullptr;
  if (!hold || spot.ends_with("-SLIDE")) return needed;
  // What the machine did with the piece tells what it was brought for.
  const PieceStory* piece = story.piece(hold->piece);
  for (const auto& [done, work] : piece->works)
    if (done > t && work.machine == machine->name && work.kind == WorkDone::Kind::kMounted) {
      needed.part = work.product.substr(work.product.rfind(' ') + 1);
      break;
    }
  if (machine->kind != "DS" || !piece->delivery) return needed;
  needed.part = "delivery";
  for (const Order& order : story.game.schedule.orders)
    if (order.id == piece->delivery->value.order) needed.order = &order;
  return needed;
}

/// The machine that the last decision about the robot sends it to, if its next skill goes there, or there is none.
Needed decided_need(const GameStory& story, const RobotStory& robot, const SkillRun* next, const Interval& idle) {
  Needed needed;
  needed.robot = robot.name;
  needed.take = true;
  const Decision* last = story.last_decision_about(robot.name, idle.from);
  if (!last || last->t + std::chrono::seconds(1) < idle.from) return needed;
  for (const MachineStory& machine : story.machines) {
    const std::string output = machine.name + "-OUTPUT";
    if (last->names(output) && (!next || (!next->spots.empty() && next->spots.front() == output)))
      needed.machine = &machine;
  }
  return needed;
}

void add_idle(const GameStory& story, const RobotStory& robot, const Interval& idle, std::vector<RobotWait>& out) {
  const SkillRun *before = nullptr, *next = nullptr;
  for (const SkillRun& skill : robot.skills) {
    if (skill.when.to <= idle.from) before = &skill;
    if (skill.when.from >= idle.to && !next) next = &skill;
  }
  std::vector<Waiting> parts;
  Needed needed = next_need(story, robot, before, next, idle.from);
  const bool holds = robot.hold_at(idle.from) != nullptr;
  if (!needed.machine && holds && !next) needed.machine = destination_of(story, robot, idle.from);
  if (!needed.machine && !holds) needed = decided_need(story, robot, next, idle);
  if (needed.machine || holds) {
    parts = reasons_for(story, idle, needed);
  } else {
    Cuts cuts(idle);
    cut_at_phases(story, cuts);
    for (const Interval& part : cuts.parts()) {
      auto game = of_the_game(story, part);
      join_or_add(parts, game ? *std::move(game) : without_work(story, robot, part, idle.from));
    }
  }
  for (Waiting& part : parts) out.push_back({std::move(part), false});
}

/// The fault of the scenario that has the robot stand at that time, if any.
const FaultStruck* standing_fault(const GameStory& story, const RobotStory& robot, SimTime t) {
  static constexpr std::string_view kStands[]{"skill_stalls", "robot_halts", "goal_lost"};
  for (const FaultStruck& fault : story.faults)
    if (fault.at == robot.name && std::ranges::find(kStands, fault.kind) != std::end(kStands) && fault.t <= t &&
        t <= fault.until)
      return &fault;
  return nullptr;
}

/// The parts of a skill in which it stood.
void add_standing(const GameStory& story, const RobotStory& robot, const SkillRun& skill, std::vector<RobotWait>& out) {
  for (const Interval& pause : story.pauses)
    if (const Interval when = common(common(pause, skill.when), story.asked()); !when.empty())
      out.push_back({{when, "pause", "the game was paused"}, true});
  for (const SkillRun::PhaseOf& phase : skill.phases) {
    const Interval when = common(phase.when, story.asked());
    if (when.empty()) continue;
    if (phase.name == "wait") {
      const std::string doing = skill.skill + ' ' + skill.target;
      const FaultStruck* fault = phase.waits_for.empty() ? standing_fault(story, robot, phase.when.from) : nullptr;
      const std::string what = fault ? "fault" : phase.waits_for.empty() ? "way" : phase.waits_for;
      const std::string why = fault ? "the fault " + fault->kind + " held up its "
                                    : (what == "way" ? "another robot" : what) + " was in the way of its ";
      for (const Interval& part : without(when, story.pauses)) out.push_back({{part, what, why + doing}, true});
      continue;
    }
    // A pick looks, or handles, from before its piece has come.
    if ((phase.name != "look" && phase.name != "handle") || skill.spots.empty() || robot.hold_at(when.from)) continue;
    const std::string& spot = skill.spots.front();
    const MachineStory* machine = story.machine_at(spot);
    if ((skill.skill != "pick" && skill.skill != "transport") || !machine || !spot.ends_with("-OUTPUT")) continue;
    const auto ready = machine->first("READY-AT-OUTPUT", when);
    if (machine->state_at(when.from) == "READY-AT-OUTPUT") continue;
    const Interval until{when.from, ready.value_or(when.to)};
    if (until.empty() || !ready) continue;
    Needed needed;
    needed.machine = machine;
    needed.take = true;
    needed.robot = robot.name;
    for (Waiting& part : reasons_for(story, until, needed))
      if (part.what != "pause") out.push_back({std::move(part), true});
  }
}

}  // namespace

std::vector<Waiting> reasons_for(const GameStory& story, const Interval& when, const Needed& needed) {
  Cuts cuts(when);
  cut_at_phases(story, cuts);
  if (needed.machine) {
    cuts.at_all(needed.machine->states);
    cuts.at_all(needed.machine->payments);
    cuts.at_all(needed.machine->cap);
  }
  if (needed.order) cuts.at(story.clock.when(needed.order->delivery_begin));
  for (const RobotStory& robot : story.robots) {
    for (const SkillRun& skill : robot.skills) cuts.at(skill.when);
    for (const RobotStory::Hold& hold : robot.holds) cuts.at(hold.when);
  }
  std::vector<Waiting> out;
  for (const Interval& part : cuts.parts()) join_or_add(out, reason_at(story, part, needed));
  return out;
}

const MachineStory* destination_of(const GameStory& story, const RobotStory& robot, SimTime t) {
  const Decision* last = story.last_decision_about(robot.name, t);
  for (const MachineStory& machine : story.machines)
    if (last && machine.kind != "BS" && last->names(machine.name + "-INPUT")) return &machine;  // BS hands out there
  return nullptr;
}

void add_to(std::vector<Waiting>& sums, const Waiting& waiting) {
  for (Waiting& sum : sums)
    if (same_reason(sum, waiting)) {
      sum.when.to += waiting.when.length();
      return;
    }
  sums.push_back({{SimTime{}, waiting.when.length()}, waiting.what, waiting.why});
}

std::string sums_text(std::vector<Waiting> sums, std::size_t most) {
  std::ranges::stable_sort(sums, std::greater(), [](const Waiting& sum) { return sum.when.length(); });
  static constexpr SimTime kCounts = std::chrono::milliseconds(500);
  std::erase_if(sums, [](const Waiting& sum) { return sum.when.length() < kCounts; });
  std::string out;
  for (std::size_t i = 0; i < std::min(most, sums.size()); ++i)
    out += (i ? "; " : "") + length_text(sums[i].when.length()) + ": " + sums[i].why;
  return out;
}

std::vector<RobotWait> waits_of(const GameStory& story, const RobotStory& robot) {
  std::vector<RobotWait> out;
  std::vector<Interval> busy;
  for (const SkillRun& skill : robot.skills) busy.push_back(skill.when);
  for (const RobotStory::Away& away : robot.off_field) busy.push_back(away.when);
  std::ranges::sort(busy, {}, &Interval::from);
  for (const Interval& idle : without(story.asked(), busy)) add_idle(story, robot, idle, out);
  for (const SkillRun& skill : robot.skills) add_standing(story, robot, skill, out);
  std::ranges::stable_sort(out, {}, [](const RobotWait& wait) { return wait.waiting.when.from; });
  return out;
}

}  // namespace cxlab::rcll
