#pragma once
// Values of the variables of a left-hand side.

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/engine/value.h"

namespace cxlab::explain {

/// In the order in which they were bound; names are without `?` and `$`.
class Bindings {
 public:
  const Value* find(std::string_view name) const {
    for (const auto& [known, value] : values_)
      if (known == name) return &value;
    return nullptr;
  }
  void bind(std::string name, Value value) { values_.emplace_back(std::move(name), std::move(value)); }
  std::size_t size() const { return values_.size(); }
  /// Forgets those that were bound since there were so many.
  void forget_beyond(std::size_t size) { values_.resize(size); }
  auto begin() const { return values_.begin(); }
  auto end() const { return values_.end(); }

 private:
  std::vector<std::pair<std::string, Value>> values_;
};

}  // namespace cxlab::explain
