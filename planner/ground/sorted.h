#pragma once
// Lists of ids in ascending order, each once.

#include <algorithm>
#include <vector>

namespace cxlab::planner {

inline void sort_unique(std::vector<int>& ids) {
  std::ranges::sort(ids);
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
}

inline bool contains(const std::vector<int>& sorted, int id) { return std::ranges::binary_search(sorted, id); }

}  // namespace cxlab::planner
