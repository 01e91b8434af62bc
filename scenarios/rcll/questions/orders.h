#pragma once
// The story of each order, with the reasons. `cxlab orders` and the page of a run show the same.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scenarios/rcll/questions/products.h"

namespace cxlab::rcll {

/// A step of a product on its way to delivery, or, where it was not delivered, where it ended.
struct OrderStep {
  int piece = 0;
  std::string what;     ///< "RING_BLUE", "delivery", "dropped"; empty: not known
  std::string machine;  ///< empty: none
  std::optional<SimTime> arrived, began, done;
  SimTime waited{};
  std::string waited_for;  ///< or how it ended
};

struct OrderAccount {
  const OrderWork* work = nullptr;
  std::string_view state;  ///< "delivered", "late", "lost", "never begun", ...
  double late_s = 0;
  SimTime waited{};
  std::string outcome;  ///< a sentence: how it ended, and why it is late or missing
  std::vector<OrderStep> steps;
};

/// One of `all`, which are the orders of both teams.
OrderAccount account_of(const GameStory& story, const OrderWork& work, const std::vector<OrderWork>& all);

}  // namespace cxlab::rcll
