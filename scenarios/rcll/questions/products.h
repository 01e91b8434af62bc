#pragma once
// Workpieces as products: where each ended, the machines that it visited, and the order that it was made for.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "scenarios/rcll/questions/waiting.h"
#include "scenarios/rcll/story/story.h"

namespace cxlab::rcll {

/// Where a workpiece is at last.
struct Fate {
  enum class Kind : std::uint8_t {
    kDelivered,
    kRefused,    ///< it came through the gate, and no order took it
    kDiscarded,  ///< through the gate of no order
    kPayment,
    kDropped,
    kTaken,  ///< by people, or by a fault
    kStored,
    kInPlay,  ///< in a gripper, on a belt, on a shelf
  };
  Kind kind{};
  SimTime t{};
  std::string text;  ///< "dropped by robot2"
  bool is_lost() const { return kind == Kind::kDropped || kind == Kind::kTaken || kind == Kind::kDiscarded; }
  bool is_over() const { return kind != Kind::kInPlay && kind != Kind::kStored; }
};
std::string_view to_string(Fate::Kind kind);
Fate fate_of(const GameStory& story, const PieceStory& piece);

/// A workpiece on a machine.
struct Visit {
  const MachineStory* machine = nullptr;
  std::string part;  ///< that it came for: "BASE_RED", "RING_BLUE", "CAP_GREY", "delivery"; empty: not known
  SimTime arrived{};
  std::optional<SimTime> began, done, left;
  std::string left_with;  ///< the robot
};
/// In order of time. `order`: whose product it is; then what it came for is known where the machine did nothing.
std::vector<Visit> visits_of(const GameStory& story, const PieceStory& piece, const Order* order);

/// A workpiece that was made for an order.
struct Attempt {
  const PieceStory* piece = nullptr;
  Fate fate;
  std::vector<Visit> visits;
  /// What the product, or its work, waited for.
  std::vector<Waiting> waits;
};

/// What a team did for an order.
struct OrderWork {
  Order order;
  Team team{};
  std::optional<Since<const Decision*>> decided;  ///< the first decision to begin it
  std::vector<Attempt> attempts;
  std::vector<Since<DeliveryJudged>> deliveries;
  std::int64_t points = 0;
  bool correct() const;
  std::optional<SimTime> delivered_at() const;
  /// The decision, or when the base was asked for where no decision names the order.
  std::optional<SimTime> begun() const;
};
std::vector<OrderWork> work_for_orders(const GameStory& story);

}  // namespace cxlab::rcll
