#pragma once
// What an agent can observe and do at all, as lists of fixed order: the spaces of a trainer with a net. As CX's trainer
// makes them: what is predefined, and every predicate and action with all objects of its parameters' types, sorted.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"

namespace cxlab::rl {

/// A predicate or an action with the types of its parameters.
struct Schema {
  std::string name;
  std::vector<std::string> types;
};

/// What the agent has answered.
struct SpaceAnswers {
  std::vector<std::string> observables, actions;  ///< predefined: `on(a#b)`
  std::vector<Schema> predicates, action_schemas;
  std::map<std::string, std::vector<std::string>> objects;  ///< by type
};

class Spaces {
 public:
  static constexpr std::size_t kMost = 1'000'000;  ///< of observables, of actions
  static constexpr const char* kNoOp = "no-op";    ///< action 0

  Spaces() = default;
  /// kInput where there are more than `kMost`.
  static Expected<Spaces> make(const SpaceAnswers& answers);

  const std::vector<std::string>& observables() const { return observables_; }
  const std::vector<std::string>& actions() const { return actions_; }
  /// A bit for each observable: whether it is among `true_now`. Adds those that the space lacks to `unknown`.
  std::vector<std::uint8_t> observation(const std::vector<std::string>& true_now,
                                        std::vector<std::string>* unknown) const;
  /// The place of an action; none: not in the space, 0 is never returned for one.
  std::size_t place_of(std::string_view action) const;

  /// {"observables": [...], "actions": [...]}
  std::string to_json() const;

 private:
  std::vector<std::string> observables_, actions_{kNoOp};
};

/// Schemas of parallel lists: the parameters of all, one after the other, and how many each has.
std::vector<Schema> schemas_of(const std::vector<std::string>& names, const std::vector<std::int64_t>& counts,
                               const std::vector<std::string>& types);

}  // namespace cxlab::rl
