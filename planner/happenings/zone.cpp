#include "planner/happenings/zone.h"

#include <algorithm>

namespace cxlab::planner {

int Zone::add_point() {
  const int before = points_++;
  std::vector<Micros> wider(static_cast<std::size_t>(points_) * static_cast<std::size_t>(points_), kAny);
  for (int from = 0; from < before; ++from)
    std::copy_n(most_.begin() + from * before, before, wider.begin() + from * points_);
  most_ = std::move(wider);
  most_.back() = 0;
  return before;
}

bool Zone::require(int from, int to, Micros least) {
  if (most(from, to) < least) return false;
  if (this->least(from, to) >= least) return true;
  // `from` is at most -least after `to`: every way from one point to another may now lead over these two.
  for (int a = 0; a < points_; ++a) {
    const Micros first = most(a, to);
    if (first >= kAny) continue;
    for (int b = 0; b < points_; ++b) {
      const Micros last = most(from, b);
      if (last < kAny) most_[at(a, b)] = std::min(most(a, b), first - least + last);
    }
  }
  return true;
}

void Zone::keep(std::span<const int> points) {
  Zone kept;
  kept.points_ = static_cast<int>(points.size());
  for (const int from : points)
    for (const int to : points) kept.most_.push_back(most(from, to));
  *this = std::move(kept);
}

bool Zone::contains(const Zone& other) const {
  return std::ranges::equal(most_, other.most_, std::ranges::greater_equal{});
}

}  // namespace cxlab::planner
