#pragma once
// What planning costs in simulated time.

#include <cstdint>
#include <optional>
#include <string>

#include "cx/base/expected.h"

namespace cxlab::planner {

/// A plan that took u work units is answered latency_a + latency_b * u seconds after it was asked for.
struct PlanningCost {
  double latency_a = 0.0;                  ///< s that any answer takes
  double latency_b = 1e-6;                 ///< s a work unit; a unit is about a microsecond of one core
  std::int64_t budget = 60'000'000;        ///< work units that a plan may take
  std::optional<std::int64_t> patience{};  ///< work units after a plan within which a better one must come
  std::string planning_time = "charged";   ///< free: answers come at once
  bool is_charged() const { return planning_time == "charged"; }

  template <class Keys>
  void fields(Keys& keys) {
    keys.below("latency", [this](auto& latency) {
      latency("a", latency_a);
      latency("b", latency_b);
    });
    keys("budget", budget);
    keys("patience", patience);
    keys.word("planning_time", planning_time, {"charged", "free"});
  }
};

inline Status validate(const PlanningCost& cost) {
  if (cost.latency_a < 0 || cost.latency_b < 0) return input_error("latency: a and b must be 0 or more");
  if (cost.budget <= 0)
    return input_error("budget: " + found_expected(std::to_string(cost.budget), "work units above 0"));
  if (cost.patience && *cost.patience <= 0)
    return input_error("patience: " + found_expected(std::to_string(*cost.patience), "work units above 0"));
  return {};
}

}  // namespace cxlab::planner
