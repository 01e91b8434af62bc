#include "planner/bounds/sequencing.h"

#include <algorithm>
#include <bit>
#include <set>

namespace cxlab::planner {

namespace {

constexpr std::size_t kMostInOrder = 12;  ///< activities of which all orders are tried

class Sequences {
 public:
  Sequences(const Activities& activities, Budget& budget) : activities_(activities), budget_(budget) {}

  PairTime run() {
    for (int i = 0; i < activities_.count(); ++i) best_ = std::max(best_, activities_.heads[i] + activities_.tails[i]);
    std::vector<std::pair<PairTime, std::vector<int>>> groups;
    for (std::vector<int>& group : find_groups()) groups.emplace_back(by_sum(group), std::move(group));
    std::ranges::stable_sort(groups, [](const auto& a, const auto& b) { return a.first > b.first; });
    for (auto& [bound, group] : groups) best_ = std::max(best_, bound);
    for (auto& [bound, group] : groups) {
      if (budget_.slice_over()) break;
      if (group.size() <= kMostInOrder) raise_by_orders(group);
    }
    return best_;
  }

 private:
  /// Not of an activity and itself, which are no time apart.
  bool exclusive(int i, int j) const { return activities_.apart[i][j] > 0 && activities_.apart[j][i] > 0; }

  /// Maximal sets of which no two can begin together, grown from pairs by what leaves most to grow.
  std::vector<std::vector<int>> find_groups() {
    const int n = activities_.count();
    std::set<std::vector<int>> found;
    for (int i = 0; i < n; ++i)
      for (int j = i + 1; j < n; ++j) {
        if (!exclusive(i, j)) continue;
        budget_.spend(Work::kBound, n);
        if (budget_.slice_over()) return {found.begin(), found.end()};
        std::vector<int> group = {i, j}, left;
        for (int k = 0; k < n; ++k)
          if (k != i && k != j && exclusive(i, k) && exclusive(j, k)) left.push_back(k);
        while (!left.empty()) {
          const auto room = [&](int k) {
            return std::ranges::count_if(left, [&](int other) { return exclusive(k, other); });
          };
          const int next = *std::ranges::max_element(left, {}, room);
          group.push_back(next);
          std::erase_if(left, [&](int k) { return k == next || !exclusive(k, next); });
        }
        std::ranges::sort(group);
        found.insert(std::move(group));
      }
    return {found.begin(), found.end()};
  }

  /// A bound from the activities with a late enough head and a long enough tail: the first head, plus the shortest
  /// times to a next one, plus the last tail.
  PairTime by_sum(const std::vector<int>& group) const {
    PairTime most = 0;
    for (const int first : group)
      for (const int last : group) {
        std::vector<int> chosen;
        for (const int k : group)
          if (activities_.heads[k] >= activities_.heads[first] && activities_.tails[k] >= activities_.tails[last])
            chosen.push_back(k);
        if (chosen.size() < 2) continue;
        std::int64_t sum = 0, longest = 0;
        for (const int k : chosen) {
          PairTime next = PairTimes::kNever;
          for (const int other : chosen)
            if (other != k) next = std::min(next, activities_.apart[k][other]);
          next = std::min(next, PairTimes::kMost);  // it can only be the last
          longest = std::max<std::int64_t>(longest, next);
          sum += next;
        }
        most = static_cast<PairTime>(std::max<std::int64_t>(
            most, std::min<std::int64_t>(activities_.heads[first] + sum - longest + activities_.tails[last],
                                         PairTimes::kMost)));
      }
    return most;
  }

  /// Raises the bound while no order ends by it.
  void raise_by_orders(const std::vector<int>& group) {
    for (;;) {
      const PairTime next = shortest_beyond(group, best_);
      if (next <= best_) return;
      if (next >= PairTimes::kNever) return;
      best_ = next;
      if (budget_.slice_over()) return;
    }
  }

  /// `limit` if some order ends by it, else the least end that an order gave up for; PairTimes::kNever: there is none.
  PairTime shortest_beyond(const std::vector<int>& group, PairTime limit) {
    const std::size_t n = group.size(), all = (std::size_t{1} << n) - 1;
    earliest_.assign((all + 1) * n, PairTimes::kNever);
    PairTime beyond = PairTimes::kNever;
    const auto reach = [&](std::size_t set, std::size_t last, PairTime time) {
      const PairTime end = time + activities_.tails[group[last]];
      if (end > limit)
        beyond = std::min(beyond, end);
      else
        earliest_[set * n + last] = std::min(earliest_[set * n + last], time);
    };
    for (std::size_t i = 0; i < n; ++i) reach(std::size_t{1} << i, i, activities_.heads[group[i]]);
    for (std::size_t set = 1; set < all; ++set)
      for (std::size_t last = 0; last < n; ++last) {
        const PairTime time = earliest_[set * n + last];
        if (time >= PairTimes::kNever) continue;
        for (std::size_t next = 0; next < n; ++next) {
          if ((set >> next) & 1) continue;
          const PairTime gap = activities_.apart[group[last]][group[next]];
          if (gap < PairTimes::kNever)
            reach(set | (std::size_t{1} << next), next, std::max(time + gap, activities_.heads[group[next]]));
        }
      }
    budget_.spend(Work::kBound, static_cast<std::int64_t>(all * n * n / 16));
    for (std::size_t last = 0; last < n; ++last)
      if (earliest_[all * n + last] < PairTimes::kNever) return limit;
    return beyond;
  }

  const Activities& activities_;
  Budget& budget_;
  PairTime best_ = 0;
  std::vector<PairTime> earliest_;  ///< by set and last activity
};

}  // namespace

PairTime shortest_sequence(const Activities& activities, Budget& budget) { return Sequences(activities, budget).run(); }

}  // namespace cxlab::planner
