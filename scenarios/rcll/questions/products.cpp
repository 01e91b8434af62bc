#include "scenarios/rcll/questions/products.h"

#include <algorithm>
#include <array>

namespace cxlab::rcll {

namespace {

/// What a robot was doing with a piece until it left the gripper.
const SkillRun* skill_before(const RobotStory& robot, SimTime t) {
  const SkillRun* out = nullptr;
  for (const SkillRun& skill : robot.skills)
    if (skill.when.from < t) out = &skill;
  return out;
}

std::string lost_from_gripper(const GameStory& story, const PieceMoved& last, SimTime t) {
  const RobotStory* robot = story.robot(last.from_name);
  const SkillRun* skill = robot ? skill_before(*robot, t) : nullptr;
  if (skill && skill->skill == "discard" && skill->when.to >= t) return "thrown away by " + last.from_name;
  return "dropped by " + last.from_name;
}

Fate of_last_move(const GameStory& story, SimTime t, const PieceMoved& last) {
  using Kind = Fate::Kind;
  if (last.to == "slide") return {Kind::kPayment, t, "payment on " + last.to_name};
  if (last.to == "floor")
    return {Kind::kDropped, t,
            last.from == "gripper" ? lost_from_gripper(story, last, t) : "fell off " + last.from_name};
  if (last.to == "crew")
    return {Kind::kTaken, t,
            last.from == "gripper" ? "taken away with " + last.from_name + ", which left the field"
                                   : "taken off " + last.from_name + " by people"};
  if (last.to == "storage") return {Kind::kStored, t, "stored in " + last.to_name};
  if (last.to == "gripper") return {Kind::kInPlay, t, "in the gripper of " + last.to_name};
  if (last.to == "gate") return {Kind::kInPlay, t, "at the gate of " + last.to_name};
  return {Kind::kInPlay, t, "on " + last.to_name};
}

/// The part that the product got last.
std::string last_part(const std::string& product) { return product.substr(product.rfind(' ') + 1); }

void begin_and_end(const GameStory& story, Visit& visit, SimTime until) {
  const MachineStory& machine = *visit.machine;
  if (machine.kind == "BS") {  // it works before the piece is there
    for (const auto& [t, state] : machine.states)
      if (state == "PROCESSING" && t <= visit.arrived) visit.began = t;
    visit.done = visit.arrived;
    return;
  }
  const Interval there{visit.arrived, visit.done.value_or(std::min(until, story.end))};
  for (const auto& [t, state] : machine.states)
    if (state == "PROCESSING" && t >= there.from && t <= there.to) visit.began = t;
}

/// Whether it brings a workpiece to a slide.
bool pays(const SkillRun& skill) { return !skill.spots.empty() && skill.spots.back().ends_with("-SLIDE"); }
bool pays(const GameStory& story, const Decision& decision) {
  return std::ranges::any_of(story.machines,
                             [&](const MachineStory& machine) { return decision.names(machine.name + "-SLIDE"); });
}

/// The last decision about the robot up to that time, if it sends the robot to that machine.
const Decision* sent_to(const GameStory& story, const RobotStory& robot, const std::string& machine, SimTime t) {
  const Decision* last = story.last_decision_about(robot.name, t);
  const bool there = last && (last->names(machine + "-OUTPUT") || last->names(machine + "-INPUT"));
  return there ? last : nullptr;
}

/// Whether a robot will bring a workpiece, which still lies where it came from, to a slide, as far as the robots'
/// decisions tell.
bool will_be_payment(const GameStory& story, const PieceStory& piece) {
  const Decision* first = nullptr;
  for (const RobotStory& robot : story.robots) {
    if (robot.hold_at(story.end)) continue;
    const SkillRun* skill = robot.skills.empty() ? nullptr : &robot.skills.back();
    if (skill && !skill->ended && !skill->spots.empty() &&
        story.machine_at(skill->spots.front()) == story.machine(piece.origin))
      return pays(*skill);
    const Decision* decision = sent_to(story, robot, piece.origin, story.end);
    const bool fetched = decision && std::ranges::any_of(robot.holds, [&](const RobotStory::Hold& hold) {
                           return hold.when.from >= decision->t;
                         });
    if (decision && !fetched && (!first || decision->t < first->t)) first = decision;
  }
  return first && pays(story, *first);
}

/// A workpiece that pays for rings, or is on its way to. One that a machine took in is none, whatever was decided
/// before.
bool is_payment(const GameStory& story, const PieceStory& piece, const Fate& fate) {
  if (fate.kind == Fate::Kind::kPayment) return true;
  const auto put_on_belt = [](const auto& one) { return one.value.from == "gripper" && one.value.to == "belt"; };
  if (!piece.works.empty() || std::ranges::any_of(piece.moves, put_on_belt)) return false;
  bool was_held = false;
  for (const RobotStory& robot : story.robots)
    for (const RobotStory::Hold& hold : robot.holds) {
      if (hold.piece != piece.number) continue;
      was_held = true;
      for (const SkillRun& skill : robot.skills)
        if (pays(skill) && !common(skill.when, hold.when).empty()) return true;
      const Decision* decision = sent_to(story, robot, piece.origin, hold.when.from);
      if (decision && pays(story, *decision)) return true;
    }
  return !was_held && !fate.is_over() && will_be_payment(story, piece);
}

/// Adds the waits of the product from one machine to the next, which has to do what is `wanted`. `until` is the end of
/// its known story if it did not get there.
void add_waits_between(const GameStory& story, const Visit& at, const Visit* next, const std::string& wanted,
                       const Order& order, SimTime until, std::vector<Waiting>& out) {
  if (!at.done) return;
  const SimTime ready = at.machine->first("READY-AT-OUTPUT", {*at.done, until}).value_or(*at.done);
  const SimTime left = at.left.value_or(until);
  Needed needed;
  needed.part = wanted;
  needed.order = &order;
  needed.robot = at.left_with;
  needed.machine = next ? next->machine : nullptr;
  if (needed.machine == at.machine) needed.machine = nullptr;  // which cannot be free before the product has left it
  const RobotStory* robot = story.robot(at.left_with);
  std::vector<Interval> at_work;
  if (robot)
    for (const SkillRun& skill : robot->skills)
      if (!skill.spots.empty() && story.machine_at(skill.spots.front()) == at.machine) at_work.push_back(skill.when);
  needed.otherwise = {{}, "robot", "no robot had come for it to " + at.machine->name};
  for (const Interval& wait : without({ready, left}, at_work))
    for (Waiting& part : reasons_for(story, wait, needed)) out.push_back(std::move(part));
  if (!robot || !at.left) return;
  needed.machine = next ? next->machine : destination_of(story, *robot, *at.left);
  std::vector<Interval> busy;
  for (const SkillRun& skill : robot->skills) busy.push_back(skill.when);
  needed.otherwise = {{}, "agent", robot->name + ", which held it, had no command"};
  for (const Interval& wait : without({*at.left, next ? next->arrived : until}, busy))
    for (Waiting& part : reasons_for(story, wait, needed)) out.push_back(std::move(part));
}

/// Adds what it waited for on the machine.
void add_waits_at(const GameStory& story, const Visit& at, const Order& order, SimTime until,
                  std::vector<Waiting>& out) {
  if (at.machine->kind == "BS") return;
  Needed needed;
  needed.machine = at.machine;
  needed.part = at.part;
  needed.order = &order;
  needed.on_belt = true;
  const std::string machine = at.machine->name;
  needed.otherwise = {{}, "agent", machine + " had no instruction"};
  for (Waiting& part : reasons_for(story, {at.arrived, at.began.value_or(until)}, needed))
    if (part.what != "belt") out.push_back(std::move(part));
  if (!at.began) return;
  for (Waiting& part : reasons_for(story, {*at.began, at.done.value_or(until)}, needed))
    if (part.why == machine + " was DOWN" || part.why == machine + " was BROKEN" || part.what == "pause")
      out.push_back(std::move(part));
}

Attempt attempt_of(const GameStory& story, const PieceStory& piece, const Order& order) {
  Attempt out{&piece, fate_of(story, piece), visits_of(story, piece, &order), {}};
  const SimTime until = out.fate.is_over() ? out.fate.t : story.end;
  for (std::size_t i = 0; i < out.visits.size(); ++i) {
    const Visit* next = i + 1 < out.visits.size() ? &out.visits[i + 1] : nullptr;
    add_waits_at(story, out.visits[i], order, out.visits[i].left.value_or(until), out.waits);
    const bool there = out.visits[i].machine->kind == "DS" || out.fate.kind == Fate::Kind::kStored;
    const std::string wanted = next ? next->part : next_part(piece.product, order);
    if (next || !there) add_waits_between(story, out.visits[i], next, wanted, order, until, out.waits);
  }
  std::erase_if(out.waits, [](const Waiting& wait) { return wait.when.empty() || wait.what == "end"; });
  std::ranges::stable_sort(out.waits, {}, [](const Waiting& wait) { return wait.when.from; });
  return out;
}

bool begins(const Decision& decision) {
  return !decision.slots.empty() && decision.slots.front().starts_with("begin") &&
         decision.slots.front().find("wait") == std::string::npos;
}

/// The order whose product such a piece may be; nullptr where the records leave more than one, or none.
OrderWork* order_of(const GameStory& story, const PieceStory& piece, const Fate& fate, std::vector<OrderWork>& works) {
  const MachineStory* origin = story.machine(piece.origin);
  std::vector<OrderWork*> fitting;
  for (OrderWork& work : works) {
    const int before = static_cast<int>(std::ranges::count_if(
        work.deliveries, [&](const auto& one) { return one.value.correct && one.t <= piece.begin(); }));
    // One that is still on its way may be delivered yet; two at once for one product are not made.
    const auto under_way = std::ranges::count_if(work.attempts, [&](const Attempt& other) {
      return other.piece->begin() < (fate.is_over() ? fate.t : story.end) &&
             (!other.fate.is_over() || other.fate.t > piece.begin());
    });
    if (!origin || work.team != origin->team || !could_become(piece.product, work.order)) continue;
    const auto released = story.published.find(work.order.id);
    if (released == story.published.end() || released->second > piece.begin() ||
        before + under_way >= work.order.quantity)
      continue;
    fitting.push_back(&work);
  }
  // A decision to begin an order comes before its base; an agent that tells what it begins, tells it of each order.
  std::vector<OrderWork*> begun;
  for (OrderWork* work : fitting)
    if (work->decided && work->decided->t <= piece.begin()) begun.push_back(work);
  if (begun.size() == 1) return begun.front();
  if (begun.size() > 1)
    return *std::ranges::max_element(begun, {}, [](const OrderWork* work) { return work->decided->t; });
  const bool told = std::ranges::any_of(
      works, [&](const OrderWork& work) { return origin && work.team == origin->team && work.decided.has_value(); });
  return fitting.size() == 1 && !told ? fitting.front() : nullptr;
}

bool is_product(const GameStory& story, const PieceStory& piece) {
  const MachineStory* origin = story.machine(piece.origin);
  if (!origin) return false;
  if (origin->kind == "BS") return true;
  return origin->kind == "SS" && std::ranges::any_of(piece.works, [](const Since<WorkDone>& one) {
           return one.value.kind == WorkDone::Kind::kUnstored;
         });
}

}  // namespace

std::string_view to_string(Fate::Kind kind) {
  static constexpr std::array<std::string_view, 8> kWords{"delivered", "refused", "discarded", "payment",
                                                          "dropped",   "taken",   "stored",    "in play"};
  return kWords[static_cast<std::size_t>(kind)];
}

Fate fate_of(const GameStory& story, const PieceStory& piece) {
  if (piece.delivery) {
    const auto& [t, judged] = *piece.delivery;
    const std::string order = "order " + std::to_string(judged.order);
    if (judged.correct) return {Fate::Kind::kDelivered, t, "delivered for " + order};
    return {Fate::Kind::kRefused, t, "refused for " + order + ": " + judged.reason};
  }
  if (piece.discarded) return {Fate::Kind::kDiscarded, *piece.discarded, "thrown away through the gate"};
  if (piece.taken && (piece.moves.empty() || piece.moves.back().t <= *piece.taken))
    return {Fate::Kind::kTaken, *piece.taken, "taken by a fault of the scenario"};
  if (!piece.moves.empty()) return of_last_move(story, piece.moves.back().t, piece.moves.back().value);
  return {Fate::Kind::kInPlay, piece.works.empty() ? SimTime{} : piece.works.back().t, "not known from this run"};
}

std::vector<Visit> visits_of(const GameStory& story, const PieceStory& piece, const Order* order) {
  std::vector<Visit> out;
  std::string product;
  std::size_t next_work = 0;
  const auto take_works = [&](SimTime until) {
    for (; next_work < piece.works.size() && piece.works[next_work].t <= until; ++next_work) {
      const auto& [t, work] = piece.works[next_work];
      product = work.product;
      if (out.empty() || out.back().machine->name != work.machine) {
        const MachineStory* machine = story.machine(work.machine);  // it came out of the storage there
        if (machine) out.push_back({machine, {}, t, {}, {}, {}, {}});
      }
      if (out.empty()) continue;
      out.back().done = t;
      out.back().part = work.kind == WorkDone::Kind::kMounted ? last_part(product) : std::string();
    }
  };
  for (const auto& [t, move] : piece.moves) {
    take_works(t);
    if (move.to == "belt") {
      const MachineStory* machine = story.machine(move.to_name);
      if (!machine) continue;
      std::string part = machine->kind == "DS" ? "delivery" : std::string();
      if (machine->kind == "BS") {
        const InstructionHeard* asked = machine->instruction_at(t);
        product = part = asked ? asked->base_color : std::string();
      } else if (part.empty() && order && (machine->kind == "RS" || machine->kind == "CS")) {
        part = next_part(product, *order);
      }
      if (!out.empty() && out.back().machine == machine && !out.back().left) continue;  // out of the storage
      out.push_back({machine, part, t, {}, {}, {}, {}});
    } else if (move.from == "belt" && !out.empty()) {
      if (move.to == "gate") {
        out.back().done = t;
      } else {
        out.back().left = t;
        if (move.to == "gripper") out.back().left_with = move.to_name;
      }
    }
  }
  take_works(story.end);
  for (std::size_t i = 0; i < out.size(); ++i) begin_and_end(story, out[i], out[i].left.value_or(story.end));
  return out;
}

bool OrderWork::correct() const {
  return std::ranges::any_of(deliveries, [](const auto& one) { return one.value.correct; });
}

std::optional<SimTime> OrderWork::delivered_at() const {
  for (const auto& [t, judged] : deliveries)
    if (judged.correct) return t;
  return std::nullopt;
}

std::optional<SimTime> OrderWork::begun() const {
  if (decided) return decided->t;
  for (const Attempt& attempt : attempts)
    if (!attempt.visits.empty()) return attempt.visits.front().began.value_or(attempt.visits.front().arrived);
  return std::nullopt;
}

std::vector<OrderWork> work_for_orders(const GameStory& story) {
  std::vector<OrderWork> out;
  for (const Order& order : story.orders())
    for (const Team team : story.teams) {
      OrderWork& work = out.emplace_back();
      work.order = order;
      work.team = team;
      for (const Decision& decision : story.decisions)
        if (!work.decided && decision.team == team && begins(decision) && decision.names_order(order.id))
          work.decided = {decision.t, &decision};
      for (const auto& one : story.deliveries)
        if (one.value.order == order.id && one.value.team == team) work.deliveries.push_back(one);
      for (const auto& [t, given] : story.points)
        if (given.order == order.id && given.team == team) work.points += given.points;
    }
  // Delivered products first: what they were made for is sure.
  for (const bool delivered : {true, false})
    for (const PieceStory& piece : story.pieces) {
      if (piece.delivery.has_value() != delivered) continue;
      const Fate fate = fate_of(story, piece);
      OrderWork* work = nullptr;
      if (delivered) {
        const DeliveryJudged& judged = piece.delivery->value;
        for (OrderWork& one : out)
          if (one.order.id == judged.order && one.team == judged.team) work = &one;
      } else if (is_product(story, piece) && !is_payment(story, piece, fate)) {
        work = order_of(story, piece, fate, out);
      }
      if (work) work->attempts.push_back(attempt_of(story, piece, work->order));
    }
  for (OrderWork& work : out)
    std::ranges::stable_sort(work.attempts, {}, [](const Attempt& one) { return one.piece->begin(); });
  return out;
}

}  // namespace cxlab::rcll
