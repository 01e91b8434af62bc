#pragma once
// Limits the work for a condition or an effect over many objects.

#include <cstdint>
#include <functional>
#include <utility>

namespace cxlab::planner {

/// Counts combinations of objects that are tried, in portions. When a portion is used up, it asks for the next one.
class Meter {
 public:
  /// How many more may be tried; 0: none.
  using Portion = std::function<std::int64_t()>;

  explicit Meter(Portion portion) : portion_(std::move(portion)) {}
  /// No more than `most` in all.
  explicit Meter(std::int64_t most) : left_(most) {}

  /// False when no more may be tried: what was found out since then means nothing.
  bool spend(std::int64_t combinations = 1) {
    left_ -= combinations;
    while (left_ < 0 && !over_) {
      const std::int64_t more = portion_ ? portion_() : 0;
      over_ = more <= 0;
      left_ += more;
    }
    return !over_;
  }
  bool over() const { return over_; }

 private:
  Portion portion_;
  std::int64_t left_ = 0;
  bool over_ = false;
};

}  // namespace cxlab::planner
