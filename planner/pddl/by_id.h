#pragma once
// Lists that are indexed by ids, which are int.

#include <concepts>
#include <utility>
#include <vector>

namespace cxlab::planner {

/// A vector whose index may be signed. As with every vector, the caller ensures that the index is valid.
template <class T>
class ById : public std::vector<T> {
  using List = std::vector<T>;

 public:
  using List::List;
  ById() = default;
  explicit ById(List list) : List(std::move(list)) {}

  decltype(auto) operator[](std::integral auto id) { return List::operator[](static_cast<std::size_t>(id)); }
  decltype(auto) operator[](std::integral auto id) const { return List::operator[](static_cast<std::size_t>(id)); }
};

}  // namespace cxlab::planner
