#pragma once
// The referee: looks at what the machines did and at every piece, releases orders, judges deliveries, keeps the score.

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "scenarios/rcll/rules/clock.h"
#include "scenarios/rcll/rules/config.h"
#include "scenarios/rcll/rules/event_log.h"
#include "scenarios/rcll/rules/exploration.h"
#include "scenarios/rcll/rules/machine.h"
#include "scenarios/rcll/rules/orders.h"
#include "sim/world.h"

namespace cxlab::rcll {

enum class PointKind : std::uint8_t {
  kDelivery,
  kRing,
  kCap,
  kBuffer,
  kPayment,
  kLate,
  kCompetitive,
  kExploration,
  kPenalty
};
inline constexpr std::size_t kPointKinds = 9;
template <>
inline constexpr std::array<std::string_view, kPointKinds> kNames<PointKind>{
    "delivery", "ring", "cap", "buffer", "payment", "late", "competitive", "exploration", "penalty"};

/// Points of a team by kind.
struct Score {
  std::array<std::int64_t, kPointKinds> by_kind{};
  std::int64_t of(PointKind kind) const { return by_kind[static_cast<std::size_t>(kind)]; }
  std::int64_t total() const;
  /// What the referee box publishes: never below 0.
  std::int64_t published() const { return std::max<std::int64_t>(0, total()); }
};

/// One product that came through a gate for an order.
struct Delivery {
  int order = 0;
  Team team{};
  SimTime at{};
  sim::PieceId piece{};
  sim::Stack stack;
  bool correct = false;     ///< accepted: it counts for its order
  std::string reason;       ///< why not: "inactive", "early", "surplus", "wrong product", "another from the storage"
  double late_s = 0;        ///< s after the end of the window, of an accepted product
  std::int64_t points = 0;  ///< all that it earned
};

/// How an order stands. Index of arrays: team.
struct OrderState {
  Order order;
  std::optional<SimTime> released;                       ///< when it was published
  std::array<int, 2> delivered{};                        ///< accepted products
  std::array<std::optional<SimTime>, 2> delivered_at{};  ///< the first of them
  std::array<std::int64_t, 2> points{};
  /// Since when the cap of the next surplus product counts: a stored product was accepted (RuleChoices).
  std::array<std::optional<SimTime>, 2> owes_cap_since{};
};

/// Points taken off a delivery worth `points` that is `late_s` after a window of `window_s`. Referee box: a quarter of
/// 75 % for each begun quarter of the window, at most 75 %; rulebook: 15 % for each begun fifth. Whole points, cut off.
std::int64_t late_deduction(std::int64_t points, double late_s, double window_s, bool in_fifths);

class GameReferee {
 public:
  /// Plan and events outlive it.
  GameReferee(GameClock clock, RuleChoices rules, Schedule schedule, const sim::FloorPlan& plan, EventLog& events,
              bool explore = false);
  GameReferee(const GameReferee&) = delete;
  GameReferee& operator=(const GameReferee&) = delete;
  /// Products that come through a gate count when `confirm` says so, not when they are seen to be right.
  void wait_for_confirmation() { waits_for_confirmation_ = true; }

  /// Looks at one tick: pieces that changed hands, and what the machines did since the last look.
  void judge(SimTime now, std::span<const sim::HolderChange> changes, std::span<const MachineEvent> events);
  /// Judges one entry of a team's report of where its machines stand. Returns the fault of an entry that names nothing
  /// that exists; else empty.
  std::string take_report(Team team, const MachineReport& entry, SimTime now);
  /// A report on the team's channel that is not in its colour is denied; the reason.
  std::string deny_report(Team team, const std::string& color, SimTime now);
  /// Takes points off (they are negative) as a penalty.
  void fine(Team team, std::int64_t points, SimTime now) { give(team, PointKind::kPenalty, points, now); }
  /// An instruction that a machine of the team has heard, and what it said.
  void take_instruction(sim::StationId machine, const Instruction& instruction, InstructError error, SimTime now);
  const Exploration& exploration() const { return exploration_; }
  /// A controller ends set-up, or the game: what speaks against it, else empty.
  std::string set_phase(Phase phase, SimTime now);
  /// A controller says whether the product of an unconfirmed delivery is right: what speaks against it, else empty.
  std::string confirm(std::int64_t id, bool correct, SimTime now);
  /// Products that wait for it.
  struct Unconfirmed {
    std::int64_t id = 0;  ///< from 1
    Team team{};
    MachineEvent event;
  };
  const std::vector<Unconfirmed>& unconfirmed() const { return unconfirmed_; }
  /// Pieces that the referee has taken off the machines of the other team, since the last call; who carries them away
  /// takes them out of play.
  std::vector<sim::PieceId> take_confiscated() { return std::exchange(confiscated_, {}); }
  /// The next release of an order or end of a phase.
  SimTime next_due() const;

  Phase phase() const { return phase_; }
  const GameClock& clock() const { return clock_; }  ///< moved by overtime
  const Score& score(Team team) const { return scores_[static_cast<std::size_t>(team)]; }
  const std::vector<OrderState>& orders() const { return orders_; }
  const std::vector<Delivery>& deliveries() const { return deliveries_; }
  const Schedule& schedule() const { return schedule_; }
  /// Grows by one with each order released and each accepted product.
  std::uint64_t order_changes() const { return order_changes_; }

 private:
  void prolong(SimTime now);
  void release_orders(SimTime now);
  void write_piece(const sim::HolderChange& change);
  void judge_piece(const sim::HolderChange& change);
  std::optional<sim::StationId> station_of(sim::Holder holder, int index) const;
  void write_work(const MachineEvent& event, WorkDone::Kind kind);
  void note(const MachineEvent& event);
  void deliver(const MachineEvent& event, Team team);
  /// `correct`: what a controller says of the product; without it the product is looked at.
  std::string rejection(const OrderState& state, const MachineEvent& event, Team team,
                        std::optional<bool> correct) const;
  void judge_delivery(OrderState& state, const MachineEvent& event, Team team, std::optional<bool> correct,
                      SimTime now);
  void accept(OrderState& state, Delivery& delivery, SimTime now);
  /// Gives the cap of a surplus product its points, where the referee box does.
  void credit_cap(OrderState& state, Delivery& delivery, SimTime now);
  std::vector<OrderState>::iterator find_order(int id);
  std::int64_t give(Team team, PointKind kind, std::int64_t points, SimTime at, int order = 0);
  /// Who or what it is; empty for the floor.
  std::string name_of(sim::Holder holder, int index) const;
  void write(SimTime at, Event event) { events_.write(at, std::move(event)); }

  GameClock clock_;
  RuleChoices rules_;
  Schedule schedule_;
  const sim::FloorPlan& plan_;
  EventLog& events_;
  Exploration exploration_;
  std::optional<SimTime> last_look_;
  Phase phase_ = Phase::kSetup;
  bool in_overtime_ = false, sudden_death_ = false;
  bool ended_ = false;  ///< by a controller
  bool waits_for_confirmation_ = false;
  std::vector<Unconfirmed> unconfirmed_;
  std::int64_t last_unconfirmed_ = 0;
  std::array<Score, 2> scores_{};
  std::vector<OrderState> orders_;
  std::vector<Delivery> deliveries_;
  std::uint64_t order_changes_ = 0;
  bool from_storage(sim::PieceId piece) const { return std::ranges::find(from_storage_, piece) != from_storage_.end(); }

  std::vector<sim::PieceId> from_storage_, confiscated_;
  std::map<sim::PieceId, SimTime> capped_at_;  ///< by a cap station
  std::array<bool, 2> storage_served_{};       ///< by team
};

}  // namespace cxlab::rcll
