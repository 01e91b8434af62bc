#pragma once
// Removes what nothing in a ground task needs, and renumbers the rest.

#include <vector>

#include "planner/ground/budget.h"
#include "planner/ground/task.h"

namespace cxlab::planner {

/// New numbers for the items that are kept, -1 for the others; moves the kept ones up in `items`.
template <class Item>
ById<int> compact(std::vector<Item>& items, const std::vector<char>& keep) {
  ById<int> renamed(items.size(), -1);
  std::size_t next = 0;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (!keep[i]) continue;
    renamed[i] = static_cast<int>(next);
    if (next != i) items[next] = std::move(items[i]);
    ++next;
  }
  items.resize(next);
  return renamed;
}

/// Facts that nothing asks for, and conditions on facts that never change.
void drop_facts(GroundTask& task);
/// Comparisons and numbers that nothing asks for. Changes nothing if the budget ends.
void drop_numbers(GroundTask& task, Budget& budget);
/// Numbers that only the metric reads come last.
void put_significant_numbers_first(GroundTask& task);

}  // namespace cxlab::planner
