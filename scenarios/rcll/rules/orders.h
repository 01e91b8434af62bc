#pragma once
// The orders of a game: drawn as the referee box draws them, or listed. Times are seconds of the
// production phase.

#include <array>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/random.h"
#include "scenarios/rcll/rules/config.h"
#include "scenarios/rcll/rules/types.h"

namespace cxlab::rcll {

struct Order {
  int id = 0;  ///< from 1
  Complexity complexity{};
  Product product;
  double activate_at = 0;     ///< s, when it is published
  double delivery_begin = 0;  ///< s
  double delivery_end = 0;    ///< s
  int delivery_gate = 1;      ///< 1..3
  int quantity = 1;
  bool competitive = false;
  bool overtime = false;  ///< the one that is published in overtime only
};

/// Payments that a ring of each colour costs, by colour in the order of kRingColors: 0, 0, 1 and 2 in some order.
using RingPrices = std::array<int, 4>;

struct Schedule {
  RingPrices ring_prices{};
  std::vector<Order> orders;
  int price(RingColor color) const { return ring_prices[static_cast<std::size_t>(color) - 1]; }
};

/// Draws prices and ten orders. `allowed`: complexities to draw from, empty = all. As the referee box: five pairs of
/// one simple (C0, C1) and one complex (C2, C3) order; where `allowed` leaves one of the two classes empty, the other
/// serves for both.
Schedule draw_schedule(RandomStream& random, const std::vector<Complexity>& allowed);

/// The order of overtime, without its id: a competitive C0, to be delivered between these times.
Order draw_overtime_order(RandomStream& random, double begin, double end);

/// An order as it is listed; `config` has been validated.
Order read_order(const OrderConfig& config, int id);
/// The order as it would be listed: the opposite of `read_order`.
OrderConfig listed(const Order& order);

}  // namespace cxlab::rcll
