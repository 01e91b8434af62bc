#include "scenarios/rcll/rules/referee.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "scenarios/rcll/rules/layout.h"

namespace cxlab::rcll {
namespace {

constexpr std::int64_t kDeliveryPoints[]{20, 30, 50, 100};  ///< by complexity
constexpr std::int64_t kRingPoints[]{5, 10, 20};            ///< by price
constexpr std::int64_t kCapPoints = 10;
constexpr std::int64_t kBufferPoints = 2;
constexpr std::int64_t kPaymentPoints = 2;
constexpr std::int64_t kCompetitivePoints = 10;
constexpr std::int64_t kStoragePoints = -5;      ///< STORE or RETRIEVE
constexpr std::int64_t kNoWorkpiecePoints = -1;  ///< instructed, and nothing came
constexpr std::int64_t kDropPoints = -10;
constexpr std::int64_t kForeignMachinePoints = -20;

}  // namespace

std::int64_t Score::total() const { return std::accumulate(by_kind.begin(), by_kind.end(), std::int64_t{0}); }

std::int64_t late_deduction(std::int64_t points, double late_s, double window_s, bool in_fifths) {
  if (late_s <= 0) return 0;
  const int steps = in_fifths ? 5 : 4;
  const int step = static_cast<int>(std::clamp(std::ceil(late_s / (window_s / steps)), 1.0, double(steps)));
  // 75 % in equal steps, in whole numbers.
  return points * step * 3 / (4 * steps);
}

GameReferee::GameReferee(GameClock clock, RuleChoices rules, Schedule schedule, const sim::FloorPlan& plan,
                         EventLog& events, bool explore)
    : clock_(clock),
      rules_(rules),
      schedule_(std::move(schedule)),
      plan_(plan),
      events_(events),
      exploration_(plan, clock_, explore, rules_.reports_by_type) {
  for (const Order& order : schedule_.orders) orders_.emplace_back().order = order;
}

void GameReferee::judge(SimTime now, std::span<const sim::HolderChange> changes, std::span<const MachineEvent> events) {
  for (const sim::HolderChange& change : changes) {
    write_piece(change);
    if (rules_.by_hand) judge_piece(change);
  }
  for (const MachineEvent& event : events) note(event);
  if (phase_ == Phase::kProduction && !ended_) prolong(now);
  const Phase phase = clock_.phase(now);
  if (!last_look_ || phase != phase_) {
    phase_ = phase;
    write(now, PhaseBegan{phase});
  }
  if (phase == Phase::kProduction) release_orders(now);
  last_look_ = now;
}

std::string GameReferee::take_report(Team team, const MachineReport& entry, SimTime now) {
  const std::uint64_t before = exploration_.changes();
  const std::vector<std::int64_t> points = exploration_.report(team, entry, now);
  const std::string nonsense = exploration_.nonsense(team, entry);
  write(now, MachineReported{.team = team,
                             .machine = entry.name,
                             .type = entry.type,
                             .zone = entry.zone,
                             .rotation = entry.rotation.value_or(-1),
                             .judged = exploration_.changes() != before,
                             .reason = nonsense});
  for (const std::int64_t point : points) give(team, PointKind::kExploration, point, now);
  return nonsense;
}

std::string GameReferee::deny_report(Team team, const std::string& color, SimTime now) {
  std::string reason = found_expected("'" + color + "' as its team_color", std::string(to_string(team)));
  write(now, MachineReported{.team = team, .machine = {}, .type = {}, .zone = {}, .rotation = {}, .reason = reason});
  return reason;
}

void GameReferee::take_instruction(sim::StationId machine, const Instruction& instruction, InstructError error,
                                   SimTime now) {
  const sim::Station& station = plan_.station(machine);
  InstructionHeard heard{.machine = station.name,
                         .operation = instruction.operation,
                         .side = instruction.side,
                         .base_color = instruction.base_color,
                         .ring_color = instruction.ring_color,
                         .order = {},
                         .shelf = {},
                         .slot = {},
                         .code = static_cast<int>(error)};
  if (station.kind == "DS") heard.order = instruction.order_id;
  if (station.kind == "SS") {
    heard.shelf = instruction.shelf;
    heard.slot = instruction.slot;
  }
  write(now, std::move(heard));
}

void GameReferee::prolong(SimTime now) {
  const std::int64_t cyan = score(Team::kCyan).published(), magenta = score(Team::kMagenta).published();
  if (sudden_death_ && cyan != magenta) clock_.production_end = now;
  if (now < clock_.production_end || cyan != magenta || clock_.overtime == SimTime::zero()) return;
  if (in_overtime_ ? (sudden_death_ || !rules_.sudden_death) : (cyan == 0 && !rules_.overtime_at_nil)) return;
  sudden_death_ = in_overtime_;
  in_overtime_ = true;
  clock_.production_end += clock_.overtime;
  write(now, Prolonged{sudden_death_ ? Prolonged::Kind::kSuddenDeath : Prolonged::Kind::kOvertime,
                       clock_.game_time(clock_.production_end)});
}

SimTime GameReferee::next_due() const {
  if (!last_look_ || clock_.phase(*last_look_) != phase_) return last_look_.value_or(SimTime::zero());
  SimTime due = kNever;
  const auto at = [&](SimTime t) {
    if (t > *last_look_) due = std::min(due, t);
  };
  at(clock_.production_begin);
  at(clock_.production_end);
  for (const OrderState& state : orders_)
    if (!state.released) at(clock_.at(state.order.activate_at));
  return due;
}

std::string GameReferee::set_phase(Phase phase, SimTime now) {
  const Phase is = clock_.phase(now);
  if (phase == is) return {};
  if (phase < is) return "the game is in " + std::string(to_string(is)) + ", and no phase comes again";
  if (is == Phase::kSetup) clock_.begin_production(now);
  if (phase == Phase::kPostGame) {
    clock_.production_end = now;
    ended_ = true;
  }
  write(now, PhaseWasSet{phase});
  return {};
}

std::string GameReferee::confirm(std::int64_t id, bool correct, SimTime now) {
  if (!waits_for_confirmation_) return "what lies under a gate is seen";
  const auto found = std::ranges::find(unconfirmed_, id, &Unconfirmed::id);
  if (found == unconfirmed_.end()) return "no delivery " + std::to_string(id) + " waits for it";
  const Unconfirmed delivery = std::move(*found);
  unconfirmed_.erase(found);
  judge_delivery(*find_order(delivery.event.order_id), delivery.event, delivery.team, correct, now);
  return {};
}

void GameReferee::release_orders(SimTime now) {
  for (OrderState& state : orders_) {
    const Order& order = state.order;
    if (state.released || now < clock_.at(order.activate_at)) continue;
    state.released = now;
    ++order_changes_;
    write(now, OrderPublished{.id = order.id,
                              .complexity = std::string(to_string(order.complexity)),
                              .product = describe(stack_of(order.product)),
                              .begin = order.delivery_begin,
                              .end = order.delivery_end,
                              .gate = order.delivery_gate,
                              .quantity = order.quantity,
                              .competitive = order.competitive});
  }
}

std::string GameReferee::name_of(sim::Holder holder, int index) const {
  const auto at = static_cast<std::size_t>(index);
  switch (holder) {
    case sim::Holder::kGripper:
      if (index >= 0 && at < plan_.robots.size()) return plan_.robots[at].name;
      break;
    case sim::Holder::kSlot:
    case sim::Holder::kSlide:
      if (index >= 0 && at < plan_.spots.size()) return plan_.spots[at].name;
      break;
    case sim::Holder::kDispenser:
    case sim::Holder::kBelt:
    case sim::Holder::kGate:
    case sim::Holder::kStorage:
      if (index >= 0 && at < plan_.stations.size()) return plan_.stations[at].name;
      break;
    case sim::Holder::kFloor:
    case sim::Holder::kCrew: break;
  }
  return {};
}

void GameReferee::write_piece(const sim::HolderChange& change) {
  const auto& at = change.position_in_world;
  write(change.at, PieceMoved{.piece = static_cast<int>(change.piece),
                              .from = std::string(sim::to_string(change.from)),
                              .from_name = name_of(change.from, change.from_index),
                              .to = std::string(sim::to_string(change.to)),
                              .to_name = name_of(change.to, change.to_index),
                              .position = {at[0], at[1], at[2]}});
}

std::optional<sim::StationId> GameReferee::station_of(sim::Holder holder, int index) const {
  if (index < 0) return std::nullopt;
  if (holder == sim::Holder::kBelt) return static_cast<sim::StationId>(index);
  if (holder == sim::Holder::kSlot || holder == sim::Holder::kSlide) return plan_.spot(sim::SpotId{index}).station;
  return std::nullopt;
}

void GameReferee::judge_piece(const sim::HolderChange& change) {
  if (change.from != sim::Holder::kGripper || clock_.phase(change.at) != Phase::kProduction) return;
  const Team team = team_of(plan_.robot(sim::RobotId{change.from_index}));
  if (change.to == sim::Holder::kFloor) give(team, PointKind::kPenalty, kDropPoints, change.at);
  if (const auto station = station_of(change.to, change.to_index);
      station && team_of(plan_.station(*station)) != team) {
    give(team, PointKind::kPenalty, kForeignMachinePoints, change.at);
    confiscated_.push_back(change.piece);
  }
}

void GameReferee::write_work(const MachineEvent& event, WorkDone::Kind kind) {
  const sim::Station& station = plan_.station(event.machine);
  WorkDone done{.kind = kind,
                .machine = station.name,
                .piece = static_cast<int>(event.piece),
                .product = describe(event.stack),
                .payments = {},
                .shelf = {},
                .slot = {}};
  if (station.kind == "RS") done.payments = event.payments;
  if (kind == WorkDone::Kind::kStored || kind == WorkDone::Kind::kUnstored) {
    done.shelf = event.slot.shelf;
    done.slot = event.slot.slot;
  }
  write(event.at, std::move(done));
}

void GameReferee::note(const MachineEvent& event) {
  const Team team = team_of(plan_.station(event.machine));
  const std::string& machine = plan_.station(event.machine).name;
  switch (event.kind) {
    case MachineEvent::Kind::kState:
      write(event.at, MachineChanged{machine, std::string(to_string(event.state))});
      break;
    case MachineEvent::Kind::kPayment: give(team, PointKind::kPayment, kPaymentPoints, event.at); break;
    case MachineEvent::Kind::kCapRetrieved:
      write_work(event, WorkDone::Kind::kCapRetrieved);
      give(team, PointKind::kBuffer, kBufferPoints, event.at);
      break;
    case MachineEvent::Kind::kMounted:
      write_work(event, WorkDone::Kind::kMounted);
      if (event.stack.cap != 0) capped_at_[event.piece] = event.at;
      break;
    case MachineEvent::Kind::kStored:
    case MachineEvent::Kind::kUnstored:
      write_work(event,
                 event.kind == MachineEvent::Kind::kStored ? WorkDone::Kind::kStored : WorkDone::Kind::kUnstored);
      if (event.at_start) from_storage_.push_back(event.piece);
      give(team, PointKind::kPenalty, kStoragePoints, event.at);
      break;
    case MachineEvent::Kind::kRelocated:
      write(event.at, Relocated{.machine = machine,
                                .product = describe(event.stack),
                                .from_shelf = event.from.shelf,
                                .from_slot = event.from.slot,
                                .shelf = event.slot.shelf,
                                .slot = event.slot.slot});
      break;
    case MachineEvent::Kind::kDelivery: deliver(event, team); break;
    case MachineEvent::Kind::kNoSpare: write(event.at, NoSparePiece{machine}); break;
    case MachineEvent::Kind::kBroke:
      write(event.at, MachineBroke{machine, event.reason});
      give(team, PointKind::kPayment, -kPaymentPoints * event.unused_payments, event.at);
      if (event.cap_buffered) give(team, PointKind::kBuffer, -kBufferPoints, event.at);
      if (event.no_workpiece && rules_.by_hand) give(team, PointKind::kPenalty, kNoWorkpiecePoints, event.at);
      break;
  }
}

std::int64_t GameReferee::give(Team team, PointKind kind, std::int64_t points, SimTime at, int order) {
  if (points == 0) return 0;
  scores_[static_cast<std::size_t>(team)].by_kind[static_cast<std::size_t>(kind)] += points;
  write(at, PointsGiven{team, std::string(to_string(kind)), points, score(team).total(), order});
  return points;
}

std::string GameReferee::rejection(const OrderState& state, const MachineEvent& event, Team team,
                                   std::optional<bool> correct) const {
  if (!state.released || *state.released > event.at) return "inactive";
  if (event.at < clock_.at(state.order.delivery_begin)) return "early";
  if (!correct.value_or(event.stack == stack_of(state.order.product)))
    return correct ? "not confirmed" : "wrong product";
  if (state.delivered[static_cast<std::size_t>(team)] >= state.order.quantity) return "surplus";
  if (rules_.storage_serves_one && from_storage(event.piece)) {
    if (state.order.overtime) return "from the storage in overtime";
    if (storage_served_[static_cast<std::size_t>(team)]) return "another from the storage";
  }
  return {};
}

std::vector<OrderState>::iterator GameReferee::find_order(int id) {
  return std::ranges::find(orders_, id, [](const OrderState& state) { return state.order.id; });
}

void GameReferee::deliver(const MachineEvent& event, Team team) {
  const auto state = find_order(event.order_id);
  if (event.order_id == 0 || state == orders_.end()) {
    write(event.at, Discarded{static_cast<int>(event.piece), describe(event.stack)});
    return;
  }
  if (!waits_for_confirmation_) return judge_delivery(*state, event, team, std::nullopt, event.at);
  unconfirmed_.push_back({++last_unconfirmed_, team, event});
  write(event.at, DeliveryUnconfirmed{last_unconfirmed_, event.order_id, team, static_cast<int>(event.piece),
                                      describe(event.stack)});
}

void GameReferee::judge_delivery(OrderState& state, const MachineEvent& event, Team team, std::optional<bool> correct,
                                 SimTime now) {
  Delivery delivery;
  delivery.order = event.order_id;
  delivery.team = team;
  delivery.at = event.at;
  delivery.piece = event.piece;
  delivery.stack = event.stack;
  delivery.reason = rejection(state, event, team, correct);
  delivery.correct = delivery.reason.empty();
  if (delivery.correct) accept(state, delivery, now);
  if (delivery.reason == "surplus" && rules_.surplus_cap_counts) credit_cap(state, delivery, now);
  write(now, DeliveryJudged{.order = delivery.order,
                            .team = team,
                            .piece = static_cast<int>(delivery.piece),
                            .product = describe(delivery.stack),
                            .correct = delivery.correct,
                            .points = delivery.points,
                            .late_s = delivery.late_s,
                            .reason = delivery.reason});
  deliveries_.push_back(std::move(delivery));
}

void GameReferee::accept(OrderState& state, Delivery& delivery, SimTime now) {
  const Order& order = state.order;
  const auto team = static_cast<std::size_t>(delivery.team);
  const auto give_for_order = [&](PointKind kind, std::int64_t points) {
    delivery.points += give(delivery.team, kind, points, now, order.id);
  };
  const std::int64_t worth = kDeliveryPoints[static_cast<std::size_t>(order.complexity)];
  delivery.late_s = std::max(0.0, to_seconds(delivery.at - clock_.at(order.delivery_end)));
  const std::int64_t deduction =
      late_deduction(worth, delivery.late_s, order.delivery_end - order.delivery_begin, rules_.late_in_fifths);
  give_for_order(PointKind::kDelivery, worth);
  give_for_order(PointKind::kLate, -deduction);
  if (order.competitive && state.delivered[team] == 0) {
    const bool first = state.delivered[1 - team] == 0;
    give_for_order(PointKind::kCompetitive, first ? kCompetitivePoints
                                            : rules_.second_keeps_points
                                                ? -std::min(worth - deduction, kCompetitivePoints)
                                                : -kCompetitivePoints);
  }
  for (const RingColor ring : order.product.rings)
    give_for_order(PointKind::kRing, kRingPoints[static_cast<std::size_t>(schedule_.price(ring))]);
  give_for_order(PointKind::kCap, kCapPoints);

  storage_served_[team] |= from_storage(delivery.piece);
  if (from_storage(delivery.piece)) state.owes_cap_since[team] = delivery.at;
  ++order_changes_;
  ++state.delivered[team];
  if (!state.delivered_at[team]) state.delivered_at[team] = delivery.at;
  state.points[team] += delivery.points;
}

void GameReferee::credit_cap(OrderState& state, Delivery& delivery, SimTime now) {
  const auto team = static_cast<std::size_t>(delivery.team);
  std::optional<SimTime>& since = state.owes_cap_since[team];
  const auto capped = capped_at_.find(delivery.piece);
  if (!since || capped == capped_at_.end() || capped->second <= *since) return;
  since.reset();
  delivery.points = give(delivery.team, PointKind::kCap, kCapPoints, now, state.order.id);
  state.points[team] += delivery.points;
}

}  // namespace cxlab::rcll
